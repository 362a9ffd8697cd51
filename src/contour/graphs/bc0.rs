//! The boundary complex: every sample gets a second edge.

use super::emst::spanning;
use crate::{Graph, Triangulation};

/// The boundary complex BC0: the spanning tree, and every Delaunay edge, shortest first, of which one end has fewer than
/// two edges when its turn comes.
///
/// So every sample of three or more that are not on one line has two edges at least. S. Ohrhallinger, S. Mudur, Computer
/// Graphics Forum 32 (2013) 196-208; their text was not at hand. n·log n time.
pub fn bc0(triangulation: &Triangulation) -> Graph {
    let kept = raised(triangulation, spanning(triangulation));
    Graph::of_edges(triangulation, |edge| kept[edge as usize])
}

/// Edges raised to two at every sample: those given, and by length each of which one end has fewer.
pub fn raised(triangulation: &Triangulation, mut kept: Vec<bool>) -> Vec<bool> {
    let mut degrees = vec![0_u32; triangulation.len()];
    for (edge, _) in triangulation.edges().iter().zip(&kept).filter(|(_, is_kept)| **is_kept) {
        for end in edge.ends {
            degrees[end as usize] += 1;
        }
    }
    for &edge in triangulation.by_length() {
        let ends = triangulation.ends(edge);
        if !kept[edge as usize] && ends.iter().any(|&end| degrees[end as usize] < 2) {
            kept[edge as usize] = true;
            for end in ends {
                degrees[end as usize] += 1;
            }
        }
    }
    kept
}
