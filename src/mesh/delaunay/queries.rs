//! What can be asked of the triangulation while it stands still.

use asphera_geometry::predicates::{Place, left_of, orientation};
use asphera_geometry::{VertexId, from_smallest};

use super::Delaunay;
use super::cells::{Cells, GHOST, NEXT, PREV, Side, Slot};
use super::editor::{Editor, Work};
use super::places::Places;
use super::star::Spoke;
use crate::Location;

impl<C: Cells> Delaunay<C> {
    /// Where an admitted place lies.
    pub(crate) fn locate(&self, points: &(impl Places + ?Sized), place: Place) -> Location {
        let Some(near) = self.near(points, place) else { return self.sheet.line.locate(place) };
        let mut work = Work::default();
        let reader = self.reader(points, &mut work);
        reader.location(place, reader.locate(place, near))
    }

    /// The nearest vertex to an admitted place, and of several the one with the smallest x, then y.
    pub(crate) fn nearest(
        &self,
        points: &(impl Places + ?Sized),
        place: Place,
    ) -> Option<VertexId> {
        let Some(near) = self.near(points, place) else {
            return self.sheet.line.nearest(points, place);
        };
        let mut work = Work::default();
        let reader = self.reader(points, &mut work);
        Some(reader.nearest(place, reader.locate(place, near)))
    }

    /// The neighbours of a vertex.
    pub(crate) fn about(&self, points: &(impl Places + ?Sized), vertex: VertexId) -> About {
        let at = points.place(vertex);
        let Some(near) = self.near(points, at) else {
            let vertices = self.sheet.line.about(at).into_iter().flatten().collect();
            return About { vertices, on_hull: true, near: None };
        };
        let mut work = Work::default();
        self.reader(points, &mut work).about(vertex, near)
    }

    /// The neighbours of a vertex which is one of those of another.
    pub(crate) fn about_next(
        &self,
        points: &(impl Places + ?Sized),
        vertex: VertexId,
        of: &About,
    ) -> About {
        match of.near {
            None => self.about(points, vertex),
            Some(near) => self.reader(points, &mut Work::default()).about(vertex, near),
        }
    }

    /// All that is there only because no vertex stands in an admitted place.
    pub(crate) fn in_conflict(
        &self,
        points: &(impl Places + ?Sized),
        place: Place,
    ) -> Vec<Conflict> {
        let Some(near) = self.near(points, place) else {
            let ends = self.sheet.line.outermost();
            return ends.map(|[first, last]| Conflict::Beyond([first, last])).into_iter().collect();
        };
        let mut work = Work::default();
        let mut reader = self.reader(points, &mut work);
        let home = reader.locate(place, near);
        if reader.corner_at(home, place).is_some() {
            return Vec::new();
        }
        reader.carve(place, home);
        let corners = work.doomed.iter().map(|&slot| self.cells.corners(slot));
        corners
            .map(|corners| match corners {
                [end, start, GHOST] => Conflict::Beyond([start, end]),
                _ => Conflict::Triangle(from_smallest(corners)),
            })
            .collect()
    }

    /// The natural neighbours of an admitted place inside the triangle or on the edge where it
    /// lies, not on the hull: see [`Editor::natural`].
    pub(crate) fn natural(
        &self,
        points: &(impl Places + ?Sized),
        place: Place,
    ) -> Option<Vec<(VertexId, f64)>> {
        let near = self.near(points, place)?;
        let mut work = Work::default();
        let mut reader = self.reader(points, &mut work);
        let home = reader.locate(place, near);
        reader.natural(place, home)
    }

    /// A triangle from which it should not be far to a place, once there are triangles.
    pub(super) fn near(&self, points: &(impl Places + ?Sized), place: Place) -> Option<Slot> {
        self.sheet.near(points, &self.cells, place)
    }

    /// Reads the triangulation, with memory of its own for what is found.
    fn reader<'a, P: Places + ?Sized>(
        &'a self,
        points: &'a P,
        work: &'a mut Work,
    ) -> Editor<'a, P, C> {
        Editor { points, cells: &self.cells, work }
    }
}

/// The neighbours of a vertex, from which a walk around the mesh goes on at once.
#[derive(Debug)]
pub struct About {
    /// Counter-clockwise. Of a vertex on the hull from the next one on the hull to the one before;
    /// of another from the smallest number on. On a line by x, then y.
    pub vertices: Vec<VertexId>,
    /// Whether the vertex lies on the hull.
    pub on_hull: bool,
    /// A triangle at the vertex; none on a line.
    near: Option<Slot>,
}

impl About {
    /// Whether there are no triangles, since all vertices lie on one line.
    pub fn on_line(&self) -> bool {
        self.near.is_none()
    }
}

/// Triangles that cannot stay when a vertex is set somewhere.
pub(crate) enum Conflict {
    /// A triangle.
    Triangle([VertexId; 3]),
    /// The end of the mesh at a side of the hull, or at the line of all vertices.
    Beyond([VertexId; 2]),
}

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    fn about(&self, vertex: VertexId, from: Slot) -> About {
        let star = self.star(self.spoke(vertex, from));
        let on_hull = star.last().is_some_and(|spoke| spoke.end == GHOST);
        let near = star.first().map(|spoke| spoke.slot);
        let ends = star.iter().map(|&Spoke { end, .. }| end);
        About { vertices: ends.filter(|&end| end != GHOST).collect(), on_hull, near }
    }

    /// Where a place lies that was located in `home`.
    fn location(&self, place: Place, home: Slot) -> Location {
        if self.cells.is_ghost(home) {
            let ghost = self.nearest_ghost(place, home);
            let [end, start, _] = self.cells.corners(ghost);
            return Location::Outside { edge: [start, end] };
        }
        if let Some(vertex) = self.corner_at(home, place) {
            return Location::At { vertex };
        }
        let corners = self.cells.corners(home);
        let at = corners.map(|corner| self.at(corner));
        let on_side = |&i: &usize| orientation(at[NEXT[i]], at[PREV[i]], place).is_eq();
        match (0..3).find(on_side) {
            Some(i) => {
                let (start, end) = (corners[NEXT[i]], corners[PREV[i]]);
                Location::OnEdge { edge: [start.min(end), start.max(end)] }
            }
            None => Location::Inside { triangle: from_smallest(corners) },
        }
    }

    /// The ghost before which a place lies and whose side of the hull is nearest to it, starting
    /// from one before which it lies. If the nearest is a corner of two such sides: the first of
    /// them, counter-clockwise.
    ///
    /// Seen from the place the sides before which it lies follow one another, and where the
    /// perpendicular falls on the line of one beyond its end, the nearest lies beyond, too.
    fn nearest_ghost(&self, place: Place, from: Slot) -> Slot {
        let ends = |ghost: Slot| {
            let [end, start] = [0, 1].map(|index| self.at(self.cells.corner(ghost, index)));
            (start, end)
        };
        let before = |ghost: Slot| {
            let (start, end) = ends(ghost);
            left_of(end, start, place)
        };
        let mut ghost = from;
        loop {
            // The next ghost lies across the side from the end to infinity.
            let (start, end) = ends(ghost);
            let beyond =
                asphera_geometry::predicates::compare_with_right_angle(end, start, place).is_lt();
            let next = self.cells.across(Side::new(ghost, 1)).slot();
            if !beyond || !before(next) {
                break;
            }
            ghost = next;
        }
        loop {
            let (start, end) = ends(ghost);
            let short =
                asphera_geometry::predicates::compare_with_right_angle(start, end, place).is_le();
            let next = self.cells.across(Side::new(ghost, 0)).slot();
            if !short || !before(next) {
                return ghost;
            }
            ghost = next;
        }
    }
}
