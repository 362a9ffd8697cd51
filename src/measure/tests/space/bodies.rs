//! Points of bodies whose figures are known in closed form.

use asphera_geometry::{Numbers, PointMm};

const GOLDEN: f64 = 2.399_963_229_728_653;

/// Directions evenly over a sphere: R. Swinbank, R. J. Purser, Q. J. R. Meteorol. Soc. 132 (2006) 1769-1793.
pub(super) fn directions(count: u32) -> impl Iterator<Item = PointMm> {
    (0..count).map(move |index| {
        let z = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(count);
        let (sin, cos) = (f64::from(index) * GOLDEN).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * cos, r * sin, z]
    })
}

pub(super) fn ball(count: u32, radius_mm: f64) -> Vec<PointMm> {
    directions(count).map(|way| way.map(|side| radius_mm * side)).collect()
}

/// The top of a ball, out to a share of its radius.
pub(super) fn cap(count: u32, radius_mm: f64, share: f64) -> Vec<PointMm> {
    (0..count)
        .map(|index| {
            let r = share * radius_mm * (f64::from(index) / f64::from(count)).sqrt();
            let (sin, cos) = (f64::from(index) * GOLDEN).sin_cos();
            [r * cos, r * sin, (radius_mm * radius_mm - r * r).sqrt()]
        })
        .collect()
}

/// Points moved along their direction from the origin by noise of a standard deviation in mm, then shifted.
pub(super) fn noisy(points: Vec<PointMm>, shift_mm: PointMm, sigma_mm: f64) -> Vec<PointMm> {
    let numbers = Numbers::new(7, 1, 0);
    let moved = points.into_iter().enumerate().map(|(at, point)| {
        let length = point.iter().map(|side| side * side).sum::<f64>().sqrt();
        let by = 1.0 + sigma_mm * numbers.normal(at) / length;
        std::array::from_fn(|axis| shift_mm[axis] + by * point[axis])
    });
    moved.collect()
}

/// The wall of a tube about z, as a spiral of even density.
pub(super) fn tube(count: u32, radius_mm: f64, length_mm: f64) -> Vec<PointMm> {
    (0..count)
        .map(|index| {
            let (sin, cos) = (f64::from(index) * GOLDEN).sin_cos();
            [radius_mm * cos, radius_mm * sin, length_mm * f64::from(index) / f64::from(count)]
        })
        .collect()
}

/// A torus about z of even density: shares of the roots of two and three, the angle of the tube by its area.
pub(super) fn torus(count: u32, ring_mm: f64, tube_mm: f64) -> Vec<PointMm> {
    let tau = std::f64::consts::TAU;
    (0..count)
        .map(|index| {
            let [u, v] = [2.0_f64, 3.0].map(|root| (f64::from(index) * root.sqrt()).fract());
            // The area up to an angle t grows as R·t + r·sin t.
            let mut t = tau * v;
            for _ in 0..30 {
                let over = ring_mm * t + tube_mm * t.sin() - tau * ring_mm * v;
                t -= over / (ring_mm + tube_mm * t.cos());
            }
            let ((sin_u, cos_u), (sin_t, cos_t)) = ((tau * u).sin_cos(), t.sin_cos());
            let from_axis = ring_mm + tube_mm * cos_t;
            [from_axis * cos_u, from_axis * sin_u, tube_mm * sin_t]
        })
        .collect()
}

/// A turn about an axis, after Rodrigues.
pub(super) struct Turn {
    axis: PointMm,
    sin: f64,
    cos: f64,
}

impl Turn {
    pub(super) fn about(axis: PointMm, angle_rad: f64) -> Turn {
        let length = axis.iter().map(|side| side * side).sum::<f64>().sqrt();
        let (sin, cos) = angle_rad.sin_cos();
        Turn { axis: axis.map(|side| side / length), sin, cos }
    }

    pub(super) fn moved(&self, at: PointMm, shift: PointMm) -> PointMm {
        let [x, y, z] = self.axis;
        let cross = [y * at[2] - z * at[1], z * at[0] - x * at[2], x * at[1] - y * at[0]];
        let along = x * at[0] + y * at[1] + z * at[2];
        std::array::from_fn(|side| {
            self.cos * at[side]
                + self.sin * cross[side]
                + (1.0 - self.cos) * along * self.axis[side]
                + shift[side]
        })
    }
}
