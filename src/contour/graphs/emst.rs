//! The Euclidean minimum spanning tree.

use crate::triangulation::EdgeId;
use crate::{Graph, Triangulation};

/// The Euclidean minimum spanning tree of the samples.
///
/// Of equally long edges those of smaller coordinates are taken, so there is one tree. J. B. Kruskal, Proceedings of the
/// AMS 7 (1956) 48-50, over the Delaunay edges, which hold it (M. I. Shamos, D. Hoey, FOCS 1975). Its edges are right for
/// samples of a smooth curve that are dense and nearly uniform (L. H. de Figueiredo, J. de Miranda Gomes, The Visual
/// Computer 11 (1994) 105-112). n·log n time.
pub fn emst(triangulation: &Triangulation) -> Graph {
    let in_tree = spanning(triangulation);
    Graph::of_edges(triangulation, |edge| in_tree[edge as usize])
}

/// Whether each edge of the triangulation belongs to the tree.
pub(crate) fn spanning(triangulation: &Triangulation) -> Vec<bool> {
    let count = triangulation.len();
    let mut in_tree = vec![false; triangulation.edges().len()];
    let mut sets = asphera_geometry::Sets::new(count);
    let mut parts = count;
    // Most of the tree are short edges. Of the others only those between two parts need an order (V. Osipov, P. Sanders, J. Singler,
    // ALENEX 2009, 52-61).
    let [short, mut long] = triangulation.parted_by_length(count + count / 4);
    let mut take = |sets: &mut asphera_geometry::Sets, edges: &[EdgeId]| {
        // Ends are fetched some dozens at a time, so that memory is waited for once.
        for run in triangulation.sorted_by_length(edges).chunks(RUN) {
            let mut ends = [[0; 2]; RUN];
            for (ends, &edge) in ends.iter_mut().zip(run) {
                *ends = triangulation.ends(edge);
            }
            for (&edge, [p, q]) in run.iter().zip(ends) {
                in_tree[edge as usize] = sets.join(p as usize, q as usize);
                parts -= usize::from(in_tree[edge as usize]);
            }
            if parts <= 1 {
                return true;
            }
        }
        false
    };
    if !take(&mut sets, &short) {
        long.retain(|&edge| {
            let [p, q] = triangulation.ends(edge).map(|end| sets.root(end as usize));
            p != q
        });
        take(&mut sets, &long);
    }
    in_tree
}

/// The edges of the tree, shortest first, equal ones by their numbers.
pub(crate) fn spanning_by_length(triangulation: &Triangulation) -> Vec<EdgeId> {
    let tree: Vec<EdgeId> = numbers(&spanning(triangulation)).collect();
    triangulation.sorted_by_length(&tree)
}

/// The longest edge of the tree, of equal ones that with the largest number; none without edges.
pub(crate) fn longest_spanning(triangulation: &Triangulation) -> Option<EdgeId> {
    let in_tree = spanning(triangulation);
    numbers(&in_tree).max_by(|&a, &b| triangulation.compare_lengths(a, b))
}

fn numbers(in_tree: &[bool]) -> impl Iterator<Item = EdgeId> + '_ {
    (0..).zip(in_tree).filter(|(_, is_in)| **is_in).map(|(edge, _)| edge)
}

/// Edges that are taken together.
const RUN: usize = 64;

/// Disjoint sets (R. E. Tarjan, Journal of the ACM 22 (1975) 215-225), joined by size.
pub(crate) struct Sets {
    parents: Vec<u32>,
    sizes: Vec<u32>,
}

impl Sets {
    /// Each element a set of its own.
    pub(crate) fn new(count: usize) -> Sets {
        Sets { parents: (0..count as u32).collect(), sizes: vec![1; count] }
    }

    /// The element that stands for the set of another.
    pub(crate) fn of(&mut self, mut element: u32) -> u32 {
        while self.parents[element as usize] != element {
            let parent = self.parents[element as usize];
            self.parents[element as usize] = self.parents[parent as usize];
            element = self.parents[element as usize];
        }
        element
    }

    /// The same, with nothing changed.
    pub(crate) fn find(&self, mut element: u32) -> u32 {
        while self.parents[element as usize] != element {
            element = self.parents[element as usize];
        }
        element
    }

    /// Joins the sets of two elements; whether they were two.
    pub(crate) fn join(&mut self, p: u32, q: u32) -> bool {
        let [mut large, mut small] = [self.of(p), self.of(q)];
        if large == small {
            return false;
        }
        if self.sizes[large as usize] < self.sizes[small as usize] {
            std::mem::swap(&mut large, &mut small);
        }
        self.parents[small as usize] = large;
        self.sizes[large as usize] += self.sizes[small as usize];
        true
    }
}
