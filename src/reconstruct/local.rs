//! Facets by local stars: every point looks at the points within a few spacings and at nothing else.
//!
//! A point's star is its Voronoi cell cut by its tangent plane (J.-D. Boissonnat, A. Ghosh, Manifold reconstruction using tangential
//! Delaunay complexes, Discrete & Computational Geometry 51 (2014)). Tangent planes differ, so of four points nearly on one
//! circle each would see another diagonal. We deviate there: one rule of the four points alone decides for all of them
//! ([`vote`]). A facet is kept where all three corners have it in their stars; small holes where corners disagree are filled ([`mend`]).

mod holes;
mod mend;
mod normals;
mod star;
mod vote;

use asphera_geometry::{PointMm, RANGE_MM, TINY_MM};
use rayon::prelude::*;
use thiserror::Error;

use self::star::{GAP, Maker};
use crate::neighbours::{Neighbours, by_coordinates};
use crate::prove::{corners, turns};

/// A surface through points.
#[derive(Clone, Debug, PartialEq)]
pub struct Reconstruction {
    /// Numbers of points, in ascending order of the smallest; neighbours agree where the surface has two sides.
    pub facets: Vec<[u32; 3]>,
    /// Points that no facet uses, in ascending order, and why.
    pub left_out: Vec<(u32, LeftOut)>,
}

/// Why a point is no vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LeftOut {
    /// A coordinate is not finite or beyond 1e12 mm.
    NoPlace,
    /// An earlier point has the same place.
    Duplicate,
    /// The neighbours lie on a line, or are too few.
    NoPlane,
    /// The corners of its facets do not agree: spacing beyond the feature size, crossing sheets or noise above the spacing.
    Disagreement,
}

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
    let mut is_used = vec![false; tree.len()];
    for &corner in facets.as_flattened() {
        is_used[corner as usize] = true;
    }
    for at in (0..tree.len()).filter(|&at| !is_used[at]) {
        let why = if planes[at].is_none() { LeftOut::NoPlane } else { LeftOut::Disagreement };
        left_out.push((tree.ids[at], why));
    }
    left_out.sort_unstable();
    for facet in &mut facets {
        *facet = facet.map(|corner| tree.ids[corner as usize]);
        let least = (0..3).min_by_key(|&corner| facet[corner]).unwrap_or(0);
        facet.rotate_left(least);
        // Sorted before they are turned, so that what is turned does not depend on the stars.
        if facet[1] > facet[2] {
            facet.swap(1, 2);
        }
    }
    facets.par_sort_unstable();
    orient(points_mm, &mut facets);
    Ok(Reconstruction { facets, left_out })
}

/// A place and its number.
type Numbered = (PointMm, u32);

/// The places that count, each once, by the smallest number; and the others.
fn admitted(points_mm: &[PointMm]) -> (Vec<Numbered>, Vec<(u32, LeftOut)>) {
    let mut left_out = Vec::new();
    let mut places = Vec::with_capacity(points_mm.len());
    for (&point, number) in points_mm.iter().zip(0..) {
        if point.iter().all(|value| value.is_finite() && value.abs() <= RANGE_MM) {
            let place = point.map(|value| if value.abs() < TINY_MM { 0.0 } else { value });
            places.push((place, number));
        } else {
            left_out.push((number, LeftOut::NoPlace));
        }
    }
    places.par_sort_unstable_by(|a, b| by_coordinates(a.0, b.0).then(a.1.cmp(&b.1)));
    places.dedup_by(|later, first| {
        let is_same = later.0 == first.0;
        if is_same {
            left_out.push((later.1, LeftOut::Duplicate));
        }
        is_same
    });
    (places, left_out)
}

/// Facets that lie in the stars of all three corners, once each.
fn agreed(stars: &[Vec<u32>]) -> Vec<[u32; 3]> {
    let has = |star: &[u32], a: u32, b: u32| {
        (0..star.len()).any(|at| {
            let next = star[(at + 1) % star.len()];
            (star[at] == a && next == b) || (star[at] == b && next == a)
        })
    };
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

/// Turns facets so that neighbours agree, and each patch outwards where it is closed, else towards the larger part of its area
/// vector. A one-sided surface stays as it is.
fn orient(points_mm: &[PointMm], facets: &mut [[u32; 3]]) {
    let Some((turned, patch)) = turns(facets) else { return };
    for (facet, _) in facets.iter_mut().zip(turned).filter(|&(_, turned)| turned) {
        facet.swap(1, 2);
    }
    // Volume about the first corner of the patch, and area vector.
    let mut sums: Vec<[f64; 5]> = vec![[0.0; 5]; facets.len()];
    for (&facet, &patch) in facets.iter().zip(&patch) {
        let apex = points_mm[facets[patch as usize][0] as usize];
        let places = corners(points_mm, facet);
        let normal = crate::geometry::double_area(places);
        let volume = crate::geometry::dot(crate::geometry::minus(places[0], apex), normal);
        let size = crate::geometry::dot(normal, normal).sqrt();
        let sum = &mut sums[patch as usize];
        for (sum, term) in sum.iter_mut().zip([volume, normal[0], normal[1], normal[2], size]) {
            *sum += term;
        }
    }
    for (facet, patch) in facets.iter_mut().zip(patch) {
        let [volume, x, y, z, size] = sums[patch as usize];
        let certain = |value: &&f64| value.abs() > 1e-9 * size;
        let side = [z, y, x].iter().find(certain).copied().unwrap_or(volume);
        if side < 0.0 {
            facet.swap(1, 2);
        }
    }
}
