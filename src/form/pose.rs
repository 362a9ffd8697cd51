//! The rigid motion between the part frame and the measured frame.

use std::f64::consts::{PI, TAU};

use crate::PointMm;

/// A rigid motion from the part frame into the measured frame: `p' = Rz·Ry·Rx·p + t`.
///
/// `Rx` turns about x by the right-hand rule, and so on; the turn about x is made first. All six numbers
/// zero (the default) is the identity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Shift along x in mm.
    pub tx_mm: f64,
    /// Shift along y in mm.
    pub ty_mm: f64,
    /// Shift along z in mm.
    pub tz_mm: f64,
    /// Rotation about x in rad.
    pub rx_rad: f64,
    /// Rotation about y in rad.
    pub ry_rad: f64,
    /// Rotation about z in rad.
    pub rz_rad: f64,
}

impl Pose {
    /// Takes a point of the part frame into the measured frame.
    pub fn to_measured(&self, part_mm: PointMm) -> PointMm {
        self.motion().to_measured(part_mm)
    }

    /// Takes a point of the measured frame into the part frame: the inverse of [`Pose::to_measured`] up
    /// to rounding, `Rᵀ·(p' − t)`.
    pub fn to_part(&self, measured_mm: PointMm) -> PointMm {
        self.motion().to_part(measured_mm)
    }

    /// The rotation matrix `Rz·Ry·Rx`, row after row.
    pub fn rotation(&self) -> [[f64; 3]; 3] {
        let (sx, cx) = self.rx_rad.sin_cos();
        let (sy, cy) = self.ry_rad.sin_cos();
        let (sz, cz) = self.rz_rad.sin_cos();
        [
            [cz * cy, cz * sy * sx - sz * cx, cz * sy * cx + sz * sx],
            [sz * cy, sz * sy * sx + cz * cx, sz * sy * cx - cz * sx],
            [-sy, cy * sx, cy * cx],
        ]
    }

    /// The pose with its sines and cosines worked out, for many points.
    pub fn motion(&self) -> Motion {
        Motion { rotation: self.rotation(), shift_mm: [self.tx_mm, self.ty_mm, self.tz_mm] }
    }

    /// Axes of the three turns in the part frame: a small change of `rx`, `ry` or `rz` multiplies the
    /// rotation matrix from the right by a turn about `e_x`, `Rxᵀ·e_y` or `(Ry·Rx)ᵀ·e_z`.
    pub(crate) fn turn_axes(&self) -> [[f64; 3]; 3] {
        let (sx, cx) = self.rx_rad.sin_cos();
        let (sy, cy) = self.ry_rad.sin_cos();
        [[1.0, 0.0, 0.0], [0.0, cx, -sx], [-sy, cy * sx, cy * cx]]
    }

    /// This motion with every angle within half a turn either way; angles that are stay as they are.
    pub(crate) fn within_half_turns(self) -> Pose {
        let [rx_rad, ry_rad, rz_rad] =
            [self.rx_rad, self.ry_rad, self.rz_rad].map(within_half_turn);
        Pose { rx_rad, ry_rad, rz_rad, ..self }
    }

    /// Whether all six numbers are finite.
    pub fn is_finite(&self) -> bool {
        [self.tx_mm, self.ty_mm, self.tz_mm, self.rx_rad, self.ry_rad, self.rz_rad]
            .iter()
            .all(|value| value.is_finite())
    }
}

/// The angle itself, or less or more whole turns, between −π and π.
pub(crate) fn within_half_turn(rad: f64) -> f64 {
    if rad.abs() <= PI { rad } else { (rad + PI).rem_euclid(TAU) - PI }
}

/// A [`Pose`] as matrix and shift: for many points, as the rotation is made once.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    pub(crate) rotation: [[f64; 3]; 3],
    pub(crate) shift_mm: [f64; 3],
}

impl Motion {
    /// A point of the part in the measured frame, mm.
    pub fn to_measured(self, part_mm: PointMm) -> PointMm {
        let turned = self.turn_to_measured(part_mm);
        std::array::from_fn(|i| turned[i] + self.shift_mm[i])
    }

    /// A direction of the part in the measured frame.
    pub fn turn_to_measured(self, direction: [f64; 3]) -> [f64; 3] {
        self.rotation
            .map(|row| row[0] * direction[0] + row[1] * direction[1] + row[2] * direction[2])
    }

    /// A measured point in the part frame, mm.
    pub fn to_part(self, measured_mm: PointMm) -> PointMm {
        let from_vertex: [f64; 3] = std::array::from_fn(|i| measured_mm[i] - self.shift_mm[i]);
        self.turn_to_part(from_vertex)
    }

    /// A measured direction in the part frame.
    pub fn turn_to_part(self, direction: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.rotation;
        std::array::from_fn(|i| a[i] * direction[0] + b[i] * direction[1] + c[i] * direction[2])
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use proptest::prelude::*;

    use super::*;

    #[test]
    fn quarter_turns_are_made_about_x_first_then_y_then_z() {
        let pose = |rx_rad, ry_rad, rz_rad| Pose { rx_rad, ry_rad, rz_rad, ..Pose::default() };
        let near = |a: PointMm, b: PointMm| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15);
        assert!(near(pose(FRAC_PI_2, 0.0, 0.0).to_measured([0., 1., 0.]), [0., 0., 1.]));
        assert!(near(pose(0.0, FRAC_PI_2, 0.0).to_measured([0., 0., 1.]), [1., 0., 0.]));
        assert!(near(pose(0.0, 0.0, FRAC_PI_2).to_measured([1., 0., 0.]), [0., 1., 0.]));
        // y goes to z by rx, z to x by ry, x to y by rz: back where it began.
        let all = pose(FRAC_PI_2, FRAC_PI_2, FRAC_PI_2);
        assert!(near(all.to_measured([0., 1., 0.]), [0., 1., 0.]));
    }

    #[test]
    fn angles_beyond_half_a_turn_come_back_as_the_same_motion() {
        let pose = Pose { rx_rad: 3.5, ry_rad: -7.0, rz_rad: 0.1, ..Pose::default() };
        let within = pose.within_half_turns();
        assert_eq!((within.rz_rad, within.rx_rad), (0.1, 3.5 - TAU));
        assert!((within.ry_rad + 7.0 - TAU).abs() < 1e-15);
        let (a, b) = (pose.to_measured([1., 2., 3.]), within.to_measured([1., 2., 3.]));
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-14));
        assert_eq!(within_half_turn(PI), PI);
    }

    proptest! {
        #[test]
        fn part_frame_and_back_is_the_identity(
            t in prop::array::uniform3(-1e3..1e3f64),
            r in prop::array::uniform3(-3.2..3.2f64),
            p in prop::array::uniform3(-1e3..1e3f64),
        ) {
            let pose = Pose {
                tx_mm: t[0], ty_mm: t[1], tz_mm: t[2], rx_rad: r[0], ry_rad: r[1], rz_rad: r[2],
            };
            let back = pose.to_part(pose.to_measured(p));
            for i in 0..3 {
                prop_assert!((back[i] - p[i]).abs() < 3e-12, "{back:?} {p:?}");
            }
        }

        #[test]
        fn turn_axes_are_the_derivatives_of_the_rotation(
            r in prop::array::uniform3(-3.2..3.2f64),
            p in prop::array::uniform3(-1.0..1.0f64),
        ) {
            let pose = |r: [f64; 3]| Pose {
                rx_rad: r[0], ry_rad: r[1], rz_rad: r[2], ..Pose::default()
            };
            let h = 1e-5;
            for (i, axis) in pose(r).turn_axes().into_iter().enumerate() {
                let (mut up, mut down) = (r, r);
                up[i] += h;
                down[i] -= h;
                let cross = [
                    axis[1] * p[2] - axis[2] * p[1],
                    axis[2] * p[0] - axis[0] * p[2],
                    axis[0] * p[1] - axis[1] * p[0],
                ];
                let analytic = pose(r).to_measured(cross);
                let (up, down) = (pose(up).to_measured(p), pose(down).to_measured(p));
                for k in 0..3 {
                    prop_assert!((analytic[k] - (up[k] - down[k]) / (2.0 * h)).abs() < 1e-9);
                }
            }
        }
    }
}
