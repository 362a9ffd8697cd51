//! The foot of a point on a freeform: the nearest place of a graph z(x, y).
//!
//! The foot makes half the squared distance f(u, v) = ½·[(u−x)² + (v−y)² + (z(u,v)−ζ)²] stationary. With
//! a = z − ζ its gradient is (u−x, v−y) + a·∇z, and its Hessian is 1 + ∇z·∇zᵀ + a·∇²z. Newton's method starts
//! straight below or above the point. Where the Hessian is not positive definite, or its step does not make
//! f smaller, the last term is left out (the rest is positive definite always), and steps are halved until
//! f falls and the place lies in the domain.
//!
//! The distance d = n·(p − foot) depends on the foot only to second order, because its first derivative
//! along the surface is the gradient above, which is 0 at the foot.

use crate::PointMm;
use crate::shape::{Jet, Shape};

/// A point of the part frame and its foot on a freeform.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeFoot {
    /// The point.
    pub(crate) part_mm: PointMm,
    /// The place of the foot.
    pub(crate) x_mm: f64,
    pub(crate) y_mm: f64,
    /// Unit normal at the foot, z positive.
    pub(crate) normal: [f64; 3],
    pub(crate) distance_mm: f64,
}

/// The foot of a point of the part frame. `None` where it would lie beyond the domain, where there is none,
/// and for points that are not finite.
pub(crate) fn foot(shape: &dyn Shape, part_mm: PointMm) -> Option<FreeFoot> {
    if !part_mm.iter().all(|coordinate| coordinate.is_finite()) {
        return None;
    }
    let mut here = start(shape, part_mm)?;
    let mut trials = MAX_TRIALS;
    while trials > 0 {
        trials -= 1;
        let tolerance = STEP_TOLERANCE * here.size_mm(part_mm);
        let full = here.newton();
        let length_mm = here.along_mm(full);
        if length_mm <= tolerance {
            return here.foot(part_mm);
        }
        let size_mm = here.size_mm(part_mm);
        let next = match here.moved(shape, part_mm, full, length_mm <= CLOSE * size_mm) {
            Some(next) => next,
            None => here.downhill(shape, part_mm, tolerance, &mut trials)?,
        };
        // Newton's error is squared by a step: below this size the next one is within rounding.
        let last = length_mm <= SQUARED_AWAY * size_mm;
        here = next;
        if last {
            return here.foot(part_mm);
        }
    }
    None
}

/// The foot on the surface itself: the place (x, y).
pub(crate) fn on_surface(shape: &dyn Shape, x_mm: f64, y_mm: f64) -> Option<FreeFoot> {
    let jet = shape.jet(x_mm, y_mm)?;
    let part_mm = [x_mm, y_mm, jet.z_mm];
    Trial::of(x_mm, y_mm, jet, part_mm)?.foot(part_mm)
}

/// Straight below or above the point; for points beside the domain, next to its border on the way inwards.
fn start(shape: &dyn Shape, part_mm: PointMm) -> Option<Trial> {
    let [x, y, _] = part_mm;
    if let Some(jet) = shape.jet(x, y) {
        return Trial::of(x, y, jet, part_mm);
    }
    let inwards = INSIDE_DOMAIN * shape.domain_mm() / x.hypot(y);
    if inwards.is_nan() || inwards >= 1.0 {
        return None;
    }
    let (u, v) = (x * inwards, y * inwards);
    Trial::of(u, v, shape.jet(u, v)?, part_mm)
}

/// A place that may be the foot.
#[derive(Clone, Copy)]
struct Trial {
    u: f64,
    v: f64,
    jet: Jet,
    /// Height of the surface above the point.
    above: f64,
    gradient: [f64; 2],
    /// Half the squared distance to the point.
    half_square: f64,
}

impl Trial {
    fn of(u: f64, v: f64, jet: Jet, [x, y, zeta]: PointMm) -> Option<Trial> {
        let above = jet.z_mm - zeta;
        let (du, dv) = (u - x, v - y);
        let gradient = [du + above * jet.gradient[0], dv + above * jet.gradient[1]];
        let half_square = 0.5 * (du * du + dv * dv + above * above);
        (half_square.is_finite() && gradient.iter().all(|entry| entry.is_finite()))
            .then_some(Trial { u, v, jet, above, gradient, half_square })
    }

    /// Length against which rounding of the coordinates is measured.
    fn size_mm(&self, [x, y, _]: PointMm) -> f64 {
        self.u.abs() + self.v.abs() + x.abs() + y.abs() + self.above.abs()
    }

    /// The step of Newton's method, or of Gauss's where the Hessian is not positive definite.
    fn newton(&self) -> [f64; 2] {
        let [zx, zy] = self.jet.gradient;
        let [zxx, zxy, zyy] = self.jet.hessian_per_mm;
        let a = 1.0 + zx * zx + self.above * zxx;
        let b = zx * zy + self.above * zxy;
        let c = 1.0 + zy * zy + self.above * zyy;
        let determinant = a * c - b * b;
        let [g, h] = self.gradient;
        if a > 0.0 && determinant > LEAST_DETERMINANT * a * c {
            [(b * h - c * g) / determinant, (b * g - a * h) / determinant]
        } else {
            self.gauss()
        }
    }

    /// The step without the curvature of the surface: (1 + ∇z·∇zᵀ)⁻¹ after Sherman and Morrison.
    fn gauss(&self) -> [f64; 2] {
        let [zx, zy] = self.jet.gradient;
        let [g, h] = self.gradient;
        let along = (zx * g + zy * h) / (1.0 + zx * zx + zy * zy);
        [along * zx - g, along * zy - h]
    }

    /// How long a step is on the surface: where that is steep, it is long over a short way in the plane.
    fn along_mm(&self, [du, dv]: [f64; 2]) -> f64 {
        let rise = self.jet.gradient[0] * du + self.jet.gradient[1] * dv;
        (du * du + dv * dv + rise * rise).sqrt()
    }

    /// The place after a step, if it is one and not farther from the point. Close to the foot the distance
    /// only changes by its rounding, and the step is right.
    fn moved(
        &self,
        shape: &dyn Shape,
        part_mm: PointMm,
        step: [f64; 2],
        is_close: bool,
    ) -> Option<Trial> {
        let (u, v) = (self.u + step[0], self.v + step[1]);
        let next = Trial::of(u, v, shape.jet(u, v)?, part_mm)?;
        // Rounding of a coordinate changes the distance by as much.
        let distance_mm = (2.0 * self.half_square).sqrt();
        let slack = DESCENT_SLACK * self.size_mm(part_mm) * distance_mm;
        (is_close || next.half_square <= self.half_square + slack).then_some(next)
    }

    /// The first of ever shorter steps of Gauss that ends nearer to the point. `None` if none does that is
    /// longer than the tolerance, or none of those that may still be tried: then the foot lies beyond the domain.
    fn downhill(
        &self,
        shape: &dyn Shape,
        part_mm: PointMm,
        tolerance: f64,
        trials: &mut usize,
    ) -> Option<Trial> {
        let mut step = self.gauss();
        while self.along_mm(step) > tolerance {
            *trials = trials.checked_sub(1)?;
            if let Some(next) = self.moved(shape, part_mm, step, false) {
                return Some(next);
            }
            step = [0.5 * step[0], 0.5 * step[1]];
        }
        None
    }

    fn foot(&self, part_mm: PointMm) -> Option<FreeFoot> {
        let [zx, zy] = self.jet.gradient;
        let n_z = (1.0 + zx * zx + zy * zy).sqrt().recip();
        let aside = zx * (self.u - part_mm[0]) + zy * (self.v - part_mm[1]);
        let distance_mm = (aside - self.above) * n_z;
        distance_mm.is_finite().then_some(FreeFoot {
            part_mm,
            x_mm: self.u,
            y_mm: self.v,
            normal: [-zx * n_z, -zy * n_z, n_z],
            distance_mm,
        })
    }
}

/// The border itself may have an infinite slope; from here Newton's method finds its way.
const INSIDE_DOMAIN: f64 = 0.95;
/// Relative size of a step that is rounding.
const STEP_TOLERANCE: f64 = 4.0 * f64::EPSILON;
/// Relative size of a step that is not asked whether it leads nearer.
const CLOSE: f64 = 1e-6;
/// Relative size of the last step but the one that rounding swallows.
const SQUARED_AWAY: f64 = 1e-9;
/// Share of the coordinates by which rounding may make the distance grow.
const DESCENT_SLACK: f64 = 16.0 * f64::EPSILON;
/// A Hessian nearer to singular is none to divide by.
const LEAST_DETERMINANT: f64 = 1e-12;
/// Places that are tried for one foot. Newton needs five or six; halved steps along a valley some dozens. Towards the end of a
/// domain, or down a slope of 10²⁰⁰, every step may be halved hundreds of times, for every point and every step of a fit.
const MAX_TRIALS: usize = 400;

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::shape::{ConicSection, Cylinder, EvenAsphere, ShapeError, ShapeParameter};

    /// A shape that counts how often it is asked.
    #[derive(Debug)]
    struct Counted<S> {
        shape: S,
        jets: AtomicUsize,
    }

    impl<S: Shape> Shape for Counted<S> {
        fn kind(&self) -> &'static str {
            self.shape.kind()
        }

        fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
            self.jets.fetch_add(1, Ordering::Relaxed);
            self.shape.jet(x_mm, y_mm)
        }

        fn parameters(&self) -> Vec<ShapeParameter> {
            self.shape.parameters()
        }

        fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
            self.shape.by_parameters(x_mm, y_mm, derivatives)
        }

        fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
            self.shape.with_parameters(values)
        }

        fn domain_mm(&self) -> f64 {
            self.shape.domain_mm()
        }
    }

    /// The foot, and how many places were tried for it.
    fn tried<S: Shape>(shape: S, part_mm: PointMm) -> (Option<FreeFoot>, usize) {
        let counted = Counted { shape, jets: AtomicUsize::new(0) };
        let found = foot(&counted, part_mm);
        (found, counted.jets.into_inner())
    }

    #[test]
    fn a_foot_is_given_up_soon_where_the_surface_ends_far_inside_or_stands_on_end() {
        let (found, few) = tried(Cylinder::new(50.0).unwrap(), [5.0, 3.0, 0.2]);
        assert!(found.is_some() && few < 12, "{few}");
        for radius_mm in [1e-5, 0.1, 1.0] {
            for part_mm in [[5.0, 3.0, 0.3], [4.0, -4.0, -7.0], [-2.0, 0.1, 1e3]] {
                let (_, jets) = tried(Cylinder::new(radius_mm).unwrap(), part_mm);
                assert!(jets <= MAX_TRIALS + 2, "radius {radius_mm} mm, {part_mm:?}: {jets}");
            }
        }
        // 7²⁵⁴ mm high beside a point of half a millimetre.
        let steep = || {
            let base = ConicSection::new(50.0, -1.0).unwrap();
            EvenAsphere::new(base, &[(254, 1.0)]).unwrap()
        };
        for part_mm in [[5.0, 5.0, 0.5], [1.5, 0.0, 0.0], [9.0, -3.0, 1e6]] {
            let (_, jets) = tried(steep(), part_mm);
            assert!(jets <= MAX_TRIALS + 2, "{part_mm:?}: {jets}");
        }
    }
}
