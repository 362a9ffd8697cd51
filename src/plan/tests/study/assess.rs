//! What the pipeline says of the points so far.

use asphera_measure::Pipeline;
use asphera_plan::{Polygon, VerdictState, WantedRegion};
use asphera_report::{NextFigures, ProspectState, Status};

use super::Simulated;

/// What is known after some points.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Share of the aperture that is sampled densely enough.
    pub coverage: Option<f64>,
    /// 99 % of the area have at most this ε.
    pub epsilon_p99: Option<f64>,
    /// Standard uncertainty of the figure that is judged.
    pub u_nm: Option<f64>,
    /// State of the verdict.
    pub verdict: VerdictState,
    /// Regions where points lack.
    pub regions: Vec<WantedRegion>,
}

/// Takes points at the places and looks at the part.
pub fn assess(part: &Simulated, places: &[[f64; 2]]) -> Findings {
    let mut pipeline = Pipeline::new(part.part.clone());
    pipeline.take_positions(part.points(places));
    let fails =
        pipeline.figures().outlook.is_some_and(|all| all.state == ProspectState::FailCertain);
    let report = pipeline.finish().report;
    let check = report.verdict.checks.first();
    let verdict = match report.verdict.status {
        _ if fails => VerdictState::FailCertain,
        Status::Pass => VerdictState::PassCertain,
        Status::None => VerdictState::NotAsked,
        Status::Fail | Status::Undecided => VerdictState::Open,
    };
    Findings {
        coverage: report.sampling.coverage,
        epsilon_p99: report.sampling.epsilon_p99,
        u_nm: check.and_then(|check| check.u),
        verdict,
        regions: report.sampling.next.iter().map(region).collect(),
    }
}

/// A region of the report as the plan takes it: its lines from above, its spacing as findings in the plane.
fn region(next: &NextFigures) -> WantedRegion {
    let flat = |ring: &Vec<[f64; 3]>| ring.iter().map(|&[x, y, _]| [x, y]).collect();
    let polygons = next.polygons.iter().map(|polygon| Polygon {
        outline_mm: flat(&polygon.outline_mm),
        holes_mm: polygon.holes_mm.iter().map(flat).collect(),
    });
    let spacing_mm = next.points_needed.map(|count| (next.area_mm2 / count as f64).sqrt());
    WantedRegion {
        polygons: polygons.collect(),
        spacing_mm,
        gain: next.adds_coverage.unwrap_or(0.0),
    }
}
