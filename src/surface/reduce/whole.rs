//! Reduction of a finished mesh, with the gap of its sampling vertex by vertex.

use super::Target;
use super::nearest::Tree;
use super::reducer::{Fate, Reducer, Tally};
use crate::area::Sum;
use crate::rim::{on_outline, refined_gaps};
use crate::triangle::Triangle;
use crate::{PointMm, VertexId};

/// What a reduction keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduction {
    /// Which points are kept: indices in order of arrival.
    pub kept: Vec<VertexId>,
    /// How many points were kept and dropped, by what their spacing followed from.
    pub tally: Tally,
    /// Projected area in mm² of the triangles whose gap is too wide for ε before any reduction, or
    /// of unknown local feature size: no reduction can mend those.
    pub sparse_area_mm2: f64,
    /// How many triangles those are.
    pub sparse_triangles: u64,
}

/// How far kept points lie from their nearest kept neighbour, in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The least distance in mm.
    pub min_mm: f64,
    /// The lower median of all in mm.
    pub median_mm: f64,
    /// The largest in mm.
    pub max_mm: f64,
}

/// Reduces `points` to what `target` asks for: first those on the outline of the surface, then all
/// others, both in their order. Were the outline not taken first, the reduced surface would end up
/// to a spacing before the measured one does. `triangles` are those of the points' mesh; their
/// corners are indices into `points`.
///
/// `lfs_mm` is the local feature size at a point in mm, infinite over a plane, `None` where it is
/// not known. Points of unknown local feature size are all kept.
///
/// The gap at a point is the widest of its triangles that are sampled densely enough. A triangle
/// that is not, by a hole or a hollow of the outline, cannot be mended by keeping its corners and
/// does not count: [`Reduction::sparse_area_mm2`] tells how much of that there is. Elsewhere every
/// point of the mesh has a kept point within ε·lfs, except where the noise limit is wider
/// ([`Tally::noise`]).
///
/// Linear time on average for every ε up to ½.
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn reduce(
    points: &[PointMm],
    triangles: impl IntoIterator<Item = [VertexId; 3]>,
    target: &Target,
    lfs_mm: impl Fn(PointMm) -> Option<f64>,
) -> Reduction {
    let lfs_mm: Vec<Option<f64>> =
        points.iter().map(|&point| target.lfs_mm(lfs_mm(point))).collect();
    let mut triangles: Vec<[VertexId; 3]> = triangles.into_iter().collect();
    let mut gaps_mm = vec![f64::NEG_INFINITY; points.len()];
    let (mut sparse, mut sparse_triangles) = (Sum::default(), 0);
    let mut refined = refined_gaps(points, &triangles).into_iter().peekable();
    // Those of the surface: neither sparse nor a sliver that reaches over the outermost points.
    let mut index = 0;
    triangles.retain(|&corners| {
        let triangle = Triangle::new(points, corners);
        let thin = refined.next_if(|&(thin, _)| thin == index);
        index += 1;
        let gap_mm = thin.map_or_else(|| triangle.gap().mm, |(_, gap)| gap.mm);
        let dense = corners.iter().all(|&corner| {
            lfs_mm[corner as usize].is_some_and(|lfs_mm| gap_mm <= target.epsilon() * lfs_mm)
        });
        if dense {
            for corner in corners {
                let widest_mm = &mut gaps_mm[corner as usize];
                *widest_mm = widest_mm.max(gap_mm);
            }
        } else {
            sparse.add(triangle.projected_area_mm2());
            sparse_triangles += 1;
        }
        dense && thin.is_none()
    });
    let outline = on_outline(points.len(), &triangles);
    drop(triangles);
    let mut reducer = Reducer::new();
    let mut kept = Vec::new();
    for on_outline in [true, false] {
        for (index, &point) in (0..).zip(points) {
            if outline[index as usize] == on_outline {
                let gap_mm = gaps_mm[index as usize];
                // A point without a dense triangle has its next one farther than ε allows.
                let gap_mm = if gap_mm >= 0.0 { gap_mm } else { f64::INFINITY };
                let spacing = target.spacing(lfs_mm[index as usize], gap_mm);
                if let Fate::Kept(_) = reducer.take(point, spacing) {
                    kept.push(index);
                }
            }
        }
    }
    kept.sort_unstable();
    Reduction { kept, tally: *reducer.tally(), sparse_area_mm2: sparse.total(), sparse_triangles }
}

/// The distances of finite points to their nearest neighbours; `None` with fewer than two points.
/// Takes n·log n time.
pub fn spread(points: &[PointMm]) -> Option<Spread> {
    let tree = Tree::new(points);
    let mut distances_mm = Vec::with_capacity(points.len());
    for (number, &point) in (0..).zip(points) {
        let (_, squared_mm2) = tree.nearest(point, |other| other != number)?;
        distances_mm.push(squared_mm2.sqrt());
    }
    let middle = distances_mm.len().checked_sub(1)? / 2;
    let (below, median_mm, above) = distances_mm.select_nth_unstable_by(middle, f64::total_cmp);
    Some(Spread {
        min_mm: below.iter().copied().fold(*median_mm, f64::min),
        median_mm: *median_mm,
        max_mm: above.iter().copied().fold(*median_mm, f64::max),
    })
}
