//! Curves from the spanning tree.

use crate::graphs::emst;
use crate::triangulation::distance_mm;
use crate::{Graph, SampleId, Triangulation};

/// The longest path of the spanning tree, closed if its ends are nearer to each other than twice its longest edge.
///
/// Branches shorter than the path stay off it, so one curve is found, open or closed. L. H. de Figueiredo, J. de Miranda Gomes,
/// *Computational morphology of curves*, The Visual Computer 11 (1994) 105-112, prove the tree right for dense samples of a
/// smooth open curve; their text was not at hand, and the rule for closing is ours. Of equally long paths the one found first
/// by numbers is taken. Sums of lengths are compared in doubles. n·log n time.
pub fn emst_curve(triangulation: &Triangulation) -> Graph {
    let tree = emst(triangulation);
    let mut ways: Vec<Vec<(SampleId, f64)>> = vec![Vec::new(); triangulation.len()];
    for &[p, q] in tree.edges() {
        let length_mm = distance_mm(triangulation.place(p), triangulation.place(q));
        ways[p as usize].push((q, length_mm));
        ways[q as usize].push((p, length_mm));
    }
    if tree.edges().is_empty() {
        return tree;
    }
    // The sample farthest from any is an end of a longest path, and the farthest from that is the other.
    let (first, _) = farthest(&ways, 0);
    let (last, before) = farthest(&ways, first);
    let mut edges = Vec::new();
    let (mut at, mut longest_mm) = (last, 0.0_f64);
    while at != first {
        let next = before[at as usize];
        longest_mm =
            longest_mm.max(distance_mm(triangulation.place(at), triangulation.place(next)));
        edges.push([at, next]);
        at = next;
    }
    let gap_mm = distance_mm(triangulation.place(first), triangulation.place(last));
    if edges.len() > 1 && gap_mm < 2.0 * longest_mm {
        edges.push([first, last]);
    }
    Graph::new(edges)
}

/// The sample with the longest way from another in the tree, and the sample before each on that way.
fn farthest(ways: &[Vec<(SampleId, f64)>], from: SampleId) -> (SampleId, Vec<SampleId>) {
    let mut before = vec![from; ways.len()];
    let mut stack = vec![(from, 0.0)];
    let mut best = (0.0, from);
    while let Some((at, way_mm)) = stack.pop() {
        if way_mm > best.0 || (way_mm == best.0 && at < best.1) {
            best = (way_mm, at);
        }
        for &(to, length_mm) in &ways[at as usize] {
            if to != before[at as usize] {
                before[to as usize] = at;
                stack.push((to, way_mm + length_mm));
            }
        }
    }
    (best.1, before)
}
