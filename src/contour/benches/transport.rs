//! Optimal transport against CGAL's.
//!
//! `cargo bench -p asphera-contour --bench transport` takes 2,000 points of a flower with 20 µm of noise to 60 vertices: the median processor
//! time of 5 runs. Where `c++` finds CGAL, its `Optimal_transportation_reconstruction_2` does so with the same points.
//! `ASPHERA_CGAL` holds more words for the compiler, such as `-I/opt/cgal/include -lgmp`.

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use asphera_contour::curves::{Transport, optimal_transport};
use asphera_contour::{PlaceMm, Samples, Triangulation};
use asphera_geometry::Numbers;

const POINTS: usize = 2000;
const VERTICES: usize = 60;
const RUNS: usize = 5;
const PEER: &str = "
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Optimal_transportation_reconstruction_2.h>
#include <algorithm>
#include <ctime>
#include <iostream>
#include <vector>
typedef CGAL::Exact_predicates_inexact_constructions_kernel Kernel;
int main(int, char** words) {
    std::vector<Kernel::Point_2> points;
    for (double x, y; std::cin >> x >> y;) points.emplace_back(x, y);
    std::vector<double> times;
    for (int run = 0; run < 5; ++run) {
        std::clock_t begun = std::clock();
        CGAL::Optimal_transportation_reconstruction_2<Kernel> found(points);
        found.run_until(std::atoi(words[1]));
        times.push_back(double(std::clock() - begun) / CLOCKS_PER_SEC);
    }
    std::sort(times.begin(), times.end());
    std::cout << times[2];
}
";

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let points = flower();
    let settings = Transport { vertices: VERTICES, tolerance_mm: 0.0, relevance: 0.0 };
    let mut times: Vec<f64> = (0..RUNS).map(|_| timed(&points, settings)).collect();
    times.sort_by(f64::total_cmp);
    let ours = times[RUNS / 2];
    println!("{POINTS} points to {VERTICES} vertices: {:.0} ms", 1e3 * ours);
    match peer(&points) {
        Ok(theirs) => println!("CGAL: {:.0} ms, {:.1} times as long", 1e3 * theirs, theirs / ours),
        Err(why) => println!("skipped: CGAL cannot be used: {why}"),
    }
}

/// The triangulation counts, as it does in CGAL's time.
#[expect(clippy::disallowed_methods, reason = "a benchmark looks at the clock")]
fn timed(points: &[PlaceMm], settings: Transport) -> f64 {
    let begun = Instant::now();
    let set = Triangulation::new(Samples::new(points).expect("finite points"));
    assert!(!optimal_transport(&set, settings).graph.edges().is_empty());
    begun.elapsed().as_secs_f64()
}

/// Points along a flower of five leaves, with noise.
fn flower() -> Vec<PlaceMm> {
    let numbers = Numbers::new(1, 0, 0);
    let step = std::f64::consts::TAU / POINTS as f64;
    (0..POINTS)
        .map(|index| {
            let (sin, cos) = (index as f64 * step).sin_cos();
            let radius = 10.0 + 3.0 * (5.0 * index as f64 * step).cos();
            let off = [2 * index, 2 * index + 1].map(|number| 0.02 * numbers.normal(number));
            [radius * cos + off[0], radius * sin + off[1]]
        })
        .collect()
}

/// Seconds of CGAL, or what it lacks.
fn peer(points: &[PlaceMm]) -> Result<f64, String> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let [source, program] = ["transport.cpp", "transport"].map(|name| folder.join(name));
    std::fs::write(&source, PEER).map_err(|error| error.to_string())?;
    let more = std::env::var("ASPHERA_CGAL").unwrap_or_default();
    let made = Command::new("c++")
        .args(["-O3", "-DNDEBUG", "-o"])
        .args([&program, &source])
        .args(more.split_whitespace())
        .output()
        .map_err(|error| format!("c++: {error}"))?;
    if !made.status.success() {
        let words = String::from_utf8_lossy(&made.stderr).into_owned();
        return Err(words.lines().next().unwrap_or("c++ failed").to_owned());
    }
    let mut child = Command::new(&program)
        .arg(VERTICES.to_string())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|error| error.to_string())?;
    let text: String = points.iter().map(|[x, y]| format!("{x} {y}\n")).collect();
    if let Some(mut input) = child.stdin.take() {
        input.write_all(text.as_bytes()).map_err(|error| error.to_string())?;
    }
    let output = child.wait_with_output().map_err(|error| error.to_string())?;
    String::from_utf8_lossy(&output.stdout).trim().parse().map_err(|_| "no time".to_owned())
}
