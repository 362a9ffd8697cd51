//! The signed orthogonal distance and its derivatives for one pose and nominal.
//!
//! With x(s) the meridian, n(s) its unit normal and p the point in the part frame, d = n(s*)·(p − x(s*))
//! at the foot s*. There p − x = d·n. Any derivative through s* vanishes: n·x′ = 0 because n is normal to
//! the surface, and n′·(p − x) = d·n′·n = 0 because n has unit length (the envelope theorem). The same
//! holds for the derivative of n itself. What remains is
//!
//! - shape parameter a: ∂d/∂a = −n·∂x/∂a = −n_z·∂z/∂a at r = s*;
//! - shift: ∂d/∂t_i = −(R·n)_i, because p = Rᵀ·(p_measured − t);
//! - turn about ω (part frame, [`Pose::turn_axes`]): ∂d = −n·(ω × p) = −ω·(p × n). On a rotational nominal p
//!   and n lie in one half plane through the axis, so p × n has no z component: exactly zero, not by rounding.
//!
//! All this holds of a freeform as well, with both coordinates of the place in the part of s. Which motions a
//! freeform does not feel (along and about a cylinder, about the axis of a toroid) is not known beforehand, so
//! derivatives within their rounding are written as 0: a symmetry leaves an empty column, not one of noise.
//!
//! None of these depends on d itself beyond the place of the foot.

use crate::nominal::conic_root;
use crate::nominal::foot::{MeridianFoot, SurfaceFoot};
use crate::nominal::freeform::FreeFoot;
use crate::pose::Motion;
use crate::shape::Shape;
use crate::{Nominal, Parameter, PointMm, Pose};

/// A pose and a nominal with the free parameters, made ready for many points.
#[derive(Clone, Debug)]
pub struct Model<'a> {
    pub(crate) nominal: &'a Nominal,
    pub(crate) motion: Motion,
    turn_axes: [[f64; 3]; 3],
    free: &'a [Parameter],
    /// The shape of a freeform and how many parameters it has, if any of them is free.
    shape: Option<(&'a dyn Shape, usize)>,
}

/// How a part lies and turns at one pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartFrame {
    motion: Motion,
    turn_axes: [[f64; 3]; 3],
}

impl PartFrame {
    pub(crate) fn of(pose: &Pose) -> PartFrame {
        PartFrame { motion: pose.motion(), turn_axes: pose.turn_axes() }
    }
}

impl<'a> Model<'a> {
    /// The rows of a part that lies at `pose`, by the parameters `free`.
    pub fn new(nominal: &'a Nominal, pose: &Pose, free: &'a [Parameter]) -> Model<'a> {
        Model::in_frame(nominal, PartFrame::of(pose), free)
    }

    /// The same for a part whose frame is known, which saves five sines and cosines.
    pub(crate) fn in_frame(
        nominal: &'a Nominal,
        PartFrame { motion, turn_axes }: PartFrame,
        free: &'a [Parameter],
    ) -> Model<'a> {
        let of_shape = free.iter().any(|parameter| matches!(parameter, Parameter::Shape(_)));
        let shape = nominal.freeform().filter(|_| of_shape);
        let shape = shape.map(|shape| (shape.as_ref(), shape.parameters().len()));
        Model { nominal, motion, turn_axes, free, shape }
    }

    /// Columns of a row: one a free parameter, and the distance.
    pub fn columns(&self) -> usize {
        self.free.len() + 1
    }

    pub(crate) fn foot(&self, measured_mm: PointMm) -> Option<SurfaceFoot> {
        self.nominal.surface_foot(self.motion.to_part(measured_mm))
    }

    /// The signed distance; `None` where there is no foot.
    pub fn distance_mm(&self, measured_mm: PointMm) -> Option<f64> {
        self.foot(measured_mm).map(|foot| foot.distance_mm())
    }

    /// Writes ∂d/∂parameter for every free parameter and then d. `None` where there is no foot.
    pub fn row(&self, measured_mm: PointMm, row: &mut [f64]) -> Option<()> {
        let foot = self.foot(measured_mm)?;
        self.derivatives(&foot, row)?;
        row[self.free.len()] = foot.distance_mm();
        Some(())
    }

    /// [`Model::row`], and the unit normal at the foot in the measured frame, which points to +z of the part.
    pub fn row_and_normal(&self, measured_mm: PointMm, row: &mut [f64]) -> Option<[f64; 3]> {
        let foot = self.foot(measured_mm)?;
        self.derivatives(&foot, row)?;
        row[self.free.len()] = foot.distance_mm();
        Some(self.motion.turn_to_measured(foot.normal()))
    }

    /// A point in the part frame, mm.
    pub fn to_part(&self, measured_mm: PointMm) -> PointMm {
        self.motion.to_part(measured_mm)
    }

    /// Writes ∂d/∂parameter for every free parameter; `None` where the shape has no derivatives.
    pub(crate) fn derivatives(&self, foot: &SurfaceFoot, row: &mut [f64]) -> Option<()> {
        match foot {
            SurfaceFoot::Meridian(foot) => self.in_meridian(foot, row),
            SurfaceFoot::Free(foot) => return self.of_freeform(foot, row),
        }
        Some(())
    }

    fn in_meridian(&self, foot: &MeridianFoot, row: &mut [f64]) {
        let normal = self.motion.turn_to_measured(foot.normal());
        let moment = foot.rho_mm * foot.n_z - foot.zeta_mm * foot.n_r;
        let (moment_x, moment_y) = (moment * foot.sin, -moment * foot.cos);
        let turn = |axis: [f64; 3]| -(axis[0] * moment_x + axis[1] * moment_y);
        for (entry, parameter) in row.iter_mut().zip(self.free) {
            *entry = match parameter {
                Parameter::Tx => -normal[0],
                Parameter::Ty => -normal[1],
                Parameter::Tz => -normal[2],
                Parameter::Rx => turn(self.turn_axes[0]),
                Parameter::Ry => turn(self.turn_axes[1]),
                Parameter::Rz => turn(self.turn_axes[2]),
                Parameter::Radius => self.by_radius(foot),
                Parameter::Conic => self.by_conic(foot),
                Parameter::A(order) => -foot.n_z * foot.s_mm.powi(i32::from(*order)),
                Parameter::Shape(_) => 0.0,
            };
        }
    }

    fn of_freeform(&self, foot: &FreeFoot, row: &mut [f64]) -> Option<()> {
        let n = foot.normal;
        let [x, y, z] = foot.part_mm;
        let normal = self.motion.turn_to_measured(n);
        let shift = |axis: usize| above_rounding(-normal[axis], 1.0);
        let moment = [y * n[2] - z * n[1], z * n[0] - x * n[2], x * n[1] - y * n[0]];
        let arm = x.abs() + y.abs() + z.abs();
        let turn = |[a, b, c]: [f64; 3]| {
            above_rounding(-(a * moment[0] + b * moment[1] + c * moment[2]), arm)
        };
        for (entry, parameter) in row.iter_mut().zip(self.free) {
            *entry = match parameter {
                Parameter::Tx => shift(0),
                Parameter::Ty => shift(1),
                Parameter::Tz => shift(2),
                Parameter::Rx => turn(self.turn_axes[0]),
                Parameter::Ry => turn(self.turn_axes[1]),
                Parameter::Rz => turn(self.turn_axes[2]),
                _ => 0.0,
            };
        }
        let Some((shape, count)) = self.shape else { return Some(()) };
        let (mut few, mut many) = ([0.0; FEW], Vec::new());
        let by_parameters = if count <= FEW {
            &mut few[..count]
        } else {
            many.resize(count, 0.0);
            &mut many[..]
        };
        shape.by_parameters(foot.x_mm, foot.y_mm, by_parameters)?;
        for (entry, parameter) in row.iter_mut().zip(self.free) {
            if let Parameter::Shape(index) = parameter {
                *entry = -n[2] * by_parameters.get(usize::from(*index))?;
            }
        }
        Some(())
    }

    /// ∂z/∂c = r²/(φ·(1+φ)) and c = 1/R. For a sphere −n_z·∂z/∂R = 1 − n_z, written without cancellation.
    fn by_radius(&self, foot: &MeridianFoot) -> f64 {
        match self.nominal {
            Nominal::Plane | Nominal::Freeform(_) => 0.0,
            Nominal::Sphere { .. } => foot.n_r * foot.n_r / (1.0 + foot.n_z),
            Nominal::Asphere(asphere) => {
                let c = asphere.radius_mm.recip();
                let phi = conic_root(c, asphere.conic, foot.s_mm);
                let cs = c * foot.s_mm;
                foot.n_z * cs * cs / (phi * (1.0 + phi))
            }
        }
    }

    /// ∂z/∂κ = c³·r⁴/(2·φ·(1+φ)²).
    fn by_conic(&self, foot: &MeridianFoot) -> f64 {
        let Nominal::Asphere(asphere) = self.nominal else { return 0.0 };
        let c = asphere.radius_mm.recip();
        let phi = conic_root(c, asphere.conic, foot.s_mm);
        let cs = c * foot.s_mm;
        -foot.n_z * cs * cs * cs * foot.s_mm / (2.0 * phi * (1.0 + phi) * (1.0 + phi))
    }
}

/// The value, or 0 if a sum of terms of that size cannot be told from it.
fn above_rounding(value: f64, size: f64) -> f64 {
    if value.abs() <= ROUNDING * size { 0.0 } else { value }
}

/// Share of its terms by which rounding of foot, normal and rotation may change a sum.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Parameters of a shape up to which a row needs no memory of its own.
const FEW: usize = 48;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::Asphere;
    use crate::nominal::parameter::moved;

    const EVERY: [Parameter; 17] = [
        Parameter::Tx,
        Parameter::Ty,
        Parameter::Tz,
        Parameter::Rx,
        Parameter::Ry,
        Parameter::Rz,
        Parameter::Radius,
        Parameter::Conic,
        Parameter::A(4),
        Parameter::A(6),
        Parameter::A(8),
        Parameter::A(10),
        Parameter::A(12),
        Parameter::A(14),
        Parameter::A(16),
        Parameter::A(18),
        Parameter::A(20),
    ];

    fn steep() -> Nominal {
        let coefficients = [(4, 3.7e-5), (6, -1.3e-8), (8, -1.4e-10), (10, -2.5e-13)];
        Nominal::Asphere(Asphere::new(11.65, -0.6, &coefficients).expect("a valid asphere"))
    }

    /// Richardson's extrapolation of central differences: error of fourth order in the step.
    fn numerical(f: impl Fn(f64) -> f64, h: f64) -> f64 {
        let central = |h: f64| (f(h) - f(-h)) / (2.0 * h);
        (4.0 * central(0.5 * h) - central(h)) / 3.0
    }

    fn check(nominal: Nominal, pose: Pose, part_mm: PointMm) -> Result<(), TestCaseError> {
        let free: Vec<Parameter> = EVERY.into_iter().filter(|&p| nominal.has(p)).collect();
        let point = pose.to_measured(part_mm);
        let mut row = vec![0.0; free.len() + 1];
        Model::new(&nominal, &pose, &free).row(point, &mut row).expect("a foot");
        for (&parameter, &analytic) in free.iter().zip(&row) {
            // Steps that move the surface at r = 9 mm by some 10 µm.
            let h = match parameter {
                Parameter::A(order) => 1e-2 * 9.0_f64.powi(-i32::from(order)),
                Parameter::Conic => 1e-2,
                _ => 1e-3,
            };
            let distance = |step: f64| {
                let (pose, nominal) =
                    moved([(parameter, step)], &pose, &nominal).expect("a pose and a nominal");
                Model::new(&nominal, &pose, &[]).distance_mm(point).expect("a foot")
            };
            let found = numerical(distance, h);
            let size = analytic.abs().max(1e-2 / h * 1e-3);
            prop_assert!(
                (found - analytic).abs() <= 2e-9 * size.max(1.0),
                "{nominal} {parameter}: analytic {analytic:e}, numerical {found:e}"
            );
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn jacobian_agrees_with_numerical_derivatives(
            place in prop::array::uniform2(-6.0..6.0f64),
            d in -0.1..0.1f64,
            t in prop::array::uniform3(-20.0..20.0f64),
            r in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let pose = Pose {
                tx_mm: t[0], ty_mm: t[1], tz_mm: t[2], rx_rad: r[0], ry_rad: r[1], rz_rad: r[2],
            };
            let nominals = [
                Nominal::Plane,
                Nominal::Sphere { radius_mm: 14.0 },
                Nominal::Sphere { radius_mm: -14.0 },
                steep(),
            ];
            for nominal in nominals {
                let z = nominal.sag_mm(place[0].hypot(place[1])) + d;
                check(nominal, pose, [place[0], place[1], z])?;
            }
        }
    }

    /// −R²·∂d/∂R against differences in the curvature, which are well scaled where those in the radius are nothing.
    #[test]
    fn derivatives_by_a_radius_are_those_by_its_curvature() {
        for radius_mm in [10.0, -100.0, 1e4, -1e5, 1e7] {
            for conic in [None, Some(-1.0), Some(0.7)] {
                let with = |c: f64| match conic {
                    None => Nominal::Sphere { radius_mm: c.recip() },
                    Some(conic) => {
                        Nominal::Asphere(Asphere::new(c.recip(), conic, &[]).expect("an asphere"))
                    }
                };
                let nominal = with(1.0 / radius_mm);
                let pose = Pose { tx_mm: 0.2, rx_rad: 1e-3, ..Pose::default() };
                for r in [0.5, 2.0, 4.0] {
                    let point = pose.to_measured([r, 0.1, nominal.sag_mm(r) + 1e-3]);
                    let mut row = [0.0; 2];
                    Model::new(&nominal, &pose, &[Parameter::Radius]).row(point, &mut row);
                    let distance = |step: f64| {
                        let nominal = with(1.0 / radius_mm + step);
                        Model::new(&nominal, &pose, &[]).distance_mm(point).expect("a foot")
                    };
                    let found = numerical(distance, 1e-3);
                    let analytic = -radius_mm * radius_mm * row[0];
                    assert!(
                        (found / analytic - 1.0).abs() < 1e-7,
                        "{nominal} at {r}: {found:e}, {analytic:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn turn_about_the_axis_has_exactly_no_influence() {
        let nominal = steep();
        let model = Model::new(&nominal, &Pose::default(), &[Parameter::Rz]);
        for i in 0..100 {
            let x = 0.08 * f64::from(i);
            let mut row = [1.0; 2];
            model.row([x, 0.3 * x - 1.0, 0.05 * x * x], &mut row).expect("a foot");
            assert_eq!(row[0], 0.0);
        }
    }
}
