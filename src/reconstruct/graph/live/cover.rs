//! Landmarks, kept up while edges come and go.
//!
//! A point is a landmark where none before it in the order lies fewer than k hops away: it is covered by no earlier one. So for every
//! point the earlier landmarks that near are counted. A change of the graph counts anew about the landmarks near it. Then points
//! are decided again in their order. Each that changes its mind changes the counts of later points alone.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use asphera_geometry::PointMm;

use super::near::Edges;
use crate::graph::landmarks::hash;
use crate::neighbours::by_coordinates;

/// Which points are landmarks.
#[derive(Clone, Debug)]
pub(super) struct Cover {
    /// Landmarks are at least so many hops apart.
    apart: u8,
    /// Where each point is in the order.
    ranks: Vec<Rank>,
    is_landmark: Vec<bool>,
    /// For each point the landmarks before it that are fewer than `apart` hops away.
    counts: Vec<u32>,
    marks: Marks,
    ring: Vec<u32>,
    next: Vec<u32>,
    ball: Vec<u32>,
}

/// A place in the order of priority.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rank {
    hash: u64,
    place: PointMm,
}

impl Rank {
    fn of(place: PointMm) -> Rank {
        Rank { hash: hash(place), place }
    }
}

impl PartialEq for Rank {
    fn eq(&self, other: &Rank) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Rank {}

impl PartialOrd for Rank {
    fn partial_cmp(&self, other: &Rank) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Rank {
    fn cmp(&self, other: &Rank) -> Ordering {
        let by_place = || by_coordinates(self.place, other.place);
        self.hash.cmp(&other.hash).then_with(by_place)
    }
}

/// Marks of points that are all taken back at once.
#[derive(Clone, Debug, Default)]
pub(super) struct Marks {
    now: u32,
    last: Vec<u32>,
}

impl Marks {
    /// Takes all marks back, of so many points.
    pub(super) fn clear(&mut self, points: usize) {
        self.now += 1;
        self.last.resize(points, 0);
    }

    /// Marks a point; gives whether it was not marked.
    #[inline]
    pub(super) fn mark(&mut self, point: u32) -> bool {
        std::mem::replace(&mut self.last[point as usize], self.now) != self.now
    }

    #[inline]
    pub(super) fn has(&self, point: u32) -> bool {
        self.last[point as usize] == self.now
    }
}

impl Cover {
    pub(super) fn new(apart: u8) -> Cover {
        Cover {
            apart,
            ranks: Vec::new(),
            is_landmark: Vec::new(),
            counts: Vec::new(),
            marks: Marks::default(),
            ring: Vec::new(),
            next: Vec::new(),
            ball: Vec::new(),
        }
    }

    pub(super) fn apart(&self) -> u8 {
        self.apart
    }

    pub(super) fn is_landmark(&self, point: u32) -> bool {
        self.is_landmark[point as usize]
    }

    pub(super) fn rank(&self, point: u32) -> &Rank {
        &self.ranks[point as usize]
    }

    /// The landmarks in their order.
    pub(super) fn landmarks(&self) -> Vec<u32> {
        let all = 0..self.is_landmark.len() as u32;
        let mut landmarks: Vec<u32> = all.filter(|&point| self.is_landmark(point)).collect();
        landmarks.sort_unstable_by_key(|&point| self.rank(point));
        landmarks
    }

    /// Takes the places of new points, which are no landmarks yet.
    pub(super) fn grow(&mut self, places_mm: &[PointMm]) {
        let new = &places_mm[self.ranks.len()..];
        self.ranks.extend(new.iter().map(|&place| Rank::of(place)));
        self.is_landmark.resize(places_mm.len(), false);
        self.counts.resize(places_mm.len(), 0);
    }

    /// Points at most so many hops from some, these included, into `ball`.
    fn fill_ball(&mut self, edges: &Edges, from: impl Iterator<Item = u32>, hops: u8) {
        let Cover { marks, ring, next, ball, .. } = self;
        marks.clear(self.ranks.len());
        ball.clear();
        ball.extend(from.filter(|&point| marks.mark(point)));
        ring.clone_from(ball);
        for _ in 0..hops {
            next.clear();
            for &inner in &*ring {
                next.extend(edges.at(inner).iter().copied().filter(|&outer| marks.mark(outer)));
            }
            ball.extend_from_slice(next);
            std::mem::swap(ring, next);
        }
    }

    /// The landmarks whose surroundings a change of edges with such ends may change. Before the change.
    pub(super) fn landmarks_near(
        &mut self,
        edges: &Edges,
        ends: impl Iterator<Item = u32>,
    ) -> Vec<u32> {
        // Of landmarks one hop apart nothing lies between.
        let Some(hops) = self.apart.checked_sub(2) else { return Vec::new() };
        let held = self.ranks.len() as u32;
        self.fill_ball(edges, ends.filter(|&end| end < held), hops);
        self.ball.iter().copied().filter(|&point| self.is_landmark(point)).collect()
    }

    /// Counts a landmark at all later points near it, or counts it no more; `met` is called with all points near it.
    pub(super) fn count(
        &mut self,
        edges: &Edges,
        landmark: u32,
        counts: bool,
        met: &mut impl FnMut(u32),
    ) {
        self.fill_ball(edges, std::iter::once(landmark), self.apart - 1);
        for &point in &self.ball {
            if self.ranks[landmark as usize] < self.ranks[point as usize] {
                let count = &mut self.counts[point as usize];
                *count = if counts { *count + 1 } else { *count - 1 };
            }
            met(point);
        }
    }

    /// Decides points again, in their order; `met` is called with all points near those that change.
    pub(super) fn decide(
        &mut self,
        edges: &Edges,
        points: impl Iterator<Item = u32>,
        met: &mut impl FnMut(u32),
    ) {
        let wrong = points.filter(|&point| self.is_wrong(point));
        let mut waiting: BinaryHeap<Reverse<(Rank, u32)>> =
            wrong.map(|point| Reverse((self.ranks[point as usize], point))).collect();
        while let Some(Reverse((_, point))) = waiting.pop() {
            if !self.is_wrong(point) {
                continue;
            }
            let is_chosen = !self.is_landmark(point);
            self.is_landmark[point as usize] = is_chosen;
            self.count(edges, point, is_chosen, met);
            let later = self.ball.iter().filter(|&&other| self.is_wrong(other));
            waiting.extend(later.map(|&other| Reverse((self.ranks[other as usize], other))));
        }
    }

    /// Whether a point is a landmark and must not be, or the other way round.
    fn is_wrong(&self, point: u32) -> bool {
        self.is_landmark(point) != (self.counts[point as usize] == 0)
    }
}
