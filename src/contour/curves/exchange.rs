//! Edge exchange: the spanning tree is turned into a closed curve edge by edge.

use std::cmp::Reverse;

use super::ruler::Ruler;
use crate::graphs::emst;
use crate::triangulation::EdgeId;
use crate::{Graph, SampleId, Triangulation};

/// Most samples that [`edge_exchange`] takes.
pub const MOST_FOR_EXCHANGE: usize = 2_000;

/// One connected curve from the spanning tree, by steps that bring samples nearer to two edges at least length.
///
/// A *snap* joins two ends. A *move* swaps an edge for another that shares an end with it: it takes one from a sample with
/// more than two and gives one to a sample with fewer. The step that adds least length is taken, until none is left. Then two edges
/// are exchanged for two others through the same four samples while the sum of lengths falls. All edges are Delaunay edges and the curve stays connected.
/// S. Ohrhallinger, S. Mudur, *Interpolating an unorganized 2D point cloud with a single closed shape*, Computer-Aided Design 43 (2011)
/// 1629-1638; the text was not at hand: the order of steps is ours. No condition is proven. Lengths are rounded to 2⁻⁴¹ of the
/// box at most, their sums are exact.
///
/// n² time or more: none for more than [`MOST_FOR_EXCHANGE`] samples.
pub fn edge_exchange(triangulation: &Triangulation) -> Option<Graph> {
    if triangulation.len() > MOST_FOR_EXCHANGE {
        return None;
    }
    let mut curve = Curve::new(triangulation);
    while let Some(step) = curve.best_step() {
        curve.take(step);
    }
    while let Some(step) = curve.best_swap() {
        curve.take(step);
    }
    Some(Graph::of_edges(triangulation, |edge| curve.is_in[edge as usize]))
}

/// Edges that go and edges that come.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Step {
    added: i64,
    come: Vec<EdgeId>,
    go: Vec<EdgeId>,
}

struct Curve<'a> {
    triangulation: &'a Triangulation,
    lengths: Vec<i64>,
    is_in: Vec<bool>,
    degrees: Vec<u32>,
}

impl Curve<'_> {
    fn new(triangulation: &Triangulation) -> Curve<'_> {
        let ruler = Ruler::new(triangulation.samples().places());
        let lengths = (0..triangulation.edges().len() as EdgeId).map(|edge| {
            let [p, q] = triangulation.ends_mm(edge);
            ruler.length(p, q)
        });
        let tree = emst(triangulation);
        let edges = triangulation.edges().iter();
        Curve {
            triangulation,
            lengths: lengths.collect(),
            is_in: edges.map(|edge| tree.joins(edge.ends[0], edge.ends[1])).collect(),
            degrees: tree.degrees(triangulation.len()),
        }
    }

    fn step(&self, come: Vec<EdgeId>, go: Vec<EdgeId>) -> Step {
        let sum = |edges: &[EdgeId]| -> i64 {
            edges.iter().map(|&edge| self.lengths[edge as usize]).sum()
        };
        Step { added: sum(&come) - sum(&go), come, go }
    }

    fn take(&mut self, step: Step) {
        for (edges, is_in) in [(step.come, true), (step.go, false)] {
            for edge in edges {
                self.is_in[edge as usize] = is_in;
                for end in self.triangulation.ends(edge) {
                    let degree = &mut self.degrees[end as usize];
                    *degree = if is_in { *degree + 1 } else { *degree - 1 };
                }
            }
        }
    }

    /// The other ends of the edges of a sample that the curve has or does not have.
    fn beside(
        &self,
        sample: SampleId,
        wants_in: bool,
    ) -> impl Iterator<Item = (SampleId, EdgeId)> + '_ {
        let spokes = self.triangulation.spokes(sample).iter();
        spokes
            .filter(move |spoke| self.is_in[spoke.edge as usize] == wants_in)
            .map(|spoke| (spoke.to, spoke.edge))
    }

    /// The snap or move of least added length.
    fn best_step(&self) -> Option<Step> {
        let mut steps = Vec::new();
        for w in (0..self.degrees.len() as SampleId).filter(|&w| self.degrees[w as usize] < 2) {
            for (u, come) in self.beside(w, false) {
                if self.degrees[u as usize] < 2 && w < u {
                    steps.push(self.step(vec![come], Vec::new()));
                }
                for (v, go) in self.beside(u, true) {
                    if self.degrees[v as usize] > 2 {
                        steps.push(self.step(vec![come], vec![go]));
                    }
                }
            }
        }
        self.least(steps)
    }

    /// The exchange of two edges for two that takes away most length.
    fn best_swap(&self) -> Option<Step> {
        let mut steps = Vec::new();
        for a in 0..self.degrees.len() as SampleId {
            for (b, first) in self.beside(a, true) {
                for (c, come) in self.beside(a, false) {
                    for (d, second) in self.beside(c, true).filter(|&(d, _)| d != b) {
                        let other = self.triangulation.edge_between(b, d);
                        let Some(other) = other.filter(|&edge| !self.is_in[edge as usize]) else {
                            continue;
                        };
                        let step = self.step(vec![come, other], vec![first, second]);
                        if step.added < 0 {
                            steps.push(step);
                        }
                    }
                }
            }
        }
        self.least(steps)
    }

    /// The step of least added length after which all samples are still connected.
    fn least(&self, steps: Vec<Step>) -> Option<Step> {
        let mut heap: std::collections::BinaryHeap<Reverse<Step>> =
            steps.into_iter().map(Reverse).collect();
        while let Some(Reverse(step)) = heap.pop() {
            if self.is_connected_after(&step) {
                return Some(step);
            }
        }
        None
    }

    fn is_connected_after(&self, step: &Step) -> bool {
        if step.go.is_empty() {
            return true;
        }
        let mut is_met = vec![false; self.degrees.len()];
        let mut open = vec![0];
        let mut met = 0;
        while let Some(sample) = open.pop() {
            if std::mem::replace(&mut is_met[sample as usize], true) {
                continue;
            }
            met += 1;
            let spokes = self.triangulation.spokes(sample).iter().filter(|spoke| {
                (self.is_in[spoke.edge as usize] || step.come.contains(&spoke.edge))
                    && !step.go.contains(&spoke.edge)
            });
            open.extend(spokes.map(|spoke| spoke.to));
        }
        met == self.degrees.len()
    }
}
