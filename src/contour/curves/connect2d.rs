//! Connect2D and SIG-Connect2D: a graph is inflated to a region with a simple border, which is then carved to its samples.

mod inflate;
mod sculpt;

use crate::graphs::{raised, sigdt};
use crate::inside::Inside;
use crate::triangulation::EdgeId;
use crate::{Graph, Triangulation};

/// Connect2D: one closed curve without crossings through the samples.
///
/// The boundary complex ([`crate::graphs::bc0`]) parts the plane. Where the outside touches a sample from several sides, all
/// but one are filled, that of the least (length of the far side - its two edges) first; what this cuts off from the
/// outside is filled, too. Then triangles are carved off the region to bring samples within it to the border, that of the
/// least added length first. No parameter; corners are kept. S. Ohrhallinger, S. Mudur, Computer Graphics Forum 32 (2013)
/// 196-208; their text was not at hand. No condition is proven.
///
/// A sample that no allowed step brings to the border stays alone; [`Graph::alone`] lists it. Of points at random in a square,
/// which are no samples of a curve, that is one in 230. Sums of lengths are
/// compared in doubles, equal ones by coordinates. n·log n time.
pub fn connect2d(triangulation: &Triangulation) -> Graph {
    let complex = crate::graphs::bc0(triangulation);
    connect(triangulation, &of(triangulation, &complex), false)
}

/// SIG-Connect2D: the same with the sphere-of-influence graph, and with several curves.
///
/// The graph is [`sigdt`] with Delaunay edges added, shortest first, where a sample has fewer than two. Proven for curves
/// without ends and ε < 0.5, neighbouring edges of a length ratio below 2: D. Marin, S. Ohrhallinger, M. Wimmer, *SIGDT: 2D
/// curve reconstruction*, Computer Graphics Forum 41 (2022); the text was not at hand. A place counts as inside if an odd number of the graph's edges lies at least between it and
/// the outside, so a curve within another is a hole; that is our choice. Beyond the condition a gap that leads into the curve may turn its inside
/// out: of an outline with a gap of two spacings strips beside the curve and chords across it remain. n·log n time.
pub fn sig_connect2d(triangulation: &Triangulation) -> Graph {
    let influence = of(triangulation, &sigdt(triangulation));
    connect(triangulation, &raised(triangulation, influence), true)
}

/// Whether each edge of the triangulation belongs to a graph.
fn of(triangulation: &Triangulation, graph: &Graph) -> Vec<bool> {
    let edges = triangulation.edges().iter();
    edges.map(|edge| graph.joins(edge.ends[0], edge.ends[1])).collect()
}

fn connect(triangulation: &Triangulation, walls: &[bool], is_nested: bool) -> Graph {
    if triangulation.triangles().is_empty() {
        return Graph::of_edges(triangulation, |edge| walls[edge as usize]);
    }
    let mut region = match is_nested {
        true => Inside::by_parity(triangulation, walls),
        false => Inside::within(triangulation, walls),
    };
    inflate::inflate(triangulation, walls, &mut region);
    if !is_nested {
        region.fill_pockets(triangulation);
    }
    sculpt::sculpt(triangulation, &mut region);
    Graph::of_edges(triangulation, |edge: EdgeId| region.is_border(triangulation, edge))
}
