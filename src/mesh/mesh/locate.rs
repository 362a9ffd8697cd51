//! Where a place lies in the mesh, and the vertex nearest to it.

use asphera_geometry::predicates::Place;
use asphera_geometry::{Rejection, VertexId, admit, place};

use super::Mesh;
use crate::Location;

impl Mesh {
    /// Where the place (`x_mm`, `y_mm`) lies. Points that wait to be inserted take no part.
    ///
    /// Coordinates below [`asphera_geometry::TINY_MM`] are taken as zero, as those of points are. Takes a walk
    /// of some triangles from one near by; of a place outside also along the hull, as far as it
    /// lies from where the walk meets it. On a line: logarithmic time.
    ///
    /// ```
    /// use asphera_mesh::{Location, Mesh};
    ///
    /// let mut mesh = Mesh::new();
    /// mesh.insert(&[[0.0, 0.0, 0.1], [1.0, 0.0, 0.2], [0.0, 1.0, 0.3]]);
    /// assert_eq!(mesh.locate(0.25, 0.25), Location::Inside { triangle: [0, 1, 2] });
    /// assert_eq!(mesh.locate(0.5, 0.5), Location::OnEdge { edge: [1, 2] });
    /// assert_eq!(mesh.locate(0.5, -3.0), Location::Outside { edge: [0, 1] });
    /// ```
    pub fn locate(&self, x_mm: f64, y_mm: f64) -> Location {
        match admit_place(x_mm, y_mm) {
            Ok(place) => self.delaunay.locate(&self.points[..], place),
            Err(rejection) => Location::Rejected(rejection),
        }
    }

    /// The vertex nearest to the place (`x_mm`, `y_mm`) in the plane, decided exactly; of several
    /// as near the one with the smallest x, then y. Heights do not matter.
    ///
    /// None in a mesh without vertices, and if the mesh admits no point in the place. Takes as long
    /// as [`Mesh::locate`], and from there some steps from neighbour to neighbour.
    pub fn nearest(&self, x_mm: f64, y_mm: f64) -> Option<VertexId> {
        self.delaunay.nearest(&self.points[..], admit_place(x_mm, y_mm).ok()?)
    }
}

/// The place as a vertex would stand there, or why none would.
pub(super) fn admit_place(x_mm: f64, y_mm: f64) -> Result<Place, Rejection> {
    admit([x_mm, y_mm, 0.0]).map(place)
}
