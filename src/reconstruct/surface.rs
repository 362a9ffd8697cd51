//! A surface through points: which places count, how its facets are numbered and turned.

use asphera_geometry::{PointMm, RANGE_MM, TINY_MM};
use rayon::prelude::*;

use crate::delaunay::Delaunay;
use crate::geometry::{dot, double_area, minus};
use crate::neighbours::by_coordinates;
use crate::prove::corners;
use crate::turning::Turning;

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
    /// The graph method has put a landmark in its place.
    Pruned,
    /// A landmark in no face of the graph method.
    NoFace,
    /// A point that would fold the surface of the graph method as a vertex.
    Folding,
    /// No facet of the method has it as a corner.
    NoFacet,
    /// It touches no big ball outside: it lies within a band of noise, or behind the surface.
    Noise,
    /// The corners of its facets do not agree: spacing beyond the feature size, crossing sheets or noise above the spacing.
    Disagreement,
}

/// Facets with the points' own numbers, in ascending order of the smallest, turned so that neighbours agree.
pub(crate) fn finished(
    points_mm: &[PointMm],
    ids: &[u32],
    mut facets: Vec<[u32; 3]>,
) -> Vec<[u32; 3]> {
    for corner in facets.as_flattened_mut() {
        *corner = ids[*corner as usize];
    }
    in_order(points_mm, facets)
}

/// Facets in ascending order of the smallest, turned so that neighbours agree.
pub(crate) fn in_order(points_mm: &[PointMm], mut facets: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    facets.par_iter_mut().with_min_len(FACETS_AT_ONCE).for_each(|facet| {
        let least = (0..3).min_by_key(|&corner| facet[corner]).unwrap_or(0);
        facet.rotate_left(least);
        // Sorted before they are turned, so that what is turned does not depend on the method.
        if facet[1] > facet[2] {
            facet.swap(1, 2);
        }
    });
    facets.par_sort_unstable();
    turned(points_mm, facets)
}

/// Facets that are in order, with their corners, turned so that neighbours agree.
pub(crate) fn turned(points_mm: &[PointMm], mut facets: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    orient(points_mm, &mut facets);
    facets
}

/// Facets that a thread takes in turn.
const FACETS_AT_ONCE: usize = 1 << 12;

/// A surface of facets by vertices of a triangulation; vertices without a facet are left out for one reason.
pub(crate) fn of_vertices(
    points_mm: &[PointMm],
    delaunay: &Delaunay,
    facets: Vec<[u32; 3]>,
    why: LeftOut,
) -> Reconstruction {
    of_numbered(points_mm, &delaunay.ids, delaunay.left_out.clone(), facets, why)
}

/// A surface of facets by places in a list of the points' numbers; those without a facet are left out for one reason.
pub(crate) fn of_numbered(
    points_mm: &[PointMm],
    ids: &[u32],
    mut left_out: Vec<(u32, LeftOut)>,
    facets: Vec<[u32; 3]>,
    why: LeftOut,
) -> Reconstruction {
    let mut is_used = vec![false; ids.len()];
    for &corner in facets.as_flattened() {
        is_used[corner as usize] = true;
    }
    let unused = ids.iter().zip(is_used).filter(|&(_, is_used)| !is_used);
    left_out.extend(unused.map(|(&id, _)| (id, why)));
    left_out.sort_unstable();
    Reconstruction { facets: finished(points_mm, ids, facets), left_out }
}

/// A place and its number.
pub(crate) type Numbered = (PointMm, u32);

/// The place of a point; `None` where a coordinate is not finite or too large.
pub(crate) fn as_place(point: PointMm) -> Option<PointMm> {
    let counts = point.iter().all(|value| value.is_finite() && value.abs() <= RANGE_MM);
    counts.then(|| point.map(|value| if value.abs() < TINY_MM { 0.0 } else { value }))
}

/// The places that count, each once, by the smallest number; and the others.
pub(crate) fn admitted(points_mm: &[PointMm]) -> (Vec<Numbered>, Vec<(u32, LeftOut)>) {
    let mut left_out = Vec::new();
    let mut places = Vec::with_capacity(points_mm.len());
    for (&point, number) in points_mm.iter().zip(0..) {
        match as_place(point) {
            Some(place) => places.push((place, number)),
            None => left_out.push((number, LeftOut::NoPlace)),
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

/// Turns facets so that neighbours agree, and each patch outwards where it is closed, else towards the larger part of its area
/// vector. A one-sided surface stays as it is.
fn orient(points_mm: &[PointMm], facets: &mut [[u32; 3]]) {
    let Some(Turning { is_turned, patch, patches }) = Turning::of(points_mm.len(), facets) else {
        return;
    };
    for (facet, _) in facets.iter_mut().zip(is_turned).filter(|&(_, turned)| turned) {
        facet.swap(1, 2);
    }
    // Volume about the first corner of the patch, and area vector.
    let mut sums = vec![[0.0; 5]; patches];
    let mut apexes: Vec<Option<PointMm>> = vec![None; patches];
    for (&facet, &patch) in facets.iter().zip(&patch) {
        let places = corners(points_mm, facet);
        let apex = *apexes[patch as usize].get_or_insert(places[0]);
        let normal = double_area(places);
        let volume = dot(minus(places[0], apex), normal);
        let size = dot(normal, normal).sqrt();
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
