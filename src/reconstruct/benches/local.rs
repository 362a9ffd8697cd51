//! Time and memory of local stars and of the proof.
//!
//! `cargo bench -p asphera-reconstruct --bench local` takes a spiral on a ball with noise of 5 nm and a random ball, 1,000,000 points
//! each, and ten times 100,000; medians of 3 runs. `ASPHERA_BENCH_POINTS` sets another larger number. Bytes are the growth of the
//! peak of resident memory over the points themselves (Linux; the first run of all, so that nothing is held before).

use std::f64::consts::TAU;
use std::time::Instant;

use asphera_geometry::PointMm;
use asphera_reconstruct::{local, prove};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;
use rayon::ThreadPoolBuilder;

mod common {
    pub(crate) mod memory;
}

use self::common::memory::peak_bytes;

const RUNS: usize = 3;
const PARTS: usize = 10;
const SEED: u64 = 1;

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let count = std::env::var("ASPHERA_BENCH_POINTS").map_or(1_000_000, |count| {
        count.parse().expect("ASPHERA_BENCH_POINTS must be a number of points")
    });
    println!("{count} points, seed {SEED}; median seconds of {RUNS} runs");
    for (name, ball) in [("spiral, 5 nm", spiral as fn(usize) -> _), ("random", random)] {
        let points = ball(count);
        let before = peak_bytes();
        let (made, _) = timed(|| local(&points).expect("few points"));
        let bytes = peak_bytes().zip(before).map(|(after, before)| after - before);
        let bytes_a_point = bytes.map(|bytes| bytes / count as u64);
        let one = with_threads(1, || median(|| local(&points)));
        let two = with_threads(2, || median(|| local(&points)));
        let part = ball(count / PARTS);
        let part = with_threads(1, || median(|| local(&part)));
        let proof = with_threads(1, || median(|| prove(&points, &made.facets)));
        println!(
            "{name}: local {one:.2} s one thread, {two:.2} s two ({:.2}); against {PARTS} x {}: {:.2}; \
             proof {proof:.2} s; {} facets of {}; bytes a point {bytes_a_point:?}",
            one / two,
            count / PARTS,
            one / (PARTS as f64 * part),
            made.facets.len(),
            2 * count - 4,
        );
    }
}

fn spiral(count: usize) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    (0..count)
        .map(|index| {
            let z = 1.0 - (2 * index + 1) as f64 / count as f64;
            let turn = 2.399_963_229_728_653 * index as f64;
            let radius_mm = 10.0 + 5e-6 * (2.0 * unit(&mut random) - 1.0);
            on_ball(radius_mm, z, turn)
        })
        .collect()
}

fn random(count: usize) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    (0..count)
        .map(|_| on_ball(10.0, 2.0 * unit(&mut random) - 1.0, TAU * unit(&mut random)))
        .collect()
}

fn on_ball(radius_mm: f64, z: f64, turn: f64) -> PointMm {
    let radius = radius_mm * (1.0 - z * z).max(0.0).sqrt();
    [radius * turn.cos(), radius * turn.sin(), radius_mm * z]
}

fn unit(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 * 2_f64.powi(-53)
}

fn with_threads<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    ThreadPoolBuilder::new().num_threads(threads).build().expect("threads").install(work)
}

fn median<T>(mut work: impl FnMut() -> T) -> f64 {
    let mut times: Vec<f64> = (0..RUNS).map(|_| timed(&mut work).1).collect();
    times.sort_by(f64::total_cmp);
    times[RUNS / 2]
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    #[expect(clippy::disallowed_methods, reason = "a benchmark measures time")]
    let start = Instant::now();
    let made = work();
    (made, start.elapsed().as_secs_f64())
}
