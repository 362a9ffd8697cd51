//! Expansion of a million scattered values in the 37 Fringe terms, and prysm's in the same run.
//!
//! `ASPHERA_PYTHON` names an interpreter with prysm; without it ours runs alone. Both take the least of
//! their repetitions. prysm works on the 785,000 pixels of a square grid that lie in the disc, ours on a
//! million places in no order; ours evaluates the terms as it goes.

#![expect(clippy::print_stdout, reason = "a benchmark prints what it finds")]

use std::process::Command;
use std::time::Instant;

use asphera_form::basis::{Basis as _, Normalisation, Scale, Zernike, expand};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

const COUNT: usize = 1_000_000;
const REPETITIONS: usize = 5;

fn main() {
    let mut random = Pcg64Mcg::seed_from_u64(2012);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let places: Vec<[f64; 2]> = (0..COUNT)
        .map(|_| {
            let (r, phi) = (9.0 * uniform().sqrt(), std::f64::consts::TAU * uniform());
            [r * phi.cos(), r * phi.sin()]
        })
        .collect();
    let values: Vec<f64> = places.iter().map(|place| place[0] * place[1] + uniform()).collect();
    println!("{COUNT} places in a disc, 37 Fringe terms, least of {REPETITIONS}");
    let ours: Vec<f64> = [1, 2].map(|threads| ours(&places, &values, threads)).to_vec();
    let Some([evaluation, squares, pixels]) = prysm() else {
        println!("prysm: not run, ASPHERA_PYTHON names no python that has it");
        return;
    };
    println!("prysm, {pixels} pixels: terms {evaluation:.3} s, least squares {squares:.3} s");
    for (threads, ours) in (1..).zip(ours) {
        println!(
            "{threads} thread(s): prysm takes {:.1} times as long, without evaluating its terms {:.1}",
            (evaluation + squares) / ours,
            squares / ours
        );
    }
}

/// Seconds, terms evaluated included.
#[expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
fn ours(places: &[[f64; 2]], values: &[f64], threads: usize) -> f64 {
    let basis = Zernike::fringe_37(Normalisation::UnitHeight);
    let scale = Scale::round(9.0).expect("a positive radius");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let mut least = f64::INFINITY;
    for _ in 0..REPETITIONS {
        let begin = Instant::now();
        let found = pool.install(|| expand(&basis, &scale, places, values, None));
        least = least.min(begin.elapsed().as_secs_f64());
        let found = found.expect("points within the disc");
        assert_eq!((found.used, found.coefficients.len()), (places.len(), basis.terms()));
    }
    println!(
        "ours, {threads} thread(s): {:.1} ms, {:.0} ns a point",
        least * 1e3,
        least * 1e9 / places.len() as f64
    );
    least
}

/// Seconds for the terms and for the least squares, and pixels.
fn prysm() -> Option<[f64; 3]> {
    let python = std::env::var_os("ASPHERA_PYTHON")?;
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/expand.py");
    let output = Command::new(python).arg(script).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    numbers.try_into().ok()
}
