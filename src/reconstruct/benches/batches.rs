//! Time and memory of a surface that takes its points in batches.
//!
//! `cargo bench -p asphera-reconstruct --bench batches` scans a ball with noise of 5 nm: 1,000,000 points along a spiral whose tracks
//! are as far apart as its points, in batches of 1,000. After each batch the changed facets are known. The same points follow in one
//! batch. `ASPHERA_BENCH_METHOD=graph` takes the graph method by priority in the place of local stars: after each batch its landmarks, cells and
//! contacts are known. Times are processor seconds of one thread, so that other work matters less. `ASPHERA_BENCH_POINTS` sets another number, `ASPHERA_BENCH_ORDER` is `spiral`, `bands` (each batch goes round the ball once,
//! by the golden angle) or `random`. Bytes are the growth of the peak of resident memory over the points themselves (Linux).

use std::f64::consts::{PI, TAU};

use asphera_geometry::PointMm;
use asphera_reconstruct::{
    FaceRule, GraphChoices, GraphSurface, LandmarkOrder, LiveGraph, LocalSurface, PointGraph, local,
};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;
use rayon::ThreadPoolBuilder;

mod common {
    pub(crate) mod clock;
    pub(crate) mod memory;
}

use self::common::clock::timed;
use self::common::memory::peak_bytes;

const BATCH: usize = 1_000;
const SEED: u64 = 1;

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let count = std::env::var("ASPHERA_BENCH_POINTS").map_or(1_000_000, |count| {
        count.parse().expect("ASPHERA_BENCH_POINTS must be a number of points")
    });
    let order = std::env::var("ASPHERA_BENCH_ORDER").unwrap_or_else(|_| "spiral".to_owned());
    let points = match order.as_str() {
        "spiral" => spiral(count),
        "bands" => bands(count),
        "random" => random(count),
        other => panic!("ASPHERA_BENCH_ORDER must be spiral, bands or random, found {other:?}"),
    };
    println!("{count} points of a ball as {order}, seed {SEED}, in batches of {BATCH}");
    let method = std::env::var("ASPHERA_BENCH_METHOD").unwrap_or_else(|_| "local".to_owned());
    let run = match method.as_str() {
        "local" => local_in_batches,
        "graph" => graph_in_batches,
        other => panic!("ASPHERA_BENCH_METHOD must be local or graph, found {other:?}"),
    };
    let pool = ThreadPoolBuilder::new().num_threads(1).build().expect("threads");
    println!("{}", pool.install(|| run(&points)));
}

fn local_in_batches(points: &[PointMm]) -> String {
    let before = peak_bytes();
    let mut surface = LocalSurface::new();
    let mut times: Vec<f64> = Vec::new();
    let mut changes = 0;
    for batch in points.chunks(BATCH) {
        let (changed, seconds) = timed(|| surface.insert(batch).expect("few points"));
        changes += changed.added.len() + changed.removed.len();
        times.push(seconds);
    }
    let bytes = bytes_a_point(before, points.len());
    let (made, asked) = timed(|| surface.surface());
    drop(surface);
    let (at_once, seconds) = timed(|| local(points).expect("few points"));
    assert_eq!(made, at_once, "in batches and at once");
    format!(
        "{}; {:.1} facets changed a point; {} facets, asked for in {asked:.2} s; bytes a point {bytes:?}",
        words(times, seconds),
        changes as f64 / points.len() as f64,
        made.facets.len(),
    )
}

fn graph_in_batches(points: &[PointMm]) -> String {
    let choices = GraphChoices { order: LandmarkOrder::Priority, ..GraphChoices::default() };
    let before = peak_bytes();
    let mut graph = LiveGraph::new(15, choices.hops).expect("numbers within range");
    let mut times: Vec<f64> = Vec::new();
    for batch in points.chunks(BATCH) {
        times.push(timed(|| graph.insert(batch).expect("few points")).1);
    }
    let bytes = bytes_a_point(before, points.len());
    let (made, asked) = timed(|| graph.surface(choices.threshold, FaceRule::Filled));
    drop(graph);
    let at_once = || -> Option<GraphSurface> {
        PointGraph::new(points, 15, &mut |_| {}).ok()?.surface(&choices, &mut |_| {}).ok()
    };
    let (at_once, seconds) = timed(at_once);
    assert_eq!(Some(&made), at_once.as_ref(), "in batches and at once");
    format!(
        "{}; {} landmarks, {} facets, asked for in {asked:.2} s; bytes a point {bytes:?}",
        words(times, seconds),
        made.map.landmarks.len(),
        made.reconstruction.facets.len(),
    )
}

fn bytes_a_point(before: Option<u64>, count: usize) -> Option<u64> {
    peak_bytes().zip(before).map(|(after, before)| (after - before) / count as u64)
}

/// Times of batches beside that of one batch.
fn words(mut times: Vec<f64>, at_once_s: f64) -> String {
    let total: f64 = times.iter().sum();
    times.sort_by(f64::total_cmp);
    let share_ms = |share: f64| 1e3 * times[((times.len() - 1) as f64 * share) as usize];
    format!(
        "{total:.2} s in all, {:.2} x one batch of {at_once_s:.2} s; a batch {:.1} ms, p99 {:.1} ms, longest {:.1} ms",
        total / at_once_s,
        share_ms(0.5),
        share_ms(0.99),
        share_ms(1.0),
    )
}

/// A spiral from pole to pole, its points as far apart as its tracks.
fn spiral(count: usize) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    let tracks = (PI * count as f64).sqrt() / 2.0;
    (0..count)
        .map(|index| {
            let z = 1.0 - (2 * index + 1) as f64 / count as f64;
            noisy(z, TAU * tracks * z.acos() / PI, &mut random)
        })
        .collect()
}

fn bands(count: usize) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    (0..count)
        .map(|index| {
            let z = 1.0 - (2 * index + 1) as f64 / count as f64;
            noisy(z, 2.399_963_229_728_653 * index as f64, &mut random)
        })
        .collect()
}

fn random(count: usize) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    (0..count)
        .map(|_| {
            let (z, turn) = (2.0 * unit(&mut random) - 1.0, TAU * unit(&mut random));
            noisy(z, turn, &mut random)
        })
        .collect()
}

fn noisy(z: f64, turn: f64, random: &mut Pcg64) -> PointMm {
    let radius_mm = 10.0 + 5e-6 * (2.0 * unit(random) - 1.0);
    let radius = radius_mm * (1.0 - z * z).max(0.0).sqrt();
    [radius * turn.cos(), radius * turn.sin(), radius_mm * z]
}

fn unit(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 * 2_f64.powi(-53)
}
