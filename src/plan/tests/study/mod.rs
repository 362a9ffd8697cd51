//! Five simulated parts, each scanned uniformly and adaptively to the same ε, coverage and uncertainty.
//!
//! Points are those of the design with a form error and noise along z. The uniform scan is a raster with the spacing that the design needs
//! where it needs the finest, as `asphera plan --from-epsilon` plans it. With hindsight a coarser raster may do: the coarsest that reaches the
//! goal is found by trial. All are looked at by the same pipeline, as if the measurement ended there. Times are those of two machines, one
//! that scans lines at constant speed and one that stops at each point, without the time of the looks.

mod assess;
mod parts;

use asphera_plan::{
    AdaptiveScan, Aperture, Axis, Batch, Ending, Goal, Known, Limits, Machine, Path, Piece,
    Schedule, Spacing, Step, VerdictState, lay, schedule, schedule_each, short_order,
};

pub use self::assess::Findings;
pub use self::parts::{Simulated, all, planned_mm};

/// A scan and what it found.
#[derive(Clone, Debug)]
pub struct Scanned {
    /// Points that were taken.
    pub points: usize,
    /// Time of a machine that scans lines, in s.
    pub time_s: f64,
    /// Time of one that stops at each point, in s.
    pub stopping_s: f64,
    /// How often the part was looked at.
    pub looks: usize,
    /// The last look.
    pub findings: Findings,
    /// Why the scan ended; `None` of a uniform one.
    pub ending: Option<Ending>,
}

/// All scans of a part.
#[derive(Clone, Debug)]
pub struct Compared {
    /// The raster as it is planned from the design.
    pub planned: Scanned,
    /// The coarsest raster that reaches the goal.
    pub hindsight: Scanned,
    /// The adaptive scan.
    pub adaptive: Scanned,
}

/// Scans a part both ways.
pub fn compare(part: &Simulated) -> Compared {
    let pitch_mm = planned_mm(&part.part);
    let planned = uniform(part, pitch_mm);
    assert!(is_reached(part, &planned.findings), "{}: {:?}", part.name, planned.findings);
    Compared {
        hindsight: coarsest_uniform(part, &planned, pitch_mm),
        planned,
        adaptive: adaptive(part),
    }
}

/// An ordinary stage for lenses.
pub fn limits() -> Limits {
    let stage = Axis { low: -60.0, high: 60.0, speed: 20.0, acceleration: 200.0 };
    Limits {
        machine: Machine::Cartesian { x: stage, y: stage },
        scan_speed_mm_s: 5.0,
        dwell_s: 0.02,
    }
}

/// The scan that goes where points lack.
pub fn adaptive(part: &Simulated) -> Scanned {
    let goal = Goal {
        coverage: part.coverage,
        u_max: Some(part.u_max_nm),
        budget_s: None,
        batch_places: 20_000,
        finest_mm: 0.0,
    };
    let mut scan = AdaptiveScan::new(goal, part.aperture, [0.0; 2], part.coarse_mm).unwrap();
    let mut batch: Batch = scan.begin([0.0; 2]);
    let (mut places, mut time_s, mut stopping_s, mut looks) = (Vec::new(), 0.0, 0.0, 0);
    let mut stands_mm = [0.0; 2];
    loop {
        let run: Schedule = schedule_each(&batch.pieces, &limits(), Some(stands_mm)).unwrap();
        assert_eq!(run.points.len(), batch.places, "{}", part.name);
        let new: Vec<[f64; 2]> = run.points.iter().map(|point| point.at_mm).collect();
        let order = short_order(stands_mm, &new).unwrap();
        stopping_s += stopping(stands_mm, order.iter().map(|&index| new[index]));
        places.extend(new);
        stands_mm = batch.pieces.last().map_or(stands_mm, |(piece, _)| piece.end());
        time_s += run.total_s;
        looks += 1;
        let findings = assess::assess(part, &places);
        let known = Known {
            regions: &findings.regions,
            coverage: findings.coverage,
            verdict: findings.verdict,
            u: findings.u_nm,
            spent_s: time_s,
            stands_mm,
        };
        match scan.next_step(&known) {
            Step::Measure(next) => batch = next,
            Step::End(ending) => {
                let ending = Some(ending);
                let points = places.len();
                return Scanned { points, time_s, stopping_s, looks, findings, ending };
            }
        }
    }
}

/// The coarsest raster that reaches the goal, to 3 % of its pitch, from one that does.
fn coarsest_uniform(part: &Simulated, reached: &Scanned, pitch_mm: f64) -> Scanned {
    let (mut fine, mut coarse, mut best) = (pitch_mm, 2.5 * pitch_mm, reached.clone());
    while coarse / fine > 1.03 {
        let pitch_mm = (coarse * fine).sqrt();
        let scanned = uniform(part, pitch_mm);
        if is_reached(part, &scanned.findings) {
            (fine, best) = (pitch_mm, scanned);
        } else {
            coarse = pitch_mm;
        }
    }
    best
}

/// Time in s through places with a stop of 0.1 s at each.
fn stopping(from_mm: [f64; 2], places: impl Iterator<Item = [f64; 2]>) -> f64 {
    let pieces: Vec<Piece> = places.map(|at_mm| Piece::Stop { at_mm }).collect();
    let limits = Limits { dwell_s: 0.1, ..limits() };
    schedule(&pieces, Spacing::AtMost { mm: 1.0 }, &limits, Some(from_mm)).unwrap().total_s
}

/// A raster over the part, with a turn at a round edge: points must enclose the aperture.
pub fn uniform(part: &Simulated, pitch_mm: f64) -> Scanned {
    let raster = Path::Raster { pitch_mm, one_way: false };
    let mut pieces = lay(&raster, &part.aperture, [0.0; 2]).unwrap();
    if let Aperture::Circle { radius_mm } = part.aperture {
        let (centre_mm, to_rad) = ([0.0; 2], std::f64::consts::TAU);
        pieces.push(Piece::Arc { centre_mm, radius_mm, from_rad: 0.0, to_rad });
    }
    let run =
        schedule(&pieces, Spacing::AtMost { mm: pitch_mm }, &limits(), Some([0.0; 2])).unwrap();
    let places: Vec<[f64; 2]> = run.points.iter().map(|point| point.at_mm).collect();
    let findings = assess::assess(part, &places);
    let (points, time_s) = (places.len(), run.total_s);
    let stopping_s = stopping([0.0; 2], places.into_iter());
    Scanned { points, time_s, stopping_s, looks: 1, findings, ending: None }
}

/// Whether a look finds the goal reached: of a part that fails, with a verdict that is certain.
pub fn is_reached(part: &Simulated, findings: &Findings) -> bool {
    let is_sampled = findings.coverage.is_some_and(|coverage| coverage >= part.coverage);
    let is_known = findings.u_nm.is_some_and(|u_nm| u_nm <= part.u_max_nm);
    is_sampled && is_known && findings.verdict != VerdictState::Open
}
