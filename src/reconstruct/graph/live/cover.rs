//! Landmarks and the hops to them, kept up while edges come and go.
//!
//! Every point knows the landmarks fewer than k hops away, and how far they are: a label each, two on the average. A change of edges
//! mends labels ring by ring, where hops change and nowhere else (as S. Even, Y. Shiloach, An on-line edge-deletion problem, 1981, for one tree).
//!
//! A point is a landmark where none before it in the order lies that near. After labels have changed, points are decided again in their
//! order. Each that changes its mind changes labels of points near it, and so the minds of later ones alone.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use asphera_geometry::PointMm;

use super::near::{Before, EdgeChanges, Edges};
use crate::graph::landmarks::{FAR, hash};
use crate::neighbours::by_coordinates;

/// Which points are landmarks, and how far they are.
#[derive(Clone, Debug)]
pub(super) struct Cover {
    /// Landmarks are at least so many hops apart.
    apart: u8,
    /// Where each point is in the order.
    ranks: Vec<Rank>,
    is_landmark: Vec<bool>,
    /// For each point all landmarks that are fewer than `apart` hops away, in no order.
    labels: Vec<Vec<Label>>,
    /// Room for points near a landmark.
    ball: Vec<u32>,
}

/// A landmark, and hops to it.
#[derive(Clone, Copy, Debug)]
struct Label {
    landmark: u32,
    hops: u8,
}

/// Points whose labels of a landmark are to be mended, by hops.
type Rings = Vec<Vec<[u32; 2]>>;

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
        let (ranks, is_landmark, labels, ball) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Cover { apart, ranks, is_landmark, labels, ball }
    }

    fn is_landmark(&self, point: u32) -> bool {
        self.is_landmark[point as usize]
    }

    fn rank(&self, point: u32) -> &Rank {
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
        self.labels.resize(places_mm.len(), Vec::new());
    }

    /// The nearest landmark of a point and hops to it; of several as near the first in the order.
    pub(super) fn nearest(&self, point: u32) -> Option<(u32, u8)> {
        let labels = self.labels[point as usize].iter();
        let order = |a: &&Label, b: &&Label| {
            a.hops.cmp(&b.hops).then_with(|| self.rank(a.landmark).cmp(self.rank(b.landmark)))
        };
        labels.min_by(order).map(|label| (label.landmark, label.hops))
    }

    #[inline]
    fn hops(&self, point: u32, landmark: u32) -> u8 {
        let labels = &self.labels[point as usize];
        labels.iter().find(|label| label.landmark == landmark).map_or(FAR, |label| label.hops)
    }

    /// Sets the hops from a point to a landmark; [`FAR`] takes the label off.
    fn set_hops(&mut self, point: u32, landmark: u32, hops: u8) {
        let labels = &mut self.labels[point as usize];
        match labels.iter().position(|label| label.landmark == landmark) {
            Some(at) if hops == FAR => {
                labels.swap_remove(at);
            }
            Some(at) => labels[at].hops = hops,
            None => labels.push(Label { landmark, hops }),
        }
    }

    /// Mends labels after edges have changed; `met` is called with all points that have others.
    pub(super) fn mend(
        &mut self,
        edges: &Edges,
        (changes, linked): (&EdgeChanges, &Before),
        met: &mut impl FnMut(u32),
    ) {
        let mut rings: Rings = vec![Vec::new(); usize::from(self.apart)];
        for &point in linked.keys() {
            for label in &self.labels[point as usize] {
                rings[usize::from(label.hops)].push([label.landmark, point]);
            }
        }
        for &[start, end] in &changes.won {
            for [from, to] in [[start, end], [end, start]] {
                for &Label { landmark, hops } in &self.labels[from as usize] {
                    if hops + 1 < self.apart && self.hops(to, landmark) > hops + 1 {
                        rings[usize::from(hops) + 1].push([landmark, to]);
                    }
                }
            }
        }
        for hops in 0..self.apart {
            for [landmark, point] in std::mem::take(&mut rings[usize::from(hops)]) {
                self.mend_at(edges, [landmark, point], hops, &mut rings, met);
            }
        }
    }

    /// Mends the label of a point that may be so many hops from a landmark. All labels of fewer hops are right.
    fn mend_at(
        &mut self,
        edges: &Edges,
        [landmark, point]: [u32; 2],
        hops: u8,
        rings: &mut Rings,
        met: &mut impl FnMut(u32),
    ) {
        let before = self.hops(point, landmark);
        if before < hops {
            return;
        }
        let is_before = |near: &u32| hops > 0 && self.hops(*near, landmark) == hops - 1;
        let is_held = point == landmark || edges.at(point).iter().any(is_before);
        if !is_held && before > hops {
            return;
        }
        let next = hops + 1;
        // Without a neighbour that is nearer, it may be one hop farther, and so may those beyond it.
        let set = match is_held {
            true => hops,
            false if next < self.apart => next,
            false => FAR,
        };
        if set != before {
            self.set_hops(point, landmark, set);
            met(point);
        }
        // One that is as far as before may have new neighbours: it was farther, and nearer before that.
        let Some(ring) = rings.get_mut(usize::from(next)) else { return };
        if !is_held {
            ring.push([landmark, point]);
        }
        for &near in edges.at(point) {
            let found = self.hops(near, landmark);
            if if is_held { found > next } else { found == next } {
                ring.push([landmark, near]);
            }
        }
    }

    /// Decides points again, in their order; `met` is called with all points that have other labels.
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
            match is_chosen {
                true => self.spread(edges, point),
                false => self.withdraw(edges, point),
            }
            self.ball.iter().for_each(|&point| met(point));
            let later = self.ball.iter().filter(|&&other| self.is_wrong(other));
            waiting.extend(later.map(|&other| Reverse((self.ranks[other as usize], other))));
        }
    }

    /// Gives the points near a landmark its label, and notes them.
    fn spread(&mut self, edges: &Edges, landmark: u32) {
        let mut ball = std::mem::take(&mut self.ball);
        ball.clear();
        ball.push(landmark);
        self.set_hops(landmark, landmark, 0);
        let mut ring = 0..1;
        for hops in 1..self.apart {
            for at in ring.clone() {
                for &near in edges.at(ball[at]) {
                    if self.hops(near, landmark) == FAR {
                        self.labels[near as usize].push(Label { landmark, hops });
                        ball.push(near);
                    }
                }
            }
            ring = ring.end..ball.len();
        }
        self.ball = ball;
    }

    /// Takes the label of a landmark off all points, and notes them.
    fn withdraw(&mut self, edges: &Edges, landmark: u32) {
        let mut ball = std::mem::take(&mut self.ball);
        ball.clear();
        ball.push(landmark);
        self.set_hops(landmark, landmark, FAR);
        let mut at = 0;
        while let Some(&point) = ball.get(at) {
            at += 1;
            for &near in edges.at(point) {
                if self.hops(near, landmark) != FAR {
                    self.set_hops(near, landmark, FAR);
                    ball.push(near);
                }
            }
        }
        self.ball = ball;
    }

    /// Whether a point is a landmark and must not be, or the other way round.
    fn is_wrong(&self, point: u32) -> bool {
        let own = self.rank(point);
        let mut others = self.labels[point as usize].iter().map(|label| label.landmark);
        let is_covered = others.any(|other| other != point && self.rank(other) < own);
        self.is_landmark(point) == is_covered
    }
}

#[cfg(test)]
impl Cover {
    /// Asserts that labels are hops to landmarks, and that landmarks are the first ones in their order.
    pub(super) fn check(&self, edges: &Edges) {
        let mut expected = vec![Vec::new(); self.labels.len()];
        for landmark in self.landmarks() {
            let mut hops_of = vec![FAR; self.labels.len()];
            hops_of[landmark as usize] = 0;
            let mut ring = vec![landmark];
            for hops in 0..self.apart {
                let mut next = Vec::new();
                for &point in &ring {
                    expected[point as usize].push((landmark, hops));
                    for &near in edges.at(point) {
                        if hops_of[near as usize] == FAR {
                            hops_of[near as usize] = hops + 1;
                            next.push(near);
                        }
                    }
                }
                ring = next;
            }
        }
        for (point, expected) in (0..).zip(&mut expected) {
            let mut found: Vec<(u32, u8)> = self.labels[point as usize]
                .iter()
                .map(|label| (label.landmark, label.hops))
                .collect();
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(&found, expected, "labels of {point}");
            assert!(!self.is_wrong(point), "{point}");
        }
    }
}
