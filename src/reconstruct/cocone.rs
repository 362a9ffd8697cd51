//! Cocone (N. Amenta, S. Choi, T. K. Dey, N. Leekha, "A simple algorithm for homeomorphic surface reconstruction",
//! doi:10.1142/S0218195902000773).
//!
//! The cocone of a point holds the places whose way from it makes less than 22.5° with its tangent plane, across the way to its pole.
//! A facet is a *candidate* where the edge of the Voronoi diagram across it meets the cocones of all three corners. Facets with sharp
//! edges are pruned, and a walk along the outer side takes one layer. Borders are found as T. K. Dey and J. Giesen (2001) do: a point
//! is *flat* where its cocone is not wider than 1.2 times the distance of its second pole and neighbours have normals within 60°.
//! An edge at a point that is not flat may be the border of an open surface and is not sharp. We deviate once more: of a sheet that
//! ends between flat points only flaps are pruned. Else one hole would take all of the surface away, as on the Stanford bunny.

mod candidates;
mod cell;
mod layer;
mod localized;
mod octree;
mod prune;
mod sheets;
mod walk;

use asphera_geometry::PointMm;

pub use self::localized::{CellCocone, POINTS_IN_CELL, loc_cocone, super_cocone};
use crate::centres;
use crate::delaunay::{Delaunay, NoDelaunay};
use crate::poles::Poles;
use crate::rings::FacetSet;
use crate::sampling::SamplingCondition;
use crate::surface::{LeftOut, Reconstruction, of_vertices};

/// A surface by cocones.
#[derive(Clone, Debug, PartialEq)]
pub struct Cocone {
    /// The surface.
    pub surface: Reconstruction,
    /// Facets whose dual edges meet three cocones.
    pub candidates: usize,
    /// Candidates without sharp edges.
    pub pruned: usize,
    /// Points whose neighbourhood is not flat: borders, sharp edges, noise, or spacing beyond the feature size.
    pub not_flat: usize,
    /// The sampling condition of the theorem.
    pub sampling: SamplingCondition,
}

/// The largest sampling ratio ε for which the theorem holds, as seed 002 states it.
pub const COCONE_BOUND: f64 = 0.05;

/// Reconstructs a surface by cocones of 22.5°.
///
/// # Errors
///
/// Points that do not span space.
pub fn cocone(points_mm: &[PointMm]) -> Result<Cocone, NoDelaunay> {
    let delaunay = Delaunay::new(points_mm)?;
    let centres = centres::of(&delaunay);
    let poles = Poles::of(&delaunay, &centres);
    let Candidates { mut set, flat, count } = candidates::of(&delaunay, &centres, &poles);
    drop(centres);
    prune::sharp(&mut set, &flat);
    let pruned = set.all().count();
    let facets = walk::outer(&set);
    let sampling = SamplingCondition::of(&delaunay.points_mm, &poles, &facets, COCONE_BOUND);
    Ok(Cocone {
        surface: of_vertices(points_mm, &delaunay, facets, LeftOut::NoFacet),
        candidates: count,
        pruned,
        not_flat: flat.iter().filter(|&&flat| !flat).count(),
        sampling,
    })
}

/// One layer of a set of facets: its outer side.
pub(crate) fn outer_layer(set: &FacetSet<'_>) -> Vec<[u32; 3]> {
    walk::outer(set)
}

/// Facets that may be of the surface, vertices that are flat, and how many facets meet three cocones.
struct Candidates<'a> {
    set: FacetSet<'a>,
    flat: Vec<bool>,
    count: usize,
}
