//! Points taken back where facets of the reduced mesh are longer than ε allows.
//!
//! The rule keeps a point within ε·lfs of every place of the surface, which is what an ε-sample is. But what is then
//! made of the points is their mesh, and its facets are those of the projection: on a slope the circle about a facet
//! that is empty in the plane may hold other points in space, and the facet is longer than any between nearest
//! neighbours, by up to one over the cosine of the slope. [`crate::assess`] measures facets, since they are what
//! heights are interpolated over. So of each facet that fails, the dropped point nearest to the place farthest from
//! its corners is taken back; that splits the facet. This is done again with the new mesh until none fails that
//! a point could mend.

use crate::nearest::WeightedTree;
use crate::rim::refined_gaps;
use crate::triangle::{Gap, Triangle};
use crate::{Mesh, PointMm, VertexId};

/// What is mended, and within which limits.
pub(super) struct Mending<'a, L, N> {
    pub(super) points: &'a [PointMm],
    pub(super) epsilon: f64,
    /// Local feature size at a place in mm, if it is known.
    pub(super) lfs_mm: L,
    /// How near to a kept point noise lets another one come, by its index, in mm.
    pub(super) narrowest_mm: N,
}

impl<L: Fn(PointMm) -> Option<f64>, N: Fn(usize) -> f64> Mending<'_, L, N> {
    /// Adds to the `kept` points, ascending; gives those that were added.
    pub(super) fn mend(&self, kept: &mut Vec<VertexId>) -> Vec<VertexId> {
        let mut added = Vec::new();
        let mut dropped = None;
        for _ in 0..ROUNDS {
            let mut mesh = Mesh::new();
            mesh.extend(kept.iter().map(|&index| self.points[index as usize]));
            mesh.flush();
            let failing = self.failing(&mesh);
            if failing.is_empty() {
                break;
            }
            let mut is_kept = vec![false; self.points.len()];
            kept.iter().for_each(|&index| is_kept[index as usize] = true);
            let all = dropped.get_or_insert_with(|| WeightedTree::of_points(self.points));
            let standing = WeightedTree::of_points(mesh.points());
            let mut back: Vec<VertexId> = failing
                .iter()
                .filter_map(|gap| {
                    let (index, away_mm) =
                        all.nearest(gap.at_mm, |other| !is_kept[other as usize])?;
                    let (_, from_kept_mm) =
                        standing.nearest(self.points[index as usize], |_| true)?;
                    let allowed = from_kept_mm >= (self.narrowest_mm)(index as usize);
                    // A point farther off would not split the facet: there is a gap in the measured ones.
                    (away_mm < gap.mm && allowed).then_some(index)
                })
                .collect();
            back.sort_unstable();
            back.dedup();
            let back = self.apart(back);
            if back.is_empty() {
                break;
            }
            kept.extend(&back);
            kept.sort_unstable();
            added.extend(back);
        }
        added
    }

    /// The gaps of the facets that fail.
    fn failing(&self, mesh: &Mesh) -> Vec<Gap> {
        let (points, triangles) = (mesh.points(), mesh.triangles());
        let at_points_mm: Vec<Option<f64>> =
            points.iter().map(|&point| (self.lfs_mm)(point)).collect();
        let mut refined = refined_gaps(points, &triangles).into_iter().peekable();
        let gaps = triangles.iter().enumerate().filter_map(|(index, &corners)| {
            let thin = refined.next_if(|&(thin, _)| thin == index);
            let gap = thin.map_or_else(|| Triangle::new(points, corners).gap(), |(_, gap)| gap);
            let own = corners.map(|corner| at_points_mm[corner as usize]);
            let sizes_mm = own.into_iter().chain([(self.lfs_mm)(gap.at_mm)]);
            // Where a size is not known all points are kept.
            let least_mm = sizes_mm.flatten().fold(f64::INFINITY, f64::min);
            (gap.mm > self.epsilon * least_mm).then_some(gap)
        });
        gaps.collect()
    }

    /// Those that are far enough from each other.
    fn apart(&self, back: Vec<VertexId>) -> Vec<VertexId> {
        let mut taken: Vec<VertexId> = Vec::new();
        let places: Vec<PointMm> = back.iter().map(|&index| self.points[index as usize]).collect();
        let tree = WeightedTree::of_points(&places);
        let mut is_taken = vec![false; back.len()];
        for (number, &index) in back.iter().enumerate() {
            let nearest = tree.nearest(places[number], |other| is_taken[other as usize]);
            let narrowest_mm = (self.narrowest_mm)(index as usize);
            if nearest.is_none_or(|(_, mm)| mm >= narrowest_mm) {
                is_taken[number] = true;
                taken.push(index);
            }
        }
        taken
    }
}

/// Most rounds; each at least halves what fails, so a few are enough where points are dense.
const ROUNDS: usize = 16;
