//! How much of an aperture is covered by samples, and what to measure next.
//!
//! **Covered** is the area of the aperture whose places lie on the mesh and are no farther from their nearest sample
//! than the target allows (for gap and ε see [`crate::assess`]). **Undersampled** are places that
//! are farther, where the surface was scanned all the same: at one of the corners of their triangle at least, samples
//! are about as far apart as here. **Uncovered** is all the rest: what lies outside the hull of the
//! mesh, and places beyond the target in triangles that bridge what nobody scanned, whose gap is above the target and more
//! than three times the smallest gap at each of their corners. A stripe scanned too coarsely is
//! undersampled, a hole in a fine scan is uncovered, whatever the target. The three add up to the area
//! of the aperture.
//!
//! The area of a triangle inside the aperture is exact but for rounding. How much of it lies within the target follows
//! from its sides (see `nearness.rs`), and for a triangle across the border of the aperture from the share of it inside.
//!
//! **Regions.** Triangles with places that are not covered are joined across the sides they share inside the
//! aperture, and so is what lies outside the hull. A region smaller than one square of the spacing it
//! needs is not listed but counted in the remainder. A region reaches to the outermost samples of what is
//! covered, so its area is larger than that of its places beyond the target. Regions are drawn as polygons on a border that
//! runs inside a circle by up to 1e-5 of its radius, else by some 1e-9 of the size; their areas are
//! sums over triangles.
//!
//! **Without an aperture** the outline of the data stands in: the mesh without the bridges that
//! reach to its hull. What is missing at the edge of a part then cannot be told from what is not part
//! of it, and is not counted; holes inside are.
//!
//! The gap outside the hull is not known: how far the farthest place there is from all samples is
//! left out of the figures of gap and ε.

mod aperture;
mod block;
mod border;
mod bridges;
mod clip;
mod clipped_gap;
mod density;
mod draw;
mod examine;
mod facet_median;
mod frame;
mod gauge;
mod nearer;
mod patches;
mod percentiles;
mod plan;
mod polygon;
mod regions;
mod tally;
mod target;
mod without;

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::Mesh;
use thiserror::Error;

pub use self::aperture::{Aperture, ApertureError};
pub use self::density::{Dense, Density};
use self::examine::Meshed;
pub use self::patches::Patch;
pub use self::percentiles::Spread;
pub use self::plan::{
    Completion, PlanError, Progress, Waypoint, completion, waypoints, write_waypoints,
};
pub use self::polygon::{Polygon, Ring};
pub use self::target::{Reach, Spacing, Target, TargetError};
use crate::outline::IslandCounts;
use crate::rim::Rim;

/// What the areas of a coverage refer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The aperture that was given.
    Aperture,
    /// The outline of the data, as no aperture was given.
    DataOutline,
}

/// The areas of a coverage, in the plane, in mm². The first is the sum of the next three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoveredAreas {
    /// Of the aperture.
    pub aperture_mm2: f64,
    /// Covered: no farther from the nearest sample than the target allows.
    pub covered_mm2: f64,
    /// Farther, though scanned.
    pub undersampled_mm2: f64,
    /// Farther, and not scanned.
    pub uncovered_mm2: f64,
    /// The part of what is not covered where that is only because its local feature size, which the
    /// target needs, is not known.
    pub lfs_unknown_mm2: f64,
}

/// How many triangles with a part in the aperture are what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CoverageCounts {
    /// Within the target.
    pub covered: u64,
    /// Beyond the target, on the surface.
    pub undersampled: u64,
    /// Beyond the target, across what was not scanned.
    pub bridging: u64,
}

/// How much of an aperture is covered, and the regions that are not.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// What the areas refer to.
    pub reference: Reference,
    /// The areas; none if there is neither an aperture nor a triangle.
    pub areas: Option<CoveredAreas>,
    /// How many triangles there are.
    pub triangles: CoverageCounts,
    /// Gaps of places in mm, by area in space inside the aperture; none without triangles there.
    pub gap_mm: Option<Spread>,
    /// Where the largest gap is.
    pub gap_max_at_mm: Option<PointMm>,
    /// ε of places where the local feature size is known, by area.
    pub epsilon: Option<Spread>,
    /// Where the largest ε is.
    pub epsilon_max_at_mm: Option<PointMm>,
    /// The smallest local feature size at the corners of triangles in the aperture, in mm; none if it is not
    /// known anywhere, infinite over a plane.
    pub lfs_min_mm: Option<f64>,
    /// The regions that are not covered, first the one that adds most to the coverage: what to measure next.
    pub patches: Vec<Patch>,
    /// The area in mm² of places that are not covered in regions too small to be listed.
    pub remainder_mm2: f64,
    /// How many those are.
    pub remainder_patches: u64,
}

impl Coverage {
    /// Covered area over that of the aperture, 0 to 1; none if there is nothing to refer to.
    pub fn coverage(&self) -> Option<f64> {
        let areas = self.areas?;
        (areas.aperture_mm2 > 0.0).then(|| (areas.covered_mm2 / areas.aperture_mm2).clamp(0.0, 1.0))
    }
}

/// Why there is no coverage.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum CoverageError {
    /// The target is none.
    #[error("the sampling target cannot be used")]
    Target(#[from] TargetError),
    /// A point is not finite.
    #[error("point {vertex} is not finite")]
    Point {
        /// Its number.
        vertex: VertexId,
    },
    /// The triangles do not fill an outline.
    #[error(
        "the {triangles} triangles are not those of a whole mesh: their outline is not one closed line about its centre"
    )]
    NotAMesh {
        /// How many triangles there are.
        triangles: usize,
    },
    /// The regions could not be drawn.
    #[error("the border of the aperture coincides with sides of triangles wherever it is drawn")]
    Coincidence,
}

/// Says how much of the aperture is covered and which regions are not.
///
/// `triangles` are all those of a mesh of `points`, in the frame of the aperture, counter-clockwise;
/// the indices of those in `left_out`, ascending, count as bridges whatever their gap, such as
/// [`crate::Topography::triangles_of_folds`]. `lfs_mm(x, y)` is the local feature size of the surface
/// in mm: infinite over a plane, none where it is not known; what is not a positive number is not
/// known either. It is asked for at each point, and about what is not covered.
///
/// Linear time but for sorting what is near the hull and the border, and for what is not covered the
/// sides about each vertex. The same triangles give the same bits.
///
/// # Errors
///
/// When a limit of the target is not a positive finite number, a point is not finite, or the
/// triangles are not those of a whole mesh. No triangles are no error: nothing is covered then.
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn cover(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    left_out: &[usize],
    aperture: Option<&Aperture>,
    target: &Target,
    lfs_mm: impl Fn(f64, f64) -> Option<f64> + Sync,
) -> Result<Coverage, CoverageError> {
    let finite = |point: &PointMm| point.iter().all(|mm| mm.is_finite());
    if let Some(vertex) = points.iter().position(|point| !finite(point)) {
        return Err(CoverageError::Point { vertex: vertex as VertexId });
    }
    let rim = || Rim::of_triangles(points, triangles);
    let meshed = Meshed { points, triangles, left_out, rim };
    meshed.examine(aperture, target, None, lfs_mm).map(|examination| examination.coverage)
}

/// All that one pass over the triangles tells.
#[derive(Clone, Debug, PartialEq)]
pub struct Examination {
    /// How much of the aperture is covered, and what is not.
    pub coverage: Coverage,
    /// For each triangle whether it is covered and has a part in the aperture.
    pub covered: Vec<bool>,
    /// How many pieces and holes the covered part has; triangles across the border of the aperture count as
    /// a whole.
    pub islands: IslandCounts,
    /// How dense the samples are, if that was asked.
    pub dense: Option<Dense>,
    /// Area in space of all triangles in mm², wherever they are.
    pub area_mm2: f64,
}

/// As [`cover`] of a mesh, `triangles` being those of [`Mesh::triangles`], none left out, with what else the same
/// pass over them tells: which are covered, and with `density` whether samples are denser than their noise allows.
///
/// Where two threads help it works in the caller's rayon pool; the bits do not depend on them.
///
/// # Errors
///
/// As [`cover`].
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn examine(
    mesh: &Mesh,
    triangles: &[[VertexId; 3]],
    aperture: Option<&Aperture>,
    target: &Target,
    density: Option<&Density>,
    lfs_mm: impl Fn(f64, f64) -> Option<f64> + Sync,
) -> Result<Examination, CoverageError> {
    let rim = || Rim::of_mesh(mesh, triangles);
    let meshed = Meshed { points: mesh.points(), triangles, left_out: &[], rim };
    meshed.examine(aperture, target, density, lfs_mm)
}
