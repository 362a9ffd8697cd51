//! How early the pass of a PV is told that is held with room to spare, and how often that is wrong.

use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use asphera_report::ProspectState;

use super::truth::{ORDERS, arrive};
use super::{Now, Prospects};
use crate::Part;
use crate::Pipeline;
use crate::nominal::parse;
use crate::random::Random;

/// A disc of 20 mm radius with points 0.2 mm apart, and a little more: form of some 50 nm with 1 nm noise, or next to none
/// with 5 nm.
fn scan(random: &mut Random, order: usize, noise_rules: bool) -> Vec<PointMm> {
    let (form_nm, noise_nm) = if noise_rules { (0.1, 5.0) } else { (8.0, 1.0) };
    let power = 2.0 * random.next();
    let waves: Vec<[f64; 4]> = (0..40)
        .map(|_| {
            let length_mm = 6.0 * 20.0_f64.powf(random.next());
            let (sin, cos) = (TAU * random.next()).sin_cos();
            let nm = form_nm * random.normal() * (length_mm / 20.0).powf(power);
            [TAU * cos / length_mm, TAU * sin / length_mm, TAU * random.next(), nm]
        })
        .collect();
    let mut points = Vec::new();
    for line in 0..208 {
        for column in 0..208 {
            let column = if line % 2 == 0 { column } else { 207 - column };
            let (x, y) = (0.2 * f64::from(column) - 20.7, 0.2 * f64::from(line) - 20.7);
            if x.hypot(y) <= 20.7 {
                let form = waves.iter().map(|[u, v, phase, nm]| nm * (u * x + v * y + phase).sin());
                let nm = form.sum::<f64>() + noise_nm * random.normal();
                points.push([x, y, 1e-6 * nm + 1e-4 * x]);
            }
        }
    }
    arrive(&mut points, random, order);
    points
}

fn part(pv_nm: f64) -> Part {
    let text = format!(
        "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 20\n\
         [sampling]\ngap_limit_mm = 0.16\ncoverage_min = 0.5\n[tolerance]\npv_nm = {pv_nm}\n"
    );
    parse("part.toml", &text).unwrap()
}

/// Limits over the PV of all points.
const TIMES: [f64; 3] = [1.5, 2.0, 4.0];

#[derive(Clone, Copy, Default)]
struct Tally {
    passes: usize,
    told: usize,
    wrong: usize,
    /// Coverage, and share of the points, when it was told first, summed.
    coverage: f64,
    points: f64,
}

/// Of one scan, by limit.
fn followed(seed: u64, order: usize, noise_rules: bool) -> [Tally; 3] {
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1);
    for _ in 0..8 {
        random.next();
    }
    let points = scan(&mut random, order, noise_rules);
    let all = points.iter().copied();
    let mut whole = Pipeline::new(part(1e9));
    whole.take_positions(all);
    let report = whole.finish().report;
    let check = &report.verdict.checks[0];
    let parts = TIMES.map(|times| part(times * check.value));
    // Of what a look sees of the whole nothing depends on the limit. The nearest one says when it is looked again.
    let mut pipeline = Pipeline::new(parts[0].clone()).expecting(Some(points.len() as u64));
    let mut prospects: [Prospects; 3] = Default::default();
    let mut tallies = [Tally::default(); 3];
    for (index, point) in points.iter().enumerate() {
        pipeline.take_position(*point);
        if index % 500 != 499 || index < 1500 {
            continue;
        }
        pipeline.figures();
        let Some(estimate) = pipeline.running.estimate() else { continue };
        for ((part, prospects), tally) in parts.iter().zip(&mut prospects).zip(&mut tallies) {
            prospects.seen = pipeline.prospects.seen.clone();
            let outlook = prospects.look(&Now {
                part,
                estimate: &estimate,
                extremes: &|| pipeline.running.extremes(),
                errors: pipeline.errors.of(&estimate.figures),
                coverage: pipeline.sampling.coverage,
                expected_points: pipeline.expected(),
                doubt: None,
            });
            let limit = &outlook.unwrap().limits[0];
            assert_ne!(limit.state, ProspectState::FailCertain, "{limit:?}");
            if limit.state == ProspectState::PassCertain && tally.told == 0 {
                tally.told = 1;
                tally.coverage = limit.coverage.unwrap();
                tally.points = (index + 1) as f64 / points.len() as f64;
            }
        }
    }
    for (times, tally) in TIMES.iter().zip(&mut tallies) {
        tally.passes =
            usize::from(check.hidden.is_some_and(|nm| check.value + nm <= times * check.value));
        tally.wrong = tally.told * (1 - tally.passes);
    }
    tallies
}

/// 12 scans, or as many as `ASPHERA_SCANS` says.
#[test]
fn passes_with_room_to_spare_are_told() {
    let scans = std::env::var("ASPHERA_SCANS").ok().and_then(|count| count.parse().ok());
    let mut tallies = [[[Tally::default(); 3]; 2]; 4];
    for seed in 0..scans.unwrap_or(12_u64) {
        let (order, noise_rules) = ([0, 1, 3][(seed % 3) as usize], seed / 3 % 2 == 1);
        let found = followed(seed, order, noise_rules);
        for (tally, found) in tallies[order][usize::from(noise_rules)].iter_mut().zip(&found) {
            tally.passes += found.passes;
            tally.told += found.told;
            tally.wrong += found.wrong;
            tally.coverage += found.coverage;
            tally.points += found.points;
        }
    }
    let (mut passes, mut told, mut wrong) = (0, 0, 0);
    for (order, tallies) in ORDERS.iter().zip(&tallies) {
        for (rules, tallies) in ["form", "noise"].iter().zip(tallies) {
            for (times, tally) in TIMES.iter().zip(tallies).filter(|(_, tally)| tally.passes > 0) {
                let mean = |sum: f64| 100.0 * sum / tally.told.max(1) as f64;
                eprintln!(
                    "{order:<16} {rules:<5} rules, limit {times} times the PV: pass told {:>3} of {:>3} at {:>5.1} % coverage and \
                     {:>5.1} % of the points, wrong {}",
                    tally.told,
                    tally.passes,
                    mean(tally.coverage),
                    mean(tally.points),
                    tally.wrong
                );
                passes += tally.passes;
                told += tally.told;
                wrong += tally.wrong;
            }
        }
    }
    eprintln!("told {told} of {passes}, wrong {wrong}");
    assert!(20 * wrong <= told && 2 * told > passes, "{told} of {passes}, {wrong} wrong");
}
