//! Sets of facets of a Delaunay triangulation, and turns about their edges.

use crate::delaunay::Delaunay;

/// A set of finite facets.
pub(crate) struct FacetSet<'a> {
    pub(crate) delaunay: &'a Delaunay,
    /// A bit for each corner of each cell: the facet opposite is in the set.
    bits: Vec<u8>,
}

/// A cell at an edge: entered across the facet opposite `behind`, left across that opposite `ahead`. The edge has the other two corners.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turn {
    pub(crate) cell: u32,
    pub(crate) behind: usize,
    pub(crate) ahead: usize,
}

impl Turn {
    /// The next cell about the edge.
    #[inline]
    pub(crate) fn next(self, delaunay: &Delaunay) -> Turn {
        let Turn { cell, behind, ahead } = self;
        let next = delaunay.neighbours[cell as usize][ahead];
        let pivot = delaunay.corners[cell as usize][behind];
        let corners = &delaunay.corners[next as usize];
        Turn {
            cell: next,
            behind: delaunay.slot_toward(next, cell),
            ahead: corners.iter().position(|&corner| corner == pivot).unwrap_or(0),
        }
    }

    /// The ends of the edge.
    pub(crate) fn edge(self, delaunay: &Delaunay) -> [u32; 2] {
        let corners = &delaunay.corners[self.cell as usize];
        let mut ends = (0..4).filter(|&slot| slot != self.behind && slot != self.ahead);
        [0; 2].map(|_| ends.next().map_or(0, |slot| corners[slot]))
    }
}

/// The turns that begin at the facet opposite a corner, one for each of its edges.
pub(crate) fn turns(cell: u32, slot: usize) -> impl Iterator<Item = Turn> {
    (0..4).filter(move |&ahead| ahead != slot).map(move |ahead| Turn { cell, behind: slot, ahead })
}

impl<'a> FacetSet<'a> {
    pub(crate) fn empty(delaunay: &'a Delaunay) -> FacetSet<'a> {
        FacetSet { delaunay, bits: vec![0; delaunay.corners.len()] }
    }

    #[inline]
    pub(crate) fn has(&self, cell: u32, slot: usize) -> bool {
        self.bits[cell as usize] >> slot & 1 == 1
    }

    /// The same facet from the other side.
    #[inline]
    pub(crate) fn other_side(&self, cell: u32, slot: usize) -> (u32, usize) {
        let other = self.delaunay.neighbours[cell as usize][slot];
        (other, self.delaunay.slot_toward(other, cell))
    }

    pub(crate) fn insert(&mut self, cell: u32, slot: usize) {
        let (other, back) = self.other_side(cell, slot);
        self.bits[cell as usize] |= 1 << slot;
        self.bits[other as usize] |= 1 << back;
    }

    pub(crate) fn remove(&mut self, cell: u32, slot: usize) {
        let (other, back) = self.other_side(cell, slot);
        self.bits[cell as usize] &= !(1 << slot);
        self.bits[other as usize] &= !(1 << back);
    }

    /// Facets of the set, each once, seen from its first cell.
    pub(crate) fn all(&self) -> impl Iterator<Item = (u32, usize)> + '_ {
        self.delaunay.facets().filter(|&(cell, slot)| self.has(cell, slot))
    }

    /// Facets of the set about an edge, from that of the turn on: each by the turn that is about to cross it, the first of all last.
    pub(crate) fn about(&self, start: Turn, mut visit: impl FnMut(Turn)) {
        let mut turn = start;
        loop {
            if self.has(turn.cell, turn.ahead) {
                visit(turn);
            }
            turn = turn.next(self.delaunay);
            if turn == start {
                return;
            }
        }
    }

    /// The first facet of the set that a turn meets, seen from the cell before it.
    pub(crate) fn first_met(&self, start: Turn) -> (u32, usize) {
        let mut turn = start;
        while !self.has(turn.cell, turn.ahead) {
            turn = turn.next(self.delaunay);
        }
        (turn.cell, turn.ahead)
    }
}
