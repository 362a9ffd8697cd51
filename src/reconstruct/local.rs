//! Facets by local stars: every point looks at the points within a few spacings and at nothing else.
//!
//! A point's star is its Voronoi cell cut by its tangent plane (J.-D. Boissonnat, A. Ghosh, Manifold reconstruction using tangential
//! Delaunay complexes, Discrete & Computational Geometry 51 (2014)). Tangent planes differ, so of four points nearly on one
//! circle each would see another diagonal. We deviate there: one rule of the four points alone decides for all of them
//! ([`vote`]). A facet is kept where all three corners have it in their stars; small holes where corners disagree are filled ([`mend`]).

mod answers;
mod filling;
mod growing;
mod holes;
mod making;
mod mend;
mod near_lists;
pub(crate) mod normals;
pub(crate) mod place_tree;
mod ring;
mod star;
mod stars;
mod vote;

use asphera_geometry::PointMm;
use thiserror::Error;

pub use self::answers::SurfaceByPlace;
pub use self::growing::{FacetChanges, LocalSurface};
pub(crate) use self::normals::Places;
pub(crate) use self::star::GAP;
pub(crate) use self::vote::basis;
use crate::surface::Reconstruction;

/// More points than memory is meant for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("expected at most {MOST_POINTS} points, found {found}; reduce them first")]
pub struct TooManyPoints {
    /// How many there are.
    pub found: usize,
}

/// The largest number of points that [`local`] takes.
pub const MOST_POINTS: usize = 12_000_000;

/// Reconstructs a surface through points by local stars, as [`LocalSurface`] does of one batch. n·log n time, some 240 bytes a point.
///
/// The facets depend on the places alone, not on their order or the threads.
///
/// # Errors
///
/// More than [`MOST_POINTS`] points.
pub fn local(points_mm: &[PointMm]) -> Result<Reconstruction, TooManyPoints> {
    let mut surface = LocalSurface::new();
    surface.take(points_mm, false)?;
    Ok(surface.into_surface())
}
