//! The Point Cloud Graph: pieces of strips as nodes, arcs between pieces of consecutive strips that are near.

use asphera_geometry::Sets;
use rayon::prelude::*;
use thiserror::Error;

use crate::cloud::{CHUNK, Cloud, PlaceId};
use crate::slab::{Grid, Slab};
use crate::strips::Strips;

/// Number of a node: its index in [`PointGraph::nodes`].
pub type NodeId = u32;

/// The graph of a cloud and a function (S. Biasotti, G. Patanè, the Point Cloud Graph, definition 2.2): nodes are the
/// τ-components of strips, arcs join components of consecutive strips that are nearer than τ.
#[derive(Clone, Debug)]
pub struct PointGraph<const D: usize> {
    pub(crate) strips: Strips,
    pub(crate) nodes: Vec<Node<D>>,
    pub(crate) arcs: Vec<Arc>,
    pub(crate) of_place: Vec<NodeId>,
}

/// A τ-component of a strip.
#[derive(Clone, Debug, PartialEq)]
pub struct Node<const D: usize> {
    /// Its strip, counted from 0.
    pub strip: u32,
    /// Places in it.
    pub places: u32,
    /// Their mean in mm. It need not lie in the material.
    pub centroid_mm: [f64; D],
    /// The box along the axes: least and largest coordinates in mm.
    pub box_mm: [[f64; D]; 2],
    /// Least and largest value of the function.
    pub range: [f64; 2],
}

/// An arc between nodes of consecutive strips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Its nodes, the one of the lower strip first.
    pub nodes: [NodeId; 2],
    /// The least distance of a place of one to a place of the other in mm, below τ.
    pub distance_mm: f64,
}

impl<const D: usize> PointGraph<D> {
    /// The graph of exact τ-components. Some n·log n time, 40 bytes a place besides the cloud.
    ///
    /// `values` are those of the function, one a place; NaN is none and must not be there.
    ///
    /// # Errors
    ///
    /// τ that is no length above 0, or less than 10⁻⁹ of the cloud; not a finite value a place.
    pub fn new(
        cloud: &Cloud<D>,
        values: &[f64],
        strips: Strips,
        tau_mm: f64,
    ) -> Result<PointGraph<D>, GraphError> {
        let of_strip = sorted_by_strip(cloud, values, &strips)?;
        if cloud.is_empty() {
            let (nodes, arcs) = (Vec::new(), Vec::new());
            return Ok(PointGraph { strips, nodes, arcs, of_place: Vec::new() });
        }
        let grid = grid(cloud, tau_mm)?;
        let slabs: Vec<Slab<D>> = of_strip
            .into_par_iter()
            .map(|places| Slab::new(cloud.places(), &grid, places))
            .collect();
        let mut firsts = Vec::with_capacity(slabs.len());
        let mut count = 0;
        for slab in &slabs {
            firsts.push(count);
            count += slab.piece_count;
        }
        let arcs: Vec<Arc> = (1..slabs.len())
            .into_par_iter()
            .flat_map_iter(|upper| {
                let found = slabs[upper - 1].arcs_to(&slabs[upper], [cloud.places(); 2], &grid);
                let firsts = [firsts[upper - 1], firsts[upper]];
                found.into_iter().map(move |(a, b, square)| Arc {
                    nodes: [firsts[0] + a, firsts[1] + b],
                    distance_mm: square.sqrt(),
                })
            })
            .collect();
        let mut of_place = vec![0; cloud.len()];
        for (slab, &first) in slabs.iter().zip(&firsts) {
            for (cell, &piece) in slab.pieces.iter().enumerate() {
                for &place in slab.places_of(cell) {
                    of_place[place as usize] = first + piece;
                }
            }
        }
        drop(slabs);
        let nodes = nodes(cloud, values, &strips, &of_place, count);
        Ok(PointGraph { strips, nodes, arcs, of_place })
    }

    /// The strips.
    pub fn strips(&self) -> &Strips {
        &self.strips
    }

    /// The nodes, by strip.
    pub fn nodes(&self) -> &[Node<D>] {
        &self.nodes
    }

    /// The arcs, by their nodes.
    pub fn arcs(&self) -> &[Arc] {
        &self.arcs
    }

    /// The node of each place.
    pub fn nodes_of_places(&self) -> &[NodeId] {
        &self.of_place
    }

    /// The connected component of each node, and how many there are.
    pub fn components(&self) -> (Vec<u32>, u32) {
        let mut sets = Sets::new(self.nodes.len());
        self.arcs.iter().for_each(|arc| {
            sets.join(arc.nodes[0] as usize, arc.nodes[1] as usize);
        });
        sets.numbered()
    }
}

/// The τ-component of each place of a whole cloud, and how many there are. Some n·log n time.
///
/// # Errors
///
/// τ as in [`PointGraph::new`].
pub fn tau_components<const D: usize>(
    cloud: &Cloud<D>,
    tau_mm: f64,
) -> Result<(Vec<u32>, u32), GraphError> {
    if cloud.is_empty() {
        return Ok((Vec::new(), 0));
    }
    let grid = grid(cloud, tau_mm)?;
    let slab = Slab::new(cloud.places(), &grid, (0..cloud.len() as u32).collect());
    let mut pieces = vec![0; cloud.len()];
    for (cell, &piece) in slab.pieces.iter().enumerate() {
        slab.places_of(cell).iter().for_each(|&place| pieces[place as usize] = piece);
    }
    Ok((pieces, slab.piece_count))
}

pub(crate) fn grid<const D: usize>(cloud: &Cloud<D>, tau_mm: f64) -> Result<Grid<D>, GraphError> {
    if !(tau_mm > 0.0 && tau_mm.is_finite()) {
        return Err(GraphError::Tau { tau_mm });
    }
    let diagonal_mm = cloud.diagonal_mm();
    // A cell larger than the cloud is as good as one of infinite size, and its square is finite.
    Grid::new(cloud, tau_mm.min(2.0 * diagonal_mm + 1.0))
        .ok_or(GraphError::FineTau { tau_mm, diagonal_mm })
}

/// The places of each strip, in their order.
pub(crate) fn sorted_by_strip<const D: usize>(
    cloud: &Cloud<D>,
    values: &[f64],
    strips: &Strips,
) -> Result<Vec<Vec<PlaceId>>, GraphError> {
    if values.len() != cloud.len() {
        return Err(GraphError::Values { found: values.len(), places: cloud.len() });
    }
    if let Some(place) = values.iter().position(|value| !value.is_finite()) {
        return Err(GraphError::NotFinite { place, value: values[place] });
    }
    let of_place: Vec<u32> = values
        .par_chunks(CHUNK)
        .flat_map_iter(|chunk| chunk.iter().map(|&value| strips.strip_of(value) as u32))
        .collect();
    let mut counts = vec![0; strips.count()];
    of_place.iter().for_each(|&strip| counts[strip as usize] += 1);
    let mut sorted: Vec<Vec<PlaceId>> = counts.into_iter().map(Vec::with_capacity).collect();
    for (place, &strip) in (0..).zip(&of_place) {
        sorted[strip as usize].push(place);
    }
    Ok(sorted)
}

/// The figures of nodes, sums in the order of places.
pub(crate) fn nodes<const D: usize>(
    cloud: &Cloud<D>,
    values: &[f64],
    strips: &Strips,
    of_place: &[NodeId],
    count: u32,
) -> Vec<Node<D>> {
    let empty = Node {
        strip: 0,
        places: 0,
        centroid_mm: [0.0; D],
        box_mm: [[f64::INFINITY; D], [f64::NEG_INFINITY; D]],
        range: [f64::INFINITY, f64::NEG_INFINITY],
    };
    let mut nodes = vec![empty; count as usize];
    let origin = cloud.bounds_mm().map_or([0.0; D], |[low, _]| low);
    for ((&node, place), &value) in of_place.iter().zip(cloud.places()).zip(values) {
        let node = &mut nodes[node as usize];
        node.places += 1;
        for axis in 0..D {
            node.centroid_mm[axis] += place[axis] - origin[axis];
            node.box_mm[0][axis] = node.box_mm[0][axis].min(place[axis]);
            node.box_mm[1][axis] = node.box_mm[1][axis].max(place[axis]);
        }
        node.range = [node.range[0].min(value), node.range[1].max(value)];
    }
    for node in &mut nodes {
        for (mean, from) in node.centroid_mm.iter_mut().zip(origin) {
            *mean = from + *mean / f64::from(node.places);
        }
        node.strip = strips.strip_of(node.range[0]) as u32;
    }
    nodes
}

/// Reason why there is no graph.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum GraphError {
    /// τ is no length.
    #[error("tau is {tau_mm} mm: expected a length above 0; --tau auto chooses one")]
    Tau {
        /// τ in mm.
        tau_mm: f64,
    },
    /// τ is too small for cells to be numbered.
    #[error(
        "tau is {tau_mm} mm and the points span {diagonal_mm:.3e} mm: expected a tau of at least a billionth of that"
    )]
    FineTau {
        /// τ in mm.
        tau_mm: f64,
        /// Diagonal of the box around the points in mm.
        diagonal_mm: f64,
    },
    /// There is not a value a place.
    #[error("{found} values of the function: expected one for each of {places} places")]
    Values {
        /// How many values there are.
        found: usize,
        /// How many places.
        places: usize,
    },
    /// A value of the function is not finite.
    #[error(
        "the function is {value} at place {place}: expected finite values; leave such points out"
    )]
    NotFinite {
        /// The place.
        place: usize,
        /// The value.
        value: f64,
    },
}
