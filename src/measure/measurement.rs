//! The final figures of one part.

use asphera_form::{Aperture, Figures, Fit, Grid as MapGrid, Pose, deviations};
use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_report::{
    FeatureFigures, FormFigures, Map, MeshFigures, Points, REPORT_FORMAT, Report, SamplingFigures,
    Timing, Verdict,
};
use asphera_surface::Plane;

use super::assessment::{Assessment, assess};
use super::cutting::{FinishedMesh, Setting};
use super::details::areas_mm2;
use super::deviation_map::DeviationMap;
use super::fitting::{Fitted, NoFit, fitted};
use super::inspection::{Inspected, Inspection};
use super::origin;
use super::projection::{Projector, measured};
use super::sampling::{Next, Remembered};
use super::space::{self, Gathered as InSpace};
use super::step::Step;
use super::systematic::Systematic;
use crate::Part;

/// All that is known of a part when its last point has landed.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The figures. Links, timing and session are still empty.
    pub report: Report,
    /// The mesh itself, in the frame of the plane of projection: to be cut, and mapped.
    pub surface: FinishedMesh,
    /// Vertices of the mesh, measured frame, mm.
    pub points_mm: Vec<PointMm>,
    /// Its triangles, counter-clockwise seen from the side the normal of the plane of projection points to:
    /// +z, where nothing else was asked for.
    pub triangles: Vec<[u32; 3]>,
    /// Deviation of every vertex, nm; NaN outside the aperture or without a fit.
    pub deviations_nm: Vec<f64>,
    /// The deviation on a regular grid of the plane of projection; `None` without a fit or without area.
    pub map: Option<DeviationMap>,
    /// The deviation over the cells of the running maps, which it replaces; `None` without a fit.
    pub cells: Option<Map>,
    /// Next measurements; `None` where that is not known.
    pub next: Option<Next>,
}

/// The maps to come.
pub(super) struct Grids {
    /// Their cells.
    pub(super) grid: Option<MapGrid>,
    /// Tells them from earlier ones.
    pub(super) version: u64,
}

/// All that was gathered while points arrived.
pub(super) struct Gathered {
    /// The points, meshed.
    pub(super) mesh: Mesh,
    /// Their counts.
    pub(super) points: Points,
    /// Standard uncertainties of the heights of the vertices, mm, where all have one and they are the weights.
    pub(super) heights_mm: Option<Vec<f64>>,
    /// The maps to come.
    pub(super) grids: Grids,
    /// Local feature sizes found before.
    pub(super) remembered: Remembered,
    /// All points, where they are meshed in space if they fold.
    pub(super) space: Option<InSpace>,
    /// Errors that all points have together.
    pub(super) systematic: Vec<Systematic>,
}

/// The final figures of the points gathered; `begin` hears of each step.
pub(super) fn measure(
    gathered: Gathered,
    mut part: Part,
    projector: &Projector,
    begin: &mut dyn FnMut(Step),
) -> Measurement {
    let Gathered { mesh, mut points, heights_mm, grids, mut remembered, space, systematic } =
        gathered;
    let Grids { grid, version: maps_version } = grids;
    begin(Step::Fit);
    let plane = projector.plane();
    let mut fitted = fitted(mesh.points(), &part, &plane, heights_mm.as_deref());
    if let Ok(Fitted { reference: Some(reference), .. }) = &fitted {
        // What stood in for it has done its part.
        part.nominal = reference.base_nominal();
    }
    let pose = fitted
        .as_ref()
        .map_or_else(|_| origin::start_of(&part, mesh.points()), |fitted| fitted.fit.pose);
    let points_mm = measured(&mesh, &plane);
    begin(Step::Sampling);
    let mut look = assess(&mesh, &part, &pose, &plane, &mut remembered);
    look.finish(&mesh, &points_mm);
    look.mesh.projection = projector.figures();
    // Coverage is that of the aperture of the design; figures are those of the points in the fit.
    if let Ok(fitted) = &fitted {
        part.aperture = fitted.aperture.clone();
    }
    let folded = look.folded.take();
    match (space, &folded) {
        (Some(space), Some(why)) => return space::measure_folded(space, points, part, why, begin),
        (Some(_), None) => look.mesh.decision = Some(space::PROJECTS.to_owned()),
        (None, _) => {}
    }
    if let Some(why) = &folded {
        // A nominal is one height at a place as well: distances to it are those of one sheet at most.
        fitted = Err(NoFit::Folded(why.clone()));
    }
    let result = fitted.as_ref().map(|fitted| &fitted.fit);
    if result.is_err() && folded.is_none() && part.aperture != Aperture::None {
        look.sampling.unknown.push(laid_about(&pose, &plane));
    }
    begin(Step::Deviation);
    let (deviations_mm, found) = match result {
        Ok(fit) => deviation(&mesh, &part, fit),
        Err(_) => (vec![f64::NAN; mesh.points().len()], None),
    };
    if let Ok(fit) = result {
        count(&mut points, fit);
    }
    let areas_mm2 = areas_of(&mesh, &look);
    let inspection = Inspection {
        part: &part,
        mesh: &mesh,
        plane: &plane,
        pose: &pose,
        fitted: fitted.as_ref(),
        look: &look,
        folded: folded.as_deref(),
        deviations_mm: &deviations_mm,
        found: found.as_ref(),
        areas_mm2: &areas_mm2,
        systematic: &systematic,
    };
    let inspected = inspection.figures(grid, begin);
    let points_mm = points_mm.into_owned();
    let setting = Setting {
        part,
        plane,
        lies: fitted.ok().map(|fitted| (fitted.fit.nominal, fitted.fit.pose)),
        gap_limit_mm: look.sampling.gap_limit_mm,
        areas_mm2: areas_mm2.into(),
        grid: inspected.grid,
        maps_version,
        remembered,
        in_space: None,
    };
    let Assessment { triangles, mesh: seen, sampling, next, .. } = look;
    let Inspected { form, features, verdict, deviations_nm, map, cells, .. } = inspected;
    Measurement {
        report: report(points, seen, sampling, features, form, verdict),
        surface: FinishedMesh::new(mesh, setting),
        points_mm,
        triangles,
        deviations_nm,
        map,
        cells,
        next,
    }
}

/// The area that each vertex stands for, of triangles that are sampled densely enough, mm².
fn areas_of(mesh: &Mesh, look: &Assessment) -> Vec<f64> {
    let triangles = look.triangles.iter().zip(&look.covered);
    let covered = triangles.filter_map(|(&corners, &covered)| covered.then_some(corners));
    areas_mm2(mesh.points(), covered)
}

/// Where the aperture was laid: without a fit nobody knows where the part lies.
fn laid_about(pose: &Pose, plane: &Plane) -> String {
    let [x_mm, y_mm, _] = plane.from_plane([pose.tx_mm, pose.ty_mm, 0.0]);
    format!(
        "without a fit the place of the part is unknown: the aperture is centred on x {x_mm:.3}, y {y_mm:.3} mm"
    )
}

/// Counts the points a fit used, and why others were not.
fn count(points: &mut Points, fit: &Fit) {
    points.used = fit.used as u64;
    for (reason, count) in [
        ("outside_aperture", fit.excluded.outside_aperture),
        ("outside_domain", fit.excluded.outside_domain),
    ] {
        if count > 0 {
            *points.flagged.entry(reason.to_owned()).or_default() += count as u64;
        }
    }
}

/// The report without links, timing and session.
pub(super) fn report(
    points: Points,
    mesh: MeshFigures,
    sampling: SamplingFigures,
    features: FeatureFigures,
    form: Option<FormFigures>,
    verdict: Verdict,
) -> Report {
    Report {
        format: REPORT_FORMAT.to_owned(),
        reading: None,
        volume: None,
        points,
        mesh,
        sampling,
        features,
        form,
        profile: None,
        contour: None,
        parts: None,
        verdict,
        links: Vec::new(),
        timing: Timing::default(),
        session: None,
    }
}

/// Deviations in mm, NaN outside the aperture, and their figures.
pub(super) fn deviation(mesh: &Mesh, part: &Part, fit: &Fit) -> (Vec<f64>, Option<Figures>) {
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
