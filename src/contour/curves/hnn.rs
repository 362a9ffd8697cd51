//! HNN-Crust.

mod search;

use rayon::prelude::*;

use self::search::{Chosen, NONE, Search};
use crate::cells::{Cells, LEAF, Node, Position};
use crate::triangulation::distance_mm;
use crate::{Graph, SampleId, Samples};

/// HNN-Crust: every sample p chooses its nearest one q, and the nearest s that is nearer to p than to q. An edge is kept
/// if both its ends chose it.
///
/// Proven: of a smooth curve without ends, sampled with ρ < 0.9 (with ε < 0.47), it is exactly the edges between samples
/// that follow each other. Decided exactly; of equally near samples that of the smallest number is chosen. S. Ohrhallinger, S. A. Mitchell,
/// M. Wimmer, Computer Graphics Forum 35 (2016) 167-176; condition and definition are certain. Unlike the authors' program the search for s
/// does not end after a number of neighbours. No mesh is made: both lie in the same or the next cells of a quadtree as a rule. n·log n time
/// on points that are about as dense everywhere; a sample whose s lies far off asks about all cells that are nearer and reach behind it.
pub fn hnn_crust(samples: &Samples) -> Graph {
    HalfNeighbours::new(samples).curve()
}

/// HNN-Crust with all edges that one of their ends chose.
pub fn one_sided_hnn_crust(samples: &Samples) -> Graph {
    HalfNeighbours::new(samples).one_sided()
}

/// The two samples that every one chooses: what both forms of HNN-Crust are made of.
pub struct HalfNeighbours {
    cells: Cells,
    /// By their positions.
    chosen: Vec<Chosen>,
}

impl HalfNeighbours {
    /// The choices of samples.
    pub fn new(samples: &Samples) -> HalfNeighbours {
        let cells = Cells::new(samples);
        let of_runs = |runs: &[Node]| {
            let mut search = Search::new(&cells);
            let mut chosen = Vec::with_capacity(LEAF * runs.len());
            runs.iter().for_each(|run| search.run(run, &mut chosen));
            chosen
        };
        // No run depends on another, and they are joined in order.
        let parts: Vec<Vec<Chosen>> = cells.leaves().par_chunks(RUNS).map(of_runs).collect();
        HalfNeighbours { cells, chosen: parts.concat() }
    }

    /// The edges that both ends chose: [`hnn_crust`].
    pub fn curve(&self) -> Graph {
        let number = |position: Position| self.cells.samples()[position as usize];
        // At most two of each: its larger ones, in order.
        let mut larger = vec![[SampleId::MAX; 2]; self.chosen.len()];
        for (at, both) in (0..).zip(&self.chosen) {
            let found = both.map(|other| {
                let is_edge = other != NONE && self.chosen[other as usize].contains(&at);
                if is_edge && number(other) > number(at) { number(other) } else { SampleId::MAX }
            });
            larger[number(at) as usize] = [found[0].min(found[1]), found[0].max(found[1])];
        }
        let edges = (0..).zip(larger).flat_map(|(sample, found)| found.map(|it| [sample, it]));
        Graph::of_sorted(edges.filter(|edge| edge[1] != SampleId::MAX).collect())
    }

    /// The edges that one of their ends chose: [`one_sided_hnn_crust`].
    pub fn one_sided(&self) -> Graph {
        let number = |position: Position| self.cells.samples()[position as usize];
        let edges = (0..).zip(&self.chosen).flat_map(|(at, both)| {
            both.iter().filter(|&&other| other != NONE).map(move |&other| [at, other])
        });
        Graph::new(edges.map(|edge| edge.map(number)))
    }

    /// The median distance of a sample to its nearest one in mm, the upper one of two; none of one sample.
    pub fn spacing_median_mm(&self) -> Option<f64> {
        let places = self.cells.places();
        let pairs = places.iter().zip(&self.chosen).filter(|(_, chosen)| chosen[0] != NONE);
        let mut distances_mm: Vec<f64> =
            pairs.map(|(&place, chosen)| distance_mm(place, places[chosen[0] as usize])).collect();
        let middle = distances_mm.len() / 2;
        (middle > 0).then(|| *distances_mm.select_nth_unstable_by(middle, f64::total_cmp).1)
    }
}

/// Runs that are searched one after the other: work enough to share.
const RUNS: usize = 1 << 9;
