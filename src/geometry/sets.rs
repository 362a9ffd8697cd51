//! Disjoint sets of numbered things (union-find).

/// A partition of 0..n.
#[derive(Clone, Debug)]
pub struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    /// `count` sets of one each.
    ///
    /// # Panics
    ///
    /// When `count` is above 2³².
    pub fn new(count: usize) -> Sets {
        let parent = (0..count)
            .map(|index| u32::try_from(index).expect("what is joined is numbered with u32"))
            .collect();
        Sets { parent }
    }

    /// Joins the sets of `a` and `b`; false where they were one already.
    ///
    /// # Panics
    ///
    /// If there is no such member.
    pub fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        // The smallest member is the root, so that it does not depend on the order of joining.
        self.parent[a.max(b)] = a.min(b) as u32;
        a != b
    }

    /// The smallest member of the set of `member`. Amortised logarithmic time (path halving).
    ///
    /// # Panics
    ///
    /// If there is no such member.
    pub fn root(&mut self, mut member: usize) -> usize {
        while self.parent[member] as usize != member {
            let parent = self.parent[member];
            self.parent[member] = self.parent[parent as usize];
            member = parent as usize;
        }
        member
    }

    /// The set of each member, and how many sets there are; sets are numbered by their smallest members.
    pub fn numbered(mut self) -> (Vec<u32>, u32) {
        let mut count = 0;
        let mut numbers = vec![0; self.parent.len()];
        for member in 0..self.parent.len() {
            let root = self.root(member);
            if root == member {
                numbers[member] = count;
                count += 1;
            } else {
                numbers[member] = numbers[root];
            }
        }
        (numbers, count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joins_in_any_order() {
        for pairs in [[(1, 4), (4, 2), (5, 3)], [(3, 5), (2, 1), (1, 4)]] {
            let mut sets = Sets::new(6);
            pairs.into_iter().for_each(|(a, b)| assert!(sets.join(a, b)));
            assert_eq!([0, 1, 2, 3, 4, 5].map(|member| sets.root(member)), [0, 1, 1, 3, 1, 3]);
        }
    }
}
