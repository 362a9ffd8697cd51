//! What works on the triangles: where a place lies, and the flips that make a triangulation
//! Delaunay.

use asphera_geometry::VertexId;
use asphera_geometry::predicates::{Place, encloses, left_of, outside_edge};

use super::cells::{Cells, GHOST, NEXT, PREV, Side, Slot};
use super::places::Places;

/// Works on the triangles of `points`.
pub(super) struct Editor<'a, P: ?Sized, C> {
    pub(super) points: &'a P,
    pub(super) cells: &'a C,
    pub(super) work: &'a mut Work,
}

/// Memory that is kept from one insertion to the next.
#[derive(Default)]
pub(super) struct Work {
    /// Cells that can be taken: two for every point that is not inserted yet.
    pub(super) spare: Vec<Slot>,
    /// How many ghosts there are: as many as sides, or vertices, of the hull.
    pub(super) ghosts: usize,
    /// Sides that may not be Delaunay.
    pub(super) suspects: Vec<Side>,
    /// Of an insertion: the sides still to be looked across, the triangles to go, and the sides
    /// around them counter-clockwise, each seen from outside, with the vertex it starts from
    /// seen from inside.
    pub(super) open: Vec<Side>,
    pub(super) doomed: Vec<Slot>,
    pub(super) border: Vec<(Side, VertexId)>,
    pub(super) strip: super::strip::Plan,
    pub(super) wide: super::wide::WideStars,
    /// How many triangles have been torn down, sides flipped and steps gone on long walks.
    pub(super) effort: usize,
}

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    #[inline(always)]
    pub(super) fn at(&self, vertex: VertexId) -> Place {
        self.points.place(vertex)
    }

    /// The triangle in which `place` lies, its sides included, or the ghost before which it lies.
    ///
    /// Walks from triangle to triangle, each time across a side that has the place on its other
    /// side. In a Delaunay triangulation such a walk ends (O. Devillers, S. Pion, M. Teillaud,
    /// Walking in a triangulation, Int. J. Found. Comput. Sci. 13 (2002) 181-199,
    /// doi:10.1142/S0129054102001047).
    pub(super) fn locate(&self, place: Place, from: Slot) -> Slot {
        self.locate_among(place, self.inside(from), |_, _| true)
            .expect("every triangle is one of all")
    }

    /// A triangle from which a walk can start: `from` or, before the hull, one behind it.
    #[inline(always)]
    pub(super) fn inside(&self, from: Slot) -> Slot {
        let mut slot = from;
        // A cell that is not used any more leads on as a ghost does, perhaps to another such.
        while self.cells.is_ghost(slot) {
            slot = self.cells.across(Side::new(slot, 2)).slot();
        }
        slot
    }

    /// The same from a triangle, no ghost, if the walk only meets some of the triangles and ghosts.
    #[inline(always)]
    pub(super) fn locate_among(
        &self,
        place: Place,
        from: Slot,
        among: impl Fn(Slot, [VertexId; 3]) -> bool,
    ) -> Option<Slot> {
        let (mut slot, mut entered) = (from, 3);
        loop {
            let corners = self.cells.corners(slot);
            if !among(slot, corners) {
                return None;
            }
            if corners[2] == GHOST {
                return Some(slot);
            }
            let at = corners.map(|corner| self.at(corner));
            let Some(index) = self.side_before(at, place, entered) else { return Some(slot) };
            let across = self.cells.across(Side::new(slot, index));
            (slot, entered) = (across.slot(), across.index());
        }
    }

    /// A side of a triangle that has `place` on its other side, but for the one it was entered by.
    #[inline(always)]
    pub(super) fn side_before(
        &self,
        at: [Place; 3],
        place: Place,
        entered: usize,
    ) -> Option<usize> {
        (0..3).find(|&i| i != entered && left_of(at[PREV[i]], at[NEXT[i]], place))
    }

    /// The corner of a triangle that stands exactly in `place`.
    pub(super) fn corner_at(&self, slot: Slot, place: Place) -> Option<VertexId> {
        let corners = self.cells.corners(slot);
        corners.into_iter().find(|&corner| corner != GHOST && self.at(corner) == place)
    }

    /// Whether a triangle cannot stay when a point is inserted at `place`: it lies inside its
    /// circumcircle or, of a ghost, beyond its side of the hull.
    #[inline(always)]
    pub(super) fn in_conflict(&self, slot: Slot, place: Place) -> bool {
        let [a, b, c] = self.cells.corners(slot);
        if c == GHOST {
            outside_edge(self.at(a), self.at(b), place)
        } else {
            encloses(self.at(a), self.at(b), self.at(c), place)
        }
    }

    /// Gives the vertex that stands at `place` another number; returns a triangle at it.
    pub(super) fn relabel(&self, place: Place, from: VertexId, to: VertexId, near: Slot) -> Slot {
        let home = self.locate(place, near);
        let corners = self.cells.corners(home);
        let Some(index) = corners.iter().position(|&corner| corner == from) else { return home };
        // The side that ends at the vertex leads to the next triangle about it.
        let first = Side::new(home, NEXT[index]);
        let mut side = first;
        loop {
            self.cells.set_corner(side.slot(), PREV[side.index()], to);
            side = self.cells.across(side).prev();
            if side == first {
                return home;
            }
        }
    }

    /// Flips suspected sides, and those that become suspect, until all are Delaunay; returns how many were.
    ///
    /// C. L. Lawson, Software for C1 surface interpolation, in: Mathematical Software III (1977)
    /// 161-194. From any triangulation of a convex region this ends with the Delaunay
    /// triangulation, and with ties decided as [`encloses`] does there is only one.
    ///
    /// ```text
    ///        a                    a
    ///      / t \                / | \
    ///     b ─── c      ▶       b t|u c
    ///      \ u /                \ | /
    ///        d                    d
    /// ```
    pub(super) fn legalize(&mut self) -> usize {
        let mut flips = 0;
        while let Some(side) = self.work.suspects.pop() {
            let (t, i) = (side.slot(), side.index());
            let corners = self.cells.corners(t);
            if corners[2] == GHOST {
                continue;
            }
            let across = self.cells.across(side);
            let (u, j) = (across.slot(), across.index());
            if self.cells.is_ghost(u) {
                continue;
            }
            let (a, d) = (corners[i], self.cells.corner(u, j));
            let [p, q, r] = corners.map(|corner| self.at(corner));
            if !encloses(p, q, r, self.at(d)) {
                continue;
            }
            let beyond_bd = self.cells.across(across.next());
            let beyond_ca = self.cells.across(side.next());
            self.cells.set_corner(t, PREV[i], d);
            self.cells.set_corner(u, PREV[j], a);
            self.cells.join(side, beyond_bd);
            self.cells.join(across, beyond_ca);
            self.cells.join(side.next(), across.next());
            self.work.suspects.extend([side, side.prev(), across, across.prev()]);
            flips += 1;
        }
        self.work.effort += 2 * flips;
        flips
    }
}
