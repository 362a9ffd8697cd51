//! The final figures of one part.

use asphera_form::figures::Sample;
use asphera_form::verdict::{Limit, forecast};
use asphera_form::{Aperture, Figures, Fit, Grid as MapGrid, Parameter, deviations};
use asphera_geometry::PointMm;
use asphera_mesh::Mesh;

use super::correlated;
use super::cutting::{FinishedMesh, Setting};
use super::defects::{self, Meshed};
use super::design::Design;
use super::details::{Indicated, areas_mm2, details, places_mm, sample};
use super::deviation_map::DeviationMap;
use super::errors::Errors;
use super::figures;
use super::fitting::{Fitted, NoFit, fitted};
use super::heights::Heights;
use super::judgement::{compare, judge};
use super::look::{Look, look};
use super::origin;
use super::projection::{Projector, measured};
use super::removal::cells_of;
use super::sampling::{Next, Remembered};
use super::standards::{self, Measured};
use super::step::Step;
use super::uncertainties::{self, assess, tell};
use super::unmeasured::{Laid, Unmeasured};
use crate::config::Part;
use crate::report::{FORMAT, Points, Report, Timing};
use crate::snapshot::Map;

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
    /// What to measure next; `None` where that is not known.
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
    /// How well their heights are known.
    pub(super) heights: Heights,
    /// The maps to come.
    pub(super) grids: Grids,
    /// Local feature sizes found before.
    pub(super) remembered: Remembered,
}

/// The final figures of the points gathered; `begin` hears of each step.
pub(super) fn measure(
    gathered: Gathered,
    mut part: Part,
    projector: &Projector,
    begin: &mut dyn FnMut(Step),
) -> Measurement {
    let Gathered { mesh, mut points, mut heights, grids, mut remembered } = gathered;
    let Grids { grid, version: maps_version } = grids;
    begin(Step::Fit);
    let plane = projector.plane();
    let mut fitted = fitted(mesh.points(), &part, &plane, &mut heights);
    if let Ok(Fitted { reference: Some(reference), .. }) = &fitted {
        // What stood in for it has done its part.
        part.nominal = reference.base_nominal();
    }
    let pose = fitted
        .as_ref()
        .map_or_else(|_| origin::start_of(&part, mesh.points()), |fitted| fitted.fit.pose);
    let points_mm = measured(&mesh, &plane);
    begin(Step::Sampling);
    let mut look = look(&mesh, &part, &pose, &plane, &mut remembered);
    look.finish(&mesh, &points_mm);
    look.mesh.projection = projector.figures();
    let folded = look.folded.take();
    if let Some(why) = &folded {
        // A nominal is one height at a place as well: distances to it are those of one sheet at most.
        fitted = Err(NoFit::Folded(why.clone()));
    }
    let result = fitted.as_ref().map(|fitted| &fitted.fit);
    if result.is_err() && folded.is_none() && part.aperture != Aperture::None {
        let [x_mm, y_mm, _] = plane.from_plane([pose.tx_mm, pose.ty_mm, 0.0]);
        let why = format!(
            "where the part lies is not known, as there is no fit: its aperture is laid about x {x_mm:.3}, y {y_mm:.3} mm"
        );
        look.sampling.unknown.push(why);
    }
    let Look { triangles, covered, mesh: seen, sampling, zones, next, .. } = look;
    begin(Step::Deviation);
    let (deviations_mm, found) = match result {
        Ok(fit) => deviation(&mesh, &part, fit),
        Err(_) => (vec![f64::NAN; mesh.points().len()], None),
    };
    if let Ok(fit) = result {
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
    let well_sampled = triangles
        .iter()
        .zip(&covered)
        .filter_map(|(&corners, &covered)| covered.then_some(corners));
    let areas_mm2 = areas_mm2(mesh.points(), well_sampled);
    let taken = fitted.as_ref().ok().and_then(|fitted| {
        uncertainties::taken(&part, mesh.points(), &deviations_mm, fitted, &areas_mm2)
    });
    let assessed = fitted
        .as_ref()
        .ok()
        .and_then(|fitted| assess(&part, mesh.points(), fitted, &plane, taken.as_ref()));
    let mut errors = Errors::new(&part);
    let known = match &part.judging.uncertainty {
        Some(_) => None,
        None => {
            errors.look(&part, mesh.points(), &plane, sampling.noise_sigma_nm);
            let known = found.as_ref().and_then(|found| errors.of(found));
            known.map(|known| taken.as_ref().map_or(known, |taken| known.over(taken)))
        }
    };
    let noise_nm = match &assessed {
        Some(assessed) => assessed.as_ref().ok().map(|of| of.uncertainty.noise.sigma_mm * 1e6),
        None => errors.noise_nm(),
    };
    let sample = sample(&part, &pose, mesh.points(), &deviations_mm, &areas_mm2);
    let design =
        fitted.as_ref().ok().and_then(|fitted| Design::new(&part, &mesh, fitted, &areas_mm2));
    let mut form = fitted.as_ref().ok().zip(found.as_ref()).map(|(fitted, found)| {
        let indicated = match &design {
            Some(design) => design.as_ref().map_err(Clone::clone).and_then(Design::indicated),
            None => sample.as_ref().map_err(ToString::to_string).map(|sample| Indicated {
                sample,
                nominal: &fitted.fit.nominal,
                from_design: false,
            }),
        };
        let details = details(&part, &sample, indicated, &areas_mm2, found.rms_nm, noise_nm);
        figures::form(&part, fitted, found, details, &plane)
    });
    begin(Step::Standards);
    // Without a fit no deviation is known.
    let counted = result.ok().and(sample.as_ref().ok());
    let grid = grid.map(|grid| counted.map_or(grid, |sample| grid_of(sample, &part, grid)));
    let cells = grid.as_ref().zip(counted).map(|(grid, sample)| cells_of(sample, grid));
    let deviations_nm: Vec<f64> = deviations_mm.iter().map(|deviation| deviation * 1e6).collect();
    let map =
        form.as_ref().and_then(|_| DeviationMap::of(&mesh, (&triangles, &covered), &deviations_nm));
    let mut of_standards = standards::Found::default();
    if let (Some(form), Ok(fit)) = (&mut form, result) {
        let measured = Measured {
            part: &part,
            fit,
            points: mesh.points(),
            deviations_mm: &deviations_mm,
            triangles: &triangles,
            covered: &covered,
            areas_mm2: &areas_mm2,
            map: map.as_ref(),
            noise_nm,
        };
        of_standards = standards::add(form, &measured);
    }
    if let (Some(form), Some(Ok(assessed))) = (&mut form, &assessed) {
        tell(form, assessed, &part);
        standards::tell(form, &of_standards, assessed, &part);
    }
    if let (Some(form), Ok(fitted)) = (&mut form, &fitted) {
        let assessed = assessed.as_ref().and_then(|assessed| assessed.as_ref().ok());
        correlated::tell(form, &part, fitted, (mesh.points(), &deviations_mm), assessed);
    }
    let unmeasured_of = |fit: Option<&Fit>, deviations_mm: &[f64], found: Option<&Figures>| {
        if let (Some(fit), Some(found)) = (fit, found) {
            let places_mm = places_mm(&fit.pose, mesh.points());
            let laid = Laid {
                places_mm: &places_mm,
                deviations_mm,
                sampling: &sampling,
                zones: &zones,
                most_bent: usize::MAX,
            };
            let free: Vec<Parameter> =
                fit.estimates.iter().map(|estimate| estimate.parameter).collect();
            let missing = sampling.coverage.map(|coverage| 1.0 - coverage);
            // Where nothing is missing there is nothing to foresee.
            let forecast = missing.filter(|missing| *missing > 0.0).and_then(|missing| {
                let (nominal, pose) = (&fit.nominal, &fit.pose);
                forecast(
                    &places_mm,
                    deviations_mm,
                    &part.aperture,
                    nominal,
                    pose,
                    &free,
                    Some(missing),
                )
            });
            let limits: Vec<&Limit> = part.judging.limits.iter().map(|(_, limit)| limit).collect();
            Unmeasured::of(&part, &limits, &laid, found.rms_nm, forecast.as_ref())
        } else {
            Unmeasured::default()
        }
    };
    begin(Step::Unmeasured);
    let unmeasured = unmeasured_of(result.as_ref().ok().copied(), &deviations_mm, found.as_ref());
    let of_design = design.as_ref().and_then(|design| design.as_ref().ok());
    let unmeasured_of_design = of_design.map(|design| {
        unmeasured_of(Some(design.fit), &design.deviations_mm, design.found.as_ref())
    });
    if let Some(form) = &mut form {
        if let Some(known) = &known {
            uncertainties::tell_noise(form, known);
        } else if form.deviation.uncertainty.is_none() {
            form.unknown.push("uncertainties: the noise of the points is not known".to_owned());
        }
        form.deviation.unmeasured = Some(unmeasured.figures());
    }
    begin(Step::Defects);
    let meshed = Meshed { mesh: &mesh, triangles: &triangles, plane: &plane, sampling: &sampling };
    let deviating = form.as_ref().map(|_| &deviations_mm[..]);
    let features = match &folded {
        Some(why) => defects::of_folded(why),
        None => defects::of_part(meshed, &part, deviating.ok_or("there is no fit".to_owned())),
    };
    begin(Step::Verdict);
    let mut without_form = Vec::new();
    let figures = form.as_mut().map_or(&mut without_form, |form| &mut form.figures);
    let mut compared = match &assessed {
        None => compare(&part, found.as_ref(), known.as_ref(), &unmeasured),
        Some(Ok(assessed)) => {
            let hidden = unmeasured_of_design.as_ref().unwrap_or(&unmeasured);
            uncertainties::compare(
                &part,
                assessed,
                Some(&areas_mm2),
                [&unmeasured, hidden],
                figures,
            )
        }
        Some(Err(error)) => uncertainties::unknown(error),
    };
    let noise_dof = assessed.as_ref().and_then(|assessed| assessed.as_ref().ok());
    let noise_dof = noise_dof.map_or(f64::INFINITY, |of| of.uncertainty.noise.dof);
    standards::hold(&mut compared, &part, form.as_ref(), noise_dof, &unmeasured);
    let verdict = judge(compared, &part, &mesh, fitted.as_ref(), &seen, &sampling);
    let points_mm = points_mm.into_owned();
    let setting = Setting {
        part,
        plane,
        lies: fitted.ok().map(|fitted| (fitted.fit.nominal, fitted.fit.pose)),
        gap_limit_mm: sampling.gap_limit_mm,
        areas_mm2: areas_mm2.into(),
        grid,
        maps_version,
        remembered,
    };
    Measurement {
        report: Report {
            format: FORMAT.to_owned(),
            reading: None,
            points,
            mesh: seen,
            sampling,
            features,
            form,
            profile: None,
            verdict,
            links: Vec::new(),
            timing: Timing::default(),
            session: None,
        },
        surface: FinishedMesh::new(mesh, setting),
        points_mm,
        triangles,
        deviations_nm,
        map,
        cells,
        next,
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

/// The cells of the maps: without an aperture those of the running maps lie where the points had come to, about another
/// origin.
fn grid_of(sample: &Sample, part: &Part, grid: MapGrid) -> MapGrid {
    let side_mm = |axis: usize| {
        sample.places_mm().iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], place| {
            [low.min(place[axis]), high.max(place[axis])]
        })
    };
    let ([x_min_mm, x_max_mm], [y_min_mm, y_max_mm]) = (side_mm(0), side_mm(1));
    if part.aperture != Aperture::None || x_min_mm >= x_max_mm || y_min_mm >= y_max_mm {
        return grid;
    }
    MapGrid { x_min_mm, x_max_mm, y_min_mm, y_max_mm, ..grid }
}
