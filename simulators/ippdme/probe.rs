//! A ball that touches a part.

use std::fmt;
use std::sync::Arc;

/// Surface of a part: its height in mm over a place (x, y) in mm; `None` beside it.
#[derive(Clone)]
pub struct Surface(Arc<dyn Fn([f64; 2]) -> Option<f64> + Send + Sync>);

impl Surface {
    /// A surface of a function.
    pub fn new(height_mm: impl Fn([f64; 2]) -> Option<f64> + Send + Sync + 'static) -> Surface {
        Surface(Arc::new(height_mm))
    }

    /// Height in mm over a place; `None` beside the part.
    pub fn height_mm(&self, place_mm: [f64; 2]) -> Option<f64> {
        (self.0)(place_mm)
    }
}

impl fmt::Debug for Surface {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Surface").finish_non_exhaustive()
    }
}

/// A ball over a part.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Surface of the part.
    pub surface: Surface,
    /// Radius of the ball in mm, 0 or more.
    pub radius_mm: f64,
}

impl Probe {
    /// Height in mm of the centre of a ball that rests on the part with its centre over a place; `None` where it finds no part.
    ///
    /// The ball touches where the normal of the surface leads through its centre. Fixed-point iteration finds that place, as long as the
    /// ball is smaller than the part's radii of curvature.
    pub fn centre_mm(&self, [x, y]: [f64; 2]) -> Option<f64> {
        let mut touched = [x, y];
        for _ in 0..ITERATIONS {
            let (_, [nx, ny, _]) = self.met(touched)?;
            let next = [x - self.radius_mm * nx, y - self.radius_mm * ny];
            let moved = (next[0] - touched[0]).hypot(next[1] - touched[1]);
            touched = next;
            if moved < CONVERGED_MM {
                break;
            }
        }
        let (height, [_, _, nz]) = self.met(touched)?;
        Some(height + self.radius_mm * nz)
    }

    /// Height and unit normal at a place.
    fn met(&self, [x, y]: [f64; 2]) -> Option<(f64, [f64; 3])> {
        let height = self.surface.height_mm([x, y])?;
        let slope = |dx: f64, dy: f64| {
            // One-sided at the edge of the part.
            let ahead = self.surface.height_mm([x + dx, y + dy]);
            let behind = self.surface.height_mm([x - dx, y - dy]);
            match (ahead, behind) {
                (Some(ahead), Some(behind)) => Some((ahead - behind) / (2.0 * STEP_MM)),
                (Some(ahead), None) => Some((ahead - height) / STEP_MM),
                (None, Some(behind)) => Some((height - behind) / STEP_MM),
                (None, None) => None,
            }
        };
        let (sx, sy) = (slope(STEP_MM, 0.0)?, slope(0.0, STEP_MM)?);
        let length = (1.0 + sx * sx + sy * sy).sqrt();
        Some((height, [-sx / length, -sy / length, 1.0 / length]))
    }
}

const ITERATIONS: usize = 100;
const CONVERGED_MM: f64 = 1e-10;
/// Step of the difference quotients.
const STEP_MM: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;

    /// In a bowl of R 40 mm the centre of a ball of 1 mm lies on a sphere of 39 mm, and on a dome on one of 41 mm.
    #[test]
    fn a_ball_on_a_sphere_shows_a_sphere_of_another_radius() {
        let sphere = |radius: f64, sign: f64| {
            Surface::new(move |[x, y]| {
                let square = radius * radius - x * x - y * y;
                (square > 0.0).then(|| sign * (radius - square.sqrt()))
            })
        };
        for (sign, centres) in [(1.0, 39.0), (-1.0, 41.0)] {
            let probe = Probe { surface: sphere(40.0, sign), radius_mm: 1.0 };
            for place in [[0.0, 0.0], [10.0, 0.0], [-12.0, 15.0], [3.0, -20.0]] {
                let centre = probe.centre_mm(place).expect("on the part");
                let [x, y]: [f64; 2] = place;
                // From the centre of the sphere at z = sign · 40.
                let found = (x * x + y * y + (centre - sign * 40.0).powi(2)).sqrt();
                assert!((found - centres).abs() < 1e-7, "{place:?}: {found}");
            }
        }
    }

    #[test]
    fn a_slope_lifts_the_centre_by_the_radius_along_its_normal() {
        let probe = Probe { surface: Surface::new(|[x, _]| Some(0.75 * x)), radius_mm: 2.0 };
        // The normal has the slope 3 : 4 : 5, so that the centre lies 2 / (4/5) above the surface.
        assert!((probe.centre_mm([1.0, 5.0]).unwrap() - (0.75 + 2.5)).abs() < 1e-9);
        let part = Surface::new(|[x, y]| (x.hypot(y) < 1.0).then_some(0.0));
        assert_eq!(Probe { surface: part, radius_mm: 0.5 }.centre_mm([2.0, 0.0]), None);
    }
}
