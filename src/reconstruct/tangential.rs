//! Tangential complexes (J.-D. Boissonnat, A. Ghosh 2014, "Manifold reconstruction using tangential Delaunay complexes",
//! doi:10.1007/s00454-013-9557-2).
//!
//! The star of a point is its Voronoi cell cut by its tangent plane. Stars of neighbours may not agree where four points lie nearly on a
//! circle. Then the corners of the facets in doubt get weights, and the stars are made again, in rounds. A weight is less than the
//! square of 0.45 times the distance of the nearest neighbour. It follows from the coordinates of the point and the round alone, so the
//! result does not depend on the order of points. We deviate once: weights are drawn instead of searched for. Tangent planes are fitted
//! to the 16 nearest neighbours, as of [`crate::local()`].

mod star;
mod weights;

use std::collections::HashSet;

use asphera_geometry::PointMm;
use rayon::prelude::*;

use self::star::{Maker, Room};
use crate::centres;
use crate::delaunay::{Delaunay, NoDelaunay};
use crate::local::normals::TangentPlane;
use crate::local::{GAP, Places as _, normals};
use crate::neighbours::{Near, Neighbours};
use crate::poles::Poles;
use crate::sampling::SamplingCondition;
use crate::surface::{LeftOut, Reconstruction, admitted, finished};

/// A surface of stars in tangent planes that agree.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangential {
    /// The surface.
    pub surface: Reconstruction,
    /// Points with a weight.
    pub weighted: usize,
    /// Rounds of weights.
    pub rounds: usize,
    /// Points whose stars have a facet that a corner does not have.
    pub inconsistent: usize,
    /// The sampling condition of the theorem.
    pub sampling: SamplingCondition,
}

/// The largest sampling ratio ε for which the theorem holds, as seed 002 states it.
pub const TANGENTIAL_BOUND: f64 = 0.09;

/// Reconstructs a surface by its tangential complex.
///
/// # Errors
///
/// Points that do not span space: then no feature size is known.
pub fn tangential(points_mm: &[PointMm]) -> Result<Tangential, NoDelaunay> {
    let delaunay = Delaunay::new(points_mm)?;
    let poles = Poles::of(&delaunay, &centres::of(&delaunay));
    let (places, mut left_out) = admitted(points_mm);
    let tree = Neighbours::of(places);
    let planes = normals::of(&tree);
    let nearest =
        tree.map_nearest(1, |_, near, _: &mut ()| near.first().map_or(0.0, |near| near.0));
    let mut maker = Maker { tree: &tree, planes: &planes, weights: vec![0.0; tree.len()] };
    let all: Vec<u32> = (0..tree.len() as u32).collect();
    let mut stars = maker.stars(&all);
    let mut rounds = 0;
    loop {
        let doubtful = doubtful(&stars);
        if doubtful.is_empty() || rounds == MOST_ROUNDS {
            break;
        }
        rounds += 1;
        for &at in &doubtful {
            let place = tree.points_mm[at as usize];
            maker.weights[at as usize] = nearest[at as usize] * weights::share(place, rounds);
        }
        let near = maker.seen_from(&doubtful);
        for (at, star) in near.iter().zip(maker.stars(&near)) {
            stars[*at as usize] = star;
        }
    }
    // Weights of points that look farther than their neighbours do may have changed since.
    stars = maker.stars(&all);
    let inconsistent = doubtful(&stars).len();
    let facets = agreed(&stars);
    let sampling = condition(&delaunay, &poles, &tree, &facets, points_mm.len());
    left_out.extend(without_facet(&tree, &planes, &facets));
    left_out.sort_unstable();
    let weighted = maker.weights.iter().filter(|&&weight| weight > 0.0).count();
    let facets = finished(points_mm, &tree.ids, facets);
    let surface = Reconstruction { facets, left_out };
    Ok(Tangential { surface, weighted, rounds, inconsistent, sampling })
}

/// Corners of facets that are not in the stars of all three, in ascending order.
fn doubtful(stars: &[Vec<u32>]) -> Vec<u32> {
    let about = |of: u32| &stars[of as usize];
    let mut found: Vec<u32> = stars
        .par_iter()
        .enumerate()
        .flat_map_iter(|(p, star)| {
            let p = p as u32;
            (0..star.len()).filter_map(move |at| {
                let (q, r) = (star[at], star[(at + 1) % star.len()]);
                let is_facet = q != GAP && r != GAP && q != r;
                (is_facet && !(has(about(q), p, r) && has(about(r), p, q))).then_some([p, q, r])
            })
        })
        .flatten_iter()
        .collect();
    found.par_sort_unstable();
    found.dedup();
    found
}

/// The sampling condition, with facets by numbers of the tree.
fn condition(
    delaunay: &Delaunay,
    poles: &Poles,
    tree: &Neighbours,
    facets: &[[u32; 3]],
    points: usize,
) -> SamplingCondition {
    let mut vertices = vec![0; points];
    for (&id, vertex) in delaunay.ids.iter().zip(0..) {
        vertices[id as usize] = vertex;
    }
    let facets: Vec<[u32; 3]> = facets
        .iter()
        .map(|facet| facet.map(|at| vertices[tree.ids[at as usize] as usize]))
        .collect();
    SamplingCondition::of(&delaunay.points_mm, poles, &facets, TANGENTIAL_BOUND)
}

impl Maker<'_> {
    /// The stars of some points, in their order.
    fn stars(&self, of: &[u32]) -> Vec<Vec<u32>> {
        of.par_iter().map_init(Room::default, |room, &at| self.star(at, room)).collect()
    }

    /// Points that some points see, themselves among them, in ascending order.
    fn seen_from(&self, points: &[u32]) -> Vec<u32> {
        let mut seen: HashSet<u32> = points.iter().copied().collect();
        let mut near: Vec<Near> = Vec::new();
        for &at in points {
            if let Some(plane) = self.planes[at as usize] {
                self.tree.within(at, plane.reach_mm, &mut near);
                seen.extend(near.iter().map(|&(_, other)| other));
            }
        }
        let mut seen: Vec<u32> = seen.into_iter().collect();
        seen.sort_unstable();
        seen
    }
}

const MOST_ROUNDS: usize = 40;

/// The points in no facet of points by numbers of the tree, and why.
fn without_facet(
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
fn has(star: &[u32], a: u32, b: u32) -> bool {
    (0..star.len()).any(|at| {
        let pair = [star[at], star[(at + 1) % star.len()]];
        pair == [a, b] || pair == [b, a]
    })
}

/// Facets that lie in the stars of all three corners, once each.
fn agreed(stars: &[Vec<u32>]) -> Vec<[u32; 3]> {
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
