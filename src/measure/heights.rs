//! How well the heights of points are known, found by their places.

use std::collections::HashMap;

use asphera_geometry::PointMm;
use asphera_surface::Plane;

/// Standard uncertainties of the heights of points, where they carry some.
#[derive(Debug, Default)]
pub(super) struct Heights {
    /// Places in the measured frame, and the uncertainty of z there, mm.
    given: Vec<(PointMm, f64)>,
    /// By places in the frame of the plane: the first of them, as many as `found` tells.
    known: HashMap<[u64; 3], f64>,
    found: usize,
    plane: Option<Plane>,
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
    pub(super) fn extend(&mut self, of: impl IntoIterator<Item = (PointMm, f64)>) {
        self.given.extend(of);
    }

    /// Uncertainty of a point in the frame of `plane`; `None` if nothing was said of it. A place measured more than once has the
    /// uncertainty of its first measurement, which is the vertex. Amortised `O(1)` as long as the plane stays.
    pub(super) fn of(&mut self, point: PointMm, plane: &Plane) -> Option<Height> {
        if self.given.is_empty() {
            return None;
        }
        if self.plane != Some(*plane) {
            (self.plane, self.found) = (Some(*plane), 0);
            self.known.clear();
        }
        if self.found < self.given.len() {
            self.known.reserve(self.given.len() - self.found);
            for (place, u_mm) in &self.given[self.found..] {
                self.known.entry(key(plane.to_plane(*place))).or_insert(*u_mm);
            }
            self.found = self.given.len();
        }
        self.known.get(&key(point)).map(|&u_mm| Height { u_mm, up: up(plane) })
    }

    /// Uncertainty of every point in the frame of `plane`, mm; `None` if nothing was said of one.
    pub(super) fn of_all(&mut self, points: &[PointMm], plane: &Plane) -> Option<Vec<f64>> {
        points.iter().map(|&point| Some(self.of(point, plane)?.u_mm)).collect()
    }
}

/// z of the measured frame in that of the plane.
pub(super) fn up(plane: &Plane) -> [f64; 3] {
    plane.axes().map(|axis| axis[2])
}

/// The bits of a place, with one zero only.
fn key(point: PointMm) -> [u64; 3] {
    point.map(|coordinate| (coordinate + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_measurement_of_a_place_counts_whatever_the_plane() {
        let mut heights = Heights::default();
        let place = [1.0, 0.0, 3.0];
        assert!(heights.of(place, &Plane::XY).is_none());
        heights.extend([(place, 1e-5), ([1.0, -0.0, 3.0], 2e-5)]);
        assert_eq!(heights.of([1.0, -0.0, 3.0], &Plane::XY).unwrap().u_mm, 1e-5);
        let turned = Plane::new([0.0; 3], [0.6, 0.0, 0.8]).unwrap();
        let found = heights.of(turned.to_plane(place), &turned).unwrap();
        assert!((found.u_mm, found.up[2]) == (1e-5, turned.normal()[2]));
        heights.extend([([4.0; 3], 3e-5)]);
        let both = [turned.to_plane([4.0; 3]), turned.to_plane(place)];
        assert_eq!(heights.of_all(&both, &turned), Some(vec![3e-5, 1e-5]));
        assert_eq!(heights.of_all(&[place, [5.0; 3]], &Plane::XY), None);
    }
}
