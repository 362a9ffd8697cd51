//! Small holes that are left where corners do not agree, as loops of border edges.

use std::collections::BTreeMap;

use asphera_geometry::PointMm;
use rayon::prelude::*;

use super::normals::TangentPlane;
use super::vote::basis;
use crate::geometry::{cross, dot, minus};

/// A hole of more sides is left open.
pub(super) const MOST_SIDES: usize = 32;

/// A hole: its corners counter-clockwise about their normals, the smallest first.
pub(super) struct Hole {
    pub(super) corners: Vec<u32>,
    /// The normals of the corners, all to one side.
    pub(super) normals: Vec<PointMm>,
}

/// The border edges of a mesh: at each corner the other ends, with the third corner of the facet there.
type Borders = BTreeMap<u32, Vec<[u32; 2]>>;

/// The holes of at most [`MOST_SIDES`] sides, in the order of their smallest corners. n·log n time.
pub(super) fn all(
    points_mm: &[PointMm],
    planes: &[Option<TangentPlane>],
    facets: &[[u32; 3]],
) -> Vec<Hole> {
    let borders = borders(facets);
    let walk = Walk { points_mm, planes, borders: &borders };
    let mut found: BTreeMap<Vec<u32>, Hole> = BTreeMap::new();
    for (&from, ends) in &borders {
        for &[to, third] in ends {
            // Begun at its smallest corner, so that each is found once.
            if let Some(hole) = walk.around(from, to, third) {
                found.entry(hole.corners.clone()).or_insert(hole);
            }
        }
    }
    found.into_values().collect()
}

fn borders(facets: &[[u32; 3]]) -> Borders {
    let mut sides: Vec<[u32; 3]> = facets
        .par_iter()
        .flat_map_iter(|&[a, b, c]| [[a, b, c], [b, c, a], [c, a, b]])
        .map(|[from, to, third]| [from.min(to), from.max(to), third])
        .collect();
    sides.par_sort_unstable();
    let mut borders = Borders::new();
    for group in sides.chunk_by(|one, other| one[..2] == other[..2]) {
        if let &[[low, high, third]] = group {
            borders.entry(low).or_default().push([high, third]);
            borders.entry(high).or_default().push([low, third]);
        }
    }
    borders
}

/// A walk along a border with the hole on its left.
struct Walk<'a> {
    points_mm: &'a [PointMm],
    planes: &'a [Option<TangentPlane>],
    borders: &'a Borders,
}

impl Walk<'_> {
    /// The hole on the side of an edge where its facet is not; `None` where it is too large, passes a corner twice, or has a
    /// smaller corner than `from`.
    fn around(&self, from: u32, to: u32, third: u32) -> Option<Hole> {
        let mut normal = self.planes[from as usize]?.normal;
        let [a, b, c] = [from, to, third].map(|at| self.points_mm[at as usize]);
        if dot(cross(minus(b, a), minus(c, a)), normal) > 0.0 {
            normal = normal.map(|side| -side);
        }
        let mut hole = Hole { corners: vec![from], normals: vec![normal] };
        let (mut before, mut at) = (from, to);
        while at != from {
            if at < from || hole.corners.len() == MOST_SIDES || hole.corners.contains(&at) {
                return None;
            }
            let here = self.planes[at as usize]?.normal;
            normal = if dot(here, normal) < 0.0 { here.map(|side| -side) } else { here };
            hole.corners.push(at);
            hole.normals.push(normal);
            (before, at) = (at, self.next(before, at, normal)?);
        }
        // Back at the first corner, the walk must go on along its first edge: on a one-sided surface it may not.
        let is_whole = self.next(before, from, hole.normals[0]) == Some(to);
        (is_whole && hole.corners.len() > 2).then_some(hole)
    }

    /// The border edge that follows: the first one clockwise from the way back.
    fn next(&self, before: u32, at: u32, normal: PointMm) -> Option<u32> {
        let along = basis(normal);
        let across = cross(normal, along);
        let angle = |end: u32| {
            let way = minus(self.points_mm[end as usize], self.points_mm[at as usize]);
            dot(way, across).atan2(dot(way, along))
        };
        let back = angle(before);
        let turn = |end: u32| (back - angle(end)).rem_euclid(std::f64::consts::TAU);
        let ends = self.borders.get(&at)?.iter().map(|&[end, _]| end);
        ends.filter(|&end| end != before)
            .min_by(|&one, &other| turn(one).total_cmp(&turn(other)).then(one.cmp(&other)))
    }
}
