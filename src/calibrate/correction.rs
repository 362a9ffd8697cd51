//! Corrections of measured places.

use std::f64::consts::PI;

use asphera_geometry::vector::{Vector, plus};

use crate::map::HeightMap;
use crate::parameter::{Machine, Parameter};

/// Readings of the axes that make a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Axes {
    /// x, y and z, mm.
    Cartesian([f64; 3]),
    /// Turned part, radial axis, probe.
    Polar {
        /// Angle, rad, counter-clockwise seen from +z.
        angle_rad: f64,
        /// Radius, mm; negative where the axis has passed the centre.
        radius_mm: f64,
        /// Height, mm.
        z_mm: f64,
    },
    /// Turned part under a probe whose place beside the plane of the radial axis counts too.
    Turned {
        /// Angle, rad, counter-clockwise seen from +z.
        angle_rad: f64,
        /// Place before the turn, mm: along the radial axis, in the sense of growing angles, and in height.
        place_mm: [f64; 3],
    },
}

impl Axes {
    /// The axes of a point in space. Of a polar machine they are those before the centre, with a radius of 0 or more.
    pub fn of_point(machine: Machine, point_mm: [f64; 3]) -> Axes {
        match machine {
            Machine::Cartesian => Axes::Cartesian(point_mm),
            Machine::Polar => {
                let [x, y, z_mm] = point_mm;
                Axes::Polar { angle_rad: y.atan2(x), radius_mm: x.hypot(y), z_mm }
            }
        }
    }

    /// The same where a polar machine measured the point beyond the centre: with a radius of 0 or less, half a turn further.
    pub fn of_point_beyond(machine: Machine, point_mm: [f64; 3]) -> Axes {
        match Axes::of_point(machine, point_mm) {
            Axes::Polar { angle_rad, radius_mm, z_mm } => {
                Axes::Polar { angle_rad: angle_rad + PI, radius_mm: -radius_mm, z_mm }
            }
            other => other,
        }
    }

    /// The place without correction, mm.
    pub fn place_mm(self) -> [f64; 3] {
        self.place().0
    }

    /// The place without correction, mm, and the direction of the radial axis.
    pub(crate) fn place(self) -> (Vector, [f64; 2]) {
        match self {
            Axes::Cartesian(place_mm) => (place_mm, [1.0, 0.0]),
            Axes::Polar { angle_rad, radius_mm, z_mm } => {
                let (sin, cos) = angle_rad.sin_cos();
                ([radius_mm * cos, radius_mm * sin, z_mm], [cos, sin])
            }
            Axes::Turned { angle_rad, place_mm: [x, y, z] } => {
                let (sin, cos) = angle_rad.sin_cos();
                ([x * cos - y * sin, x * sin + y * cos, z], [cos, sin])
            }
        }
    }

    fn machine(self) -> Machine {
        match self {
            Axes::Cartesian(_) => Machine::Cartesian,
            Axes::Polar { .. } | Axes::Turned { .. } => Machine::Polar,
        }
    }
}

/// Errors of a machine that are taken out of its places.
#[derive(Clone, Debug, PartialEq)]
pub struct Correction {
    machine: Machine,
    values: Vec<(Parameter, f64)>,
    map: Option<HeightMap>,
}

impl Correction {
    /// The correction by values of parameters and a map of height errors. `None` where a parameter is not the
    /// machine's or stands twice, or a value is not finite.
    pub fn new(
        machine: Machine,
        mut values: Vec<(Parameter, f64)>,
        map: Option<HeightMap>,
    ) -> Option<Correction> {
        values.sort_by_key(|(parameter, _)| *parameter);
        let is_right = values.iter().all(|(parameter, value)| {
            value.is_finite() && machine.parameters().contains(parameter)
        });
        let is_twice = values.windows(2).any(|pair| pair[0].0 == pair[1].0);
        (is_right && !is_twice).then_some(Correction { machine, values, map })
    }

    /// Kind of machine.
    pub fn machine(&self) -> Machine {
        self.machine
    }

    /// Values of its parameters; the others are 0.
    pub fn values(&self) -> &[(Parameter, f64)] {
        &self.values
    }

    /// Errors of height beside those.
    pub fn map(&self) -> Option<&HeightMap> {
        self.map.as_ref()
    }

    /// The corrected place in mm: all effects are those at the measured place. `None` beyond the map of height
    /// errors, and of axes of another machine. `O(terms)`.
    pub fn apply(&self, axes: Axes) -> Option<[f64; 3]> {
        if axes.machine() != self.machine {
            return None;
        }
        let (place, outward) = axes.place();
        let mut corrected = place;
        for &(parameter, value) in &self.values {
            corrected = plus(corrected, value, parameter.effect(place, outward));
        }
        if let Some(map) = &self.map {
            corrected[2] -= map.height_mm([place[0], place[1]])?;
        }
        Some(corrected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: [f64; 3], expected: [f64; 3]) {
        let off = found.iter().zip(expected).map(|(found, expected)| (found - expected).abs());
        assert!(off.fold(0.0, f64::max) < 1e-15, "{found:?} against {expected:?}");
    }

    #[test]
    fn a_place_is_moved_as_the_parameters_say() {
        let values = vec![(Parameter::TiltY, 2e-3), (Parameter::Squareness, 1e-3)];
        let map = HeightMap::new(10.0, vec![(2, 0, 1e-3)]).expect("a map");
        let correction = Correction::new(Machine::Cartesian, values, Some(map)).expect("right");
        // Z(2,0) of unit RMS is √3·(2r² − 1), at the centre −√3.
        let at_centre = correction.apply(Axes::Cartesian([0.0, 0.0, 5.0])).expect("on the map");
        close(at_centre, [0.0, 0.01, 5.0 + 3f64.sqrt() * 1e-3]);
        let off = correction.apply(Axes::Cartesian([0.0, 10.0, 0.0])).expect("on the map");
        close(off, [0.01, 10.0, -3f64.sqrt() * 1e-3]);
        assert_eq!(correction.apply(Axes::Cartesian([8.0, 8.0, 0.0])), None, "beyond the map");
    }

    #[test]
    fn a_radius_beyond_the_centre_is_moved_along_its_own_axis() {
        let values = vec![(Parameter::OffsetRadial, 0.1), (Parameter::OffsetTangential, 0.2)];
        let correction = Correction::new(Machine::Polar, values, None).expect("right");
        let at = |radius_mm| {
            let axes = Axes::Polar { angle_rad: 0.0, radius_mm, z_mm: 1.0 };
            correction.apply(axes).expect("a place")
        };
        close(at(3.0), [3.1, 0.2, 1.0]);
        close(at(-3.0), [-2.9, 0.2, 1.0]);
        assert_eq!(correction.apply(Axes::Cartesian([0.0; 3])), None, "another machine");
    }

    /// The tangential offset of a calibration and a laser line that passes the axis by as much are one geometry.
    #[test]
    fn a_turned_place_is_the_polar_one_with_a_tangential_offset() {
        let offset = vec![(Parameter::OffsetTangential, 0.2)];
        let correction = Correction::new(Machine::Polar, offset, None).expect("right");
        let none = Correction::new(Machine::Polar, Vec::new(), None).expect("right");
        for angle_rad in [0.0, 0.7, -2.0, 40.0] {
            let polar = Axes::Polar { angle_rad, radius_mm: -3.0, z_mm: 1.0 };
            let turned = Axes::Turned { angle_rad, place_mm: [-3.0, 0.2, 1.0] };
            let expected = correction.apply(polar).expect("a place");
            close(none.apply(turned).expect("a place"), expected);
            close(turned.place_mm(), expected);
        }
        let at = Axes::Turned { angle_rad: 0.0, place_mm: [3.0, 0.0, 1.0] };
        close(correction.apply(at).expect("a place"), [3.0, 0.2, 1.0]);
    }

    #[test]
    fn wrong_values_are_no_correction() {
        let new =
            |machine, values: &[(Parameter, f64)]| Correction::new(machine, values.to_vec(), None);
        assert_eq!(new(Machine::Polar, &[(Parameter::TiltX, 1e-6)]), None);
        assert_eq!(new(Machine::Cartesian, &[(Parameter::TiltX, f64::NAN)]), None);
        let twice = [(Parameter::TiltX, 1e-6), (Parameter::TiltX, 1e-6)];
        assert_eq!(new(Machine::Cartesian, &twice), None);
        assert_eq!(HeightMap::new(1.0, vec![(2, 1, 0.0)]), None);
        assert_eq!(HeightMap::new(0.0, vec![(2, 0, 0.0)]), None);
    }
}
