//! The state of the sampling: how far the surface lies from its samples, and whether that will do.
//!
//! **Gap.** Over a triangle of the mesh, lifted to its heights, the gap is the largest distance from
//! a point of the triangle to the nearest of its three corners: the circumradius, or less where an
//! angle is obtuse. Another vertex may be nearer still in space, never farther: the gap is an upper
//! bound of the distance from the mesh to the nearest sample. Thin triangles along the outline reach
//! over samples that are not their corners; their gap is bounded by those (see `rim.rs`).
//!
//! **Places.** The distance to the nearest sample differs from place to place of a triangle: 0 at its corners, the gap
//! at the farthest place. Percentiles and areas are those of places (see `nearness.rs`); the state of a triangle is
//! that of its farthest one.
//!
//! **ε.** A set of samples is an ε-sample of a surface if every point x of the surface has a sample
//! within ε·lfs(x), with lfs(x) the distance from x to the medial axis (N. Amenta, M. Bern, Discrete
//! & Computational Geometry 22 (1999) 481-504, doi:10.1007/PL00009475). The ε of a triangle is its
//! gap over the smallest lfs at its three corners. lfs changes by no more than the way gone, which is
//! no longer than the gap to the nearest corner: so if the true lfs is passed, no point of the triangle
//! has a ratio above ε / (1 - ε), at the limits in use a difference in the second digit. Cocone's guarantees
//! need ε < 0.05 (W. El-Hayek et al., J. Phys.: Conf. Ser. 483 (2014) 012003,
//! doi:10.1088/1742-6596/483/1/012003, table 1); the caller passes the limit that counts.
//!
//! **Gaps in the outline.** A Delaunay triangulation fills the convex hull. Triangles that bridge a
//! hole, a hollow of the outline or the part not scanned yet have large gaps, so a gap limit sorts
//! them out. Thin triangles along a convex outline have small gaps and little area, and stay.

mod bins;
mod running;

use asphera_geometry::nearness::{Entry, Nearness, quantile};
use asphera_geometry::{Gap, PointMm, Sum, Triangle, VertexId};

pub use self::running::{RunningSampling, RunningSpread};
use crate::rim::refined_gaps;

/// When a triangle is sampled densely enough. Without a limit every triangle is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Criteria {
    /// Largest allowed gap in mm.
    pub gap_limit_mm: Option<f64>,
    /// Largest allowed ε: gap over local feature size.
    pub epsilon_limit: Option<f64>,
    /// Projected area in mm² the whole aperture has; the reference of the coverage.
    pub aperture_area_mm2: Option<f64>,
}

/// Whether a triangle is sampled densely enough, and if not, why.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// Within all limits.
    Good,
    /// The gap is above its limit, whatever ε is: a gap in the data, or a bridge over what is not
    /// surface.
    OverGap,
    /// The gap is within its limit or has none, but the surface bends too much for it: ε is above
    /// its limit.
    OverEpsilon,
}

/// How many triangles are in each [`State`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StateCounts {
    /// Triangles sampled densely enough.
    pub good: u64,
    /// Triangles whose gap is above its limit.
    pub over_gap: u64,
    /// Triangles of which only ε is above its limit.
    pub over_epsilon: u64,
}

/// The state of the sampling of a set of triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sampling {
    /// How many triangles are in each state.
    pub triangles: StateCounts,
    /// Area in space in mm².
    pub area_mm2: f64,
    /// Area of the projection in mm².
    pub projected_area_mm2: f64,
    /// Projected area in mm² of the places that are not within the limits.
    pub undersampled_area_mm2: f64,
    /// Largest gap in mm; `None` without triangles.
    pub gap_max_mm: Option<f64>,
    /// Where the largest gap is; the first triangle's of several.
    pub gap_max_at_mm: Option<PointMm>,
    /// Largest ε, perhaps infinite; `None` without triangles.
    pub epsilon_max: Option<f64>,
    /// 99th percentile of ε by area: 99 % of the area in space are places up to it.
    pub epsilon_p99: Option<f64>,
    /// Projected area of the places within the limits over that of the aperture, or where the criteria name
    /// none, of all triangles. `None` if that area is not positive. Above 1 where the triangles
    /// reach beyond the aperture.
    pub coverage: Option<f64>,
}

/// A set of triangles with the state of each, and their figures.
#[derive(Clone, Debug)]
pub struct Survey {
    triangles: Vec<[VertexId; 3]>,
    /// One for each triangle.
    states: Vec<State>,
    sampling: Sampling,
}

impl Survey {
    /// The figures of all triangles.
    pub fn sampling(&self) -> &Sampling {
        &self.sampling
    }

    /// The triangles and their states, in the order in which they were given.
    pub fn triangles(&self) -> impl Iterator<Item = ([VertexId; 3], State)> + '_ {
        self.triangles.iter().copied().zip(self.states.iter().copied())
    }

    /// The triangles sampled densely enough: what is known of the surface.
    pub fn good(&self) -> impl Iterator<Item = [VertexId; 3]> + '_ {
        self.triangles().filter_map(|(corners, state)| (state == State::Good).then_some(corners))
    }
}

/// Gauges `triangles`, whose corners are indices into `points`.
///
/// `lfs_mm(x, y)` is the local feature size of the surface in mm; infinite over a plane. An upper
/// bound of it, such as the smaller radius of curvature, gives a lower bound of ε. It is asked for
/// once for each point. A local feature size that is not a positive
/// number makes ε infinite.
///
/// What lies outside the aperture is left out by not passing it. Linear time on average, and some
/// 40 bytes of memory a triangle.
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn assess(
    points: &[PointMm],
    triangles: impl IntoIterator<Item = [VertexId; 3]>,
    criteria: &Criteria,
    lfs_mm: impl Fn(f64, f64) -> f64,
) -> Survey {
    let triangles: Vec<[VertexId; 3]> = triangles.into_iter().collect();
    let lfs_at_points_mm: Vec<f64> = points.iter().map(|&[x, y, _]| lfs_mm(x, y)).collect();
    let mut refined = refined_gaps(points, &triangles).into_iter().peekable();
    let mut states = Vec::with_capacity(triangles.len());
    let mut tally = Tally::default();
    for (index, &corners) in triangles.iter().enumerate() {
        let triangle = Triangle::new(points, corners);
        let gap = match refined.next_if(|&(thin, _)| thin == index) {
            Some((_, gap)) => gap,
            None => triangle.gap(),
        };
        let lfs_mm = corners
            .into_iter()
            .map(|corner| sound(lfs_at_points_mm[corner as usize]))
            .fold(f64::INFINITY, f64::min);
        let epsilon = gap.mm / lfs_mm;
        let state = criteria.state(gap.mm, epsilon);
        let beyond = criteria.share_beyond(state, &triangle.nearness(gap.mm), lfs_mm);
        tally.add(&triangle, (state, beyond), gap, lfs_mm);
        states.push(state);
    }
    Survey { triangles, states, sampling: tally.figures(criteria.aperture_area_mm2) }
}

impl Criteria {
    /// The state of a triangle. A value equal to its limit is within it.
    pub(crate) fn state(&self, gap_mm: f64, epsilon: f64) -> State {
        if self.gap_limit_mm.is_some_and(|limit_mm| gap_mm > limit_mm) {
            State::OverGap
        } else if self.epsilon_limit.is_some_and(|limit| epsilon > limit) {
            State::OverEpsilon
        } else {
            State::Good
        }
    }

    /// The share of a triangle in that state that is not within the limits.
    pub(crate) fn share_beyond(&self, state: State, nearness: &Nearness, lfs_mm: f64) -> f64 {
        if state == State::Good {
            return 0.0;
        }
        let of_epsilon_mm = self.epsilon_limit.map_or(f64::INFINITY, |limit| limit * lfs_mm);
        nearness.share_beyond(self.gap_limit_mm.unwrap_or(f64::INFINITY).min(of_epsilon_mm))
    }
}

/// What the figures are made of.
#[derive(Default)]
struct Tally {
    counts: StateCounts,
    area: Sum,
    good: Sum,
    undersampled: Sum,
    projected: Sum,
    widest: Option<Gap>,
    /// The largest ε.
    worst: Option<f64>,
    /// Each triangle with the smallest local feature size at its corners.
    places: Vec<Entry>,
}

impl Tally {
    fn add(&mut self, triangle: &Triangle, (state, beyond): (State, f64), gap: Gap, lfs_mm: f64) {
        let projected_mm2 = triangle.projected_area_mm2();
        self.area.add(triangle.area_mm2());
        self.projected.add(projected_mm2);
        let count = match state {
            State::Good => &mut self.counts.good,
            State::OverGap => &mut self.counts.over_gap,
            State::OverEpsilon => &mut self.counts.over_epsilon,
        };
        *count += 1;
        self.good.add(projected_mm2 * (1.0 - beyond));
        self.undersampled.add(projected_mm2 * beyond);
        if self.widest.is_none_or(|widest| gap.mm > widest.mm) {
            self.widest = Some(gap);
        }
        let epsilon = gap.mm / lfs_mm;
        self.worst = Some(self.worst.map_or(epsilon, |worst| worst.max(epsilon)));
        let nearness = triangle.nearness(gap.mm);
        self.places.push(Entry { nearness, unit_mm: lfs_mm, weight: 1.0 });
    }

    fn figures(self, aperture_area_mm2: Option<f64>) -> Sampling {
        let projected_mm2 = self.projected.total();
        let reference_mm2 = aperture_area_mm2.unwrap_or(projected_mm2);
        Sampling {
            triangles: self.counts,
            area_mm2: self.area.total(),
            projected_area_mm2: projected_mm2,
            undersampled_area_mm2: self.undersampled.total(),
            gap_max_mm: self.widest.map(|gap| gap.mm),
            gap_max_at_mm: self.widest.map(|gap| gap.at_mm),
            epsilon_max: self.worst,
            epsilon_p99: quantile(&self.places, 0.99),
            coverage: (reference_mm2 > 0.0).then(|| self.good.total() / reference_mm2),
        }
    }
}

/// The local feature size, or 0 where there is none: a surface without one is undersampled.
fn sound(lfs_mm: f64) -> f64 {
    if lfs_mm > 0.0 { lfs_mm } else { 0.0 }
}
