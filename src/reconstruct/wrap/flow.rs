//! The discrete gradient of the Delaunay radius function (U. Bauer, H. Edelsbrunner 2017, "The Morse theory of Čech and Delaunay
//! complexes", doi:10.1090/tran/6991).
//!
//! Simplices with one smallest empty sphere make an interval. Its largest simplex *owns* the others: it is the one whose corners are
//! all on the sphere. A simplex that is an interval of its own is *critical*: its sphere has its centre inside it.
//! A corner exactly on the ball of the facet opposite owns nothing, so each simplex has one owner, ties included.

use asphera_geometry::predicates::in_facet_ball;
use rayon::prelude::*;

use crate::delaunay::Delaunay;
use crate::geometry::{dot, minus};

/// Owners of all simplices.
pub(super) struct Flow<'a> {
    pub(super) delaunay: &'a Delaunay,
    /// A bit for each corner of each cell: the cell owns the facet opposite.
    owned: Vec<u8>,
    /// Ends of edges, in ascending order.
    pub(super) edges: Vec<[u32; 2]>,
    edge_owners: Vec<Owner>,
}

/// The largest simplex of an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Owner {
    /// The simplex itself.
    Itself,
    /// A facet: the cell, and the corner opposite.
    Facet(u32, u8),
    /// A tetrahedron.
    Cell(u32),
}

impl<'a> Flow<'a> {
    pub(super) fn of(delaunay: &'a Delaunay) -> Flow<'a> {
        let owned: Vec<u8> = (0..delaunay.tetrahedra as u32)
            .into_par_iter()
            .map(|cell| {
                let is_owned = |&slot: &usize| {
                    let facet = delaunay.facet(cell, slot).map(|corner| delaunay.place(corner));
                    let apex = delaunay.corners[cell as usize][slot];
                    in_facet_ball(facet, delaunay.place(apex)).is_gt()
                };
                (0..4).filter(is_owned).fold(0, |bits, slot| bits | 1 << slot)
            })
            .collect();
        let mut edges: Vec<[u32; 2]> = delaunay.corners[..delaunay.tetrahedra]
            .iter()
            .flat_map(|corners| PAIRS.map(|[one, other]| ends(corners[one], corners[other])))
            .collect();
        edges.par_sort_unstable();
        edges.dedup();
        let edge_owners = vec![Owner::Itself; edges.len()];
        let mut flow = Flow { delaunay, owned, edges, edge_owners };
        flow.own_edges();
        flow
    }

    /// Finds the owners of edges: tetrahedra that own both facets there, else facets whose corner opposite sees the edge at an obtuse angle.
    fn own_edges(&mut self) {
        let delaunay = self.delaunay;
        for (cell, slot) in delaunay.facets() {
            if self.facet_owner(cell, slot) != Owner::Itself {
                continue;
            }
            let facet = delaunay.facet(cell, slot);
            if let Some(corner) = obtuse_corner(delaunay, facet) {
                let edge = ends(facet[(corner + 1) % 3], facet[(corner + 2) % 3]);
                self.set_edge(edge, Owner::Facet(cell, slot as u8));
            }
        }
        for cell in 0..delaunay.tetrahedra as u32 {
            let corners = delaunay.corners[cell as usize];
            for [one, other] in PAIRS {
                // The other two corners are behind the facets that meet in this edge.
                let behind = 0b1111 & !(1 << one | 1 << other);
                if self.owned[cell as usize] & behind == behind {
                    self.set_edge(ends(corners[one], corners[other]), Owner::Cell(cell));
                }
            }
        }
    }

    fn set_edge(&mut self, edge: [u32; 2], owner: Owner) {
        if let Some(at) = self.edge_number(edge) {
            self.edge_owners[at] = owner;
        }
    }

    pub(super) fn edge_number(&self, edge: [u32; 2]) -> Option<usize> {
        self.edges.binary_search(&edge).ok()
    }

    pub(super) fn edge_owner(&self, edge: usize) -> Owner {
        self.edge_owners[edge]
    }

    pub(super) fn facet_owner(&self, cell: u32, slot: usize) -> Owner {
        let owns = |cell: u32, slot: usize| {
            self.owned.get(cell as usize).is_some_and(|bits| bits >> slot & 1 == 1)
        };
        let other = self.delaunay.neighbours[cell as usize][slot];
        if owns(cell, slot) {
            Owner::Cell(cell)
        } else if owns(other, self.delaunay.slot_toward(other, cell)) {
            Owner::Cell(other)
        } else {
            Owner::Itself
        }
    }

    pub(super) fn is_critical_cell(&self, cell: u32) -> bool {
        self.owned[cell as usize] == 0
    }

    pub(super) fn is_critical_facet(&self, cell: u32, slot: usize) -> bool {
        self.facet_owner(cell, slot) == Owner::Itself
            && obtuse_corner(self.delaunay, self.delaunay.facet(cell, slot)).is_none()
    }
}

/// The corner of a facet with an obtuse angle. What rounding leaves open may fall either way: both are gradients.
fn obtuse_corner(delaunay: &Delaunay, facet: [u32; 3]) -> Option<usize> {
    let places = facet.map(|corner| delaunay.place(corner));
    (0..3).find(|&corner| {
        let [one, other] = [1, 2].map(|step| minus(places[(corner + step) % 3], places[corner]));
        dot(one, other) < 0.0
    })
}

/// The ends of an edge in ascending order.
pub(super) fn ends(one: u32, other: u32) -> [u32; 2] {
    [one.min(other), one.max(other)]
}

/// Corners of the edges of a cell.
const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
