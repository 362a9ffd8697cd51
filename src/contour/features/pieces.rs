//! The pieces of a curve: lines, arcs and free pieces, by what they cost.

use super::course::{Course, Noise};
use super::moments::Moments;
use crate::PlaceMm;

/// What a piece is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    Line,
    Arc,
    /// Neither, within the noise.
    Free,
}

/// Points of a course that are of one form: from `first` to before `end`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Piece {
    pub(super) first: usize,
    pub(super) end: usize,
    pub(super) form: Form,
}

/// A course in pieces. A closed course begins where its first piece begins.
pub(super) struct Cut {
    pub(super) course: Course,
    pub(super) pieces: Vec<Piece>,
}

/// Cuts a course into the pieces that cost least.
///
/// A piece costs the sum of its squared distances over σ², and ln N for each of its numbers and for its end (G. Schwarz's criterion, Annals of
/// Statistics 6 (1978) 461-464): 3 of a line, 4 of an arc. A free piece costs what noise explains, n + 6·√(2n), and a quarter of n as σ is known to a tenth. It costs as much beside as arcs of
/// [`POINTS_OF_ARC`] points each, [`LEAST_ARCS`] to [`MOST_ARCS`] of them: a plate of lines and arcs pays for each of its pieces. And it costs what its
/// points stand off the cubics through their neighbours beyond 3.5 σ. Dynamic programming finds the least sum over ends at up to [`NODES`]
/// points, and at those unless they are many; then each end moves to where the two pieces beside it cost least, and short pieces that cost less without it leave. A closed course is cut at the point it begins with, then anew at
/// an end that was found. Time [`NODES`]·n.
pub(super) fn cut(course: &Course, noise: &Noise, sigma_mm: f64) -> Cut {
    let mut cut = linear(course, noise, 0, sigma_mm);
    if !course.is_closed() || cut.pieces.len() == 1 {
        return cut;
    }
    let mut start = cut.pieces[cut.pieces.len() / 2].first;
    for _ in 0..MOST_TURNS {
        cut = linear(course, noise, start, sigma_mm);
        let count = cut.pieces.len();
        if count == 1 || !is_one(&cut, noise, start, sigma_mm) {
            break;
        }
        // The end it was cut at is none.
        start = (start + cut.pieces[count / 2].first) % course.places_mm().len();
    }
    cut
}

/// Whether the last piece and the first cost less as one.
fn is_one(cut: &Cut, noise: &Noise, start: usize, sigma_mm: f64) -> bool {
    let [first, last] = [cut.pieces[0], cut.pieces[cut.pieces.len() - 1]];
    let turned = cut.course.beginning_at(last.first);
    let count = turned.places_mm().len();
    let costs = Costs::new(&turned, noise, (start + last.first) % count, sigma_mm);
    let end = count - last.first;
    costs.least(0, end + first.end).0 < costs.least(0, end).0 + costs.least(end, end + first.end).0
}

/// The pieces of a course that begins at one of its points.
fn linear(course: &Course, noise: &Noise, start: usize, sigma_mm: f64) -> Cut {
    let course = course.beginning_at(start);
    let costs = Costs::new(&course, noise, start, sigma_mm);
    let mut ends = costs.best_ends();
    for _ in 0..MOST_MOVES {
        if !costs.moved(&mut ends) {
            break;
        }
    }
    let pieces = ends.windows(2).map(|ends| {
        let (_, form) = costs.least(ends[0], ends[1]);
        Piece { first: ends[0], end: ends[1], form }
    });
    let pieces = without_runs(&costs, pieces.collect());
    Cut { pieces, course }
}

/// Makes each run of [`RUN`] arcs or more a free piece, if that costs less at the price of two arcs: arc after arc, and no line between them, is
/// how a free form looks.
fn without_runs(costs: &Costs, pieces: Vec<Piece>) -> Vec<Piece> {
    let runs = pieces.chunk_by(|piece, next| piece.form == Form::Arc && next.form == Form::Arc);
    let joined = runs.flat_map(|run| {
        let [first, end] = [run[0].first, run[run.len() - 1].end];
        let arcs: f64 = run.iter().map(|it| costs.least(it.first, it.end).0).sum();
        let is_free = run.len() >= RUN && costs.of_free(first, end, LEAST_ARCS) < arcs;
        match is_free {
            true => vec![Piece { first, end, form: Form::Free }],
            false => run.to_vec(),
        }
    });
    joined.collect()
}

/// The costs of pieces of a course.
struct Costs<'a> {
    places_mm: &'a [PlaceMm],
    variance_mm2: f64,
    /// Sums of what points stand off beyond what noise explains: of all before each.
    excess: Vec<f64>,
    /// ln N.
    price: f64,
}

impl<'a> Costs<'a> {
    fn new(course: &'a Course, noise: &Noise, start: usize, sigma_mm: f64) -> Costs<'a> {
        let places_mm = course.places_mm();
        let count = places_mm.len();
        let mut excess = vec![0.0; count + 1];
        for index in 0..count {
            let left = noise.left_mm[(start + index) % count] / sigma_mm;
            let beyond = if left.is_nan() { 0.0 } else { (left * left - FAR * FAR).max(0.0) };
            excess[index + 1] = excess[index] + beyond;
        }
        Costs { places_mm, variance_mm2: sigma_mm * sigma_mm, excess, price: (count as f64).ln() }
    }

    /// The least cost of the points from `first` to before `end`, and the form.
    fn least(&self, first: usize, end: usize) -> (f64, Form) {
        let mut moments = Moments::default();
        (first..end).for_each(|index| moments.add(self.way(first, index)));
        self.of(&moments, first, end)
    }

    fn way(&self, first: usize, index: usize) -> PlaceMm {
        let [at, from] = [self.places_mm[index], self.places_mm[first]];
        [at[0] - from[0], at[1] - from[1]]
    }

    fn of(&self, moments: &Moments, first: usize, end: usize) -> (f64, Form) {
        let count = (end - first) as f64;
        if end - first < LEAST_OF_PIECE {
            return (f64::INFINITY, Form::Free);
        }
        let line = moments.line_squares_mm2() / self.variance_mm2 + 3.0 * self.price + CHANCE;
        let arc =
            moments.circle_squares_mm2() / self.variance_mm2 + 4.0 * self.price + 2.0 * CHANCE;
        let arcs = (count / POINTS_OF_ARC).clamp(LEAST_ARCS, MOST_ARCS);
        let free = self.of_free(first, end, arcs);
        if line <= arc && line <= free {
            (line, Form::Line)
        } else if arc <= free {
            (arc, Form::Arc)
        } else {
            (free, Form::Free)
        }
    }

    /// The cost of a free piece that costs as much beside as some arcs.
    fn of_free(&self, first: usize, end: usize, arcs: f64) -> f64 {
        let count = (end - first) as f64;
        let off = self.excess[end] - self.excess[first];
        let noise = 1.25 * count + 6.0 * (2.0 * count).sqrt();
        noise + off + arcs * (4.0 * self.price + 2.0 * CHANCE)
    }

    /// The ends, 0 and the count included, that dynamic programming over nodes finds.
    fn best_ends(&self) -> Vec<usize> {
        let count = self.places_mm.len();
        let size = count.div_ceil(NODES).max(1);
        let may_turn = |at: usize| self.excess[at + 1] > self.excess[at];
        let is_node = |&at: &usize| at % size == 0 || may_turn(at) || may_turn(at - 1);
        let mut nodes: Vec<usize> = (0..count).filter(is_node).chain([count]).collect();
        if nodes.len() > 3 * NODES {
            nodes = (0..count).step_by(size).chain([count]).collect();
        }
        let mut best = vec![(f64::INFINITY, 0); nodes.len()];
        best[0].0 = 0.0;
        for from in 0..nodes.len() - 1 {
            let before = best[from].0;
            if before.is_infinite() {
                continue;
            }
            let mut moments = Moments::default();
            for to in from + 1..nodes.len() {
                (nodes[to - 1]..nodes[to])
                    .for_each(|index| moments.add(self.way(nodes[from], index)));
                let cost = before + self.of(&moments, nodes[from], nodes[to]).0;
                if cost < best[to].0 {
                    best[to] = (cost, from);
                }
            }
        }
        let mut ends = vec![count];
        let mut at = nodes.len() - 1;
        while at > 0 {
            at = best[at].1;
            ends.push(nodes[at]);
        }
        ends.reverse();
        ends
    }

    /// Moves each end to where the two pieces beside it cost least, and drops short pieces that cost less as parts of those beside them;
    /// whether anything changed.
    fn moved(&self, ends: &mut Vec<usize>) -> bool {
        let reach = self.places_mm.len().div_ceil(NODES);
        if reach <= 1 {
            return false;
        }
        let mut is_moved = false;
        for index in 1..ends.len() - 1 {
            let [first, at, end] = [ends[index - 1], ends[index], ends[index + 1]];
            let within = [at.saturating_sub(reach).max(first), (at + reach).min(end)];
            let (_, place) = self.best_end(first, within, end);
            is_moved |= place != at;
            ends[index] = place;
        }
        let mut index = 1;
        while index + 2 < ends.len() {
            let [first, from, to, end] = [0, 1, 2, 3].map(|step| ends[index - 1 + step]);
            let three =
                || self.least(first, from).0 + self.least(from, to).0 + self.least(to, end).0;
            if to - from <= SHORT * reach {
                let (cost, place) = self.best_end(first, [from, to], end);
                if cost < three() {
                    ends.remove(index);
                    ends[index] = place;
                    is_moved = true;
                    continue;
                }
            }
            index += 1;
        }
        is_moved
    }

    /// Where, from `low` to `high`, points from `first` to before `end` fall into two pieces at least cost, and that.
    fn best_end(&self, first: usize, [low, high]: [usize; 2], end: usize) -> (f64, usize) {
        let mut before = Moments::default();
        (first..low).for_each(|point| before.add(self.way(first, point)));
        let mut after = Moments::default();
        (high..end).rev().for_each(|point| after.add(self.way(end - 1, point)));
        let mut costs_after = vec![0.0; high - low + 1];
        for place in (low..=high).rev() {
            costs_after[place - low] = self.of(&after, place, end).0;
            if place > low {
                after.add(self.way(end - 1, place - 1));
            }
        }
        let mut best = (f64::INFINITY, low);
        for place in low..=high {
            let cost = self.of(&before, first, place).0 + costs_after[place - low];
            if cost < best.0 {
                best = (cost, place);
            }
            if place < high {
                before.add(self.way(first, place));
            }
        }
        best
    }
}

/// Most places where dynamic programming lets a piece end.
const NODES: usize = 600;
/// A piece of so many times the points from node to node or fewer is short.
const SHORT: usize = 6;
/// Least points of a piece.
const LEAST_OF_PIECE: usize = 4;
/// What a point of a free piece may stand off, in σ, at no cost.
const FAR: f64 = 3.5;
/// What a piece costs beside, and again if it is no line: among the many ends and forms that are tried, chance finds good ones.
const CHANCE: f64 = 12.0;
/// Points for each of which a free piece costs as much as an arc,
const POINTS_OF_ARC: f64 = 30.0;
/// the least such arcs,
const LEAST_ARCS: f64 = 2.5;
/// and the most. With σ off by a tenth a rounded rectangle of 200 points still costs less, and a flower of twelve arcs more.
const MOST_ARCS: f64 = 5.0;
/// Arcs in a row that may be a free form.
const RUN: usize = 5;
/// Most beginnings that are tried of a closed course.
const MOST_TURNS: usize = 4;
/// Most times that all ends are moved.
const MOST_MOVES: usize = 20;
