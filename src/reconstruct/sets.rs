//! Disjoint sets of numbered things (union-find).

/// A partition of 0..n.
pub(crate) struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    /// `count` sets of one each; fewer than 2³².
    pub(crate) fn new(count: usize) -> Sets {
        Sets { parent: (0..count as u32).collect() }
    }

    /// Joins the sets of `a` and `b`; gives whether they were different.
    pub(crate) fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        // The smallest member is the root, so that it does not depend on the order of joining.
        self.parent[a.max(b) as usize] = a.min(b);
        a != b
    }

    /// The smallest member of the set of `member`. Amortised logarithmic time (path halving).
    pub(crate) fn root(&mut self, mut member: u32) -> u32 {
        while self.parent[member as usize] != member {
            let parent = self.parent[member as usize];
            self.parent[member as usize] = self.parent[parent as usize];
            member = parent;
        }
        member
    }
}
