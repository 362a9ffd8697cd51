//! A strip when it is closed: its pieces, and the arcs to those of the strip below.

use asphera_geometry::{PointMm, greater, lesser};

use crate::cloud::PlaceId;
use crate::slab::{Grid, Slab};

/// The nodes and arcs of a strip.
#[derive(Clone, Debug, PartialEq)]
pub struct ClosedStrip {
    /// Its number: the strip reaches from so many widths to one more.
    pub strip: i64,
    /// Number of its first node; the others follow.
    pub first_node: u64,
    /// Its pieces.
    pub nodes: Vec<RunningNode>,
    /// Node of the strip below, node of this one, least distance in mm.
    pub arcs: Vec<([u64; 2], f64)>,
}

/// A τ-component of a strip.
#[derive(Clone, Debug, PartialEq)]
pub struct RunningNode {
    /// Points in it.
    pub points: u64,
    /// Places in it: equal points share one.
    pub places: u64,
    /// The mean of the places in mm, to 10⁻¹⁰ τ.
    pub centroid_mm: PointMm,
    /// The box along the axes: least and largest coordinates in mm.
    pub box_mm: [PointMm; 2],
}

/// Points of a strip, in the order in which they came.
#[derive(Clone, Debug, Default)]
pub(super) struct StripPoints {
    pub(super) rows: Vec<u64>,
    pub(super) at_mm: Vec<PointMm>,
}

/// A closed strip with its points.
#[derive(Clone, Debug)]
pub(super) struct Strip {
    pub(super) closed: ClosedStrip,
    pub(super) points: StripPoints,
    slab: Slab<3>,
}

impl Strip {
    /// Finds the pieces of a strip and joins them with those of the one below. n·log n time.
    pub(super) fn new(
        number: i64,
        points: StripPoints,
        below: Option<&Strip>,
        first_node: u64,
        grid: &Grid<3>,
    ) -> Strip {
        let slab = Slab::new(&points.at_mm, grid, (0..points.at_mm.len() as PlaceId).collect());
        let arcs = below.map_or_else(Vec::new, |below| {
            let places = [&below.points.at_mm[..], &points.at_mm];
            let found = below.slab.arcs_to(&slab, places, grid);
            let lower = below.closed.first_node;
            found
                .into_iter()
                .map(|(a, b, square)| {
                    ([lower + u64::from(a), first_node + u64::from(b)], square.sqrt())
                })
                .collect()
        });
        let nodes = nodes(&points.at_mm, grid, &slab);
        let closed = ClosedStrip { strip: number, first_node, nodes, arcs };
        Strip { closed, points, slab }
    }

    /// The node of each point, counted from the first one of the strip.
    pub(super) fn nodes_of_points(&self) -> Vec<u32> {
        let mut nodes = vec![0; self.points.rows.len()];
        for (cell, &piece) in self.slab.pieces.iter().enumerate() {
            self.slab.places_of(cell).iter().for_each(|&point| nodes[point as usize] = piece);
        }
        nodes
    }
}

/// The figures of every piece. Sums are whole numbers in each cell and run over the cells in their order, so the order of the points
/// changes no bit.
fn nodes(all: &[PointMm], grid: &Grid<3>, slab: &Slab<3>) -> Vec<RunningNode> {
    let empty = RunningNode {
        points: 0,
        places: 0,
        centroid_mm: [0.0; 3],
        box_mm: [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]],
    };
    let mut nodes = vec![empty; slab.piece_count as usize];
    let mut firsts: Vec<Option<PointMm>> = vec![None; nodes.len()];
    let mut places: Vec<PointMm> = Vec::new();
    for (at, (cell, &piece)) in slab.cells.iter().zip(&slab.pieces).enumerate() {
        let points = slab.places_of(at);
        distinct(all, points, &mut places);
        let node = &mut nodes[piece as usize];
        let mut sum = [0_i64; 3];
        for place in &places {
            let inside = grid.in_cell(place, cell);
            (0..3).for_each(|axis| sum[axis] += inside[axis]);
        }
        let [low, high] = slab.boxes_mm[at];
        for axis in 0..3 {
            node.box_mm[0][axis] = lesser(node.box_mm[0][axis], low[axis]);
            node.box_mm[1][axis] = greater(node.box_mm[1][axis], high[axis]);
        }
        let count = places.len() as u64;
        let mean = grid.mean(cell, &sum, count);
        let first = *firsts[piece as usize].get_or_insert(mean);
        node.points += points.len() as u64;
        node.places += count;
        for axis in 0..3 {
            node.centroid_mm[axis] += count as f64 * (mean[axis] - first[axis]);
        }
    }
    for (node, first) in nodes.iter_mut().zip(firsts) {
        let Some(first) = first else { continue };
        for (mean, from) in node.centroid_mm.iter_mut().zip(first) {
            *mean = from + *mean / node.places as f64;
        }
    }
    nodes
}

/// The places of the points of a cell, each once.
fn distinct(all: &[PointMm], points: &[PlaceId], places: &mut Vec<PointMm>) {
    places.clear();
    places.extend(points.iter().map(|&point| all[point as usize]));
    if (0..6).any(|at| is_in_rows(places, at / 2, (at / 2 + 1 + at % 2) % 3)) {
        return;
    }
    places.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    places.dedup();
}

/// Whether places come in rows, as those of a scan do: none goes back along an axis, and those that are as far along it go one way
/// across. Then no two are equal.
fn is_in_rows(places: &[PointMm], along: usize, across: usize) -> bool {
    let [Some(first), Some(last)] = [places.first(), places.last()] else { return true };
    let ahead = (last[along] - first[along]).signum();
    let mut aside = 0.0;
    places.windows(2).all(|pair| {
        let step = |axis: usize| pair[1][axis] - pair[0][axis];
        if step(along) != 0.0 {
            return step(along).signum() == ahead;
        }
        if aside == 0.0 {
            aside = step(across).signum();
        }
        step(across) != 0.0 && step(across).signum() == aside
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_each_taken_once_whatever_their_order() {
        let rows: Vec<PointMm> =
            (0..20).map(|at| [f64::from(at % 5), f64::from(at / 5), 0.5]).collect();
        let turn = |of: fn(&PointMm) -> PointMm| rows.iter().map(of).collect::<Vec<_>>();
        let mut there_and_back = rows.clone();
        there_and_back[5..10].reverse();
        let twice = [&rows[..], &rows[7..8]].concat();
        let mut neighbours = rows.clone();
        neighbours.insert(8, rows[7]);
        let clouds = [
            (rows.clone(), true),
            (rows.iter().rev().copied().collect(), true),
            (turn(|[x, y, z]| [-x, *y, *z]), true),
            (turn(|[x, y, z]| [*y, *z, *x]), true),
            (turn(|[x, y, z]| [*z, *x, -y]), true),
            (rows[..1].to_vec(), true),
            (there_and_back, false),
            (twice, false),
            (neighbours, false),
            (vec![rows[3]; 3], false),
        ];
        for (points, is_scan) in clouds {
            let ways = (0..6).filter(|at| is_in_rows(&points, at / 2, (at / 2 + 1 + at % 2) % 3));
            assert_eq!(ways.count() > 0, is_scan, "{points:?}");
            let ids: Vec<PlaceId> = (0..points.len() as PlaceId).collect();
            let mut found = Vec::new();
            distinct(&points, &ids, &mut found);
            let mut expected = points.clone();
            for list in [&mut found, &mut expected] {
                list.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap());
            }
            expected.dedup();
            assert_eq!(found, expected);
        }
    }
}
