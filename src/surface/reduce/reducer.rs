//! Points kept or dropped as they arrive.

use asphera_geometry::{PointMm, Rejection, TINY_MM, admit};

use super::grid::Grid;
use super::target::squared_mm2;
use super::{Bound, Spacing};

/// Keeps each point that arrives unless one kept before lies nearer than its spacing.
///
/// The points kept are *packed*, none nearer to an earlier one than its own spacing, and they
/// *cover* the rest: every dropped point has one within its spacing. Both hold for any points and
/// any spacings. A distance that falls short of the spacing by less than a part in 10⁹ counts as
/// the spacing, so that rounding does not thin a raster unevenly.
///
/// ```
/// use asphera_surface::reduce::{Fate, Reducer, Spacing};
///
/// let mut reducer = Reducer::new();
/// let spacing = Spacing::given(0.2)?;
/// assert_eq!(reducer.take([0.0, 0.0, 0.0], spacing), Fate::Kept(0));
/// assert_eq!(reducer.take([0.1, 0.0, 0.0], spacing), Fate::Dropped { by: 0 });
/// assert_eq!(reducer.take([0.2, 0.0, 0.0], spacing), Fate::Kept(1));
/// assert_eq!(reducer.arrivals(), [0, 2]);
/// # Ok::<(), asphera_surface::reduce::TargetError>(())
/// ```
#[derive(Default)]
pub struct Reducer {
    /// The kept points, in order of arrival.
    points: Vec<PointMm>,
    /// When each arrived, counted from 0.
    arrivals: Vec<u64>,
    /// One for each power of two that spacings asked for so far; each holds all kept points.
    grids: Vec<Grid>,
    /// The kept point that was met last.
    recent: u32,
    tally: Tally,
}

/// Fate of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It is kept; the kept points are numbered from 0 in order of arrival.
    Kept(u32),
    /// It is dropped.
    Dropped {
        /// A kept point nearer than the spacing, not always the nearest.
        by: u32,
    },
    /// It is no point.
    Rejected(Rejection),
}

/// How many points there were, by what their spacing followed from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Those whose spacing satisfies both conditions.
    pub epsilon: Split,
    /// Those whose spacing follows from the noise and is wider than ε allows.
    pub noise: Split,
    /// Those measured hardly densely enough for ε, before any reduction.
    pub sparse: Split,
    /// Those of unknown local feature size, all of them kept.
    pub unknown: Split,
    /// Those whose spacing was given as a length.
    pub given: Split,
    /// Those not finite or out of range.
    pub rejected: u64,
}

/// How many points of a kind were kept and dropped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Split {
    /// How many were kept.
    pub retained: u64,
    /// How many were dropped.
    pub dropped: u64,
}

impl Reducer {
    /// Without points.
    pub fn new() -> Reducer {
        Reducer::default()
    }

    /// Takes the next point and says what becomes of it.
    ///
    /// Takes constant time where the spacing of neighbours differs by no more than half their
    /// distance, as every spacing that follows from ε ≤ ½ does; a spacing that jumps is right but
    /// may be slower. Spacings over a range of 2ᵏ cost k + 1 times the memory of a grid, 8 to 12
    /// bytes a kept point.
    ///
    /// # Panics
    ///
    /// At 2³² - 1 kept points.
    pub fn take(&mut self, point: PointMm, spacing: Spacing) -> Fate {
        let point = match admit(point) {
            Ok(point) => point,
            Err(rejection) => {
                self.tally.rejected += 1;
                return Fate::Rejected(rejection);
            }
        };
        let arrival = self.tally.total();
        let covered = self.covering(point, spacing.mm());
        let split = self.tally.of(spacing.bound());
        if let Some(by) = covered {
            split.dropped += 1;
            self.recent = by;
            return Fate::Dropped { by };
        }
        split.retained += 1;
        let number = u32::try_from(self.points.len())
            .ok()
            .filter(|&number| number < u32::MAX)
            .expect("fewer than 2^32 - 1 points are kept");
        self.points.push(point);
        self.arrivals.push(arrival);
        self.grids.iter_mut().for_each(|grid| grid.push(&self.points));
        self.recent = number;
        Fate::Kept(number)
    }

    /// The kept points in order of arrival.
    pub fn points(&self) -> &[PointMm] {
        &self.points
    }

    /// For each kept point, how many were taken before it: its index in the stream.
    pub fn arrivals(&self) -> &[u64] {
        &self.arrivals
    }

    /// How many points there were of each kind.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// A kept point nearer than the spacing.
    fn covering(&mut self, point: PointMm, spacing_mm: f64) -> Option<u32> {
        // Below this no two admitted points differ by less and are not the same: only those in one
        // place would be found, and the mesh counts them.
        if spacing_mm < TINY_MM {
            return None;
        }
        let below_mm = spacing_mm * (1.0 - TOLERANCE);
        let below_mm2 = below_mm * below_mm;
        // On a scan line the point that covers one most often covers the next.
        if let Some(&recent) = self.points.get(self.recent as usize)
            && squared_mm2(recent, point) < below_mm2
        {
            return Some(self.recent);
        }
        let exponent = Grid::exponent(spacing_mm);
        let known = self.grids.iter().position(|grid| grid.side_exponent() == exponent);
        let index = known.unwrap_or_else(|| {
            self.grids.push(Grid::new(exponent, &self.points));
            self.grids.len() - 1
        });
        self.grids[index].any_within(point, spacing_mm, below_mm2, &self.points)
    }
}

impl Tally {
    /// How many points were kept.
    pub fn retained(&self) -> u64 {
        self.splits().iter().map(|split| split.retained).sum()
    }

    /// How many points were dropped.
    pub fn dropped(&self) -> u64 {
        self.splits().iter().map(|split| split.dropped).sum()
    }

    /// How many points there were, rejected ones included.
    pub fn total(&self) -> u64 {
        self.retained() + self.dropped() + self.rejected
    }

    /// A dropped point is kept after all.
    pub(super) fn take_back(&mut self, bound: Bound) {
        let split = self.of(bound);
        split.dropped -= 1;
        split.retained += 1;
    }

    fn splits(&self) -> [Split; 5] {
        [self.epsilon, self.noise, self.sparse, self.unknown, self.given]
    }

    fn of(&mut self, bound: Bound) -> &mut Split {
        match bound {
            Bound::Epsilon => &mut self.epsilon,
            Bound::Noise => &mut self.noise,
            Bound::Sparse => &mut self.sparse,
            Bound::Unknown => &mut self.unknown,
            Bound::Given => &mut self.given,
        }
    }
}

/// By what share a distance may fall short of the spacing: above the rounding of coordinates up to
/// 10⁵ spacings from the origin, below what any purpose can tell.
const TOLERANCE: f64 = 1e-9;
