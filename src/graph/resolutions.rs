//! Graphs of several resolutions: strips halved again and again, each graph mapped onto the coarser one.

use crate::cloud::Cloud;
use crate::extract::ExtractError;
use crate::functions::Field;
use crate::graph::{NodeId, PointGraph};
use crate::strips::Strips;

/// The graph of one resolution.
#[derive(Clone, Debug)]
pub struct Resolution<const D: usize> {
    /// The graph.
    pub graph: PointGraph<D>,
    /// The node of the next coarser graph that holds each node; none of the coarsest.
    ///
    /// An arc of this graph leads within one of those nodes, or along an arc of the coarser graph.
    pub coarser: Vec<NodeId>,
}

/// Graphs of the strips, of the strips halved, and so on, the coarsest first. Time of a graph for each.
///
/// Pieces are exact τ-components: a piece of half a strip lies in one piece of the strip. So the graphs are consistent, which
/// grown pieces are not.
///
/// # Errors
///
/// Errors as of [`PointGraph::new`]; more strips than [`MOST_STRIPS`](crate::MOST_STRIPS).
pub fn resolutions<const D: usize>(
    cloud: &Cloud<D>,
    field: &Field,
    coarsest: &Strips,
    tau_mm: f64,
    halvings: u32,
) -> Result<Vec<Resolution<D>>, ExtractError> {
    let mut strips = coarsest.clone();
    let first = PointGraph::new(cloud, &field.values, strips.clone(), tau_mm)?;
    let mut found = vec![Resolution { graph: first, coarser: Vec::new() }];
    for level in 0..halvings as usize {
        strips = strips.divided(2)?;
        let graph = PointGraph::new(cloud, &field.values, strips.clone(), tau_mm)?;
        let mut coarser = vec![0; graph.nodes.len()];
        for (&node, &holder) in graph.of_place.iter().zip(&found[level].graph.of_place) {
            coarser[node as usize] = holder;
        }
        found.push(Resolution { graph, coarser });
    }
    Ok(found)
}
