//! Curves and areas beside GEOS, CGAL and the authors' HNN-Crust, in one run.
//!
//!     cargo bench -p asphera-contour --bench peers -- [--points N] [--json]
//!
//! Processor seconds of one thread, the triangulation among them, medians of 3 runs, each peer on the same points. N is 1,000,000 where
//! it is not said; HNN-Crust has a tenth, optimal transport 2,000 points. What is missing of the peers is said, and such rows are ours
//! alone.

mod common {
    #[path = "../../../reconstruct/benches/common/clock.rs"]
    pub(crate) mod clock;
    pub(crate) mod clouds;
    pub(crate) mod peer;
}

use asphera_contour::curves::{Transport, hnn_crust, optimal_transport};
use asphera_contour::regions::{alpha_shape, connecting_alpha_mm};
use asphera_contour::{PlaceMm, Samples, Triangulation};
use asphera_geometry::Numbers;
use rayon::ThreadPoolBuilder;

use self::common::clock::timed;
use self::common::clouds::{SEED, flower, shuffled, square};
use self::common::peer::{Found, Peers};

const RUNS: usize = 3;
const TRANSPORTED: usize = 2000;
const VERTICES: usize = 60;
/// Radius of the α-shapes in mean spacings: few samples are left out, and the border is that of the area.
const SPACINGS: f64 = 2.0;
/// Share between the shortest and the longest edge up to which the concave hull keeps sides.
const RATIO: f64 = 0.01;

/// Times of the same work.
struct Row {
    of: &'static str,
    points: usize,
    ours: Found,
    peer: &'static str,
    theirs: Option<Found>,
}

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_json = arguments.iter().any(|argument| argument == "--json");
    let points = arguments.iter().position(|argument| argument == "--points");
    let count = points.map_or(1_000_000, |at| number(arguments.get(at + 1)));
    let peers = Peers::find();
    if !is_json {
        println!("{count} points; seed {SEED}");
        peers.missing().iter().for_each(|words| println!("{words}"));
        println!(
            "{:<38}{:>9}{:>9}{:>9}  {:<22}{:>9}{:>9}{:>8}",
            "", "points", "found", "ours, s", "peer", "found", "s", "ratio"
        );
    }
    let show = |row: Row| if is_json { print_json(&row) } else { print_line(&row) };
    let one = ThreadPoolBuilder::new().num_threads(1).build().expect("threads");
    one.install(|| {
        areas(count, &peers, &show);
        curves(count / 10, &peers, &show);
        transport(&peers, &show);
    });
}

fn number(word: Option<&String>) -> usize {
    let found = word.and_then(|word| word.replace('_', "").parse().ok());
    found
        .filter(|&count| count >= 10_000)
        .expect("--points must be followed by a number from 10000 on")
}

/// α-shapes of points at random in a square.
fn areas(count: usize, peers: &Peers, show: &dyn Fn(Row)) {
    let points = square(count);
    let points = points.as_slice();
    let alpha_mm = SPACINGS / (count as f64).sqrt();
    let row = |of, ours, peer, theirs| Row { of, points: count, ours, peer, theirs };
    let mesh = ours(|| meshed(points).triangles().len());
    show(row("Delaunay", mesh, "CGAL Delaunay", theirs(|| peers.cgal("delaunay", points, 0.0))));
    let alpha = ours(|| alpha_shape(&meshed(points), alpha_mm).border().edges().len());
    let cgal = theirs(|| peers.cgal("alpha", points, alpha_mm));
    show(row("alpha-shape", alpha, "CGAL Alpha_shape_2", cgal));
    let hull = theirs(|| peers.concave_hull(points, RATIO));
    show(row("alpha-shape", alpha, "GEOS concave_hull", hull));
    let connecting = ours(|| {
        let mesh = meshed(points);
        let alpha_mm = connecting_alpha_mm(&mesh).expect("triangles");
        alpha_shape(&mesh, alpha_mm).border().edges().len()
    });
    let cgal = theirs(|| peers.cgal("connecting", points, 0.0));
    show(row("alpha-shape, least connecting alpha", connecting, "CGAL find_optimal", cgal));
}

/// HNN-Crust of a closed curve.
fn curves(count: usize, peers: &Peers, show: &dyn Fn(Row)) {
    let traced = flower(count);
    for (of, points) in
        [("HNN-Crust, in no order", shuffled(traced.clone())), ("HNN-Crust, traced", traced)]
    {
        let ours = ours(|| hnn_crust(&Samples::new(&points).expect("finite points")).edges().len());
        let theirs = theirs(|| peers.hnn_crust(&points));
        show(Row { of, points: count, ours, peer: "its authors", theirs });
    }
}

/// Optimal transport of a noisy curve to few vertices.
fn transport(peers: &Peers, show: &dyn Fn(Row)) {
    let points = noisy_flower(TRANSPORTED);
    let settings = Transport { vertices: VERTICES, tolerance_mm: 0.0, relevance: 0.0 };
    let ours = ours(|| optimal_transport(&meshed(&points), settings).graph.edges().len());
    let theirs = theirs(|| peers.cgal("transport", &points, VERTICES as f64));
    show(Row { of: "optimal transport", points: TRANSPORTED, ours, peer: "CGAL", theirs });
}

/// Points along a flower of five leaves, with 20 µm of noise.
fn noisy_flower(count: usize) -> Vec<PlaceMm> {
    let numbers = Numbers::new(SEED, 0, 0);
    let step = std::f64::consts::TAU / count as f64;
    (0..count)
        .map(|index| {
            let (sin, cos) = (index as f64 * step).sin_cos();
            let radius = 10.0 + 3.0 * (5.0 * index as f64 * step).cos();
            let off = [2 * index, 2 * index + 1].map(|number| 0.02 * numbers.normal(number));
            [radius * cos + off[0], radius * sin + off[1]]
        })
        .collect()
}

fn meshed(points: &[PlaceMm]) -> Triangulation {
    Triangulation::new(Samples::new(points).expect("finite points"))
}

/// The median of our runs.
fn ours(work: impl Fn() -> usize) -> Found {
    median(
        (0..RUNS).map(|_| timed(&work)).map(|(count, seconds)| Found { seconds, count }).collect(),
    )
    .expect("runs")
}

/// The median of a peer's runs; none where it is not there.
fn theirs(work: impl Fn() -> Option<Found>) -> Option<Found> {
    median((0..RUNS).map_while(|_| work()).collect())
}

fn median(mut runs: Vec<Found>) -> Option<Found> {
    runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    runs.get(runs.len() / 2).copied()
}

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn print_line(row: &Row) {
    let Row { of, points, ours, peer, theirs } = row;
    let beside = theirs.map_or_else(
        || format!("{:>9}{:>9}{:>8}", "-", "-", "-"),
        |it| format!("{:>9}{:>9.3}{:>8.2}", it.count, it.seconds, it.seconds / ours.seconds),
    );
    println!("{of:<38}{points:>9}{:>9}{:>9.3}  {peer:<22}{beside}", ours.count, ours.seconds);
}

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn print_json(row: &Row) {
    let Row { of, points, ours, peer, theirs } = row;
    let known = |value: Option<f64>| value.map_or("null".to_owned(), |value| format!("{value:.4}"));
    println!(
        "{{\"of\": \"{of}\", \"points\": {points}, \"seed\": {SEED}, \"ours_s\": {:.4}, \"peer\": \"{peer}\", \"peer_s\": {}, \
         \"ratio\": {}}}",
        ours.seconds,
        known(theirs.map(|it| it.seconds)),
        known(theirs.map(|it| it.seconds / ours.seconds))
    );
}
