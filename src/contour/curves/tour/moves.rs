//! Steps that shorten a tour.

use super::Order;
use crate::curves::ruler::Ruler;
use crate::{SampleId, Triangulation};

/// A step and what it takes off the tour.
#[derive(Clone, Copy)]
pub(super) struct Move {
    pub(super) gain: i64,
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    /// The edges a-b and c-d become a-c and b-d.
    Reverse([SampleId; 2], [SampleId; 2]),
    /// A piece goes between two samples that follow each other.
    Shift {
        /// The piece's first and last sample, and those beside it.
        piece: [SampleId; 2],
        beside: [SampleId; 2],
        /// Where it goes, in the direction from first to last.
        into: [SampleId; 2],
        /// Whether the piece keeps its direction.
        keeps: bool,
    },
}

impl Move {
    /// Takes the step; the samples whose neighbours changed.
    pub(super) fn take(self, order: &mut Order) -> Vec<SampleId> {
        let ends = match self.kind {
            Kind::Reverse([a, b], [c, d]) => vec![a, b, c, d],
            Kind::Shift { piece: [a, z], beside: [before, after], into: [c, d], .. } => {
                vec![a, z, before, after, c, d]
            }
        };
        let neighbours = |order: &Order, sample: SampleId| {
            let [p, q] = [true, false].map(|is_after| order.beside(sample, is_after));
            [p.min(q), p.max(q)]
        };
        let old: Vec<_> = ends.iter().map(|&sample| (sample, neighbours(order, sample))).collect();
        self.exchange(order);
        let changed = old.into_iter().filter(|&(sample, old)| neighbours(order, sample) != old);
        changed.map(|(sample, _)| sample).collect()
    }

    fn exchange(self, order: &mut Order) {
        match self.kind {
            Kind::Reverse(ab, cd) => order.exchange(ab, cd),
            Kind::Shift { piece: [a, z], beside: [before, after], into: [c, d], keeps } => {
                // before a..z after ... c d  ->  before c ... after z..a d  ->  before after ... c z..a d
                order.exchange([before, a], [c, d]);
                order.exchange([before, c], [after, z]);
                if keeps {
                    order.exchange([c, z], [a, d]);
                }
            }
        }
    }
}

/// What steps are made of.
pub(super) struct Moves<'a> {
    pub(super) triangulation: &'a Triangulation,
    pub(super) ruler: &'a Ruler,
    pub(super) near: &'a [Vec<SampleId>],
}

impl Moves<'_> {
    fn length(&self, p: SampleId, q: SampleId) -> i64 {
        self.ruler.length(self.triangulation.place(p), self.triangulation.place(q))
    }

    /// The step of most gain that gives a sample an edge to one near it; none if no step gains.
    pub(super) fn best(&self, order: &Order, sample: SampleId) -> Option<Move> {
        let mut best: Option<Move> = None;
        let mut offer = |step: Move| {
            if step.gain > best.map_or(0, |best| best.gain) {
                best = Some(step);
            }
        };
        for is_after in [true, false] {
            self.reversals(order, sample, is_after, &mut offer);
            for count in 1..=LONGEST_PIECE.min(order.len().saturating_sub(3)) {
                self.shifts(order, sample, is_after, count, &mut offer);
            }
        }
        best
    }

    fn reversals(&self, order: &Order, a: SampleId, is_after: bool, offer: &mut impl FnMut(Move)) {
        let b = order.beside(a, is_after);
        let old = self.length(a, b);
        for &c in &self.near[a as usize] {
            let new = self.length(a, c);
            if new >= old {
                return;
            }
            let d = order.beside(c, is_after);
            let gain = old + self.length(c, d) - new - self.length(b, d);
            offer(Move { gain, kind: Kind::Reverse([a, b], [c, d]) });
        }
    }

    /// Shifts of the piece that begins with a sample and goes on in one direction.
    fn shifts(
        &self,
        order: &Order,
        a: SampleId,
        is_after: bool,
        count: usize,
        offer: &mut impl FnMut(Move),
    ) {
        let mut piece = [a; LONGEST_PIECE];
        for index in 1..count {
            piece[index] = order.beside(piece[index - 1], is_after);
        }
        let piece = &piece[..count];
        let z = piece[count - 1];
        let beside = [order.beside(a, !is_after), order.beside(z, is_after)];
        let [before, after] = beside;
        let freed = self.length(before, a) + self.length(z, after) - self.length(before, after);
        for &c in &self.near[a as usize] {
            for keeps in [true, false] {
                // a comes beside c, z beside the sample on the other side of the gap.
                let d = order.beside(c, is_after == keeps);
                if piece.contains(&c) || piece.contains(&d) {
                    continue;
                }
                let added = self.length(a, c) + self.length(z, d) - self.length(c, d);
                let into = if keeps { [c, d] } else { [d, c] };
                let kind = Kind::Shift { piece: [a, z], beside, into, keeps };
                offer(Move { gain: freed - added, kind });
            }
        }
    }
}

/// Most samples of a piece that is shifted.
const LONGEST_PIECE: usize = 3;
