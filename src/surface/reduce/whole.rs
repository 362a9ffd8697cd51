//! Reduction of a finished mesh, with the gap of its sampling vertex by vertex.

use asphera_geometry::{PointMm, Sum, Triangle, VertexId, WeightedTree};
use asphera_mesh::Mesh;

use super::mend::{Mended, Mending, Shortfall};
use super::reducer::{Fate, Reducer, Tally};
use super::{About, Keep, Spacing, Target};
use crate::noise::assess_spacing;
use crate::rim::{cut_by_outline, on_outline, refined_gaps};

/// What a reduction keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduction {
    /// Which points are kept: indices in order of arrival.
    pub retained: Vec<VertexId>,
    /// How many points were kept and dropped, by what their spacing followed from.
    pub tally: Tally,
    /// How many of the kept points were taken back because a facet between the others was longer than ε allows: on
    /// slopes the facets of a projected mesh are.
    pub mended: u64,
    /// Facets that stay beyond ε although points were measured between, as noise keeps those apart; `None` where the
    /// target is reached wherever the measured points reach it.
    pub shortfall: Option<Shortfall>,
    /// Whether noise turned any facet by more than the limit before the reduction. If none, points
    /// are dropped only where ε asks for no more of them.
    pub overdense: bool,
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
/// `lfs_mm` is the local feature size at a place in mm, measured or between measured points; infinite over a plane, `None` where it is
/// not known. Points of unknown local feature size are all kept.
///
/// The gap at a point is the widest of its triangles that are sampled densely enough. A triangle
/// that is not, by a hole or a hollow of the outline, cannot be mended by keeping its corners and
/// does not count: [`Reduction::sparse_area_mm2`] tells how much of that there is. Elsewhere every
/// point of the mesh has a kept point within ε·lfs, and [`crate::assess`] finds no facet of the reduced mesh
/// with a larger ε, except where the noise needs a wider spacing ([`Tally::noise`]).
///
/// *Noise.* If noise turns a facet by more than the limit ([`Reduction::overdense`]), at least one
/// point is dropped, and of the reduced mesh no facet is turned so far, whatever its shape, except
/// where the bound's conditions ([`crate::noise::SpacingCriteria::packed_bound_mm`]) do not hold:
/// across holes, at points of unknown local feature size or measured too sparsely, along the outline
/// ([`crate::noise::Spacing::outline_area_mm2`]), and where gaps differ much from point to point.
/// [`crate::noise::assess_spacing`] of the reduced mesh tells.
///
/// With [`Keep::Most`] shares of that bound are tried first, and the first with which no facet of the
/// mesh is turned too far is taken. That takes the time of up to five meshes of the kept points.
///
/// Linear time on average for every ε up to ½; where facets must be mended n·log n.
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
    let lfs_anywhere_mm = lfs_mm;
    let lfs_mm: Vec<Option<f64>> =
        points.iter().map(|&point| target.lfs_mm(lfs_anywhere_mm(point))).collect();
    let mut triangles: Vec<[VertexId; 3]> = triangles.into_iter().collect();
    // A point without a dense triangle has its next one farther than ε allows.
    let nothing = About { gap_mm: f64::INFINITY, gap_nearby_mm: f64::INFINITY, cosine: 1.0 };
    let mut about = vec![nothing; points.len()];
    let (mut sparse, mut sparse_triangles) = (Sum::default(), 0);
    let mut turned = Vec::new();
    let mut refined = refined_gaps(points, &triangles).into_iter().peekable();
    let kept_triangles: Vec<bool> = triangles
        .iter()
        .enumerate()
        .map(|(index, &corners)| {
            let triangle = Triangle::new(points, corners);
            let thin = refined.next_if(|&(thin, _)| thin == index);
            let gap_mm = thin.map_or_else(|| triangle.gap().mm, |(_, gap)| gap.mm);
            let dense = corners.iter().all(|&corner| {
                lfs_mm[corner as usize].is_some_and(|lfs_mm| gap_mm <= target.epsilon() * lfs_mm)
            });
            let projected_mm2 = triangle.projected_area_mm2();
            if !dense {
                sparse.add(projected_mm2);
                sparse_triangles += 1;
                return false;
            }
            let cosine = (projected_mm2 / triangle.area_mm2()).max(f64::MIN_POSITIVE);
            for corner in corners {
                about[corner as usize].widen(gap_mm, cosine);
            }
            let places = corners.map(|corner| points[corner as usize]);
            let overdense =
                target.noise().and_then(|noise| target.criteria().is_overdense(places, noise));
            if overdense == Some(true) {
                turned.push(index);
            }
            thin.is_none()
        })
        .collect();
    let overdense = !turned.is_empty() && {
        let cut = cut_by_outline(points, &triangles);
        turned.iter().any(|index| cut.binary_search(index).is_err())
    };
    drop(turned);
    // Those of the surface: neither sparse nor a sliver that reaches over the outermost points.
    let mut of_surface = kept_triangles.into_iter();
    triangles.retain(|_| of_surface.next() == Some(true));
    let outline = on_outline(points.len(), &triangles);
    widen_nearby(&triangles, &mut about);
    drop(triangles);
    let spacing = |index: usize| match overdense {
        true => target.spacing(lfs_mm[index], about[index]),
        false => target.spacing_where_not_overdense(lfs_mm[index], about[index]),
    };
    // The bound holds for the worst of facets; often a smaller share of it will do.
    let shares = if overdense && target.keep() == Keep::Most { &SHARES[..] } else { &[] };
    let tried = shares.iter().find_map(|&share| {
        let packed = pack(points, &outline, |index| spacing(index).scaled(share));
        passes(points, &packed.0, target).then_some(packed)
    });
    let (mut kept, mut tally) = tried.unwrap_or_else(|| pack(points, &outline, spacing));
    let narrowest_mm = |index: usize| match overdense {
        true => target.narrowest_mm(about[index]),
        false => 0.0,
    };
    let lfs_mm = |place: PointMm| target.lfs_mm(lfs_anywhere_mm(place));
    let mending = Mending { points, epsilon: target.epsilon(), lfs_mm, narrowest_mm };
    let Mended { added, shortfall } = mending.mend(&mut kept);
    added.iter().for_each(|&index| tally.take_back(spacing(index as usize).bound()));
    Reduction {
        retained: kept,
        tally,
        mended: added.len() as u64,
        shortfall,
        overdense,
        sparse_area_mm2: sparse.total(),
        sparse_triangles,
    }
}

/// Notes for every point the widest gap at the corners of its triangles.
fn widen_nearby(triangles: &[[VertexId; 3]], about: &mut [About]) {
    for corners in triangles {
        let widest_mm =
            corners.map(|corner| about[corner as usize].gap_mm).into_iter().fold(0.0, f64::max);
        for &corner in corners {
            let nearby_mm = &mut about[corner as usize].gap_nearby_mm;
            *nearby_mm = if nearby_mm.is_finite() { nearby_mm.max(widest_mm) } else { widest_mm };
        }
    }
}

/// Keeps points at their spacings, those of the outline first.
fn pack(
    points: &[PointMm],
    outline: &[bool],
    spacing: impl Fn(usize) -> Spacing,
) -> (Vec<VertexId>, Tally) {
    let mut reducer = Reducer::new();
    let mut kept = Vec::new();
    for on_outline in [true, false] {
        for (index, &point) in (0..).zip(points) {
            if outline[index as usize] == on_outline
                && let Fate::Kept(_) = reducer.take(point, spacing(index as usize))
            {
                kept.push(index);
            }
        }
    }
    kept.sort_unstable();
    (kept, *reducer.tally())
}

/// Whether noise turns no facet of the mesh of these points too far.
fn passes(points: &[PointMm], kept: &[VertexId], target: &Target) -> bool {
    let mut mesh = Mesh::new();
    mesh.extend(kept.iter().map(|&index| points[index as usize]));
    mesh.flush();
    let noise = |_, _| target.noise();
    let found =
        assess_spacing(mesh.points(), mesh.triangles(), target.criteria(), noise, |_, _| 1.0);
    found.overdense_area_mm2 == 0.0
}

/// Shares of the bound that are tried where as many points as possible are to be kept. An even raster
/// needs 0.55 to 0.75 of it.
const SHARES: [f64; 5] = [0.5, 0.6, 0.7, 0.8, 0.9];

impl About {
    /// Takes in a triangle: the widest gap and the steepest slope count.
    fn widen(&mut self, gap_mm: f64, cosine: f64) {
        self.gap_mm = if self.gap_mm.is_finite() { self.gap_mm.max(gap_mm) } else { gap_mm };
        self.cosine = self.cosine.min(cosine);
    }
}

/// The distances of finite points to their nearest neighbours; `None` with fewer than two points.
/// Takes n·log n time.
pub fn spread(points: &[PointMm]) -> Option<Spread> {
    let tree = WeightedTree::of_points(points);
    let mut distances_mm = Vec::with_capacity(points.len());
    for (number, &point) in (0..).zip(points) {
        let (_, distance_mm) = tree.nearest(point, |other| other != number)?;
        distances_mm.push(distance_mm);
    }
    let middle = distances_mm.len().checked_sub(1)? / 2;
    let (below, median_mm, above) = distances_mm.select_nth_unstable_by(middle, f64::total_cmp);
    Some(Spread {
        min_mm: below.iter().copied().fold(*median_mm, f64::min),
        median_mm: *median_mm,
        max_mm: above.iter().copied().fold(*median_mm, f64::max),
    })
}
