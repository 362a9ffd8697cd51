//! Which measured points belong to which kept one.

use asphera_geometry::{PointMm, WeightedTree};
use rayon::prelude::*;

/// The measured points nearest to each kept one, and the kept ones about it.
pub(super) struct Cells {
    kept: WeightedTree,
    points: Vec<u32>,
    /// Where those of each kept point start, and the end of the last.
    starts: Vec<usize>,
}

impl Cells {
    /// Gives each point to the nearest of those `kept`; those of a cell lie by their distance in the plane.
    pub(super) fn new(points: &[PointMm], kept: &[PointMm]) -> Cells {
        let tree = WeightedTree::of_points(kept);
        let owners: Vec<Option<u32>> = points
            .par_iter()
            .map(|&point| tree.nearest(point, |_| true).map(|(owner, _)| owner))
            .collect();
        let mut starts = vec![0; kept.len() + 1];
        for owner in owners.iter().flatten() {
            starts[*owner as usize + 1] += 1;
        }
        for number in 0..kept.len() {
            starts[number + 1] += starts[number];
        }
        let mut next = starts.clone();
        let mut sorted = vec![0; starts[kept.len()]];
        for (index, owner) in (0..).zip(&owners) {
            if let Some(owner) = owner {
                let place = &mut next[*owner as usize];
                sorted[*place] = index;
                *place += 1;
            }
        }
        for (number, &at) in kept.iter().enumerate() {
            let squared_mm2 = |index: &u32| {
                let point = points[*index as usize];
                (point[0] - at[0]).powi(2) + (point[1] - at[1]).powi(2)
            };
            sorted[starts[number]..starts[number + 1]]
                .sort_by(|p, q| squared_mm2(p).total_cmp(&squared_mm2(q)).then(p.cmp(q)));
        }
        Cells { kept: tree, points: sorted, starts }
    }

    /// The points of a cell, the nearest to its kept point first.
    pub(super) fn of(&self, number: usize) -> &[u32] {
        &self.points[self.starts[number]..self.starts[number + 1]]
    }

    /// The `count` kept points nearest to a place, its own included.
    pub(super) fn about(&self, place: PointMm, count: usize) -> Vec<u32> {
        self.kept.least_few(place, count)
    }
}
