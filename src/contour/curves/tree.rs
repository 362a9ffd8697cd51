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
    if tree.edges().is_empty() {
        return tree;
    }
    let ways = Ways::new(triangulation, &tree);
    // The sample farthest from any is an end of a longest path, and the farthest from that is the other.
    let (first, _) = ways.farthest(0);
    let (last, before) = ways.farthest(first);
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

/// The ways along a tree.
struct Ways<'a> {
    triangulation: &'a Triangulation,
    /// The neighbours of sample i are `others[first[i]..first[i + 1]]`.
    first: Vec<u32>,
    others: Vec<SampleId>,
}

impl<'a> Ways<'a> {
    fn new(triangulation: &'a Triangulation, tree: &Graph) -> Ways<'a> {
        let mut first = vec![0; triangulation.len() + 1];
        for &end in tree.edges().as_flattened() {
            first[end as usize + 1] += 1;
        }
        for sample in 0..triangulation.len() {
            first[sample + 1] += first[sample];
        }
        let mut next = first.clone();
        let mut others = vec![0; 2 * tree.edges().len()];
        for &[p, q] in tree.edges() {
            for (at, to) in [(p, q), (q, p)] {
                let place = &mut next[at as usize];
                others[*place as usize] = to;
                *place += 1;
            }
        }
        Ways { triangulation, first, others }
    }

    /// The sample with the longest way from another in the tree, and the sample before each on that way.
    fn farthest(&self, from: SampleId) -> (SampleId, Vec<SampleId>) {
        let mut before = vec![from; self.triangulation.len()];
        let mut stack = vec![(from, 0.0)];
        let mut best = (0.0, from);
        while let Some((at, way_mm)) = stack.pop() {
            if way_mm > best.0 || (way_mm == best.0 && at < best.1) {
                best = (way_mm, at);
            }
            let others = self.first[at as usize] as usize..self.first[at as usize + 1] as usize;
            for &to in &self.others[others] {
                if to != before[at as usize] {
                    before[to as usize] = at;
                    let [at, to_mm] = [at, to].map(|sample| self.triangulation.place(sample));
                    stack.push((to, way_mm + distance_mm(at, to_mm)));
                }
            }
        }
        (best.1, before)
    }
}
