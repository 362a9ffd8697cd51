//! A reference made from the points, kept up while they still arrive.
//!
//! Every point adds its products of splines to the normal equations over a net, and its distance to one cell of a map;
//! both are about a surface the points have already. An estimate solves the normal equations over the cells that hold
//! points: the sum of the squares follows from them exactly, and the distances in the cells of the map change with the
//! splines. In between, always when a point arrives and never when somebody asks:
//!
//! * when points have grown by an eighth, or less where what they leave has grown more, the smoothness is chosen anew from
//!   the sums alone, and they are moved to the surface that gives;
//! * when points or their extent have grown so far that a reference made anew would have other knots, when a point lies
//!   beyond the net, which reaches an eighth of the longer side over the points it was made for, and when points have
//!   doubled, base, net and sums are made anew from all of them.
//!
//! An estimate of fewer than 512 points is that of a reference made for it alone.
//!
//! So knots and sums are at nearly all moments those a reference made anew would have: knots lie at multiples of a distance
//! that goes in steps. What differs is the base, fitted to fewer points, and how the smoothness is looked for.

use super::SplineFit;
use super::accumulated::{Accumulated, FEW, FINEST};
use super::reference::{Base, ReferenceError, ReferenceSettings, made};
use crate::{Fit, Grid, LiveError, LiveEstimate, PointMm};

/// The running estimator where no design is known: as [`crate::Live`], of the surface [`crate::reference()`] makes.
///
/// After [`LiveReference::settle`] its figures are those of that reference, but for what linearisation leaves out, some
/// millionths; so they are of fewer than 512 points, of which an estimate makes it anew. Of more, base and net are those of
/// fewer points. RMS is then within 2 % and PV within 5 % of those of a reference made anew from the same points, usually
/// within 0.2 %, whether noise is what is left, or a defect or waves the knots cannot follow.
///
/// PV is that of the points that were largest and smallest in their cell of the map, about the surface there was when
/// they came.
///
/// Knots are no nearer to each other than 40 cells over the longer side make them, and no finer than the points allow
/// so far, which bounds what an estimate costs. Finer ones are for [`crate::reference()`] in the end.
///
/// It keeps every point, 24 bytes each, beside 480 bytes for each cell of the net and 150 for each of the map.
#[derive(Clone, Debug)]
pub struct LiveReference {
    settings: ReferenceSettings,
    grid: Grid,
    points: Vec<PointMm>,
    /// Number of points at which the next full reference is made.
    next_reference: usize,
    /// Number of points when knots got another distance.
    stepped_at: usize,
    kept: Option<Accumulated>,
    failure: Option<ReferenceError>,
}

impl LiveReference {
    /// An estimator without points, with a map over `grid` in the part frame. Fails on an impossible grid; what else is
    /// wrong with the settings, the first reference finds: see [`LiveReference::failure`].
    pub fn new(settings: ReferenceSettings, grid: Grid) -> Result<LiveReference, LiveError> {
        LiveReference::from_points(settings, grid, Vec::new())
    }

    /// An estimator that has taken points already, settled. Fails on an impossible grid.
    pub fn from_points(
        settings: ReferenceSettings,
        grid: Grid,
        points: Vec<PointMm>,
    ) -> Result<LiveReference, LiveError> {
        grid.validate()?;
        let (next_reference, kept, failure) = (FIRST_REFERENCE, None, None);
        let mut live =
            LiveReference { settings, grid, points, next_reference, stepped_at: 0, kept, failure };
        if live.points.len() >= FIRST_REFERENCE {
            live.settle();
        }
        Ok(live)
    }

    /// Takes a point of the measured frame. `O(1)`, but `O(n)` and the time of a full reference whenever one is made of n
    /// points, which happens as often as the logarithm of points and extent grows: amortised constant.
    pub fn push(&mut self, point: PointMm) {
        self.points.push(point);
        if self.points.len() >= self.next_reference {
            return self.settle();
        }
        let Some(kept) = &mut self.kept else { return };
        let outgrown = !kept.add(point, &self.grid) && kept.can_widen;
        let is_due =
            |at: usize| self.points.len() > at + at / if at < FEW { REMADE_FEW } else { REMADE };
        let outdated = is_due(kept.made_at) && kept.is_outdated()
            || is_due(self.stepped_at) && kept.has_other_knots();
        // Where a finer or wider net was refused, the next is tried with twice the points.
        if self.failure.is_none() && (outgrown || outdated) {
            return self.refer();
        }
        kept.keep_up();
    }

    /// Takes all points of another estimator, as if they had been pushed here after those that are here. Fails unless
    /// settings and grid are the same, and then changes nothing.
    pub fn merge(&mut self, other: LiveReference) -> Result<(), LiveError> {
        if self.settings != other.settings || self.grid != other.grid {
            return Err(LiveError::Different { what: "settings" });
        }
        other.points.into_iter().for_each(|point| self.push(point));
        Ok(())
    }

    /// Makes the reference of all points so far anew. `O(n)`, and what [`crate::reference()`] takes for its splines.
    pub fn settle(&mut self) {
        self.next_reference = (2 * self.points.len()).max(FIRST_REFERENCE);
        self.refer();
    }

    fn refer(&mut self) {
        match self.of_all() {
            Ok(kept) => {
                if self.kept.as_ref().is_none_or(|before| before.step_mm != kept.step_mm) {
                    self.stepped_at = self.points.len();
                }
                self.kept = Some(kept);
                self.failure = None;
            }
            Err(failure) => self.failure = Some(failure),
        }
    }

    /// All points about a reference made of them.
    fn of_all(&self) -> Result<Accumulated, ReferenceError> {
        let made = made(&self.points, &self.settings, FINEST)?;
        Ok(Accumulated::of_points(made, &self.points, &self.settings, &self.grid))
    }

    /// The figures of the points so far; `None` before the first reference could be made. The cost depends on the
    /// cells of net and map, not on the number of points.
    pub fn estimate(&self) -> Option<LiveEstimate> {
        let kept = self.kept.as_ref()?;
        if self.points.len() < CHEAP
            && let Ok(anew) = self.of_all()
        {
            return anew.estimate(&self.grid);
        }
        kept.estimate(&self.grid)
    }

    /// The criterion, as reports give it; `None` before the first reference.
    pub fn method(&self) -> Option<&'static str> {
        self.kept.as_ref().map(|kept| kept.base.method())
    }

    /// What lies under the splines, and its fit to a sample of the points, as of the last full reference.
    pub fn base(&self) -> Option<(Base, &Fit)> {
        self.kept.as_ref().map(|kept| (kept.base, &*kept.base_fit))
    }

    /// The splines, as of the last time their smoothness was chosen.
    pub fn spline(&self) -> Option<&SplineFit> {
        self.kept.as_ref().map(|kept| &kept.spline)
    }

    /// Points taken, of whatever kind.
    pub fn taken(&self) -> usize {
        self.points.len()
    }

    /// Why the latest attempt at a full reference gave none; `None` if it gave one or there was no attempt.
    pub fn failure(&self) -> Option<&ReferenceError> {
        self.failure.as_ref()
    }
}

/// Points before the first attempt at a reference.
const FIRST_REFERENCE: usize = 64;
/// Of fewer points an estimate makes the reference anew, in some 2 ms.
const CHEAP: usize = 512;
/// No net is remade for the same reason, unless a point lies beyond, before points have grown by one of so many parts, few
/// points and more.
const REMADE_FEW: usize = 64;
const REMADE: usize = 16;
