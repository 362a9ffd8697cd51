//! Reconstruction beside CGAL and SciPy, in one run.
//!
//!     cargo bench -p asphera-reconstruct --bench peers -- [--points N] [--json]
//!
//! Processor seconds of one thread, each peer on the same points next to ours. N is 1,000,000 where it is not said; exact clouds
//! have a tenth, for peers take long over ties. Two threads are held against one by the clock, which needs a machine that does
//! nothing else. Without g++ and `libcgal-dev`, or without `ASPHERA_PYTHON`, the rows say ours alone.

mod common {
    pub(crate) mod clock;
    pub(crate) mod clouds;
    pub(crate) mod peer;
}

use std::time::Instant;

use asphera_geometry::PointMm;
use asphera_reconstruct::{Delaunay, GraphChoices, LocalSurface, PointGraph, local};
use rayon::{ThreadPool, ThreadPoolBuilder};

use self::common::clock::timed;
use self::common::clouds::{
    SEED, asphere_grid, ball_spiral, exact_ball, lens_grid, random_cube, torus_rings,
};
use self::common::peer::Peers;

/// Points of a batch.
const BATCH: usize = 1_000;
/// Neighbours of a point in its graph.
const NEIGHBOURS: usize = 16;

/// Times of the same work.
struct Row {
    of: &'static str,
    cloud: &'static str,
    points: usize,
    ours_s: f64,
    peer: &'static str,
    peer_s: Option<f64>,
}

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let is_json = arguments.iter().any(|argument| argument == "--json");
    let count = arguments
        .iter()
        .position(|argument| argument == "--points")
        .map_or(1_000_000, |at| number(arguments.get(at + 1)));
    let peers = Peers::find();
    if !is_json {
        println!("{count} points, of exact clouds {}; seed {SEED}", count / 10);
        peers.missing().iter().for_each(|words| println!("{words}"));
        let [points, ours, theirs, ratio] = ["points", "ours, s", "theirs, s", "ratio"];
        println!("{points:>71}{ours:>10}{theirs:>22}{ratio:>8}");
    }
    let show = |row: Row| if is_json { print_json(&row) } else { print_line(&row) };
    on_scans(count, &peers, &show);
    on_exact(count / 10, &peers, &show);
    delaunay(count, &peers, &show);
    threads(count, &show);
}

fn number(word: Option<&String>) -> usize {
    let found = word.and_then(|word| word.replace('_', "").parse().ok());
    found
        .filter(|&count| count >= 10_000)
        .expect("--points must be followed by a number from 10000 on")
}

/// Surfaces of noisy scans, in one batch, in batches, and by the graph.
fn on_scans(count: usize, peers: &Peers, show: &dyn Fn(Row)) {
    let (ball, grid) = (ball_spiral(count), asphere_grid(count));
    let front_s = peers.cgal_s("front", &ball);
    let row = |of, ours_s, peer, peer_s| Row {
        of,
        cloud: "ball along a spiral, 5 nm",
        points: ball.len(),
        ours_s,
        peer,
        peer_s,
    };
    let one = pool(1);
    let (whole, ours_s) = one.install(|| timed(|| local(&ball).expect("few points")));
    show(row("local, one batch", ours_s, "CGAL front", front_s));
    let (batched, ours_s) = one.install(|| timed(|| in_batches(&ball)));
    show(row("local, batches of 1,000", ours_s, "CGAL front", front_s));
    assert_eq!(batched.surface(), whole, "in batches and at once");
    drop((batched, whole));
    let (graph, ours_s) = one.install(|| timed(|| graph(&ball)));
    show(row("nearest 16", ours_s, "cKDTree", peers.neighbours_s(&ball, NEIGHBOURS)));
    let choices = GraphChoices::default();
    let ((), more_s) = one.install(|| timed(|| drop(graph.surface(&choices, &mut |_| {}))));
    show(row("graph", ours_s + more_s, "CGAL front", front_s));
    let ours_s = one.install(|| timed(|| local(&grid).expect("few points"))).1;
    show(Row {
        of: "local, one batch",
        cloud: "raster on an asphere, 5 nm",
        points: grid.len(),
        ours_s,
        peer: "CGAL front",
        peer_s: peers.cgal_s("front", &grid),
    });
}

/// Surfaces of points that tie.
fn on_exact(count: usize, peers: &Peers, show: &dyn Fn(Row)) {
    for (cloud, points) in
        [("exact torus rings", torus_rings(count)), ("exact raster", lens_grid(count))]
    {
        let ours_s = pool(1).install(|| timed(|| local(&points).expect("few points"))).1;
        let peer_s = peers.cgal_s("front", &points);
        let (of, points) = ("local, one batch", points.len());
        show(Row { of, cloud, points, ours_s, peer: "CGAL front", peer_s });
    }
}

/// Triangulations of all points at once.
fn delaunay(count: usize, peers: &Peers, show: &dyn Fn(Row)) {
    for (cloud, points) in [
        ("random cube", random_cube(count)),
        ("ball along a spiral, 5 nm", ball_spiral(count)),
        ("raster on an asphere, 5 nm", asphere_grid(count)),
        ("exact ball", exact_ball(count / 10)),
        ("exact torus rings", torus_rings(count / 10)),
        ("exact raster", lens_grid(count / 10)),
    ] {
        let made = || Delaunay::new(&points).expect("points in space");
        let ours_s = pool(1).install(|| timed(|| drop(made()))).1;
        let peer_s = peers.cgal_s("delaunay", &points);
        let points = points.len();
        show(Row { of: "Delaunay", cloud, points, ours_s, peer: "CGAL", peer_s });
    }
}

/// One thread against two, by the clock.
fn threads(count: usize, show: &dyn Fn(Row)) {
    let ball = ball_spiral(count);
    let pairs: [(&'static str, &(dyn Fn() + Sync)); 2] = [
        ("local, two threads by the clock", &|| drop(local(&ball).expect("few points"))),
        ("graph, two threads by the clock", &|| {
            drop(graph(&ball).surface(&GraphChoices::default(), &mut |_| {}));
        }),
    ];
    for (of, work) in pairs {
        let [one_s, two_s] = [1, 2].map(|threads| {
            let pool = pool(threads);
            #[expect(clippy::disallowed_methods, reason = "a benchmark measures time")]
            let start = Instant::now();
            pool.install(work);
            start.elapsed().as_secs_f64()
        });
        let (cloud, points) = ("ball along a spiral, 5 nm", ball.len());
        show(Row { of, cloud, points, ours_s: two_s, peer: "one thread", peer_s: Some(one_s) });
    }
}

fn in_batches(points: &[PointMm]) -> LocalSurface {
    let mut surface = LocalSurface::new();
    for batch in points.chunks(BATCH) {
        surface.insert(batch).expect("few points");
    }
    surface
}

fn graph(points: &[PointMm]) -> PointGraph<'_> {
    PointGraph::new(points, NEIGHBOURS, &mut |_| {}).expect("few points")
}

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")
}

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn print_line(row: &Row) {
    let Row { of, cloud, points, ours_s, peer, peer_s } = row;
    let beside = peer_s.map_or_else(
        || format!("{:>10}{:>8}", "-", "-"),
        |peer_s| format!("{peer_s:>10.2}{:>8.2}", peer_s / ours_s),
    );
    println!("{of:<34}{cloud:<28}{points:>9}{ours_s:>10.2}{peer:>12}{beside}");
}

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn print_json(row: &Row) {
    let Row { of, cloud, points, ours_s, peer, peer_s } = row;
    let known = |value: Option<f64>| value.map_or("null".to_owned(), |value| format!("{value:.4}"));
    println!(
        "{{\"of\": \"{of}\", \"cloud\": \"{cloud}\", \"points\": {points}, \"seed\": {SEED}, \"ours_s\": {ours_s:.4}, \
         \"peer\": \"{peer}\", \"peer_s\": {}, \"ratio\": {}}}",
        known(*peer_s),
        known(peer_s.map(|peer_s| peer_s / ours_s))
    );
}
