//! Segments: chains of nodes between branches, as polylines, and the segment of each node.

use crate::graph::{NodeId, PointGraph};

/// A chain of nodes between two nodes that are no simple passage: ends, branches.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// Its nodes from end to end. Branches are the ends of several chains; the chain of a lone node has one.
    pub nodes: Vec<NodeId>,
}

impl<const D: usize> PointGraph<D> {
    /// The maximal chains of the graph, by their first nodes. A closed ring of passages begins and ends at its smallest node. Time
    /// grows with nodes and arcs.
    pub fn segments(&self) -> Vec<Segment> {
        let mut beside: Vec<Vec<NodeId>> = vec![Vec::new(); self.nodes.len()];
        for arc in &self.arcs {
            beside[arc.nodes[0] as usize].push(arc.nodes[1]);
            beside[arc.nodes[1] as usize].push(arc.nodes[0]);
        }
        beside.iter_mut().for_each(|others| others.sort_unstable());
        let is_passage = |node: NodeId| beside[node as usize].len() == 2;
        let mut is_taken = vec![false; self.nodes.len()];
        let mut segments = Vec::new();
        let ends = (0..self.nodes.len() as u32).filter(|&node| !is_passage(node));
        for end in ends {
            if beside[end as usize].is_empty() {
                segments.push(Segment { nodes: vec![end] });
            }
            for &next in &beside[end as usize] {
                let is_new = if is_passage(next) { !is_taken[next as usize] } else { end < next };
                if is_new {
                    segments.push(self.follow(&beside, &mut is_taken, [end, next]));
                }
            }
        }
        for node in 0..self.nodes.len() as u32 {
            if is_passage(node) && !is_taken[node as usize] {
                is_taken[node as usize] = true;
                let next = beside[node as usize][0];
                segments.push(self.follow(&beside, &mut is_taken, [node, next]));
            }
        }
        segments.sort_by(|a, b| a.nodes.cmp(&b.nodes));
        segments
    }

    fn follow(
        &self,
        beside: &[Vec<NodeId>],
        is_taken: &mut [bool],
        [start, mut at]: [NodeId; 2],
    ) -> Segment {
        let mut nodes = vec![start, at];
        let mut before = start;
        while at != start && beside[at as usize].len() == 2 {
            is_taken[at as usize] = true;
            let [a, b] = [beside[at as usize][0], beside[at as usize][1]];
            (before, at) = (at, if a == before { b } else { a });
            nodes.push(at);
        }
        Segment { nodes }
    }

    /// A segment of each node: the first one that holds it; and how many there are.
    pub fn segments_of_nodes(&self) -> (Vec<u32>, usize) {
        let segments = self.segments();
        let mut of_node = vec![u32::MAX; self.nodes.len()];
        for (number, segment) in (0..).zip(&segments) {
            for &node in &segment.nodes {
                let known = &mut of_node[node as usize];
                *known = (*known).min(number);
            }
        }
        (of_node, segments.len())
    }
}
