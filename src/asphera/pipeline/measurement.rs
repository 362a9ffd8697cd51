//! The final figures of one part.

use asphera_form::{Figures, Fit, Status as FormStatus, Tolerance, deviations, fit, verdict};
use asphera_link::Flags;
use asphera_surface::{Grid, Mesh, PointMm, Survey, rasterize};

use super::figures;
use super::name;
use super::running::fit_settings;
use crate::config::Part;
use crate::report::{Check, FORMAT, Points, Report, Status, Timing, Verdict};

/// All that is known of a part when its last point has landed.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The figures. Links, timing and session are still empty.
    pub report: Report,
    /// Vertices of the mesh, measured frame, mm.
    pub points_mm: Vec<PointMm>,
    /// Its triangles, counter-clockwise seen from +z.
    pub triangles: Vec<[u32; 3]>,
    /// Deviation of every vertex, nm; NaN outside the aperture or without a fit.
    pub deviations_nm: Vec<f64>,
    /// The deviation on a regular grid of the measured frame; `None` without a fit or without area.
    pub map: Option<DeviationMap>,
}

/// A deviation map on a regular grid.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviationMap {
    /// The nodes, measured frame.
    pub grid: Grid,
    /// Deviation at every node, nm, x fastest; NaN where nothing was measured.
    pub values_nm: Vec<f64>,
}

pub(super) fn measure(mesh: &Mesh, part: &Part, mut points: Points) -> Measurement {
    let result = fit(mesh.points(), &part.nominal, &fit_settings(part));
    let pose = result.as_ref().map(|fit| fit.pose).unwrap_or_default();
    let survey = figures::survey(mesh, part, &pose);
    let sampling = figures::sampling(mesh, &survey);
    let (deviations_mm, found) = match &result {
        Ok(fit) => deviation(mesh, part, fit),
        Err(_) => (vec![f64::NAN; mesh.points().len()], None),
    };
    if let Ok(fit) = &result {
        points.used = fit.used as u64;
        for (flag, count) in [
            (Flags::OUTSIDE_APERTURE, fit.excluded.outside_aperture),
            (Flags::OUT_OF_RANGE, fit.excluded.outside_domain),
        ] {
            if count > 0 {
                *points.flagged.entry(name(flag).to_owned()).or_default() += count as u64;
            }
        }
    }
    let form = result
        .as_ref()
        .ok()
        .zip(found.as_ref())
        .map(|(fit, found)| figures::form(part, fit, found));
    let mut verdict = judge(part, found.as_ref());
    match &result {
        Err(error) => verdict.reasons.push(format!("no fit: {error}")),
        Ok(fit) if !fit.termination.is_converged() => {
            undecide(
                &mut verdict,
                format!("the fit did not converge: {}", figures::termination(&fit.termination)),
            );
        }
        Ok(_) => {}
    }
    if let Some(coverage) = sampling.coverage.filter(|coverage| *coverage < part.coverage_min) {
        undecide(
            &mut verdict,
            format!(
                "only {:.1} % of the aperture is sampled densely enough, {:.1} % are wanted",
                100.0 * coverage,
                100.0 * part.coverage_min
            ),
        );
    }
    if !mesh.projectable() {
        let conflicts = mesh.counts().conflicts;
        undecide(
            &mut verdict,
            format!("not projectable: {conflicts} points stand above or below others"),
        );
    }
    let deviations_nm: Vec<f64> = deviations_mm.iter().map(|deviation| deviation * 1e6).collect();
    let map = form.as_ref().and_then(|_| deviation_map(mesh, &survey, &deviations_nm));
    Measurement {
        report: Report {
            format: FORMAT.to_owned(),
            points,
            mesh: figures::mesh(mesh, mesh.area().lifted_mm2),
            sampling,
            form,
            verdict,
            links: Vec::new(),
            timing: Timing::default(),
            session: None,
        },
        points_mm: mesh.points().to_vec(),
        triangles: mesh.triangles().collect(),
        deviations_nm,
        map,
    }
}

/// A pass becomes undecided; a fail stands, for what is measured already breaks a limit.
pub(crate) fn undecide(verdict: &mut Verdict, reason: String) {
    if verdict.status == Status::Pass {
        verdict.status = Status::Undecided;
    }
    verdict.reasons.push(reason);
}

/// Deviations in mm, NaN outside the aperture, and their figures.
fn deviation(mesh: &Mesh, part: &Part, fit: &Fit) -> (Vec<f64>, Option<Figures>) {
    let mut all_mm = deviations(mesh.points(), &fit.nominal, &fit.pose);
    let found = Figures::new(mesh.points(), &all_mm, &fit.pose, &part.aperture);
    for (point, deviation) in mesh.points().iter().zip(&mut all_mm) {
        let [x, y, _] = fit.pose.to_part(*point);
        if !part.aperture.contains(x, y) {
            *deviation = f64::NAN;
        }
    }
    (all_mm, found)
}

fn judge(part: &Part, found: Option<&Figures>) -> Verdict {
    let verdict = verdict(found, &Tolerance { pv_nm: part.pv_nm, rms_nm: part.rms_nm });
    Verdict {
        status: match verdict.status {
            FormStatus::Pass => Status::Pass,
            FormStatus::Fail => Status::Fail,
            FormStatus::Undecided => Status::Undecided,
        },
        checks: verdict
            .checks
            .iter()
            .map(|check| Check {
                name: check.name.to_owned(),
                limit: check.limit,
                value: check.value,
                ok: check.ok,
            })
            .collect(),
        reasons: verdict.reason.map(|reason| reason.to_string()).into_iter().collect(),
    }
}

/// The deviation at nodes as far apart as the points are on average, over well-sampled triangles in the
/// aperture only: a gap is never bridged.
fn deviation_map(mesh: &Mesh, survey: &Survey, deviations_nm: &[f64]) -> Option<DeviationMap> {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for point in mesh.points() {
        for axis in 0..2 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    let size = [high[0] - low[0], high[1] - low[1]];
    let pitch = (size[0] * size[1] / mesh.points().len() as f64).sqrt();
    let pitch = pitch.max(size[0] / MAX_NODES).max(size[1] / MAX_NODES);
    if !(pitch.is_finite() && pitch > 0.0) {
        return None;
    }
    let nodes = |length: f64| (length / pitch).round() as usize + 1;
    let (nx, ny) = (nodes(size[0]).max(2), nodes(size[1]).max(2));
    let grid = Grid {
        x0_mm: low[0],
        y0_mm: low[1],
        dx_mm: size[0] / (nx - 1) as f64,
        dy_mm: size[1] / (ny - 1) as f64,
        nx,
        ny,
    };
    let values_nm = rasterize(mesh.points(), survey.good(), deviations_nm, &grid).ok()?;
    Some(DeviationMap { grid, values_nm })
}

/// Most nodes along one side of a map.
const MAX_NODES: f64 = 1023.0;
