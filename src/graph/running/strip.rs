//! A strip when it is closed: its pieces, and the arcs to those of the strip below.

use asphera_geometry::PointMm;

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
            for axis in 0..3 {
                sum[axis] += inside[axis];
                node.box_mm[0][axis] = node.box_mm[0][axis].min(place[axis]);
                node.box_mm[1][axis] = node.box_mm[1][axis].max(place[axis]);
            }
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
    let own = points.iter().map(|&point| all[point as usize]);
    if points.len() > FEW {
        places.extend(own);
        places.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        places.dedup();
        return;
    }
    for place in own {
        if !places.contains(&place) {
            places.push(place);
        }
    }
}

/// Points of a cell up to which each is held against all.
const FEW: usize = 32;
