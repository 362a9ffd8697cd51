//! What stands off a part: defects from the deviation where there is a nominal, from the points where there is none.

use asphera_form::Pose;
use asphera_geometry::VertexId;
use asphera_mesh::Mesh;
use asphera_report::{DefectFigures, DefectSearchFigures, FeatureFigures, SamplingFigures};
use asphera_surface::Plane;
use asphera_surface::curvature::Adjacency;
use asphera_surface::defects::{
    Defect, DefectKind, DefectSettings, DefectsUnknown, DeviatingSurface, Samples, find_defects,
    search_defects,
};
use asphera_surface::noise::{Along, Noise};

use super::details::places_mm;
use super::errors::stated_noise_mm;
use super::partition::{self, Patches};
use crate::{DefectLimits, Part};

/// A meshed part, in the frame of its plane of projection.
#[derive(Clone, Copy)]
pub(crate) struct Meshed<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) triangles: &'a [[VertexId; 3]],
    pub(crate) plane: &'a Plane,
    /// Where the part lies in that frame; `None` without a part.
    pub(crate) pose: Option<&'a Pose>,
    /// Figures of its sampling.
    pub(crate) sampling: &'a SamplingFigures,
}

/// The defects of a part, and which way it bends. `deviations_mm` are those of the vertices, NaN outside the aperture,
/// or why there are none.
///
/// Takes some 40 ns a vertex where there are few defects.
pub(crate) fn of_part(
    meshed: Meshed<'_>,
    part: &Part,
    deviations_mm: Result<&[f64], String>,
) -> FeatureFigures {
    let counts = |vertex: usize| deviations_mm.as_ref().is_ok_and(|all| all[vertex].is_finite());
    let noise = meshed.noise().or_else(|| stated_noise(part));
    let mut figures = partition::figures(
        Patches::new(meshed.mesh.points(), counts),
        noise,
        part.flat_below_per_mm,
    );
    let searched = match (&part.defects, deviations_mm) {
        (None, _) => Err("not wanted: the nominal says defects = false".to_owned()),
        (Some(_), Err(why)) => Err(why),
        (Some(limits), Ok(deviations_mm)) => meshed.by_deviation(limits, deviations_mm, noise),
    };
    told(&mut figures, searched, part.defects.as_ref(), meshed.plane);
    figures
}

/// The defects of a mesh in the frame of `plane`, and which way it bends: all that the final report says of them.
/// `deviations_mm` are those of its vertices, `pose` is where the part lies, `sampling` what is known of it.
pub fn features_of_mesh(
    mesh: &Mesh,
    part: &Part,
    deviations_mm: &[f64],
    (plane, pose): (&Plane, &Pose),
    sampling: &SamplingFigures,
) -> FeatureFigures {
    let triangles = &mesh.triangles();
    let meshed = Meshed { mesh, triangles, plane, pose: Some(pose), sampling };
    of_part(meshed, part, Ok(deviations_mm))
}

/// The same of points of which nothing else is known.
///
/// Takes two to three times as long as their mesh.
pub(crate) fn of_points(meshed: Meshed<'_>) -> FeatureFigures {
    let noise = meshed.noise();
    let patches = Patches::new(meshed.mesh.points(), |_| true);
    let mut figures = partition::figures(patches, noise, crate::FLAT_BELOW_PER_MM);
    let limits = DefectLimits::default();
    told(&mut figures, meshed.by_points(&limits, noise), Some(&limits), meshed.plane);
    figures
}

/// Features of a surface of which none are looked for, with the reason.
pub(crate) fn not_looked_for(why: &str) -> FeatureFigures {
    FeatureFigures {
        defects_unknown: Some(why.to_owned()),
        partition_unknown: Some(why.to_owned()),
        ..FeatureFigures::default()
    }
}

/// Result of a search.
struct Searched {
    defects: Vec<Defect>,
    by: DefectSearchFigures,
}

impl Meshed<'_> {
    /// The noise of the heights, if it is known.
    fn noise(&self) -> Option<Noise> {
        Noise::new(1e-6 * self.sampling.noise_sigma_nm?, Along::Z).ok()
    }

    /// The distance points have: of half of the surface, or on average over the hull.
    fn spacing_mm(&self) -> Option<f64> {
        let (area_mm2, points) = (self.mesh.area().projected_mm2, self.mesh.points().len());
        let spacing_mm =
            self.sampling.spacing_median_mm.unwrap_or_else(|| (area_mm2 / points as f64).sqrt());
        (spacing_mm > 0.0 && spacing_mm.is_finite()).then_some(spacing_mm)
    }

    fn by_deviation(
        &self,
        limits: &DefectLimits,
        deviations_mm: &[f64],
        noise: Option<Noise>,
    ) -> Result<Searched, String> {
        let spacing_mm = self.spacing_mm().ok_or("the points span no area")?;
        let about_mm = self.pose.map(|pose| places_mm(pose, self.mesh.points()));
        let surface = DeviatingSurface {
            points: self.mesh.points(),
            triangles: self.triangles,
            deviations_mm,
            places_mm: about_mm.as_deref(),
            spacing_mm,
            reach_mm: REACH * spacing_mm,
        };
        let found =
            search_defects(&surface, &settings(limits, noise)?).map_err(|why| told_why(&why))?;
        let by = DefectSearchFigures {
            reference: "nominal".to_owned(),
            window_mm: found.window_mm,
            largest_mm: found.largest_mm,
            sigma_nm: 1e6 * found.sigma_mm,
            threshold_sigmas: found.threshold,
            false_expected: limits.false_expected,
            min_height_nm: limits.min_height_nm,
            lower: 0,
            points: found.vertices,
            points_unknown: found.unreferenced,
        };
        Ok(Searched { defects: found.defects, by })
    }

    fn by_points(&self, limits: &DefectLimits, noise: Option<Noise>) -> Result<Searched, String> {
        let points = self.mesh.points();
        let spacing_mm = self.spacing_mm().ok_or("the points span no area")?;
        let adjacency = Adjacency::new(points, self.triangles, Some(REACH * spacing_mm))
            .map_err(|why| why.to_string())?;
        let samples = Samples {
            points,
            triangles: self.triangles,
            adjacency: &adjacency,
            deviations_mm: None,
        };
        let found =
            find_defects(&samples, &settings(limits, noise)?).map_err(|why| told_why(&why))?;
        let by = DefectSearchFigures {
            reference: "points".to_owned(),
            window_mm: found.window_mm,
            largest_mm: found.largest_mm,
            sigma_nm: 1e6 * found.sigma_mm,
            threshold_sigmas: found.threshold,
            false_expected: limits.false_expected,
            min_height_nm: limits.min_height_nm,
            lower: 0,
            points: points.len() as u64,
            points_unknown: found.unreferenced,
        };
        Ok(Searched { defects: found.defects, by })
    }
}

/// The noise that the nominal file states for every point.
fn stated_noise(part: &Part) -> Option<Noise> {
    Noise::new(stated_noise_mm(part)?, Along::Z).ok()
}

fn settings(limits: &DefectLimits, noise: Option<Noise>) -> Result<DefectSettings, String> {
    let mut settings = DefectSettings::default()
        .with_false_expected(limits.false_expected)
        .map_err(|error| error.to_string())?;
    if let Some(largest_mm) = limits.largest_mm {
        settings = settings.with_largest_mm(largest_mm).map_err(|error| error.to_string())?;
    }
    Ok(match noise {
        Some(noise) => settings.with_noise(noise),
        None => settings,
    })
}

fn told_why(why: &DefectsUnknown) -> String {
    asphera_report::error_chain(why)
}

/// Adds what a search gave: the most significant, as far as they are high enough, and how many more there are.
fn told(
    figures: &mut FeatureFigures,
    searched: Result<Searched, String>,
    limits: Option<&DefectLimits>,
    plane: &Plane,
) {
    let limits = limits.copied().unwrap_or_default();
    match searched {
        Err(why) => figures.defects_unknown = Some(why),
        Ok(Searched { mut defects, mut by }) => {
            let all = defects.len();
            defects.retain(|defect| 1e6 * defect.height_mm.abs() >= limits.min_height_nm);
            by.lower = (all - defects.len()) as u64;
            figures.defects_more = defects.len().saturating_sub(limits.listed) as u64;
            let listed = defects.iter().take(limits.listed);
            figures.defects = Some(listed.map(|defect| defect_figures(defect, plane)).collect());
            figures.defects_search = Some(by);
        }
    }
}

fn defect_figures(defect: &Defect, plane: &Plane) -> DefectFigures {
    let orientation_deg = defect.direction.map(|[x, y]| {
        let degrees = y.atan2(x).to_degrees();
        // A rounded remainder may reach the turn itself.
        match defect.kind {
            DefectKind::Step => degrees.rem_euclid(360.0) % 360.0,
            _ => degrees.rem_euclid(180.0) % 180.0,
        }
    });
    DefectFigures {
        kind: kind(defect.kind).to_owned(),
        shape: shape(defect).to_owned(),
        at_mm: plane.from_plane(defect.centre_mm),
        height_nm: 1e6 * defect.height_mm,
        height_u_nm: 1e6 * defect.height_uncertainty_mm,
        area_mm2: defect.area_mm2,
        area_u_mm2: defect.area_uncertainty_mm2,
        length_mm: defect.length_mm,
        width_mm: defect.width_mm,
        orientation_deg,
        volume_um3: defect.volume_mm3.map(|volume_mm3| 1e9 * volume_mm3),
        points: defect.vertices,
        on_border: defect.on_border,
        significance: defect.significance,
    }
}

fn kind(kind: DefectKind) -> &'static str {
    match kind {
        DefectKind::Pit => "pit",
        DefectKind::Bump => "bump",
        DefectKind::Scratch => "scratch",
        DefectKind::Ridge => "ridge",
        DefectKind::Step => "step",
        DefectKind::Spike => "spike",
    }
}

fn shape(defect: &Defect) -> &'static str {
    match defect.kind {
        DefectKind::Spike => "point",
        DefectKind::Scratch | DefectKind::Ridge | DefectKind::Step => match defect.direction {
            Some(_) => "straight",
            None => "bent",
        },
        DefectKind::Pit | DefectKind::Bump => {
            let ratio = defect.length_mm.zip(defect.width_mm).map(|(length, width)| length / width);
            if ratio.is_some_and(|ratio| ratio >= LONG) { "long" } else { "round" }
        }
    }
}

/// The length of an edge that bridges a gap, in distances of the points: as for their sampling.
const REACH: f64 = 6.0;
/// Length over width from which on a pit is called long.
const LONG: f64 = 1.5;

#[cfg(test)]
mod tests;
