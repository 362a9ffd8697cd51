//! HNN-Crust.

mod search;

use rayon::prelude::*;

use self::search::{Chosen, NONE, Search};
use crate::cells::{Cells, Node};
use crate::{Graph, SampleId, Samples};

/// HNN-Crust: every sample p chooses its nearest one q, and the nearest s that is nearer to p than to q. An edge is kept
/// if both its ends chose it.
///
/// Proven: of a smooth curve without ends, sampled with ρ < 0.9 (with ε < 0.47), it is exactly the edges between samples
/// that follow each other. Decided exactly; of equally near samples that of the smallest number is chosen. S. Ohrhallinger, S. A. Mitchell,
/// M. Wimmer, Computer Graphics Forum 35 (2016) 167-176; condition and definition are certain. Unlike the authors' program the search for s
/// does not end after a number of neighbours. No mesh is made. n·log n time on points that are about as dense everywhere; a sample whose s
/// lies far off asks about all that are nearer.
pub fn hnn_crust(samples: &Samples) -> Graph {
    let cells = Cells::new(samples);
    let chosen = choices(&cells);
    let number = |position: u32| cells.samples()[position as usize];
    // At most two of each: its larger ones, in order.
    let mut larger = vec![[SampleId::MAX; 2]; samples.len()];
    for (at, both) in (0..).zip(&chosen) {
        let is_edge = |other: u32| {
            other != NONE && chosen[other as usize].contains(&at) && number(other) > number(at)
        };
        let mut found = both.map(|other| if is_edge(other) { number(other) } else { NONE });
        found.sort_unstable();
        larger[number(at) as usize] = found;
    }
    let edges = (0..).zip(larger).flat_map(|(sample, found)| found.map(|other| [sample, other]));
    Graph::of_sorted(edges.filter(|edge| edge[1] != SampleId::MAX).collect())
}

/// HNN-Crust with all edges that one of their ends chose.
pub fn one_sided_hnn_crust(samples: &Samples) -> Graph {
    let cells = Cells::new(samples);
    let chosen = choices(&cells);
    let number = |position: u32| cells.samples()[position as usize];
    let edges = (0..).zip(&chosen).flat_map(|(at, both)| {
        both.iter().filter(|&&other| other != NONE).map(move |&other| [at, other])
    });
    Graph::new(edges.map(|edge| edge.map(number)))
}

/// The choices of all samples, by their positions.
fn choices(cells: &Cells) -> Vec<Chosen> {
    let leaves = cells.leaves();
    let of_runs = |runs: &[Node]| {
        let mut search = Search::new(cells);
        let mut chosen = Vec::with_capacity(8 * runs.len());
        runs.iter().for_each(|run| search.run(run, &mut chosen));
        chosen
    };
    // No run depends on another, and they are joined in order.
    let parts: Vec<Vec<Chosen>> = leaves.par_chunks(RUNS).map(of_runs).collect();
    parts.concat()
}

/// Runs that are searched one after the other: work enough to share.
const RUNS: usize = 1 << 9;
