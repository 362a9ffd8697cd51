//! Matching of least cost in a general graph.

use super::forest::Forest;

/// A node without a partner.
pub(super) const NONE: usize = usize::MAX;

/// A graph with costs, a matching to begin with, and potentials that prove it.
pub(super) struct Start {
    /// Ends of each edge.
    pub(super) edges: Vec<[usize; 2]>,
    /// Cost of each edge.
    pub(super) costs: Vec<i64>,
    /// An even number for every node: of both ends of an edge, and twice its cost, the sum is at least 0, and 0 of an edge that is matched.
    pub(super) potentials: Vec<i64>,
    /// The edges that are matched at first.
    pub(super) matched: Vec<usize>,
}

/// Whether each edge belongs to a matching with as many edges as any has; if it leaves no node out, to one of least cost among those.
///
/// J. Edmonds, *Maximum matching and a polyhedron with 0,1-vertices*, Journal of Research of the NBS 69B (1965) 125-130, in the form of
/// Z. Galil, ACM Computing Surveys 18 (1986) 23-38. Nodes matched at first stay matched. Of matchings of equal cost it takes one
/// that depends on the numbers of edges and nodes alone. n·m·log n time at most for n nodes and m edges here, with n - 2·matched stages.
pub(super) fn matching(start: &Start) -> Vec<bool> {
    let mut forest = Forest::new(start);
    while forest.augment() {}
    let mut is_matched = vec![false; start.edges.len()];
    for end in forest.partners().iter().filter(|&&end| end != NONE) {
        is_matched[end / 2] = true;
    }
    is_matched
}
