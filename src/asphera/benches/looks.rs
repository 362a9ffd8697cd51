//! What it costs to foresee limits while points arrive: the longest stall, and the share of the running time.
//!
//! `cargo bench -p asphera --bench looks` takes 1,000,000 points of a spiral as they arrive and asks for the figures every
//! 12,000 points, as a daemon does that gets 100,000 a second: without limits, and with limits of PV and RMS, of zones,
//! of what terms leave, of slope and of B. `ASPHERA_BENCH_POINTS` sets another number of points, `RAYON_NUM_THREADS` the
//! threads. A stall is the time of one call; the share is that of all calls in the time in which the points arrive. At last it
//! says how long the final figures take, with the uncertainties of all limits.

use std::f64::consts::TAU;

use asphera::clock::Clock;
use asphera_geometry::PointMm;
use asphera_measure::Pipeline;

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let count = std::env::var("ASPHERA_BENCH_POINTS").map_or(1_000_000, |count| {
        count.parse().expect("ASPHERA_BENCH_POINTS must be a number of points")
    });
    let threads = rayon::current_num_threads();
    println!(
        "{count} points of a spiral of 9 mm on an asphere, 100 nm form, 2 nm noise, {threads} threads; figures every {EVERY} points"
    );
    let points: Vec<PointMm> = spiral(count).collect();
    for (name, limits) in LIMITS {
        let part = asphera_nominal::parse("part", &format!("{NOMINAL}{limits}"));
        let part = part.expect("a nominal made for the benchmark");
        let mut pipeline = Pipeline::new(part).expecting(Some(count as u64));
        let mut calls_s = Vec::new();
        let started = Clock::start();
        for chunk in points.chunks(EVERY) {
            chunk.iter().for_each(|&point| pipeline.take_position(point));
            let clock = Clock::start();
            let figures = pipeline.figures();
            calls_s.push((clock.now().as_secs_f64(), figures.points.received));
        }
        let whole_s = started.now().as_secs_f64();
        let finishing = Clock::start();
        let measurement = pipeline.finish();
        let finish_s = finishing.now().as_secs_f64();
        let all_s: f64 = calls_s.iter().map(|(seconds, _)| seconds).sum();
        calls_s.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (longest_s, at) = calls_s[0];
        let median_s = calls_s[calls_s.len() / 2].0;
        let running_s = count as f64 / POINTS_PER_S;
        println!(
            "{name}: longest {:.1} ms at {at} points, the next {:.1} and {:.1}; median {:.2} ms; {:.2} s of {} calls, {:.0} ns a \
             point, {:.1} % of the running time; points taken in {:.2} s; the final \
             figures in {finish_s:.2} s, {} limits held",
            1e3 * longest_s,
            1e3 * calls_s[1].0,
            1e3 * calls_s[2].0,
            1e3 * median_s,
            all_s,
            calls_s.len(),
            1e9 * all_s / count as f64,
            100.0 * all_s / running_s,
            whole_s - all_s,
            measurement.report.verdict.checks.iter().filter(|check| check.ok).count(),
        );
    }
}

/// Points of the asphere along a spiral of equal area a point, with form and noise.
fn spiral(count: usize) -> impl Iterator<Item = PointMm> {
    let pitch = (std::f64::consts::PI * 81.0 / count as f64).sqrt();
    let mut state = 42_u64;
    (0..count).map(move |index| {
        let rho = 9.0 * ((index as f64 + 0.5) / count as f64).sqrt();
        let (sin, cos) = (TAU * rho / pitch).sin_cos();
        let (x, y) = (rho * cos, rho * sin);
        let noise = (0..4).map(|_| unit(&mut state) - 0.5).sum::<f64>() * 3.0_f64.sqrt();
        let c = 1.0 / 11.65;
        let z = c * rho * rho / (1.0 + (1.0 + 0.1 * c * c * rho * rho).sqrt());
        let nm = 50.0 * (0.9 * x).sin() * (0.7 * y).cos() + 2.0 * noise;
        [x, y, z + 1e-6 * nm]
    })
}

/// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014), from 0 to below 1.
fn unit(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut draw = *state;
    draw = (draw ^ (draw >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    draw = (draw ^ (draw >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (((draw ^ (draw >> 31)) >> 11) as f64) / (1_u64 << 53) as f64
}

const NOMINAL: &str = "[surface]\nkind = \"asphere\"\nradius_mm = 11.65\nconic = -1.1\n\
    [aperture]\nshape = \"circle\"\nradius_mm = 8.9\n[sampling]\ngap_limit_mm = 0.1\n";

/// None, those of the whole, and all kinds, held and broken.
const LIMITS: [(&str, &str); 6] = [
    ("no limits", ""),
    ("PV and RMS", "[tolerance]\npv_nm = 200\nrms_nm = 40\n"),
    ("PV and RMS, guarded", "[tolerance]\npv_nm = 200\nrms_nm = 40\nguard_probability = 0.95\n"),
    (
        "PV, RMS and B, guarded",
        "[tolerance]\npv_nm = 200\nrms_nm = 40\nguard_probability = 0.95\nindication = \"3/-(200)\"\n",
    ),
    (
        "all, held",
        "[tolerance]\npv_nm = 200\nrms_nm = 40\nslope_max_urad = 200\nslope_over_mm = 1\nslope_step_mm = 0.5\n\
         indication = \"3/500(200)\"\nguard_probability = 0.95\n\
         [[tolerance.zone]]\nouter_mm = 5\npv_nm = 200\n[[tolerance.zone]]\ninner_mm = 5\nouter_mm = 8.9\nrms_nm = 40\n\
         [[tolerance.less]]\nterms = [\"tilt\", \"power\"]\npv_nm = 200\n",
    ),
    (
        "all, doubtful",
        "[tolerance]\npv_nm = 105\nrms_nm = 24\nslope_max_urad = 20\nslope_over_mm = 1\nslope_step_mm = 0.5\n\
         indication = \"3/500(100)\"\nguard_probability = 0.95\n\
         [[tolerance.zone]]\nouter_mm = 5\npv_nm = 104\n[[tolerance.zone]]\ninner_mm = 5\nouter_mm = 8.9\nrms_nm = 24\n\
         [[tolerance.less]]\nterms = [\"tilt\", \"power\"]\npv_nm = 100\n",
    ),
];
const EVERY: usize = 12_000;
const POINTS_PER_S: f64 = 100_000.0;
