//! Blossoms: rings of an odd number of blocks that count as one.

use super::forest::{Forest, Label};
use super::matching::NONE;

/// Way round a blossom from a child to its base, on the side on which steps come in pairs.
#[derive(Clone, Copy)]
struct Way {
    /// Place of the child.
    from: usize,
    forward: bool,
    count: usize,
}

impl Way {
    fn new(from: usize, count: usize) -> Way {
        Way { from, forward: from % 2 == 1, count }
    }

    /// How many steps lead to the base.
    fn steps(self) -> usize {
        if self.forward { self.count - self.from } else { self.from }
    }

    /// The place after some steps.
    fn at(self, steps: usize) -> usize {
        match self.forward {
            true => (self.from + steps) % self.count,
            false => (self.from + self.count * (1 + steps / self.count) - steps) % self.count,
        }
    }
}

impl Forest<'_> {
    /// The base of the blossom that an edge between two outer nodes closes; none if their trees are not one.
    pub(super) fn meeting(&self, first: usize, second: usize) -> Option<usize> {
        let mut ways = [first, second];
        let mut passed = std::collections::BTreeSet::new();
        // In turns, so that the time is that of the shorter way.
        let mut turn = 0;
        while ways != [NONE; 2] {
            if ways[turn] != NONE {
                let block = self.block_of[ways[turn]];
                if !passed.insert(block) {
                    return Some(self.base[block]);
                }
                ways[turn] = match self.label_end[block] {
                    NONE => NONE,
                    end => {
                        let inner = self.block_of[self.node(end)];
                        self.node(self.label_end[inner])
                    }
                };
            }
            turn = 1 - turn;
        }
        None
    }

    /// Makes the blossom that an edge closes.
    pub(super) fn add_blossom(&mut self, base: usize, edge: usize) {
        let [first, second] = self.start.edges[edge];
        let root = self.block_of[base];
        let blossom = self.take_blossom();
        let (mut children, mut joints) = (Vec::new(), Vec::new());
        let mut block = self.block_of[first];
        while block != root {
            children.push(block);
            joints.push(self.label_end[block]);
            block = self.block_of[self.node(self.label_end[block])];
        }
        children.push(root);
        children.reverse();
        joints.reverse();
        joints.push(2 * edge);
        let mut block = self.block_of[second];
        while block != root {
            children.push(block);
            joints.push(self.label_end[block] ^ 1);
            block = self.block_of[self.node(self.label_end[block])];
        }
        for &child in &children {
            self.parent[child] = blossom;
        }
        self.base[blossom] = base;
        self.parent[blossom] = NONE;
        self.label[blossom] = Label::Outer;
        self.label_end[blossom] = self.label_end[root];
        self.potential[blossom] = 0;
        self.children[blossom] = children;
        self.joints[blossom] = joints;
        let leaves = self.leaves(blossom);
        for &leaf in &leaves {
            if self.label[self.block_of[leaf]] == Label::Inner {
                self.queue.push(leaf);
            }
        }
        for &leaf in &leaves {
            self.block_of[leaf] = blossom;
        }
        self.best[blossom] = self.best_of(&leaves, blossom);
    }

    /// The edge of least slack from nodes of a blossom to an outer block beyond it.
    fn best_of(&self, leaves: &[usize], blossom: usize) -> usize {
        let mut best = NONE;
        for &leaf in leaves {
            for &end in self.ends_across(leaf) {
                let beyond = self.block_of[self.node(end)];
                let is_less = best == NONE || self.slack(end / 2) < self.slack(best);
                if beyond != blossom && self.label[beyond] == Label::Outer && is_less {
                    best = end / 2;
                }
            }
        }
        best
    }

    /// Takes a blossom apart, at the end of a stage with the blossoms of potential 0 within.
    pub(super) fn expand(&mut self, blossom: usize, is_end: bool) {
        let children = std::mem::take(&mut self.children[blossom]);
        for &child in &children {
            self.parent[child] = NONE;
            if child >= self.nodes && is_end && self.potential[child] == 0 {
                self.expand(child, true);
            } else {
                for leaf in self.leaves(child) {
                    self.block_of[leaf] = child;
                }
            }
        }
        let joints = std::mem::take(&mut self.joints[blossom]);
        if !is_end && self.label[blossom] == Label::Inner {
            self.relabel(blossom, &children, &joints);
        }
        self.label[blossom] = Label::Free;
        self.label_end[blossom] = NONE;
        self.base[blossom] = NONE;
        self.best[blossom] = NONE;
        self.give_back(blossom);
    }

    /// Labels the children of an inner blossom that was taken apart.
    fn relabel(&mut self, blossom: usize, children: &[usize], joints: &[usize]) {
        let count = children.len();
        let entry = self.block_of[self.node(self.label_end[blossom] ^ 1)];
        let Some(from) = children.iter().position(|&child| child == entry) else { return };
        let way = Way::new(from, count);
        // The joint that a step crosses, as the end of the block it leads to.
        let crossed = |step: usize| match way.forward {
            true => joints[way.at(step)],
            false => joints[way.at(step + 1)] ^ 1,
        };
        let mut end = self.label_end[blossom];
        let mut step = 0;
        while step < way.steps() {
            let [reached, next] = [self.node(end ^ 1), self.node(crossed(step) ^ 1)];
            // What the blossom's way in left behind is wiped, so that each child gets its own label.
            self.label[reached] = Label::Free;
            self.label[next] = Label::Free;
            self.assign(reached, Label::Inner, end);
            self.is_tight[crossed(step) / 2] = true;
            end = crossed(step + 1);
            self.is_tight[end / 2] = true;
            step += 2;
        }
        let base = children[way.at(step)];
        for labelled in [self.node(end ^ 1), base] {
            self.label[labelled] = Label::Inner;
            self.label_end[labelled] = end;
        }
        self.best[base] = NONE;
        // The others are reached only if a way into them was found before.
        let mut step = step + 1;
        while children[way.at(step)] != entry {
            let child = children[way.at(step)];
            step += 1;
            if self.label[child] == Label::Outer {
                continue;
            }
            let leaves = self.leaves(child);
            if let Some(leaf) = leaves.into_iter().find(|&leaf| self.label[leaf] != Label::Free) {
                self.label[leaf] = Label::Free;
                let partner = self.node(self.mate[self.base[child]]);
                self.label[partner] = Label::Free;
                self.assign(leaf, Label::Inner, self.label_end[leaf]);
            }
        }
    }

    /// Turns the matching within a blossom so that a node of it is left out.
    fn turn(&mut self, blossom: usize, node: usize) {
        let mut child = node;
        while self.parent[child] != blossom {
            child = self.parent[child];
        }
        if child >= self.nodes {
            self.turn(child, node);
        }
        let Some(from) = self.children[blossom].iter().position(|&other| other == child) else {
            return;
        };
        let way = Way::new(from, self.children[blossom].len());
        let mut step = 0;
        while step < way.steps() {
            let [first, second] =
                [step + 1, step + 2].map(|step| self.children[blossom][way.at(step)]);
            let end = match way.forward {
                true => self.joints[blossom][way.at(step + 1)],
                false => self.joints[blossom][way.at(step + 2)] ^ 1,
            };
            for (child, end) in [(first, end), (second, end ^ 1)] {
                if child >= self.nodes {
                    self.turn(child, self.node(end));
                }
            }
            let [p, q] = [end, end ^ 1].map(|end| self.node(end));
            (self.mate[p], self.mate[q]) = (end ^ 1, end);
            step += 2;
        }
        self.children[blossom].rotate_left(from);
        self.joints[blossom].rotate_left(from);
        self.base[blossom] = self.base[self.children[blossom][0]];
    }

    /// Swaps matched and other edges along the way between two roots through an edge.
    pub(super) fn augment_along(&mut self, edge: usize) {
        let [first, second] = self.start.edges[edge];
        for (mut node, mut end) in [(first, 2 * edge + 1), (second, 2 * edge)] {
            loop {
                let block = self.block_of[node];
                if block >= self.nodes {
                    self.turn(block, node);
                }
                self.mate[node] = end;
                let label_end = self.label_end[block];
                if label_end == NONE {
                    break;
                }
                let inner = self.block_of[self.node(label_end)];
                let before = self.label_end[inner];
                let entered = self.node(before ^ 1);
                node = self.node(before);
                if inner >= self.nodes {
                    self.turn(inner, entered);
                }
                self.mate[entered] = before;
                end = before ^ 1;
            }
        }
    }
}
