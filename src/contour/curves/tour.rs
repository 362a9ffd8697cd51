//! TSP: a short tour through all samples.

mod moves;
mod order;

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;

use self::moves::{Move, Moves};
use self::order::Order;
use super::connect2d;
use super::ruler::Ruler;
use crate::{Graph, SampleId, Triangulation};

/// Most samples that [`tsp`] takes.
pub const MOST_FOR_TOUR: usize = 100_000;

/// A short closed tour through all samples.
///
/// J. Giesen, *Curve reconstruction, the traveling salesman problem and Menger's theorem on length*, Discrete and Computational
/// Geometry 24 (2000) 577-603, proves that the shortest tour is right for dense samples of one closed curve, corners included; the text was
/// not at hand. The tour here is not the shortest. It begins with [`connect2d`], samples left out put in where they
/// add least. Then it is shortened by the step of most gain, as long as one is found: 2-opt reverses a piece (G. A. Croes, Operations Research
/// 6 (1958) 791-812), Or-opt moves up to three samples elsewhere (I. Or 1976). New edges lead from a sample to one of its eight
/// nearest. Lengths are rounded to 2⁻⁴¹ of the box at most, their sums are exact.
///
/// n² time at worst, as every reversal may take n: none for more than [`MOST_FOR_TOUR`] samples.
pub fn tsp(triangulation: &Triangulation) -> Option<Graph> {
    if triangulation.len() > MOST_FOR_TOUR {
        return None;
    }
    if triangulation.triangles().is_empty() {
        return Some(Graph::of_edges(triangulation, |_| true));
    }
    let ruler = Ruler::new(triangulation.samples().places());
    let near: Vec<Vec<SampleId>> = (0..triangulation.len() as SampleId)
        .map(|sample| triangulation.nearby(sample).take(NEAR).collect())
        .collect();
    let first = first_tour(triangulation, &ruler, &near);
    let mut order = Order::new(first);
    let moves = Moves { triangulation, ruler: &ruler, near: &near };
    loop {
        let all = 0..triangulation.len() as SampleId;
        let mut heap: Heap = all
            .filter_map(|sample| Some((moves.best(&order, sample)?.gain, Reverse(sample))))
            .collect();
        if heap.is_empty() {
            return Some(order.graph());
        }
        while let Some(&(gain, _)) = heap.peek() {
            let best = |sample| moves.best(&order, sample);
            let Some(step) = current_best(&mut heap, gain, best) else { continue };
            for sample in step.take(&mut order) {
                if let Some(step) = moves.best(&order, sample) {
                    heap.push((step.gain, Reverse(sample)));
                }
            }
        }
    }
}

/// Samples by the gain of their best step, as it was when they were put in.
type Heap = BinaryHeap<(i64, Reverse<SampleId>)>;

/// The step of a gain, the greatest in the heap.
///
/// Steps taken since may have changed what is best for a sample. Then there is no step. All samples of that gain go back with
/// what is best now, for none must be before another by its number alone.
fn current_best(
    heap: &mut Heap,
    gain: i64,
    best: impl Fn(SampleId) -> Option<Move>,
) -> Option<Move> {
    let mut steps = Vec::new();
    while let Some(top) = heap.peek_mut().filter(|top| top.0 == gain) {
        let (_, Reverse(sample)) = PeekMut::pop(top);
        steps.push((sample, best(sample)));
    }
    let holds = |&(_, step): &(SampleId, Option<Move>)| step.is_some_and(|step| step.gain == gain);
    // One step may be the best of several samples, found from its several ends.
    let step = if steps.iter().all(holds) { steps.first()?.1 } else { None };
    let again = steps.into_iter();
    heap.extend(again.filter_map(|(sample, step)| Some((step?.gain, Reverse(sample)))));
    step
}

/// The tour of Connect2D with all other samples put in, nearest first.
fn first_tour(
    triangulation: &Triangulation,
    ruler: &Ruler,
    near: &[Vec<SampleId>],
) -> Vec<SampleId> {
    let count = triangulation.len();
    let chains = connect2d(triangulation).chains(count);
    let length =
        |p: SampleId, q: SampleId| ruler.length(triangulation.place(p), triangulation.place(q));
    let around = |ring: &[SampleId]| -> i64 {
        ring.iter().zip(ring.iter().cycle().skip(1)).map(|(&p, &q)| length(p, q)).sum()
    };
    let closed = chains.into_iter().filter(|chain| chain.closed).map(|chain| chain.samples);
    let longest = closed.max_by_key(|ring| (ring.len(), around(ring)));
    // Without a closed curve the corners of the largest triangle begin one.
    let largest = || triangulation.triangles().iter().max_by_key(|&corners| around(corners));
    let ring = longest.or_else(|| Some(largest()?.to_vec())).unwrap_or_default();
    let mut next: Vec<Option<SampleId>> = vec![None; count];
    let mut before = next.clone();
    let start = ring[0];
    for (&from, &to) in ring.iter().zip(ring.iter().cycle().skip(1)) {
        (next[from as usize], before[to as usize]) = (Some(to), Some(from));
    }
    let mut out: Vec<SampleId> =
        (0..count as SampleId).filter(|&sample| next[sample as usize].is_none()).collect();
    // All lengths are compared: two samples nearest to each other share the first.
    out.sort_by_cached_key(|&sample| {
        let lengths = near[sample as usize].iter().map(|&to| length(sample, to));
        (lengths.collect::<Vec<i64>>(), sample)
    });
    for sample in out {
        let cost = |from: SampleId, to: SampleId| {
            (length(from, sample) + length(sample, to) - length(from, to), from, to)
        };
        let at = |&other: &SampleId| {
            let [to, from] = [next[other as usize]?, before[other as usize]?];
            Some(cost(other, to).min(cost(from, other)))
        };
        let few = near[sample as usize].iter().filter_map(at).min();
        let best = few.or_else(|| triangulation.nearby(sample).find_map(|other| at(&other)));
        let Some((_, from, to)) = best else { continue };
        (next[from as usize], before[sample as usize]) = (Some(sample), Some(from));
        (next[sample as usize], before[to as usize]) = (Some(to), Some(sample));
    }
    let mut tour = vec![start];
    let mut at = start;
    while let Some(to) = next[at as usize].filter(|&to| to != start) {
        tour.push(to);
        at = to;
    }
    tour
}

/// So many of the nearest samples are tried.
const NEAR: usize = 8;
