//! Facets by local stars: every point looks at the points within a few spacings and at nothing else.
//!
//! A point's star is its Voronoi cell cut by its tangent plane (J.-D. Boissonnat, A. Ghosh, Manifold reconstruction using tangential
//! Delaunay complexes, Discrete & Computational Geometry 51 (2014)). Tangent planes differ, so of four points nearly on one
//! circle each would see another diagonal. We deviate there: one rule of the four points alone decides for all of them
//! ([`vote`]). A facet is kept where all three corners have it in their stars; small holes where corners disagree are filled ([`mend`]).

mod holes;
mod mend;
pub(crate) mod normals;
mod star;
mod vote;

use asphera_geometry::PointMm;
use rayon::prelude::*;
use thiserror::Error;

use self::normals::TangentPlane;
pub(crate) use self::star::GAP;
use self::star::Maker;
pub(crate) use self::vote::basis;
use crate::neighbours::Neighbours;
use crate::surface::{LeftOut, Reconstruction, admitted, finished};

/// More points than memory is meant for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("expected at most {MOST_POINTS} points, found {found}; reduce them first")]
pub struct TooManyPoints {
    /// How many there are.
    pub found: usize,
}

/// The largest number of points that [`local`] takes.
pub const MOST_POINTS: usize = 12_000_000;

/// Reconstructs a surface through points by local stars. n·log n time, some 440 bytes a point.
///
/// The facets depend on the places alone, not on their order or the threads.
///
/// # Errors
///
/// More than [`MOST_POINTS`] points.
pub fn local(points_mm: &[PointMm]) -> Result<Reconstruction, TooManyPoints> {
    if points_mm.len() > MOST_POINTS {
        return Err(TooManyPoints { found: points_mm.len() });
    }
    let (places, mut left_out) = admitted(points_mm);
    let tree = Neighbours::of(places);
    let planes = normals::of(&tree);
    let maker = Maker { tree: &tree, planes: &planes };
    let stars = tree.map_nearest(normals::NEAREST, |at, near, room| maker.star(at, near, room));
    let mut facets = agreed(&stars);
    facets.extend(mend::facets(&tree, &planes, &facets));
    left_out.extend(without_facet(&tree, &planes, &facets));
    left_out.sort_unstable();
    let facets = finished(points_mm, &tree.ids, facets);
    Ok(Reconstruction { facets, left_out })
}

/// The points in no facet of points by numbers of the tree, and why.
pub(crate) fn without_facet(
    tree: &Neighbours,
    planes: &[Option<TangentPlane>],
    facets: &[[u32; 3]],
) -> Vec<(u32, LeftOut)> {
    let mut is_used = vec![false; tree.len()];
    for &corner in facets.as_flattened() {
        is_used[corner as usize] = true;
    }
    let unused = (0..tree.len()).filter(|&at| !is_used[at]);
    unused
        .map(|at| {
            let why = if planes[at].is_none() { LeftOut::NoPlane } else { LeftOut::Disagreement };
            (tree.ids[at], why)
        })
        .collect()
}

/// Whether two points follow each other in a star, whichever is first.
pub(crate) fn has(star: &[u32], a: u32, b: u32) -> bool {
    (0..star.len()).any(|at| {
        let pair = [star[at], star[(at + 1) % star.len()]];
        pair == [a, b] || pair == [b, a]
    })
}

/// Facets that lie in the stars of all three corners, once each.
pub(crate) fn agreed(stars: &[Vec<u32>]) -> Vec<[u32; 3]> {
    stars
        .par_iter()
        .enumerate()
        .flat_map_iter(|(p, star)| {
            let p = p as u32;
            (0..star.len()).filter_map(move |at| {
                let (q, r) = (star[at], star[(at + 1) % star.len()]);
                let is_first = q != GAP && r != GAP && q != r && p < q && p < r;
                (is_first && has(&stars[q as usize], p, r) && has(&stars[r as usize], p, q))
                    .then_some([p, q, r])
            })
        })
        .collect()
}
