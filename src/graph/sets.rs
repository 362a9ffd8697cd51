//! Disjoint sets of numbered things (union-find).

/// A partition of 0..n.
#[derive(Clone, Debug)]
pub struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    /// `count` sets of one each.
    pub fn new(count: u32) -> Sets {
        Sets { parent: (0..count).collect() }
    }

    /// Joins the sets of `a` and `b`; false where they were one already.
    ///
    /// # Panics
    ///
    /// If there is no such member.
    pub fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        // The smallest member is the root, so that it does not depend on the order of joining.
        self.parent[a.max(b) as usize] = a.min(b);
        a != b
    }

    /// The smallest member of the set of `member`. Amortised logarithmic time (path halving).
    ///
    /// # Panics
    ///
    /// If there is no such member.
    pub fn root(&mut self, mut member: u32) -> u32 {
        while self.parent[member as usize] != member {
            let parent = self.parent[member as usize];
            self.parent[member as usize] = self.parent[parent as usize];
            member = parent;
        }
        member
    }

    /// The set of each member, and how many sets there are; sets are numbered by their smallest members.
    pub fn numbered(mut self) -> (Vec<u32>, u32) {
        let mut count = 0;
        let mut numbers = vec![0; self.parent.len()];
        for member in 0..self.parent.len() as u32 {
            let root = self.root(member);
            if root == member {
                numbers[member as usize] = count;
                count += 1;
            } else {
                numbers[member as usize] = numbers[root as usize];
            }
        }
        (numbers, count)
    }
}
