//! Loops of a graph, each with the strips that it spans.

use crate::graph::{NodeId, PointGraph};

/// A loop: an arc too many to make a tree, with the strips between which it is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loop {
    /// The node where its two branches part, and the one where they meet again.
    pub nodes: [NodeId; 2],
    /// The strips of these nodes.
    pub strips: [u32; 2],
    /// The range of the function in which it is surely open: from the end of the lower strip to the start of the upper one. Of
    /// consecutive strips it is empty.
    pub range: [f64; 2],
}

impl Loop {
    /// Strips from one end to the other: 1 of a loop that two strips make, 2 of the smallest one around a strip.
    pub fn span(&self) -> u32 {
        self.strips[1] - self.strips[0]
    }

    /// Length of the range in which it is open, in the units of the function.
    pub fn extent(&self) -> f64 {
        (self.range[1] - self.range[0]).max(0.0)
    }
}

impl<const D: usize> PointGraph<D> {
    /// All loops, as many as arcs less nodes plus components, the widest first. Time nearly grows with arcs.
    ///
    /// Strips are passed from below. Where two branches of one piece below meet again, the loop's lower end is the highest
    /// strip from which both come; then the branches count as one. These are the pairs of extended persistence of the graph
    /// (P. K. Agarwal, H. Edelsbrunner, J. Harer, Y. Wang, Discrete & Computational Geometry 36 (2006) 553-572,
    /// doi:10.1007/s00454-006-1265-8).
    pub fn loops(&self) -> Vec<Loop> {
        let mut below: Vec<(NodeId, NodeId)> =
            self.arcs.iter().map(|arc| (arc.nodes[1], arc.nodes[0])).collect();
        below.sort_unstable();
        let bounds = self.strips.bounds();
        let of = |nodes: [NodeId; 2]| {
            let strips = nodes.map(|node| self.nodes[node as usize].strip);
            let range = [bounds[strips[0] as usize + 1], bounds[strips[1] as usize]];
            Loop { nodes, strips, range }
        };
        let mut loops: Vec<Loop> = closed(self.nodes.len(), &below).into_iter().map(of).collect();
        loops.sort_by(|a, b| b.span().cmp(&a.span()).then(a.nodes.cmp(&b.nodes)));
        loops
    }
}

/// The loops that arcs close, each by the node where it begins and the one where it ends. Nodes are numbered by strip; arcs are
/// (upper node, lower node), sorted. Two arcs may join the same nodes.
pub(crate) fn closed(nodes: usize, arcs: &[(NodeId, NodeId)]) -> Vec<[NodeId; 2]> {
    let mut merged = Merged::new(nodes);
    let closes = |&(upper, lower): &(NodeId, NodeId)| {
        let closes = merged.closes(upper, lower);
        merged.join(upper, lower);
        closes.map(|closes| closes.ends)
    };
    arcs.iter().filter_map(closes).collect()
}

/// Nodes, some of which count as one, each with one node below it at most.
pub(crate) struct Merged {
    same: Vec<NodeId>,
    below: Vec<Option<NodeId>>,
}

/// A loop that an arc closes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Closes {
    /// The node where its branches part, and the one where they meet.
    pub(crate) ends: [NodeId; 2],
    /// The nodes of both branches next to the lower end, and next to the upper one. Each stands for those that count as one with it.
    pub(crate) branches: [[NodeId; 2]; 2],
}

impl Merged {
    pub(crate) fn new(count: usize) -> Merged {
        Merged { same: (0..count as u32).collect(), below: vec![None; count] }
    }

    /// The node that stands for all which count as one with this one.
    pub(crate) fn root(&mut self, mut node: NodeId) -> NodeId {
        while self.same[node as usize] != node {
            let next = self.same[node as usize];
            self.same[node as usize] = self.same[next as usize];
            node = next;
        }
        node
    }

    /// The loop that closes where `lower` is put below `upper`.
    pub(crate) fn closes(&mut self, upper: NodeId, lower: NodeId) -> Option<Closes> {
        let upper_root = self.root(upper);
        let other = self.below[upper_root as usize]?;
        let high = [self.root(other), self.root(lower)];
        let mut low = high;
        let mut at = high;
        while at[0] != at[1] {
            low = at;
            let [a, b] = at.map(|node| self.below[node as usize]);
            at = [self.root(a?), self.root(b?)];
        }
        Some(Closes { ends: [at[0], upper], branches: [low, high] })
    }

    /// Puts `lower` below `upper`. Nodes of one strip below both count as one from there on, as far down as both branches reach.
    pub(crate) fn join(&mut self, upper: NodeId, lower: NodeId) {
        let upper = self.root(upper);
        let Some(other) = self.below[upper as usize] else {
            self.below[upper as usize] = Some(lower);
            return;
        };
        let (mut a, mut b) = (self.root(other), self.root(lower));
        while a != b {
            // Both lie in one strip, and so do the nodes below them.
            let (kept, gone) = (a.min(b), a.max(b));
            let under = [kept, gone].map(|node| self.below[node as usize]);
            self.same[gone as usize] = kept;
            let [Some(first), Some(second)] = under else {
                // One branch began here: two components became one.
                self.below[kept as usize] = under[0].or(under[1]);
                return;
            };
            (a, b) = (self.root(first), self.root(second));
        }
    }
}
