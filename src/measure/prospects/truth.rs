//! Many scans of random form with limits near their figures: what was called certain, against what came out.

use std::f64::consts::TAU;

use asphera_figures::{Reference, Sample, Term, peak_to_valley, remove, rms};
use asphera_form::{Aperture, FitSettings, Nominal, deviations, fit};
use asphera_geometry::PointMm;
use asphera_report::ProspectState;

use crate::Part;
use crate::Pipeline;
use crate::nominal::parse;
use crate::random::Random;

/// In which order points arrive.
pub(super) const ORDERS: [&str; 4] = ["lines", "spiral outwards", "spiral inwards", "no order"];

/// A disc of 20 mm radius, and a little more, with points 0.5 mm apart, of waves from 6 mm to three times its width whose amplitude
/// goes with a power of their length from 0 to 2.
fn scan(random: &mut Random, order: usize) -> Vec<PointMm> {
    let power = 2.0 * random.next();
    let waves: Vec<[f64; 4]> = (0..40)
        .map(|_| {
            let length_mm = 6.0 * 20.0_f64.powf(random.next());
            let (sin, cos) = (TAU * random.next()).sin_cos();
            let nm = 8.0 * random.normal() * (length_mm / 20.0).powf(power);
            [TAU * cos / length_mm, TAU * sin / length_mm, TAU * random.next(), nm]
        })
        .collect();
    let noise_nm = 2.0 * random.next();
    let mut points = Vec::new();
    for line in 0..84 {
        for column in 0..84 {
            let column = if line % 2 == 0 { column } else { 83 - column };
            let (x, y) = (0.5 * f64::from(column) - 20.75, 0.5 * f64::from(line) - 20.75);
            if x.hypot(y) <= 20.75 {
                let form = waves.iter().map(|[u, v, phase, nm]| nm * (u * x + v * y + phase).sin());
                let nm = form.sum::<f64>() + noise_nm * random.normal();
                points.push([x, y, 1e-6 * nm + 1e-4 * x]);
            }
        }
    }
    arrive(&mut points, random, order);
    points
}

/// Puts points that lie line by line into an order.
pub(super) fn arrive(points: &mut [PointMm], random: &mut Random, order: usize) {
    let radius = |point: &PointMm| point[0].hypot(point[1]);
    match order {
        0 => {}
        1 => points.sort_by(|a, b| radius(a).total_cmp(&radius(b))),
        2 => points.sort_by(|a, b| radius(b).total_cmp(&radius(a))),
        _ => {
            for last in (1..points.len()).rev() {
                points.swap(last, (random.next() * (last + 1) as f64) as usize);
            }
        }
    }
}

const NAMES: [&str; 6] = [
    "pv_nm",
    "rms_nm",
    "pv_nm 0-10 mm",
    "rms_nm 12-20 mm",
    "pv_nm less tilt, power",
    "rms_nm less astigmatism",
];

/// The figures of these names, by the kernel alone.
fn figures(points: &[PointMm]) -> [f64; 6] {
    let settings = FitSettings::default();
    let found = fit(points, &Nominal::Plane, &settings).unwrap();
    let deviations_mm = deviations(points, &found.nominal, &found.pose);
    let places: Vec<[f64; 2]> =
        points.iter().map(|&point| found.pose.to_part(point)).map(|[x, y, _]| [x, y]).collect();
    let sample = |aperture| Sample::new(&places, &deviations_mm, None, &aperture).unwrap();
    let whole = sample(Aperture::Circle { radius_mm: 20.0 });
    let pv = |sample: &Sample| peak_to_valley(sample).unwrap().value;
    let rms = |sample: &Sample| rms(sample, Reference::Zero).unwrap().value;
    [
        pv(&whole),
        rms(&whole),
        pv(&sample(Aperture::Annulus { inner_mm: 0.0, outer_mm: 10.0 })),
        rms(&sample(Aperture::Annulus { inner_mm: 12.0, outer_mm: 20.0 })),
        pv(&remove(&whole, &[Term::Tilt, Term::Power]).unwrap().sample),
        rms(&remove(&whole, &[Term::Astigmatism]).unwrap().sample),
    ]
}

fn part(limits: &[f64; 6], guard: &str) -> Part {
    let [pv, rms, inner, outer, power, astigmatism] = limits;
    let text = format!(
        "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 20\n\
         [sampling]\ngap_limit_mm = 0.4\ncoverage_min = 0.5\n\
         [tolerance]\npv_nm = {pv}\nrms_nm = {rms}\n{guard}\
         [[tolerance.zone]]\nouter_mm = 10\npv_nm = {inner}\n\
         [[tolerance.zone]]\ninner_mm = 12\nouter_mm = 20\nrms_nm = {outer}\n\
         [[tolerance.less]]\nterms = [\"tilt\", \"power\"]\npv_nm = {power}\n\
         [[tolerance.less]]\nterms = [\"astigmatism\"]\nrms_nm = {astigmatism}\n\
         [uncertainty]\ndraws = 20\n"
    );
    parse("part.toml", &text).unwrap()
}

/// What was said of one limit, or of many.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    fails: usize,
    told_fail: usize,
    wrong_fail: usize,
    passes: usize,
    told_pass: usize,
    /// The verdict was fail or undecided.
    wrong_pass: usize,
    /// Coverage when a pass was told first, summed.
    coverage: f64,
}

impl Tally {
    fn add(&mut self, other: &Tally) {
        self.fails += other.fails;
        self.told_fail += other.told_fail;
        self.wrong_fail += other.wrong_fail;
        self.passes += other.passes;
        self.told_pass += other.told_pass;
        self.wrong_pass += other.wrong_pass;
        self.coverage += other.coverage;
    }

    fn right(&self) -> f64 {
        1.0 - self.wrong_pass as f64 / self.told_pass.max(1) as f64
    }

    fn print(&self, name: &str) {
        eprintln!(
            "{name:<24} fail told {:>4} of {:>4}, wrong {}; pass told {:>4} of {:>4} at {:>5.1} % coverage, right {:>5.1} %",
            self.told_fail,
            self.fails,
            self.wrong_fail,
            self.told_pass,
            self.passes,
            100.0 * self.coverage / self.told_pass.max(1) as f64,
            100.0 * self.right(),
        );
    }
}

/// What was said of one scan, by limit.
fn followed(seed: u64) -> [Tally; 6] {
    let order = (seed % 4) as usize;
    let guard = if seed % 8 < 4 { "" } else { "guard_probability = 0.95\n" };
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1);
    for _ in 0..8 {
        random.next();
    }
    let points = scan(&mut random, order);
    let limits = figures(&points).map(|nm| nm * (0.75 + 0.75 * random.next()));
    let mut pipeline = Pipeline::new(part(&limits, guard)).expecting(Some(points.len() as u64));
    let mut tallies = [Tally::default(); 6];
    for (index, point) in points.iter().enumerate() {
        pipeline.take_position(*point);
        if index % 125 != 124 || index < 1500 {
            continue;
        }
        let Some(outlook) = pipeline.figures().outlook else { continue };
        for (name, tally) in NAMES.iter().zip(&mut tallies) {
            let limit = outlook.limits.iter().find(|limit| limit.figure.name == *name).unwrap();
            match limit.state {
                ProspectState::FailCertain => tally.told_fail = 1,
                ProspectState::PassCertain if tally.told_pass == 0 => {
                    tally.told_pass = 1;
                    tally.coverage = limit.coverage.unwrap();
                }
                _ => {}
            }
        }
    }
    let report = pipeline.finish().report;
    for (name, tally) in NAMES.iter().zip(&mut tallies) {
        let check = report.verdict.checks.iter().find(|check| check.figure.name == *name).unwrap();
        let broken = !check.ok && check.doubt.is_none();
        tally.fails = usize::from(broken);
        tally.passes = usize::from(check.ok);
        tally.wrong_fail = usize::from(tally.told_fail == 1 && !broken);
        tally.wrong_pass = usize::from(tally.told_pass == 1 && !check.ok);
        if tally.wrong_fail + tally.wrong_pass > 0 {
            let (order, limit) = (ORDERS[order], check.limit);
            eprintln!("scan {seed}, {order}: {name} wrong, {} of {limit} nm", check.value);
        }
    }
    tallies
}

/// 64 scans, or as many as `ASPHERA_SCANS` says.
#[test]
fn what_was_called_certain_came_out() {
    let scans = std::env::var("ASPHERA_SCANS").ok().and_then(|count| count.parse().ok());
    let mut by_limit = [Tally::default(); 6];
    let mut by_order = [Tally::default(); 4];
    for seed in 0..scans.unwrap_or(64_u64) {
        for (limit, found) in followed(seed).iter().enumerate() {
            by_limit[limit].add(found);
            by_order[(seed % 4) as usize].add(found);
        }
    }
    NAMES.iter().zip(&by_limit).for_each(|(name, tally)| tally.print(name));
    ORDERS.iter().zip(&by_order).for_each(|(name, tally)| tally.print(name));
    let mut all = Tally::default();
    by_limit.iter().for_each(|tally| all.add(tally));
    all.print("all");
    assert_eq!(all.wrong_fail, 0);
    assert!(all.right() >= 0.95, "{all:?}");
    // And something is said at all.
    assert!(5 * all.told_fail > all.fails && 2 * all.told_pass > all.passes, "{all:?}");
}
