//! Places of the plane of projection, as reports write them: in the measured frame, with their height.

use std::fmt;

use asphera_form::{Nominal, Pose};
use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_surface::Plane;

/// Gives places of the plane their height.
#[derive(Clone)]
pub(super) struct Lifted<'a> {
    plane: Plane,
    heights: Heights<'a>,
}

/// Where heights come from.
#[derive(Clone)]
enum Heights<'a> {
    /// A nominal as it lies.
    Nominal(Nominal, Pose),
    /// The mesh; outside it, its nearest point.
    Mesh(&'a Mesh),
}

impl<'a> Lifted<'a> {
    /// Onto a nominal that lies at `pose` in the frame of the plane.
    pub(super) fn onto_nominal(plane: Plane, nominal: &Nominal, pose: &Pose) -> Lifted<'static> {
        Lifted { plane, heights: Heights::Nominal(nominal.clone(), *pose) }
    }

    /// Onto a mesh in the frame of the plane.
    pub(super) fn onto_mesh(plane: Plane, mesh: &'a Mesh) -> Lifted<'a> {
        Lifted { plane, heights: Heights::Mesh(mesh) }
    }

    /// A place u, v in the measured frame.
    pub(super) fn at(&self, [u, v]: [f64; 2]) -> PointMm {
        self.plane.from_plane([u, v, self.height_mm([u, v])])
    }

    /// The height over a place u, v, in the frame of the plane.
    pub(super) fn height_mm(&self, [u, v]: [f64; 2]) -> f64 {
        match &self.heights {
            Heights::Nominal(nominal, pose) => height_in_plane_mm(nominal, pose, [u, v]),
            Heights::Mesh(mesh) => mesh
                .interpolate_linear(u, v)
                .or_else(|| Some(mesh.points()[mesh.nearest(u, v)? as usize][2]))
                .unwrap_or(0.0),
        }
    }
}

impl fmt::Debug for Lifted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let onto = match self.heights {
            Heights::Nominal(..) => "a nominal",
            Heights::Mesh(_) => "a mesh",
        };
        write!(f, "places of {:?} onto {onto}", self.plane)
    }
}

/// The height over a place of the plane at which the nominal is met, along the plane's normal.
///
/// The tangent plane at the place of the part under the last guess gives the next one.
fn height_in_plane_mm(nominal: &Nominal, pose: &Pose, [u, v]: [f64; 2]) -> f64 {
    let turned = pose.rotation();
    let mut w = pose.tz_mm;
    for _ in 0..STEPS {
        let [x, y, z] = pose.to_part([u, v, w]);
        let above_mm = z - super::height_mm(nominal, [x, y]);
        let [gx, gy] = match nominal.gradient(x, y) {
            found if found.iter().all(|slope| slope.is_finite()) => found,
            _ => [0.0; 2],
        };
        // How fast the height above the nominal grows along the normal of the plane.
        let rate = turned[2][2] - gx * turned[2][0] - gy * turned[2][1];
        let next = w - above_mm / rate;
        if !next.is_finite() {
            break;
        }
        w = next;
        if above_mm.abs() <= ENOUGH_MM {
            break;
        }
    }
    w
}

const STEPS: usize = 20;
const ENOUGH_MM: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_on_the_nominal() {
        let nominal = Nominal::Sphere { radius_mm: 20.0 };
        let pose =
            Pose { tx_mm: 1.0, ty_mm: -2.0, tz_mm: 3.0, rx_rad: 0.3, ry_rad: -0.2, rz_rad: 1.0 };
        let plane = Plane::new([0.0; 3], [0.1, 0.2, 1.0]).unwrap();
        let lifted = Lifted::onto_nominal(plane, &nominal, &pose);
        for place in [[1.0, -2.0], [4.0, 1.0], [-3.0, -6.0]] {
            let found = lifted.at(place);
            let [u, v, _] = plane.to_plane(found);
            assert!((u - place[0]).hypot(v - place[1]) < 1e-12);
            let [x, y, z] = pose.to_part(plane.to_plane(found));
            assert!((z - nominal.sag_mm(x.hypot(y))).abs() < 1e-8, "{found:?}");
        }
    }
}
