//! Optimal transport: points carried onto few edges at the least cost.

mod about;
mod ears;
mod ends;
mod load;
mod planar;
mod star;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use rayon::prelude::*;

use self::planar::Planar;
use self::star::{Collapses, Star};
use super::{MovedCurve, lee_reach_mm};
use crate::{Graph, SampleId, Triangulation};

/// When [`optimal_transport`] ends, and which edges it gives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transport {
    /// So many vertices stay; 0 goes by the tolerance.
    pub vertices: usize,
    /// Largest root of the mean cost of a point in mm; counts if `vertices` is 0.
    pub tolerance_mm: f64,
    /// Least relevance of an edge: its length squared over the mean cost of its points.
    pub relevance: f64,
}

/// The curve with few vertices to which the points are carried at the least cost: it approximates, and noise and outliers may lie beside it.
///
/// All points start as vertices of the Delaunay triangulation, within a wide square. The edge whose collapse adds the least cost goes, one end
/// into the other; edges in the way are flipped before. Then the vertex moves to where the points of its edges ask for the least
/// square distance, if that lessens the cost; all do so again at the end. Each point of the star goes to its nearest edge. The points of an edge go, whichever costs less,
/// to the nearer end each, or onto the edge: distance squared across it, and along it m·(l²/12 + c²), where the points share the edge in
/// stretches of length l in their order and c leads to the middle of the stretch. An edge belongs to the curve if its points go onto it and its
/// relevance is large enough: so edges between outliers go. F. de Goes, D. Cohen-Steiner, P. Alliez, M. Desbrun, Computer Graphics Forum
/// 30 (2011) 1593-1602; the text was not at hand, the description is that of CGAL's manual. Ties, the order of flips, the tolerance that is taken
/// from the points and the least relevance are our choice. A place counts once. In doubles. No condition is proven. n·log n time for points
/// with noise or steps that differ; n³ and more in straight rows of even steps, where one vertex gets the edges of a whole row.
pub fn optimal_transport(triangulation: &Triangulation, settings: Transport) -> MovedCurve {
    let mut planar = Planar::new(triangulation);
    let mut queue = Queue::new(&planar);
    let count = triangulation.len();
    let mut left = count;
    let mut targets = Vec::new();
    let mut cost_mm2 = 0.0;
    while left > settings.vertices.max(2) {
        let Some((from, to)) = queue.next(&planar) else { break };
        let Some(star) = Star::collapsed(&planar, from, to) else { continue };
        let next_mm2: f64 = cost_mm2 + star.added_mm2;
        let is_within = (next_mm2.max(0.0) / count as f64).sqrt() <= settings.tolerance_mm;
        if settings.vertices == 0 && !is_within {
            break;
        }
        let mut touched = planar.collapse(&star);
        cost_mm2 = next_mm2;
        if let Some(star) = Star::moved(&planar, to) {
            cost_mm2 += star.added_mm2;
            touched.extend(planar.relocate(&star));
        }
        touched.sort_unstable();
        touched.dedup();
        left -= 1;
        targets.push(to);
        queue.renew(&planar, &touched);
    }
    settle(&mut planar, targets);
    found(triangulation, &planar, settings.relevance)
}

/// The tolerance that [`optimal_transport`] takes where none is given: a sixth of [`lee_reach_mm`].
pub fn transport_tolerance_mm(triangulation: &Triangulation) -> Option<f64> {
    lee_reach_mm(triangulation).map(|reach_mm| reach_mm / 6.0)
}

/// Moves the vertices that others went into again, the last first, while that lessens the cost.
fn settle(planar: &mut Planar, mut targets: Vec<SampleId>) {
    let mut is_first = vec![true; planar.len()];
    targets.reverse();
    targets.retain(|&vertex| {
        planar.is_there(vertex) && std::mem::replace(&mut is_first[vertex as usize], false)
    });
    for _ in 0..ROUNDS {
        let mut is_moved = false;
        for &vertex in &targets {
            if let Some(star) = Star::moved(planar, vertex) {
                planar.relocate(&star);
                is_moved = true;
            }
        }
        if !is_moved {
            return;
        }
    }
}

fn found(triangulation: &Triangulation, planar: &Planar, relevance: f64) -> MovedCurve {
    let places_mm = planar.samples_mm();
    let (mut edges, mut squares_mm2, mut points) = (Vec::new(), 0.0, 0);
    for (ends, load) in planar.loaded() {
        let [p, q] = ends.map(|end| planar.place(end));
        let squared_mm2 = (p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2);
        let mean_mm2 = load.cost_mm2 / load.samples.len() as f64;
        if load.is_along && squared_mm2 >= relevance * mean_mm2 {
            edges.push(ends);
            squares_mm2 += load.across_mm2;
            points += load.samples.len();
        }
    }
    debug_assert_eq!(places_mm.len(), triangulation.len());
    let sigma_mm = (squares_mm2 / points.max(1) as f64).sqrt();
    MovedCurve { graph: Graph::new(edges), places_mm, sigma_mm }
}

/// How often the vertices that stay are moved at most.
const ROUNDS: usize = 20;

/// The cheapest collapse of every vertex, cheapest first.
struct Queue {
    heap: BinaryHeap<Reverse<(Key, u32)>>,
    /// How often each vertex was renewed: what was queued before is void.
    rounds: Vec<u32>,
}

/// A collapse and its rank: cost, length of the edge, distance to the next vertex, then the numbers of the vertices.
type Key = (i64, i64, i64, SampleId, SampleId);

impl Queue {
    fn new(planar: &Planar) -> Queue {
        let keys: Vec<Option<Key>> = (0..planar.len() as SampleId)
            .into_par_iter()
            .map_init(
                || Collapses::new(planar),
                |collapses, vertex| Queue::key(planar, collapses, vertex),
            )
            .collect();
        let rounds = vec![0; keys.len()];
        let heap = keys.into_iter().flatten().map(|key| Reverse((key, 0))).collect();
        Queue { heap, rounds }
    }

    /// The next collapse: from a vertex into another.
    fn next(&mut self, planar: &Planar) -> Option<(SampleId, SampleId)> {
        loop {
            let Reverse(((.., from, to), round)) = self.heap.pop()?;
            if planar.is_there(from) && self.rounds[from as usize] == round {
                return Some((from, to));
            }
        }
    }

    fn renew(&mut self, planar: &Planar, vertices: &[SampleId]) {
        let mut collapses = Collapses::new(planar);
        for &vertex in vertices {
            self.rounds[vertex as usize] += 1;
            if let Some(key) = Queue::key(planar, &mut collapses, vertex) {
                self.heap.push(Reverse((key, self.rounds[vertex as usize])));
            }
        }
    }

    fn key(planar: &Planar, collapses: &mut Collapses, vertex: SampleId) -> Option<Key> {
        let (to, added_mm2) = collapses.cheapest(vertex)?;
        let [length_mm2, next_mm2] = planar.spacing_mm2(vertex, to);
        let whole = |value_mm2: f64| planar.whole(value_mm2);
        Some((whole(added_mm2), whole(length_mm2), whole(next_mm2), vertex, to))
    }
}

#[cfg(test)]
mod tests;
