//! Along which directions a surface is the same when it is shifted.

use crate::Nominal;
use crate::fit::symmetry::disc;

impl Nominal {
    /// Whether a shift along x, and along y, of the part frame leaves the surface where it is: both for a plane, the
    /// one along its axis for a cylinder. Along such a direction the surface has no origin of its own.
    ///
    /// A freeform slides where it has no slope at any of the places looked at and no end.
    pub fn slides(&self) -> [bool; 2] {
        let shape = match self {
            Nominal::Plane => return [true; 2],
            Nominal::Sphere { .. } | Nominal::Asphere(_) => return [false; 2],
            Nominal::Freeform(shape) => shape,
        };
        let radius_mm = (WITHIN * shape.domain_mm()).min(LARGEST_MM);
        let mut steepest = [0.0_f64; 2];
        for [x_mm, y_mm] in disc(radius_mm, PLACES) {
            let Some(jet) = shape.jet(x_mm, y_mm) else { return [false; 2] };
            for (steepest, slope) in steepest.iter_mut().zip(jet.gradient) {
                *steepest = steepest.max(slope.abs());
            }
        }
        [0, 1].map(|axis| {
            let flat = steepest[axis] <= FLAT * (1.0 + steepest[1 - axis]);
            let endless = [-FAR_MM, FAR_MM].into_iter().all(|far_mm| {
                let at_mm = if axis == 0 { [far_mm, 0.0] } else { [0.0, far_mm] };
                shape.sag_mm(at_mm[0], at_mm[1]).is_some()
            });
            flat && endless
        })
    }
}

/// Places looked at.
const PLACES: usize = 64;
/// The border of the domain is left out.
const WITHIN: f64 = 0.9;
/// Places of an endless surface lie within this distance.
const LARGEST_MM: f64 = 10.0;
/// A smaller slope is rounding.
const FLAT: f64 = 1e-14;
/// A surface that reaches as far has no end.
const FAR_MM: f64 = 1e5;

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::shape::{Conic, ConicSection, Cylinder, OffAxis, Shape, Toroid};

    fn of(shape: impl Shape + 'static) -> [bool; 2] {
        Nominal::Freeform(Arc::new(shape)).slides()
    }

    #[test]
    fn planes_slide_everywhere_cylinders_along_their_axis_and_the_others_nowhere() {
        assert_eq!(Nominal::Plane.slides(), [true; 2]);
        assert_eq!(of(Conic::plane()), [true; 2]);
        assert_eq!(Nominal::Sphere { radius_mm: 1e7 }.slides(), [false; 2]);
        assert_eq!(of(Conic::sphere(-50.0).unwrap()), [false; 2]);
        let cylinder = Cylinder::new(15.0).unwrap();
        let piece = OffAxis::parallel(Arc::new(cylinder.clone()), 4.0, 3.0).unwrap();
        assert_eq!((of(cylinder), of(piece)), ([false, true], [false, true]));
        let along_x = ConicSection::new(40.0, -0.5).unwrap();
        assert_eq!(of(Toroid::unrotated(along_x, &[]).unwrap()), [true, false]);
    }
}
