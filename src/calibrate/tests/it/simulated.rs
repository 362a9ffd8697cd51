//! Machines with errors that measure artefacts, written down from how such machines work: nothing of the crate is used
//! but its types.

use std::f64::consts::TAU;

use asphera_calibrate::{Axes, Parameter, Pose};
use asphera_geometry::Numbers;

/// Errors of a machine: values of parameters, 0 where they are not named.
#[derive(Clone, Debug, Default)]
pub(crate) struct Errors(pub(crate) Vec<(Parameter, f64)>);

impl Errors {
    fn of(&self, parameter: Parameter) -> f64 {
        self.0.iter().find(|(named, _)| *named == parameter).map_or(0.0, |(_, value)| *value)
    }

    /// Where the probe truly is when the axes of a machine with linear axes read x, y, z.
    fn true_cartesian(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        [
            x * (1.0 + self.of(Parameter::ScaleX))
                + y * self.of(Parameter::Squareness)
                + z * self.of(Parameter::TiltX),
            y * (1.0 + self.of(Parameter::ScaleY)) + z * self.of(Parameter::TiltY),
            z * (1.0 + self.of(Parameter::ScaleZ)),
        ]
    }

    /// The same of a machine with a turning part: the probe stands beside the axis of rotation by the offsets, and the
    /// part has turned under it.
    fn true_polar(&self, angle: f64, radius: f64, z: f64) -> [f64; 3] {
        let along = radius * (1.0 + self.of(Parameter::ScaleRadial))
            + self.of(Parameter::OffsetRadial)
            + z * self.of(Parameter::TiltRadial);
        let across = self.of(Parameter::OffsetTangential) + z * self.of(Parameter::TiltTangential);
        let (sin, cos) = angle.sin_cos();
        [
            along * cos - across * sin,
            along * sin + across * cos,
            z * (1.0 + self.of(Parameter::ScaleZ)),
        ]
    }

    /// Where the probe truly is.
    pub(crate) fn true_place(&self, axes: Axes) -> [f64; 3] {
        match axes {
            Axes::Cartesian(place) => self.true_cartesian(place),
            Axes::Polar { angle_rad, radius_mm, z_mm } => {
                self.true_polar(angle_rad, radius_mm, z_mm)
            }
            Axes::Turned { .. } => unreachable!("no simulated machine has such axes"),
        }
    }
}

/// A sphere, or a flat of no curvature, with a form error.
#[derive(Clone, Copy)]
pub(crate) struct Part {
    pub(crate) centre: [f64; 3],
    /// mm; negative for the inside of a sphere.
    pub(crate) radius: f64,
    /// Form error along the normal at a place of the artefact, mm.
    pub(crate) form: fn([f64; 2]) -> f64,
    /// Turn about z through its centre, rad.
    pub(crate) turn: f64,
}

pub(crate) fn perfect(_: [f64; 2]) -> f64 {
    0.0
}

impl Part {
    pub(crate) fn ball(centre: [f64; 3], radius: f64) -> Part {
        Part { centre, radius, form: perfect, turn: 0.0 }
    }

    /// How far above the surface a place is, along the normal.
    fn distance(&self, place: [f64; 3]) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|axis| place[axis] - self.centre[axis]);
        let far = (x * x + y * y + z * z).sqrt();
        let (sin, cos) = self.turn.sin_cos();
        // What lies at (u, v) of the artefact has been carried to u·e + v·f by its turn.
        let on_artefact = [x * cos + y * sin, -x * sin + y * cos];
        self.radius.signum() * (far - self.radius.abs()) - (self.form)(on_artefact)
    }

    /// Reading of z with which the probe of the machine touches the surface.
    fn touched(&self, errors: &Errors, axes_at: impl Fn(f64) -> Axes) -> Axes {
        let mut z = self.centre[2] + self.radius;
        for _ in 0..200 {
            let off = self.distance(errors.true_place(axes_at(z)));
            z -= off;
            if off.abs() < 1e-14 {
                break;
            }
        }
        axes_at(z)
    }
}

/// A spiral of a machine with a turning part, from the rim to the centre; noise of the probe in mm.
pub(crate) fn spiral(
    errors: &Errors,
    part: Part,
    reach: f64,
    count: usize,
    noise: (f64, u64),
) -> Pose {
    let numbers = Numbers::new(noise.1, 0, 0);
    let axes = (0..count).map(|index| {
        let share = (index as f64 + 0.5) / count as f64;
        let radius_mm = reach * (1.0 - share).sqrt();
        // Turns of equal width, so that the points are even.
        let angle_rad = TAU * (30.0 * (1.0 - share).sqrt()).fract();
        let touched = part.touched(errors, |z_mm| Axes::Polar { angle_rad, radius_mm, z_mm });
        let Axes::Polar { z_mm, .. } = touched else { return touched };
        let z_mm = z_mm + noise.0 * numbers.normal(index);
        Axes::Polar { angle_rad, radius_mm, z_mm }
    });
    Pose { axes: axes.collect(), turn_rad: part.turn, shift_mm: [0.0; 2] }
}

/// A raster of a machine with linear axes over a disc about the part.
pub(crate) fn raster(
    errors: &Errors,
    part: Part,
    reach: f64,
    lines: i32,
    noise: (f64, u64),
) -> Pose {
    let numbers = Numbers::new(noise.1, 1, 0);
    let mut axes = Vec::new();
    for row in -lines..=lines {
        for step in -lines..=lines {
            let at = |index: i32| reach * f64::from(index) / f64::from(lines);
            let [x, y] = [at(if row % 2 == 0 { step } else { -step }), at(row)];
            if x * x + y * y > reach * reach {
                continue;
            }
            let [x, y] = [x + part.centre[0], y + part.centre[1]];
            let touched = part.touched(errors, |z| Axes::Cartesian([x, y, z]));
            let Axes::Cartesian([x, y, z]) = touched else { continue };
            let z = z + noise.0 * numbers.normal(axes.len());
            axes.push(Axes::Cartesian([x, y, z]));
        }
    }
    Pose { axes, turn_rad: part.turn, shift_mm: [part.centre[0], part.centre[1]] }
}
