//! How well the heights of points are known.

use asphera_mesh::{Mesh, Outcome};
use asphera_surface::Plane;

/// Standard uncertainties of the heights of the points a mesh was given, in their order.
#[derive(Debug, Default)]
pub(super) struct Heights {
    /// mm; NaN where nothing was said.
    u_z_mm: Vec<f64>,
}

/// How well the height of one point is known, and which way that is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Height {
    /// Its standard uncertainty, mm.
    pub(super) u_mm: f64,
    /// z of the measured frame in that of the plane.
    pub(super) up: [f64; 3],
}

impl Heights {
    /// Takes that of the next point.
    pub(super) fn push(&mut self, u_z_mm: Option<f64>) {
        self.u_z_mm.push(u_z_mm.unwrap_or(f64::NAN));
    }

    /// Uncertainty of every vertex, mm; `None` if nothing was said of one. A place measured more than once has the
    /// uncertainty of its first measurement, which is the vertex. `O(n)`.
    pub(super) fn of_vertices(&self, mesh: &Mesh) -> Option<Vec<f64>> {
        let mut found = vec![f64::NAN; mesh.points().len()];
        for (index, &u_z_mm) in self.u_z_mm.iter().enumerate() {
            if let Some(Outcome::Vertex(vertex)) = mesh.outcome(index) {
                found[vertex as usize] = u_z_mm;
            }
        }
        found.iter().all(|u_z_mm| !u_z_mm.is_nan()).then_some(found)
    }
}

/// z of the measured frame in that of the plane.
pub(super) fn up(plane: &Plane) -> [f64; 3] {
    plane.axes().map(|axis| axis[2])
}
