//! A set of edges between samples, and the chains it is made of.

use crate::samples::{PlaceMm, SampleId, Samples};
use crate::triangulation::{EdgeId, Triangulation, distance_mm};

/// Edges between samples: the outcome of every method.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Graph {
    edges: Vec<[SampleId; 2]>,
}

/// A run of edges through samples with exactly two edges.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chain {
    /// The samples in order; of a closed chain the first is not repeated.
    pub samples: Vec<SampleId>,
    /// Whether the last sample is joined to the first.
    pub closed: bool,
}

impl Graph {
    /// The graph of edges in any order; each counts once, and none from a sample to itself.
    pub fn new(edges: impl IntoIterator<Item = [SampleId; 2]>) -> Graph {
        let mut edges: Vec<[SampleId; 2]> =
            edges.into_iter().filter(|[p, q]| p != q).map(|[p, q]| [p.min(q), p.max(q)]).collect();
        edges.sort_unstable();
        edges.dedup();
        Graph { edges }
    }

    /// The graph of sorted edges, the smaller end first and each there once.
    pub(crate) fn of_sorted(edges: Vec<[SampleId; 2]>) -> Graph {
        debug_assert!(edges.iter().all(|[p, q]| p < q) && edges.is_sorted_by(|a, b| a < b));
        Graph { edges }
    }

    /// The graph of those edges of a triangulation for which `wanted` is true.
    pub(crate) fn of_edges(
        triangulation: &Triangulation,
        wanted: impl Fn(EdgeId) -> bool,
    ) -> Graph {
        let edges = (0..).zip(triangulation.edges());
        // They are sorted already, and each is there once.
        Graph { edges: edges.filter(|&(id, _)| wanted(id)).map(|(_, edge)| edge.ends).collect() }
    }

    /// The edges, the smaller end first, sorted.
    pub fn edges(&self) -> &[[SampleId; 2]] {
        &self.edges
    }

    /// The edges by rows of the input, counted from 0, the smaller row first, sorted. Of repeated points the first row
    /// stands for all.
    pub fn edges_by_row(&self, samples: &Samples) -> Vec<[u32; 2]> {
        let rows = |&[p, q]: &[SampleId; 2]| {
            let [p, q] = [samples.row_of(p), samples.row_of(q)];
            [p.min(q), p.max(q)]
        };
        let mut edges: Vec<[u32; 2]> = self.edges.iter().map(rows).collect();
        edges.sort_unstable();
        edges
    }

    /// Whether an edge joins two samples.
    pub fn joins(&self, p: SampleId, q: SampleId) -> bool {
        self.edges.binary_search(&[p.min(q), p.max(q)]).is_ok()
    }

    /// Whether every edge of this graph is one of another, too.
    pub fn is_part_of(&self, other: &Graph) -> bool {
        self.edges.iter().all(|&[p, q]| other.joins(p, q))
    }

    /// How many edges each of `samples` samples has.
    pub fn degrees(&self, samples: usize) -> Vec<u32> {
        let mut degrees = vec![0; samples];
        for &end in self.edges.as_flattened() {
            degrees[end as usize] += 1;
        }
        degrees
    }

    /// The samples with one edge: where curves end.
    pub fn ends(&self, samples: usize) -> Vec<SampleId> {
        self.with_degree(samples, |degree| degree == 1)
    }

    /// The samples with more than two edges: where curves meet.
    pub fn junctions(&self, samples: usize) -> Vec<SampleId> {
        self.with_degree(samples, |degree| degree > 2)
    }

    /// The samples without an edge: what a method left out.
    pub fn alone(&self, samples: usize) -> Vec<SampleId> {
        self.with_degree(samples, |degree| degree == 0)
    }

    fn with_degree(&self, samples: usize, wanted: impl Fn(u32) -> bool) -> Vec<SampleId> {
        let degrees = self.degrees(samples);
        (0..).zip(degrees).filter(|&(_, degree)| wanted(degree)).map(|(sample, _)| sample).collect()
    }

    /// The chains: first those that begin at an end or a junction, then the closed ones, each from its smallest sample on.
    /// Every edge belongs to one chain.
    pub fn chains(&self, samples: usize) -> Vec<Chain> {
        let degrees = self.degrees(samples);
        let mut first = vec![0_usize; samples + 1];
        for (sample, &degree) in degrees.iter().enumerate() {
            first[sample + 1] = first[sample] + degree as usize;
        }
        let mut next = first.clone();
        let mut ways = vec![(0, 0); 2 * self.edges.len()];
        for (index, &[p, q]) in self.edges.iter().enumerate() {
            for (from, to) in [(p, q), (q, p)] {
                ways[next[from as usize]] = (to, index);
                next[from as usize] += 1;
            }
        }
        let mut used = vec![false; self.edges.len()];
        let mut chains = Vec::new();
        let mut follow = |start: usize, used: &mut Vec<bool>| {
            for &(to, edge) in &ways[first[start]..first[start + 1]] {
                if used[edge] {
                    continue;
                }
                used[edge] = true;
                let mut on_way = vec![start as SampleId, to];
                let mut last = to as usize;
                while degrees[last] == 2 && last != start {
                    let onward = ways[first[last]..first[last + 1]].iter().find(|way| !used[way.1]);
                    let Some(&(to, edge)) = onward else { break };
                    used[edge] = true;
                    on_way.push(to);
                    last = to as usize;
                }
                let closed = last == start;
                if closed {
                    on_way.pop();
                }
                chains.push(Chain { samples: on_way, closed });
            }
        };
        for start in (0..samples).filter(|&sample| degrees[sample] != 2) {
            follow(start, &mut used);
        }
        for start in 0..samples {
            follow(start, &mut used);
        }
        chains
    }
}

impl Chain {
    /// The places along the chain in mm; of a closed chain the first is not repeated.
    pub fn places_mm(&self, samples: &Samples) -> Vec<PlaceMm> {
        self.samples.iter().map(|&sample| samples.places()[sample as usize]).collect()
    }

    /// Length of the chain in mm, the closing edge included.
    pub fn length_mm(&self, samples: &Samples) -> f64 {
        let places = self.places_mm(samples);
        let closing = match (self.closed, &places[..]) {
            (true, [first, .., last]) => distance_mm(*first, *last),
            _ => 0.0,
        };
        places.windows(2).map(|pair| distance_mm(pair[0], pair[1])).sum::<f64>() + closing
    }
}
