//! Corners of a ring that are cut off where one of its vertices does not see what lies behind.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use super::ends::{doubled_area_mm2, is_left_turn};
use crate::PlaceMm;

/// The vertices of a ring that are left, numbered round it from the one that is to see all others.
///
/// Stars of straight rows may have thousands: so corners queue, and n of them take n·log n time.
#[derive(Default)]
pub(super) struct Ears {
    after: Vec<usize>,
    before: Vec<usize>,
    /// Whether the first does not see the side from each vertex to the next.
    is_hidden: Vec<bool>,
    /// How often each was queued: what was queued before is void.
    rounds: Vec<u32>,
    queue: BinaryHeap<Ear>,
}

/// A corner that may be cut off: that which leaves the most to be seen goes first, of equal ones the first round the ring.
struct Ear {
    seen_mm2: f64,
    corner: Reverse<usize>,
    round: u32,
}

impl Ears {
    /// Cuts corners off and gives each with its neighbours to `take`, until the first vertex sees all others; false if that cannot be.
    ///
    /// A corner goes if it hides something, and if `vertex`, which lies within the ring, sees the side that comes instead.
    pub(super) fn cut(
        &mut self,
        count: usize,
        vertex: PlaceMm,
        at: impl Fn(usize) -> PlaceMm,
        mut take: impl FnMut([usize; 3]),
    ) -> bool {
        let is_hidden = |from: usize, to: usize| !is_left_turn(at(0), at(from), at(to));
        self.start(count);
        let mut hidden = 0;
        for corner in 1..count - 1 {
            self.is_hidden[corner] = is_hidden(corner, corner + 1);
            hidden += usize::from(self.is_hidden[corner]);
        }
        (1..count).for_each(|corner| self.queue(corner, vertex, &at));
        let mut left = count;
        while hidden > 0 {
            if left < 4 {
                return false;
            }
            let Some(Ear { corner: Reverse(corner), round, .. }) = self.queue.pop() else {
                return false;
            };
            if round != self.rounds[corner] {
                continue;
            }
            let [a, c] = [self.before[corner], self.after[corner]];
            take([a, corner, c]);
            (self.after[a], self.before[c]) = (c, a);
            left -= 1;
            hidden -= usize::from(self.is_hidden[corner]) + usize::from(self.is_hidden[a]);
            // All that leads to the first vertex or from it is seen.
            self.is_hidden[a] = a != 0 && c != 0 && is_hidden(a, c);
            hidden += usize::from(self.is_hidden[a]);
            for corner in [a, c].into_iter().filter(|&corner| corner != 0) {
                self.queue(corner, vertex, &at);
            }
        }
        true
    }

    /// The vertices that are left, round the ring from the first on.
    pub(super) fn left(&self) -> impl Iterator<Item = usize> {
        let next = |&corner: &usize| Some(self.after[corner]).filter(|&after| after != 0);
        std::iter::successors(Some(0), next)
    }

    fn start(&mut self, count: usize) {
        self.after.clear();
        self.after.extend((1..count).chain([0]));
        self.before.clear();
        self.before.extend([count - 1].into_iter().chain(0..count - 1));
        self.is_hidden.clear();
        self.is_hidden.resize(count, false);
        self.rounds.clear();
        self.rounds.resize(count, 0);
        self.queue.clear();
    }

    fn queue(&mut self, corner: usize, vertex: PlaceMm, at: &impl Fn(usize) -> PlaceMm) {
        self.rounds[corner] += 1;
        let [before, after] = [self.before[corner], self.after[corner]];
        if !(self.is_hidden[corner] || self.is_hidden[before]) {
            return;
        }
        let [a, b, c] = [before, corner, after].map(at);
        if is_left_turn(a, b, c) && is_left_turn(vertex, a, c) {
            // Nought has no sign here.
            let seen_mm2 = doubled_area_mm2(at(0), a, c) + 0.0;
            self.queue.push(Ear { seen_mm2, corner: Reverse(corner), round: self.rounds[corner] });
        }
    }
}

impl Ord for Ear {
    fn cmp(&self, other: &Ear) -> Ordering {
        self.seen_mm2.total_cmp(&other.seen_mm2).then(self.corner.cmp(&other.corner))
    }
}

impl PartialOrd for Ear {
    fn partial_cmp(&self, other: &Ear) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ear {
    fn eq(&self, other: &Ear) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Ear {}
