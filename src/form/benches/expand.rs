//! Expansion of a million scattered values in the 37 Fringe terms, and prysm's in the same run.
//!
//! `ASPHERA_PYTHON` names an interpreter with prysm; without it ours runs alone. Both take the least of
//! their repetitions. prysm works on the 785,000 pixels of a square grid that lie in the disc, ours on a
//! million places in no order; ours evaluates what it sums as it goes.
//!
//! Times of one thread: 124 ns a point by the products of the terms (`basis/terms.rs`, which bases that are not of
//! the disc still take), 48 ns by moments (`basis/moments`): 26 ns are sums of products, 9 ns residuals, the rest
//! Chebyshev polynomials and powers. Tried and left: tiles of two by five rows, 63 ns, for they do not fit into
//! sixteen registers. Not tried: wider vector instructions chosen at run time, which need unsafe code.

#![expect(clippy::print_stdout, reason = "a benchmark prints what it finds")]

use std::process::Command;
use std::time::Instant;

use asphera_form::basis::{Basis as _, Normalisation, Scale, Zernike, expand};
use asphera_form::shape::{Cells, Series, Shape as _};
use asphera_form::{PointMm, Smoothing, fit_spline};
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
    surfaces(&places, &values);
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

/// Result of `work`, and how many seconds it took.
fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    #[expect(clippy::disallowed_methods, reason = "a benchmark reads the clock")]
    let begin = Instant::now();
    let result = work();
    (result, begin.elapsed().as_secs_f64())
}

/// A series of 37 terms as a surface, and splines fitted to the points; one thread.
fn surfaces(places: &[[f64; 2]], values: &[f64]) {
    let basis = Zernike::fringe_37(Normalisation::UnitHeight);
    let scale = Scale::round(9.0).expect("a positive radius");
    let series = Series::new(basis, scale, &[1e-3; 37]).expect("37 coefficients");
    let places = &places[..100_000];
    let (sum, seconds) =
        timed(|| places.iter().filter_map(|at| series.sag_mm(at[0], at[1])).sum::<f64>());
    assert!(sum.is_finite());
    println!("series of 37 terms: height {:.0} ns", seconds * 1e9 / places.len() as f64);
    let (jets, seconds) = timed(|| {
        let jets = places.iter().filter_map(|at| series.jet(at[0], at[1]));
        jets.map(|jet| jet.hessian_per_mm[1]).sum::<f64>()
    });
    assert!(jets.is_finite());
    println!("series of 37 terms: derivatives {:.0} ns", seconds * 1e9 / places.len() as f64);
    let points: Vec<PointMm> =
        places.iter().zip(values).map(|(at, &value)| [at[0], at[1], value]).collect();
    let cells =
        Cells { x_min_mm: -9.0, y_min_mm: -9.0, step_x_mm: 0.45, step_y_mm: 0.45, nx: 40, ny: 40 };
    let (fit, seconds) = timed(|| fit_spline(&points, &cells, Smoothing::CrossValidation));
    let fit = fit.expect("points that determine a surface");
    println!(
        "splines of 40 by 40 cells by cross validation, {} points: {seconds:.2} s, noise {:?} mm",
        fit.used, fit.noise_mm
    );
}

/// Seconds, terms evaluated included.
fn ours(places: &[[f64; 2]], values: &[f64], threads: usize) -> f64 {
    let basis = Zernike::fringe_37(Normalisation::UnitHeight);
    let scale = Scale::round(9.0).expect("a positive radius");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let mut least = f64::INFINITY;
    for _ in 0..REPETITIONS {
        let (found, seconds) =
            timed(|| pool.install(|| expand(&basis, &scale, places, values, None)));
        least = least.min(seconds);
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
