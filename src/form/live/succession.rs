//! A new reference by squares that is made on the way: a few points of those so far with each one that comes.
//!
//! Linearising millions of points at once takes seconds, in which points wait that arrive. So the reference stays in
//! use while the one that follows takes [`CATCHES_UP`] earlier points for each new one. It has all of them when half as many more
//! have come, long before the next one is due. What it is at a number of points does not hang on how they were handed over.

use crate::live::Live;
use crate::live::linearised::{Linearised, Place};

/// A reference that has some of the points.
#[derive(Clone, Debug)]
pub(super) struct Upcoming {
    linearised: Linearised,
    /// Points it has, the first ones.
    taken: usize,
}

impl Live {
    /// Begins a reference at an estimate, which follows the present one when it has all points. The present one has those
    /// before `new`, and goes on.
    pub(super) fn announce(&mut self, place: Place, new: usize) {
        let slant = self.settings.slant(&place.fit);
        let made_at = self.points.len();
        // Blocks and the uncertainty of a mean weight are those of a robust loss.
        let linearised = Linearised::new(place.fit, slant, made_at, 1, None, &self.settings);
        self.upcoming = Some(Box::new(Upcoming { linearised, taken: 0 }));
        if let Some(reference) = &mut self.reference {
            let u_mm = self.uncertainties_mm.get(new..).unwrap_or(&[]);
            reference.add_all(&self.points[new..], u_mm, &self.settings);
        }
    }

    /// Lets the reference that follows, if there is one, take so many more of the points. When it has all it takes over.
    pub(super) fn succeed(&mut self, most: usize) {
        let Some(mut upcoming) = self.upcoming.take() else { return };
        let next = upcoming.taken..self.points.len().min(upcoming.taken.saturating_add(most));
        let (points, u_mm) = (&self.points[next.clone()], self.uncertainties_mm.get(next.clone()));
        let u_mm = u_mm.unwrap_or(&[]);
        upcoming.taken = next.end;
        if most <= CATCHES_UP {
            for (index, &point) in points.iter().enumerate() {
                upcoming.linearised.add(point, u_mm.get(index).copied(), &self.settings);
            }
        } else {
            upcoming.linearised.add_all(points, u_mm, &self.settings);
        }
        if upcoming.taken == self.points.len() {
            self.reference = Some(upcoming.linearised);
        } else {
            self.upcoming = Some(upcoming);
        }
    }
}

/// Points taken for each that comes: the reference has them all when half as many more have come.
pub(super) const CATCHES_UP: usize = 3;
