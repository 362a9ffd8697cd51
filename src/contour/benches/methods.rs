//! How the time of every method grows, and whether it depends on the order of the points.
//!
//! `cargo bench -p asphera-contour --bench methods` runs each on samples of a closed curve: ten times 100,000 of them against
//! 1,000,000 at once, the triangulation made before; medians of 3 runs. `ASPHERA_BENCH_POINTS` sets another larger number,
//! `ASPHERA_BENCH_RUNS` another number of runs, `ASPHERA_BENCH_METHODS` names the methods, with commas between. A method that takes fewer points is named as such.

use std::time::Instant;

use asphera_contour::{Method, Parameters, PlaceMm, Samples, Triangulation};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;

const PARTS: usize = 10;

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let count = std::env::var("ASPHERA_BENCH_POINTS").map_or(1_000_000, |count| {
        count.parse().expect("ASPHERA_BENCH_POINTS must be a number of points")
    });
    println!(
        "{count} points against {PARTS} x {}, {} threads",
        count / PARTS,
        rayon::current_num_threads()
    );
    let runs = std::env::var("ASPHERA_BENCH_RUNS")
        .map_or(3, |runs| runs.parse().expect("ASPHERA_BENCH_RUNS must be a number of runs"));
    let large = curve(count);
    let small = curve(count / PARTS);
    let [whole, part] = [&large, &small].map(|points| median(runs, || drop(meshed(points))));
    println!("| triangulation | {:.0} ms | {:.2} |", 1e3 * whole, whole / (PARTS as f64 * part));
    let mut shuffled = large.clone();
    shuffle(&mut shuffled);
    let random = median(runs, || drop(meshed(&shuffled)));
    println!(
        "| the same, in no order | {:.0} ms | traced / random {:.2} |",
        1e3 * random,
        whole / random
    );
    let wanted = std::env::var("ASPHERA_BENCH_METHODS").ok();
    let is_wanted = |method: &Method| {
        wanted.as_ref().is_none_or(|names| names.split(',').any(|name| name == method.name()))
    };
    for method in Method::ALL.into_iter().filter(is_wanted) {
        if let Err(refused) = method.run(&meshed(&large), &Parameters::new()) {
            println!("| {} | {refused} | |", method.name());
            continue;
        }
        let run = |points: &[PlaceMm]| {
            // What a method shares with others is made anew for each: order of lengths, nearest samples, trees.
            let mut times: Vec<f64> = (0..runs)
                .map(|_| {
                    let mesh = meshed(points);
                    timed(|| drop(method.run(&mesh, &Parameters::new())))
                })
                .collect();
            times.sort_by(f64::total_cmp);
            times[runs / 2]
        };
        let [whole, part] = [run(&large), run(&small)];
        println!(
            "| {} | {:.0} ms | {:.2} |",
            method.name(),
            1e3 * whole,
            whole / (PARTS as f64 * part)
        );
    }
}

fn meshed(points: &[PlaceMm]) -> Triangulation {
    Triangulation::new(Samples::new(points).expect("finite points"))
}

fn median(runs: usize, run: impl Fn()) -> f64 {
    let mut times: Vec<f64> = (0..runs).map(|_| timed(&run)).collect();
    times.sort_by(f64::total_cmp);
    times[runs / 2]
}

#[expect(clippy::disallowed_methods, reason = "a benchmark looks at the clock")]
fn timed(run: impl FnOnce()) -> f64 {
    let begun = Instant::now();
    run();
    begun.elapsed().as_secs_f64()
}

/// Samples of a flower of twelve leaves in the order in which it is traced, their places jittered along it.
fn curve(count: usize) -> Vec<PlaceMm> {
    let mut random = Pcg64::seed_from_u64(1);
    let step = std::f64::consts::TAU / count as f64;
    (0..count)
        .map(|index| {
            let jitter = (random.next_u64() >> 11) as f64 * 2_f64.powi(-53);
            let angle = (index as f64 + 0.3 * jitter) * step;
            let radius = 10.0 + 3.0 * (12.0 * angle).cos();
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect()
}

/// Fisher and Yates's shuffle.
fn shuffle(points: &mut [PlaceMm]) {
    let mut random = Pcg64::seed_from_u64(2);
    for last in (1..points.len()).rev() {
        points.swap(last, (random.next_u64() % (last as u64 + 1)) as usize);
    }
}
