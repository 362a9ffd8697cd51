//! The triangles about one vertex, and what stands around them.
//!
//! ```text
//!          b ◀──── a          a spoke leads from the vertex to a, its triangle on its left;
//!           \     /           the rim leads from a to b; the next spoke, counter-clockwise,
//!            vertex           leads to b
//! ```

use asphera_geometry::VertexId;
use asphera_geometry::predicates::Place;

use super::cells::{Cells, GHOST, NEXT, PREV, Side, Slot};
use super::editor::Editor;
use super::places::Places;

/// A triangle of a star.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spoke {
    /// Where the spoke ends, which is where the rim starts.
    pub(super) end: VertexId,
    /// The rim, seen from outside the star.
    pub(super) outside: Side,
    pub(super) slot: Slot,
}

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    /// A side that starts at `vertex`, which is one of the triangulation, walking to it from a
    /// triangle.
    pub(super) fn spoke(&self, vertex: VertexId, from: Slot) -> Side {
        let home = self.locate(self.at(vertex), from);
        let corners = self.cells.corners(home);
        let index = corners.iter().position(|&corner| corner == vertex);
        Side::new(home, PREV[index.expect("a walk to a vertex ends at a triangle that has it")])
    }

    /// All sides that start where `first` does, counter-clockwise, ghosts' among them.
    pub(super) fn spokes(&self, first: Side) -> impl Iterator<Item = Side> + '_ {
        let mut next = Some(first);
        std::iter::from_fn(move || {
            let side = next?;
            let turned = self.cells.across(side.prev());
            next = (turned != first).then_some(turned);
            Some(side)
        })
    }

    /// The star of the vertex from which `first` starts.
    ///
    /// Of a vertex on the hull the corner at infinity ends the last spoke, so that the first one
    /// ends at the next vertex of the hull; of another one the smallest number comes first.
    pub(super) fn star(&self, first: Side) -> Vec<Spoke> {
        let mut star: Vec<Spoke> = self
            .spokes(first)
            .map(|side| Spoke {
                end: self.cells.end(side),
                outside: self.cells.across(side.next()),
                slot: side.slot(),
            })
            .collect();
        if let Some(ghost) = star.iter().position(|spoke| spoke.end == GHOST) {
            star.rotate_left(ghost + 1);
        } else {
            let smallest = (0..star.len()).min_by_key(|&index| star[index].end).unwrap_or(0);
            star.rotate_left(smallest);
        }
        star
    }

    /// The nearest vertex to `place`, and of several the one with the smallest x, then y.
    ///
    /// Goes from vertex to neighbour from a corner of `home` as long as that one is better. A
    /// vertex that is not nearest has a neighbour nearer to the place: the one across the edge of
    /// its Voronoi cell that the straight way to the place passes. Those nearest to it lie on one
    /// empty circle, so they are the corners of a convex polygon with no other edges inside than
    /// between them, and along its boundary x, then y, has no minimum but the smallest.
    pub(super) fn nearest(&self, place: Place, home: Slot) -> VertexId {
        // Of a ghost the third corner is none.
        let mut spoke = Side::new(home, 2);
        loop {
            let centre = self.cells.corner(spoke.slot(), NEXT[spoke.index()]);
            let mut best = (centre, spoke);
            for side in self.spokes(spoke) {
                let end = self.cells.end(side);
                if end != GHOST && nearer(place, self.at(end), self.at(best.0)) {
                    best = (end, side.next());
                }
            }
            if best.0 == centre {
                return centre;
            }
            spoke = best.1;
        }
    }
}

/// Whether `p` is nearer to `place` than `q`, or as near and smaller by x, then y.
pub(super) fn nearer(place: Place, p: Place, q: Place) -> bool {
    asphera_geometry::predicates::compare_distances_from(place, p, q)
        .then_with(|| asphera_geometry::predicates::by_x_then_y(p, q))
        .is_lt()
}
