//! Sections: the lines in which a lifted mesh is cut, and the figures of their profiles.
//!
//! A path in the plane of projection stands for the vertical surface above it: a segment or a
//! radius for a plane, a circle for a cylinder. Where that surface cuts the triangles, lifted to
//! their heights, lies the section. It is found by going from triangle to triangle along the path
//! ([`section`]), so it takes time in proportion to the triangles met and not to those of the mesh,
//! and is to be had while the mesh still grows. A plane of any direction may cut the mesh in many
//! places; to find them all, all triangles are looked at ([`cut`]). So are facets of a surface in space
//! ([`cut_facets`]).
//!
//! Which triangles and sides a path meets is decided exactly. So where it runs through vertices or
//! along edges, as every other section of a raster does, nothing is lost and nothing comes twice.
//! Places and heights are rounded.
//!
//! Nothing is bridged. Where the path leaves the mesh, or crosses a triangle that the caller does
//! not hold to be surface, the section is broken, and each piece says why it begins and ends.

mod arcs;
mod circle;
mod circle_fit;
mod disc;
mod error;
mod line;
mod normal_equations;
mod pieces;
mod plane;
mod polynomial_fit;
mod profile;
mod walk;

use asphera_geometry::predicates::Place;
use asphera_geometry::{PointMm, Triangle, VertexId, admit, place};
use asphera_mesh::Mesh;

pub use self::circle_fit::CircleFit;
pub use self::error::SectionError;
use self::pieces::Builder;
pub use self::pieces::{Limit, Piece, Section, SectionPoint, Source};
pub use self::plane::{CuttingPlane, cut, cut_facets};
pub use self::polynomial_fit::{MAX_DEGREE, PolynomialFit};
pub use self::profile::{Profile, ProfileError, ProfileFigures, Sample};

/// A line in the plane of projection along which a mesh is cut. Lengths in mm, angles in rad,
/// counter-clockwise from the direction of x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SectionPath {
    /// From one place to another.
    Segment {
        /// Where it starts: x and y in mm.
        from_mm: [f64; 2],
        /// Where it ends: x and y in mm.
        to_mm: [f64; 2],
    },
    /// Once around, counter-clockwise.
    Circle {
        /// Its centre: x and y in mm.
        centre_mm: [f64; 2],
        /// Its radius in mm, above 0.
        radius_mm: f64,
        /// Where on it the section starts and ends.
        start_rad: f64,
    },
    /// From a centre outwards, as far as the mesh reaches.
    Radius {
        /// The centre: x and y in mm.
        centre_mm: [f64; 2],
        /// The direction. Multiples of a quarter turn, rounded as they are, are taken as exact.
        angle_rad: f64,
    },
}

/// The section of a mesh along a path, broken where a triangle has a gap above `gap_limit_mm` (as
/// in [`crate::assess`], though thin triangles along the outline are judged by their own gap alone).
/// Without a limit it is broken only where the path lies outside the convex hull.
///
/// The arc position of its points is the distance from the start along the path in the plane. The
/// points are the crossings with the edges of the mesh; on a circle more are set in between, so that
/// no two are more than a degree apart, since the section of a triangle is not straight there.
///
/// Points that wait to be inserted take no part. A path that meets no triangle gives no pieces, and
/// where it only touches the mesh at one place there is none either. Takes as long as
/// [`Mesh::locate`] and a look at the neighbours of each vertex the path passes; where it starts
/// outside the mesh, or a circle leaves it, also a walk along the hull.
///
/// # Errors
///
/// If the path has no length or no direction, or a number is not finite or out of range.
///
/// ```
/// use asphera_surface::sections::{SectionPath, section};
/// use asphera_mesh::Mesh;
///
/// let mut mesh = Mesh::new();
/// mesh.insert(&[[0.0, 0.0, 0.0], [2.0, 0.0, 2.0], [0.0, 2.0, 4.0]]);
/// let path = SectionPath::Segment { from_mm: [0.5, 0.5], to_mm: [5.0, 0.5] };
/// let found = section(&mesh, &path, None)?;
/// let [start, end] = found.pieces[0].points[..] else { panic!("there are two") };
/// assert_eq!((start.s_mm, start.at_mm), (0.0, [0.5, 0.5, 1.5]));
/// assert_eq!((end.s_mm, end.at_mm), (1.0, [1.5, 0.5, 2.5]));
/// # Ok::<(), asphera_surface::sections::SectionError>(())
/// ```
pub fn section(
    mesh: &Mesh,
    path: &SectionPath,
    gap_limit_mm: Option<f64>,
) -> Result<Section, SectionError> {
    let within = within_gap(mesh.points(), gap_limit_mm)?;
    section_where(mesh, path, within)
}

/// The same, broken where a triangle is not kept. `keep` is asked about each triangle met, at most
/// some times; its corners are given as in [`Mesh::triangles`].
///
/// A section along an edge is kept if one of the triangles beside it is.
///
/// # Errors
///
/// As [`section`].
pub fn section_where(
    mesh: &Mesh,
    path: &SectionPath,
    keep: impl FnMut([VertexId; 3]) -> bool,
) -> Result<Section, SectionError> {
    let mut builder = Builder::new(mesh.points(), keep);
    match *path {
        SectionPath::Segment { from_mm, to_mm } => {
            let [from, to] =
                [("start of the section", from_mm), ("end of the section", to_mm)].map(admitted);
            let (from, to) = (from?, to?);
            if from == to {
                return Err(SectionError::ZeroLength { at_mm: from });
            }
            line::trace(mesh, &line::Way::segment(from, to), &mut builder);
        }
        SectionPath::Radius { centre_mm, angle_rad } => {
            let from = admitted(("centre of the radius", centre_mm))?;
            let direction = direction(angle_rad)?;
            line::trace(mesh, &line::Way::ray(from, direction), &mut builder);
        }
        SectionPath::Circle { centre_mm, radius_mm, start_rad } => {
            let centre = admitted(("centre of the circle", centre_mm))?;
            let start = direction(start_rad)?;
            let disc = disc::Disc::new(centre, radius_mm)?;
            arcs::lay_out(mesh, &disc, start, start_rad, &mut builder);
        }
    }
    Ok(builder.finish())
}

/// Whether the gap of a triangle is within a limit.
pub(crate) fn within_gap(
    points: &[PointMm],
    gap_limit_mm: Option<f64>,
) -> Result<impl Fn([VertexId; 3]) -> bool + '_, SectionError> {
    if let Some(limit_mm) = gap_limit_mm
        && !(limit_mm.is_finite() && limit_mm > 0.0)
    {
        return Err(SectionError::GapLimit { limit_mm });
    }
    Ok(move |corners| {
        gap_limit_mm.is_none_or(|limit_mm| Triangle::new(points, corners).gap().mm <= limit_mm)
    })
}

fn admitted((what, at_mm): (&'static str, [f64; 2])) -> Result<Place, SectionError> {
    admit([at_mm[0], at_mm[1], 0.0]).map(place).map_err(|rejection| SectionError::Place {
        what,
        at_mm,
        rejection,
    })
}

/// The unit vector of an angle. A component of the size of the angle's own rounding is zero.
fn direction(angle_rad: f64) -> Result<[f64; 2], SectionError> {
    if !(-MAX_ANGLE_RAD..=MAX_ANGLE_RAD).contains(&angle_rad) {
        return Err(SectionError::Angle { angle_rad });
    }
    let (sin, cos) = angle_rad.sin_cos();
    let rounding = f64::EPSILON * angle_rad.abs().max(1.0);
    Ok([cos, sin].map(|component| if component.abs() < rounding { 0.0 } else { component }))
}

/// Some hundred turns: beyond, the rounding of the angle itself would show.
const MAX_ANGLE_RAD: f64 = 1000.0;
