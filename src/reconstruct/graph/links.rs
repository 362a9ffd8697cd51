//! The neighbourhood graph: an edge from every point to each of its nearest.

use rayon::prelude::*;

use crate::neighbours::Neighbours;

/// An undirected graph on the points of a tree, by their numbers in it.
pub(super) struct Links {
    /// Where the neighbours of each point start; one more at the end.
    starts: Vec<u32>,
    ends: Vec<u32>,
}

impl Links {
    /// The graph with an edge between points of which one is among the `count` nearest of the other. n·log n time.
    pub(super) fn of(tree: &Neighbours, count: usize) -> Links {
        let len = tree.len();
        let nearest = tree.nearest_of_all(count);
        let stride = count.min(len.saturating_sub(1));
        let list = |at: usize| &nearest[at * stride..(at + 1) * stride];
        // Edges that only the point at their start knows, given to their ends.
        let mut back: Vec<[u32; 2]> = (0..len)
            .into_par_iter()
            .flat_map_iter(|at| {
                let is_one_way = move |&end: &u32| !list(end as usize).contains(&(at as u32));
                list(at).iter().copied().filter(is_one_way).map(move |end| [end, at as u32])
            })
            .collect();
        back.par_sort_unstable();
        let mut starts = Vec::with_capacity(len + 1);
        let mut ends = Vec::with_capacity(nearest.len() + back.len());
        starts.push(0);
        let mut next = 0;
        for at in 0..len {
            ends.extend_from_slice(list(at));
            while let Some(&[_, start]) = back.get(next).filter(|edge| edge[0] as usize == at) {
                ends.push(start);
                next += 1;
            }
            starts.push(ends.len() as u32);
        }
        Links { starts, ends }
    }

    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// The neighbours of a point, in no order that means anything.
    #[inline]
    pub(super) fn at(&self, point: u32) -> &[u32] {
        let point = point as usize;
        &self.ends[self.starts[point] as usize..self.starts[point + 1] as usize]
    }
}
