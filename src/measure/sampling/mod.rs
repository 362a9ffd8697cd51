//! How densely a part is sampled: one look at a whole mesh, and what it tells.
//!
//! The figures are those of `asphera_surface::coverage`, made in the plane of projection; the aperture is laid
//! there with the part ([`border`]), and what has a place is turned back into the measured frame. The local
//! feature size is the nominal's ([`meridian`], [`freeform`]), or, without one, that of the points ([`measured`]).

mod border;
mod current;
mod design_spacing;
mod findings;
mod freeform;
mod lfs;
mod measured;
mod meridian;
mod next;
mod noise;
mod places;
mod reach;
mod scale;
mod wanted;
mod zones;

use asphera_form::{Aperture, Nominal, Pose};
use asphera_geometry::{PointMm, RANGE_MM, VertexId};
use asphera_mesh::Mesh;
use asphera_surface::Plane;

pub(crate) use self::current::Current;
pub use self::design_spacing::{DesignSpacing, design_spacing};
use self::findings::Look;
pub(crate) use self::findings::{Findings, differs, in_steps, of_noise};
pub use self::lfs::Remembered;
pub use self::measured::Readings;
pub use self::next::{MOST_PLACES, Next};
pub(crate) use self::noise::HIDDEN;
use self::places::Lifted;
use self::scale::Scale;
pub use self::wanted::Wanted;
pub(crate) use self::zones::ZoneSampling;
use asphera_report::{FeatureFigures, SamplingFigures, Waypoints};

use super::assessment::assess;
use super::defects::{self, Meshed};
use super::folded::still_true;
use super::meshing::Meshing;
use super::projection::{Along, measured as in_measured_frame};
use super::space;
use crate::Part;

/// A mesh in the frame of its plane of projection.
#[derive(Clone, Copy)]
pub struct Sampled<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Its triangles.
    pub triangles: &'a [[VertexId; 3]],
    /// The plane.
    pub plane: &'a Plane,
}

/// The sampling of points of which nothing else is known.
#[derive(Clone, Debug)]
pub struct PointsSampling {
    /// The figures.
    pub figures: SamplingFigures,
    /// Defects, and which way the surface bends.
    pub features: FeatureFigures,
    /// Where to measure next, if anything is known.
    pub waypoints: Option<Waypoints>,
}

/// Says how densely points sample their surface, projected as `along` says. Those that are not finite are left
/// out.
pub fn sampling_of_points(
    points: impl IntoIterator<Item = PointMm>,
    along: Along,
    wanted: Wanted,
) -> PointsSampling {
    let (mesh, triangles, plane, folded) = match Meshing::of(points, along) {
        Meshing::InSpace { points_mm, folded } => {
            return space::sampling(&points_mm, wanted, folded.as_deref());
        }
        Meshing::InPlane { mesh, triangles, plane, folded } => (mesh, triangles, plane, folded),
    };
    let sampled = Sampled { mesh: &mesh, triangles: &triangles, plane: &plane };
    if let Some(folded) = folded {
        let (extents, advice) = still_true(&in_measured_frame(&mesh, &plane));
        let features = defects::not_looked_for(&folded);
        let figures = of_folded(sampled, wanted, vec![folded, extents, advice]).figures;
        return PointsSampling { figures, features, waypoints: None };
    }
    let findings = of_points(sampled, wanted);
    let waypoints = findings.waypoints(sampled);
    let features = defects::of_points(Meshed {
        mesh: &mesh,
        triangles: &triangles,
        plane: &plane,
        pose: None,
        sampling: &findings.figures,
    });
    PointsSampling { figures: findings.figures, features, waypoints }
}

/// The sampling of a mesh in the frame of `plane`, of a part that lies there at `pose`: all that the final
/// report says of it. `remembered` saves the second look at one part what only depends on its nominal.
pub fn sampling_of_mesh(
    mesh: &Mesh,
    part: &Part,
    pose: &Pose,
    plane: &Plane,
    remembered: &mut Remembered,
) -> SamplingFigures {
    assess(mesh, part, pose, plane, remembered).sampling
}

/// Says nothing of the sampling of a surface that does not project but why.
pub(crate) fn of_folded(sampled: Sampled<'_>, wanted: Wanted, unknown: Vec<String>) -> Findings {
    Findings::unknown(sampled, wanted, &Scale::of(sampled, wanted), unknown)
}

/// Looks at the sampling of a part that lies at `pose` in the frame of the plane.
pub(crate) fn of_part(
    sampled: Sampled<'_>,
    part: &Part,
    pose: &Pose,
    remembered: &mut Remembered,
) -> Findings {
    let points = sampled.mesh.points();
    let wanted = Wanted::of(part);
    let scale = Scale::of(sampled, wanted);
    let mut unknown = Vec::new();
    let aperture = match border::laid(&part.aperture, &part.nominal, pose) {
        Ok(aperture) => aperture,
        Err(error) => {
            unknown.push(format!("the aperture cannot be laid into the points: {error}"));
            return Findings::unknown(sampled, wanted, &scale, unknown);
        }
    };
    let counts = |point: PointMm| {
        let [x, y, _] = pose.to_part(point);
        part.aperture.contains(x, y)
    };
    let reach_mm = scale.reach_mm().ok_or_else(|| no_area(sampled.mesh));
    let lifted = Lifted::onto_nominal(*sampled.plane, &part.nominal, pose);
    let known_mm = |place| lifted.height_mm(place);
    let noise = reach_mm
        .clone()
        .and_then(|reach_mm| noise::noise(sampled.mesh, reach_mm, counts, known_mm));
    let readings = noise.as_ref().map(Readings::from).map_err(String::clone);
    let source = remembered
        .look(Some((part, pose)), sampled, readings, reach_mm)
        .map_err(|why| unknown.push(why))
        .ok();
    let reach_mm = remembered.reach_mm(&part.aperture, points, pose);
    let lfs_mm = remembered.lfs_mm(pose);
    let zones = zones::laid(part, pose);
    Look { sampled, wanted, scale, aperture, zones, noise, source, reach_mm, unknown }
        .findings(lfs_mm, &lifted)
}

/// The local feature size of a mesh of these readings, as the sampling report takes it: that of a part at its pose, or
/// of the points. With where it comes from.
///
/// # Errors
///
/// Why it is not known, in words.
pub fn feature_size(
    sampled: Sampled<'_>,
    laid: Option<(&Part, &Pose)>,
    readings: Readings,
) -> Result<(Remembered, &'static str), String> {
    let scale = Scale::of(sampled, Wanted::default());
    let reach_mm = scale.reach_mm().ok_or_else(|| no_area(sampled.mesh));
    let mut remembered = Remembered::default();
    let source = remembered.look(laid, sampled, Ok(readings), reach_mm)?;
    Ok((remembered, source))
}

/// Looks at the sampling of a surface of which nothing is known but the points.
pub(crate) fn of_points(sampled: Sampled<'_>, wanted: Wanted) -> Findings {
    let scale = Scale::of(sampled, wanted);
    let mut unknown = Vec::new();
    let reach_mm = scale.reach_mm().ok_or_else(|| no_area(sampled.mesh));
    let noise = reach_mm
        .clone()
        .and_then(|reach_mm| noise::noise(sampled.mesh, reach_mm, |_| true, |_| 0.0));
    let mut remembered = Remembered::default();
    let readings = noise.as_ref().map(Readings::from).map_err(String::clone);
    let source =
        remembered.look(None, sampled, readings, reach_mm).map_err(|why| unknown.push(why)).ok();
    let pose = Pose::default();
    let reach_mm = remembered.reach_mm(&Aperture::None, sampled.mesh.points(), &pose);
    let lfs_mm = remembered.lfs_mm(&pose);
    let lifted = Lifted::onto_mesh(*sampled.plane, sampled.mesh);
    let (aperture, zones) = (None, Vec::new());
    Look { sampled, wanted, scale, aperture, zones, noise, source, reach_mm, unknown }
        .findings(lfs_mm, &lifted)
}

/// Why the points of a mesh without triangles make no surface.
pub fn no_area(mesh: &Mesh) -> String {
    let counts = mesh.counts();
    match counts.rejected {
        0 => "the points span no area".to_owned(),
        rejected => format!(
            "the points span no area: {rejected} of {} lie farther than {RANGE_MM:e} mm from the origin and were left out. Check the unit of the file, and delete numbers that mean missing points",
            counts.pushed
        ),
    }
}

/// The height of a nominal over a place of the part in mm; beyond its domain that at the end of it, on the
/// way to the axis.
fn height_mm(nominal: &Nominal, [x, y]: [f64; 2]) -> f64 {
    if nominal.is_rotational() {
        return nominal.sag_mm(x.hypot(y).min(nominal.domain_mm()));
    }
    nominal.height_mm(x, y).unwrap_or_else(|| {
        let inwards = (nominal.domain_mm() / x.hypot(y)).min(1.0) * WITHIN;
        nominal.height_mm(x * inwards, y * inwards).unwrap_or(f64::NAN)
    })
}

/// The border of a domain itself may be beyond it by rounding.
const WITHIN: f64 = 1.0 - 1e-12;

/// Triangles of a chunk. Sums over it are part of the result.
const CHUNK: usize = 1 << 14;

#[cfg(test)]
mod tests;
