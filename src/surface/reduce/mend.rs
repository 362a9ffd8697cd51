//! Points taken back where facets of the reduced mesh are longer than ε allows.
//!
//! The rule keeps a point within ε·lfs of every place of the surface, which is what an ε-sample is. But what is then
//! made of the points is their mesh, and its facets are those of the projection: on a slope the circle about a facet
//! that is empty in the plane may hold other points in space, and the facet is longer than any between nearest
//! neighbours, by up to one over the cosine of the slope. [`crate::assess`] measures facets, since they are what
//! heights are interpolated over. So of each facet that fails, the dropped point nearest to the place farthest from
//! its corners is taken back; that splits the facet. This is done again with the new mesh until none fails that
//! a point could mend.

use asphera_geometry::{Gap, PointMm, Triangle, VertexId, WeightedTree};
use asphera_mesh::Mesh;

use crate::rim::refined_gaps;

/// What is mended, and within which limits.
pub(super) struct Mending<'a, L, N> {
    pub(super) points: &'a [PointMm],
    pub(super) epsilon: f64,
    /// Local feature size at a place in mm, if it is known.
    pub(super) lfs_mm: L,
    /// How near to a kept point noise lets another one come, by its index, in mm.
    pub(super) narrowest_mm: N,
}

/// The outcome of mending.
pub(super) struct Mended {
    /// The points that were added.
    pub(super) added: Vec<VertexId>,
    /// The facets it could not mend.
    pub(super) shortfall: Option<Shortfall>,
}

/// Facets beyond ε where the measured points are dense enough for it: it is the reduction that falls short there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shortfall {
    /// How many there are.
    pub facets: u64,
    /// The largest ratio of their gap to the local feature size.
    pub epsilon_max: f64,
}

/// A facet that fails.
struct Failing {
    gap: Gap,
    /// The smallest local feature size about it.
    lfs_mm: f64,
}

impl<L: Fn(PointMm) -> Option<f64>, N: Fn(usize) -> f64> Mending<'_, L, N> {
    /// Adds to the `kept` points, ascending.
    pub(super) fn mend(&self, kept: &mut Vec<VertexId>) -> Mended {
        let mut added = Vec::new();
        let mut measured = None;
        for round in 0.. {
            let mut mesh = Mesh::new();
            mesh.extend(kept.iter().map(|&index| self.points[index as usize]));
            mesh.flush();
            let failing = self.failing(&mesh);
            if failing.is_empty() {
                break;
            }
            let measured = measured.get_or_insert_with(|| WeightedTree::of_points(self.points));
            let back = if round < ROUNDS {
                self.back(&failing, measured, mesh.points(), kept)
            } else {
                Vec::new()
            };
            if back.is_empty() {
                let standing = WeightedTree::of_points(mesh.points());
                let shortfall = self.shortfall(&failing, measured, &standing);
                return Mended { added, shortfall };
            }
            kept.extend(&back);
            kept.sort_unstable();
            added.extend(back);
        }
        Mended { added, shortfall: None }
    }

    /// The dropped points that split the facets that fail, as far as noise allows.
    fn back(
        &self,
        failing: &[Failing],
        measured: &WeightedTree,
        standing: &[PointMm],
        kept: &[VertexId],
    ) -> Vec<VertexId> {
        let mut is_kept = vec![false; self.points.len()];
        kept.iter().for_each(|&index| is_kept[index as usize] = true);
        let standing = WeightedTree::of_points(standing);
        let splits = |Failing { gap, .. }: &Failing| {
            let (index, away_mm) = measured.nearest(gap.at_mm, |other| !is_kept[other as usize])?;
            let (_, from_kept_mm) = standing.nearest(self.points[index as usize], |_| true)?;
            let allowed = from_kept_mm >= (self.narrowest_mm)(index as usize);
            // A point farther off would not split the facet: there is a gap in the measured ones.
            (away_mm < gap.mm && allowed).then_some(index)
        };
        let mut back: Vec<VertexId> = failing.iter().filter_map(splits).collect();
        back.sort_unstable();
        back.dedup();
        self.apart(back)
    }

    /// Of the facets that fail, those that would not with all measured points. `standing`: the kept points.
    fn shortfall(
        &self,
        failing: &[Failing],
        measured: &WeightedTree,
        standing: &WeightedTree,
    ) -> Option<Shortfall> {
        let is_measured = |&&Failing { gap, lfs_mm }: &&Failing| {
            let away_mm = |tree: &WeightedTree| Some(tree.nearest(gap.at_mm, |_| true)?.1);
            // The way across a thin facet of the outline, which comes on top of the gap beneath it.
            let across_mm = away_mm(standing).map_or(0.0, |mm| (gap.mm - mm).max(0.0));
            away_mm(measured).is_some_and(|mm| mm + across_mm <= self.epsilon * lfs_mm)
        };
        let short = failing.iter().filter(is_measured);
        short.fold(None, |so_far: Option<Shortfall>, &Failing { gap, lfs_mm }| {
            let Shortfall { facets, epsilon_max } =
                so_far.unwrap_or(Shortfall { facets: 0, epsilon_max: 0.0 });
            let epsilon_max = epsilon_max.max(gap.mm / lfs_mm);
            Some(Shortfall { facets: facets + 1, epsilon_max })
        })
    }

    /// The facets that fail.
    fn failing(&self, mesh: &Mesh) -> Vec<Failing> {
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
            let lfs_mm = sizes_mm.flatten().fold(f64::INFINITY, f64::min);
            (gap.mm > self.epsilon * lfs_mm).then_some(Failing { gap, lfs_mm })
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
const ROUNDS: u32 = 16;
