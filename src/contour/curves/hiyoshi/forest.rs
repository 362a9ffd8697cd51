//! One stage after the other of Edmonds's algorithm: alternating trees from all nodes without a partner.
//!
//! An end is a number 2·e or 2·e + 1: the first or second end of the edge e. Blossoms are numbered after the nodes; *block* is a node or a
//! blossom. Outer blocks lie at an even distance from the root of their tree, inner ones at an odd one.

use super::matching::{NONE, Start};

/// Place of a block in the trees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Label {
    Free,
    Outer,
    Inner,
}

/// The trees, the blossoms and the matching.
pub(super) struct Forest<'a> {
    pub(super) start: &'a Start,
    pub(super) nodes: usize,
    /// The ends across the edges of each node.
    across: Vec<Vec<usize>>,
    /// The end of its partner, of each node.
    pub(super) mate: Vec<usize>,
    pub(super) label: Vec<Label>,
    /// The end through which each block got its label.
    pub(super) label_end: Vec<usize>,
    /// The outermost block round each node.
    pub(super) block_of: Vec<usize>,
    pub(super) parent: Vec<usize>,
    pub(super) children: Vec<Vec<usize>>,
    /// The ends that join each child to the next.
    pub(super) joints: Vec<Vec<usize>>,
    pub(super) base: Vec<usize>,
    pub(super) potential: Vec<i64>,
    /// The edge of least slack to an outer block, of each block.
    pub(super) best: Vec<usize>,
    pub(super) is_tight: Vec<bool>,
    pub(super) queue: Vec<usize>,
    unused: Vec<usize>,
}

/// What limits a change of the potentials.
enum Limit {
    /// An edge to a free block, or between outer blocks, becomes tight.
    Edge(usize),
    /// The potential of an inner blossom becomes 0.
    Blossom(usize),
}

impl<'a> Forest<'a> {
    pub(super) fn new(start: &'a Start) -> Forest<'a> {
        let nodes = start.potentials.len();
        let mut across = vec![Vec::new(); nodes];
        for (edge, &[p, q]) in start.edges.iter().enumerate() {
            across[p].push(2 * edge + 1);
            across[q].push(2 * edge);
        }
        let mut mate = vec![NONE; nodes];
        for &edge in &start.matched {
            let [p, q] = start.edges[edge];
            (mate[p], mate[q]) = (2 * edge + 1, 2 * edge);
        }
        let mut potential = start.potentials.clone();
        potential.resize(2 * nodes, 0);
        let mut base: Vec<usize> = (0..nodes).collect();
        base.resize(2 * nodes, NONE);
        Forest {
            start,
            nodes,
            across,
            mate,
            label: vec![Label::Free; 2 * nodes],
            label_end: vec![NONE; 2 * nodes],
            block_of: (0..nodes).collect(),
            parent: vec![NONE; 2 * nodes],
            children: vec![Vec::new(); 2 * nodes],
            joints: vec![Vec::new(); 2 * nodes],
            base,
            potential,
            best: vec![NONE; 2 * nodes],
            is_tight: vec![false; start.edges.len()],
            queue: Vec::new(),
            unused: (nodes..2 * nodes).rev().collect(),
        }
    }

    pub(super) fn partners(&self) -> &[usize] {
        &self.mate
    }

    /// The node at an end.
    pub(super) fn node(&self, end: usize) -> usize {
        self.start.edges[end / 2][end % 2]
    }

    /// How far the potentials of an edge's ends are from proving it.
    pub(super) fn slack(&self, edge: usize) -> i64 {
        let [p, q] = self.start.edges[edge];
        self.potential[p] + self.potential[q] + 2 * self.start.costs[edge]
    }

    pub(super) fn take_blossom(&mut self) -> usize {
        // A blossom has three nodes or more that no other has at its level: there are numbers enough.
        self.unused.pop().unwrap_or(NONE)
    }

    pub(super) fn give_back(&mut self, blossom: usize) {
        self.unused.push(blossom);
    }

    /// The ends across the edges of a node.
    pub(super) fn ends_across(&self, node: usize) -> &[usize] {
        &self.across[node]
    }

    /// One stage: adds an edge to the matching if that can be done.
    pub(super) fn augment(&mut self) -> bool {
        self.label.fill(Label::Free);
        self.best.fill(NONE);
        self.is_tight.fill(false);
        self.queue.clear();
        for node in 0..self.nodes {
            if self.mate[node] == NONE && self.label[self.block_of[node]] == Label::Free {
                self.assign(node, Label::Outer, NONE);
            }
        }
        while !self.grow() {
            let Some((change, limit)) = self.limit() else { return false };
            self.change(change);
            match limit {
                Limit::Edge(edge) => {
                    self.is_tight[edge] = true;
                    let [p, q] = self.start.edges[edge];
                    let from = if self.label[self.block_of[p]] == Label::Outer { p } else { q };
                    self.queue.push(from);
                }
                Limit::Blossom(blossom) => self.expand(blossom, false),
            }
        }
        for blossom in self.nodes..2 * self.nodes {
            if self.is_outermost(blossom)
                && self.label[blossom] == Label::Outer
                && self.potential[blossom] == 0
            {
                self.expand(blossom, true);
            }
        }
        true
    }

    /// Whether a blossom is in use and within no other.
    fn is_outermost(&self, blossom: usize) -> bool {
        self.base[blossom] != NONE && self.parent[blossom] == NONE
    }

    /// Labels the block of a node, reached through an end; of an inner one its partner becomes outer.
    pub(super) fn assign(&mut self, node: usize, label: Label, end: usize) {
        let block = self.block_of[node];
        for labelled in [node, block] {
            self.label[labelled] = label;
            self.label_end[labelled] = end;
            self.best[labelled] = NONE;
        }
        if label == Label::Outer {
            let leaves = self.leaves(block);
            self.queue.extend(leaves);
        } else {
            let mate = self.mate[self.base[block]];
            self.assign(self.node(mate), Label::Outer, mate ^ 1);
        }
    }

    /// Grows the trees along tight edges; whether a way between two of them was found and the matching augmented.
    fn grow(&mut self) -> bool {
        while let Some(node) = self.queue.pop() {
            for index in 0..self.across[node].len() {
                let end = self.across[node][index];
                let (edge, other) = (end / 2, self.node(end));
                if self.block_of[node] == self.block_of[other] {
                    continue;
                }
                let slack = self.slack(edge);
                self.is_tight[edge] |= slack <= 0;
                let label = self.label[self.block_of[other]];
                if self.is_tight[edge] {
                    match label {
                        Label::Free => self.assign(other, Label::Inner, end ^ 1),
                        Label::Outer => match self.meeting(node, other) {
                            Some(base) => self.add_blossom(base, edge),
                            None => {
                                self.augment_along(edge);
                                return true;
                            }
                        },
                        // Within an inner blossom: the way that was found to this node counts if the blossom is opened.
                        Label::Inner if self.label[other] == Label::Free => {
                            self.label[other] = Label::Inner;
                            self.label_end[other] = end ^ 1;
                        }
                        Label::Inner => {}
                    }
                } else if label == Label::Outer {
                    self.offer_best(self.block_of[node], edge, slack);
                } else if self.label[other] == Label::Free {
                    self.offer_best(other, edge, slack);
                }
            }
        }
        false
    }

    fn offer_best(&mut self, block: usize, edge: usize, slack: i64) {
        let best = self.best[block];
        if best == NONE || slack < self.slack(best) {
            self.best[block] = edge;
        }
    }

    /// The largest change of the potentials that keeps them a proof, and what limits it; none if nothing does.
    fn limit(&self) -> Option<(i64, Limit)> {
        let mut least: Option<(i64, Limit)> = None;
        let mut offer = |change: i64, limit: Limit| {
            if least.as_ref().is_none_or(|least| change < least.0) {
                least = Some((change, limit));
            }
        };
        for node in 0..self.nodes {
            let best = self.best[node];
            if self.label[self.block_of[node]] == Label::Free && best != NONE {
                offer(self.slack(best), Limit::Edge(best));
            }
        }
        for block in 0..2 * self.nodes {
            if self.parent[block] != NONE || self.base[block] == NONE {
                continue;
            }
            match self.label[block] {
                // Roots change together, so all outer potentials are even or all are odd.
                Label::Outer if self.best[block] != NONE => {
                    offer(self.slack(self.best[block]) / 2, Limit::Edge(self.best[block]));
                }
                Label::Inner if block >= self.nodes => {
                    offer(self.potential[block], Limit::Blossom(block));
                }
                _ => {}
            }
        }
        least
    }

    fn change(&mut self, change: i64) {
        for node in 0..self.nodes {
            match self.label[self.block_of[node]] {
                Label::Outer => self.potential[node] -= change,
                Label::Inner => self.potential[node] += change,
                Label::Free => {}
            }
        }
        for blossom in self.nodes..2 * self.nodes {
            if self.is_outermost(blossom) {
                match self.label[blossom] {
                    Label::Outer => self.potential[blossom] += change,
                    Label::Inner => self.potential[blossom] -= change,
                    Label::Free => {}
                }
            }
        }
    }

    /// The nodes within a block.
    pub(super) fn leaves(&self, block: usize) -> Vec<usize> {
        let mut leaves = Vec::new();
        let mut open = vec![block];
        while let Some(block) = open.pop() {
            if block < self.nodes {
                leaves.push(block);
            } else {
                open.extend(self.children[block].iter().rev());
            }
        }
        leaves
    }
}
