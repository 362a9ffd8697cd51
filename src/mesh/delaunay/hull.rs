//! The hull, closed where it turns right.

use asphera_geometry::predicates::left_of;

use super::cells::{Cells, GHOST, Side, Slot};
use super::editor::Editor;
use super::fan::Out;
use super::places::Places;

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    /// Fills the corner between the side of the hull before `ghost` and the next, if the hull turns
    /// right there, and those that turn right then. Triangles are suspect afterwards. Returns the ghost
    /// that lies where `ghost` lay.
    ///
    /// ```text
    ///            ghost's side
    ///      start ──────▶ corner
    ///          \          │           start, end and corner make a triangle
    ///            \        ▼ the next ghost's
    ///              ──▶ end
    /// ```
    ///
    /// The two ghosts' cells become the triangle's and the new ghost's. All is done on the ring of
    /// ghosts itself: it does not matter how far around the hull this leads.
    pub(super) fn close_corner(&mut self, ghost: Slot) -> Slot {
        let mut heir = ghost;
        let mut open = vec![ghost];
        while let Some(ghost) = open.pop() {
            let [corner, start, last] = self.cells.corners(ghost);
            if last != GHOST {
                continue;
            }
            let next = self.cells.across(Side::new(ghost, 1)).slot();
            let end = self.cells.corner(next, 0);
            if !left_of(self.at(corner), self.at(start), self.at(end)) {
                continue;
            }
            // A long line is closed as a whole.
            let folded = [(ghost, Out::Ahead), (next, Out::Back)]
                .into_iter()
                .find(|&(edge, out)| self.fold(edge, out));
            if let Some((edge, _)) = folded {
                if !self.cells.is_ghost(heir) {
                    heir = edge;
                }
                open.extend([edge, self.cells.across(Side::new(edge, 0)).slot()]);
                continue;
            }
            let [inner, next_inner] =
                [ghost, next].map(|slot| self.cells.across(Side::new(slot, 2)));
            let before = self.cells.across(Side::new(ghost, 0));
            let after = self.cells.across(Side::new(next, 1));
            let sides = [0, 1, 2].map(|index| Side::new(next, index));
            self.cells.write(next, [start, end, corner], [next_inner, inner, Side::new(ghost, 2)]);
            self.cells.set_across(next_inner, sides[0]);
            self.cells.set_across(inner, sides[1]);
            self.cells.write(ghost, [end, start, GHOST], [before, after, sides[2]]);
            self.cells.set_across(after, Side::new(ghost, 1));
            self.work.ghosts -= 1;
            if next == heir {
                heir = ghost;
            }
            self.work.suspects.extend([sides[0], sides[1]]);
            open.extend([ghost, before.slot()]);
        }
        heir
    }
}
