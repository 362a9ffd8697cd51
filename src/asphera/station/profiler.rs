//! A line scanner on a linear or rotary axis: from a profile to points in the part frame.

use asphera_calibrate::{Axes, Correction};
use asphera_link::{Flags, Profile};

use super::kinematics::{Axis, Point};
use super::synchronizer::Record;

/// A line scanner that an axis moves over the part, or the part under it.
///
/// A point of the profile has u = across(x) and h = height(z), mm. The laser line has the angle s, rad. A linear axis
/// stands at v, mm. A rotary axis stands at θ, rad, and the laser line passes it by c, mm.
///
/// ```text
/// linear           position = [u cos s, v + u sin s, h]
/// turning, radial  position = R(θ) · [u cos s, c + u sin s, h]
/// turning, axial   position = R(θ) · [h, c + u sin s, u cos s]
/// ```
///
/// R(θ) turns about z, counter-clockwise seen from +z.
#[derive(Clone, Debug, PartialEq)]
pub struct Profiler {
    /// Stream of the synchronizer whose readings have the profiles.
    pub stream: usize,
    /// Profile coordinate x to mm along the laser line.
    pub across: Scaling,
    /// Profile coordinate z to mm in height.
    pub height: Scaling,
    /// Axis by which the laser line gets over the part.
    pub carriage: Carriage,
    /// Angle of the laser line, rad: against x, positive towards y; of an axial profile against the axis of rotation, positive
    /// in the sense of growing angles.
    pub skew_rad: f64,
}

/// Axis by which a laser line gets over the part.
#[derive(Clone, Debug, PartialEq)]
pub enum Carriage {
    /// Linear axis along y, mm.
    Linear(Axis),
    /// Rotary axis that turns the part about z.
    Turning {
        /// θ, rad, counter-clockwise seen from +z.
        rotary: Axis,
        /// Direction of the profile.
        profile: ProfileDirection,
        /// Distance by which the laser line passes the axis of rotation, mm, in the sense of growing angles.
        tangential_mm: f64,
    },
}

/// Direction of a profile over a part that turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProfileDirection {
    /// Along the radius, heights along the axis of rotation: the face of a disc or lens.
    Radial,
    /// Along the axis of rotation, heights along the radius: a shaft or a ball from its side.
    Axial,
}

impl Carriage {
    /// The axis itself.
    pub(crate) fn axis(&self) -> &Axis {
        match self {
            Carriage::Linear(axis) | Carriage::Turning { rotary: axis, .. } => axis,
        }
    }

    /// Whether heights lie along z.
    pub(super) fn measures_along_z(&self) -> bool {
        !matches!(self, Carriage::Turning { profile: ProfileDirection::Axial, .. })
    }

    /// The axes at a point of a profile: `stand` in mm or rad is that of the axis, `along_mm` and `beside_mm` lie along the
    /// profile and across it, `height_mm` is the height.
    fn axes(&self, stand: f64, [along_mm, beside_mm]: [f64; 2], height_mm: f64) -> Axes {
        match *self {
            Carriage::Linear(_) => Axes::Cartesian([along_mm, stand + beside_mm, height_mm]),
            Carriage::Turning { profile, tangential_mm, .. } => {
                let tangential_mm = tangential_mm + beside_mm;
                let place_mm = match profile {
                    ProfileDirection::Radial => [along_mm, tangential_mm, height_mm],
                    ProfileDirection::Axial => [height_mm, tangential_mm, along_mm],
                };
                Axes::Turned { angle_rad: stand, place_mm }
            }
        }
    }

    /// Standard uncertainties along x, y and z of a place, mm, by one of where the axis stands, mm or rad.
    fn spread_mm(&self, place_mm: [f64; 3], u: f64) -> [f64; 3] {
        match self {
            Carriage::Linear(_) => [0.0, u, 0.0],
            Carriage::Turning { .. } => [place_mm[1].abs() * u, place_mm[0].abs() * u, 0.0],
        }
    }
}

/// Measured length to a coordinate: `value · scale + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// mm per mm measured; negative where the coordinate runs the other way.
    pub scale: f64,
    /// mm added after scaling.
    pub offset_mm: f64,
}

impl Profiler {
    /// Angle of the laser line against x, degrees.
    pub(super) fn skew_deg(&self) -> f64 {
        self.skew_rad.to_degrees()
    }

    /// Adds a point for each of the profile, good or flagged; one that is flagged where there is no profile.
    pub(super) fn points(
        &self,
        record: &Record,
        correction: Option<&Correction>,
        out: &mut Vec<Point>,
    ) {
        let mut flags = record.flags;
        let axis = self.carriage.axis();
        let stand = axis.value(record, &mut flags);
        let reading = record.readings.get(self.stream).and_then(Option::as_ref);
        let profile = reading.and_then(|reading| reading.values.profile());
        flags |= reading.map_or(Flags::UNJOINED, |reading| reading.flags);
        let points_mm = profile.map(Profile::points_mm).unwrap_or_default();
        if points_mm.is_empty() {
            out.push(Point::new(record, [0.0; 3], flags | Flags::NO_SIGNAL));
            return;
        }
        let (sin, cos) = self.skew_rad.sin_cos();
        let u = axis.spread(record);
        out.extend(points_mm.iter().map(|point_mm| match point_mm {
            Some([x_mm, z_mm]) => {
                let u_mm = self.across.value_mm(*x_mm);
                let line_mm = [u_mm * cos, u_mm * sin];
                let axes = self.carriage.axes(stand, line_mm, self.height.value_mm(*z_mm));
                let point = Point::corrected(record, axes, correction, flags);
                Point { u_mm: self.carriage.spread_mm(axes.place_mm(), u), ..point }
            }
            None => Point::new(record, [0.0; 3], flags | Flags::NO_SIGNAL),
        }));
    }
}

impl Scaling {
    fn value_mm(self, measured_mm: f64) -> f64 {
        measured_mm * self.scale + self.offset_mm
    }
}

#[cfg(test)]
mod tests {
    use super::super::kinematics::{Kinematics, Source};
    use super::*;
    use asphera_link::{Nanos, Reading, Values};

    fn profiler(skew_deg: f64) -> Profiler {
        Profiler {
            stream: 0,
            across: Scaling { scale: -1.0, offset_mm: 2.0 },
            height: Scaling { scale: -1.0, offset_mm: 100.0 },
            carriage: Carriage::Linear(Axis {
                source: Some(Source { stream: 0, channel: 0 }),
                scale: 0.05,
                offset: -10.0,
                errors: None,
            }),
            skew_rad: skew_deg.to_radians(),
        }
    }

    fn record(step: Option<f64>, points: &[Option<[f64; 2]>], flags: Flags) -> Record {
        let values: Values = [step].into_iter().collect();
        let profile: Profile = points.iter().copied().collect();
        let values = values.with_profile(profile);
        let reading =
            Reading { host: Nanos::ZERO, device_time_ns: None, count: None, values, flags };
        Record {
            count: Some(3),
            host: Nanos::ZERO,
            readings: vec![Some(reading)],
            flags: Flags::empty(),
            spreads: Vec::new(),
        }
    }

    fn points(profiler: Profiler, record: &Record) -> Vec<Point> {
        let mut points = Vec::new();
        Kinematics::Line(profiler).points(record, None, &mut points);
        points
    }

    #[test]
    fn each_point_of_a_profile_is_a_point_good_or_flagged() {
        let record =
            record(Some(40.0), &[Some([5.0, 70.0]), None, Some([-5.0, 71.0])], Flags::empty());
        let made = points(profiler(0.0), &record);
        let good = |point: &Point| point.is_good().then_some(point.position_mm);
        let places: Vec<_> = made.iter().map(good).collect();
        assert_eq!(places, [Some([-3.0, -8.0, 30.0]), None, Some([7.0, -8.0, 29.0])]);
        assert_eq!(made[1].flags, Flags::NO_SIGNAL);
        assert!(made.iter().all(|point| point.count == Some(3)));
    }

    #[test]
    fn a_skew_line_advances_with_its_points() {
        let made =
            points(profiler(30.0), &record(Some(200.0), &[Some([-8.0, 0.0])], Flags::empty()));
        let [x, y, z] = made[0].position_mm;
        assert!(
            (x - 10.0 * 0.75_f64.sqrt()).abs() < 1e-12 && (y - 5.0).abs() < 1e-12 && z == 100.0
        );
    }

    #[test]
    fn a_stage_with_a_count_of_its_own_gives_the_place() {
        let source = Some(Source { stream: 1, channel: 0 });
        let carriage = Carriage::Linear(Axis { source, ..profiler(0.0).carriage.axis().clone() });
        let profiler = Profiler { carriage, ..profiler(0.0) };
        let mut record = record(Some(1e6), &[Some([1.0, 1.0]); 2], Flags::empty());
        record.readings.push(Some(Reading {
            host: Nanos::ZERO,
            device_time_ns: None,
            count: None,
            values: [Some(100.0)].into_iter().collect(),
            flags: Flags::empty(),
        }));
        assert!(points(profiler.clone(), &record).iter().all(|point| point.position_mm[1] == -5.0));
        record.readings[1] = None;
        assert!(points(profiler, &record).iter().all(|point| point.flags == Flags::UNJOINED));
    }

    #[test]
    fn profiles_without_a_place_or_without_points_are_flagged() {
        let nowhere = points(profiler(0.0), &record(None, &[Some([1.0, 1.0]); 4], Flags::empty()));
        assert_eq!(nowhere.len(), 4);
        assert!(nowhere.iter().all(|point| point.flags == Flags::NO_SIGNAL));
        let empty = points(profiler(0.0), &record(Some(1.0), &[], Flags::DELAYED));
        assert_eq!(empty[0].flags, Flags::NO_SIGNAL | Flags::DELAYED);
        let lost = Record {
            readings: vec![None],
            flags: Flags::UNJOINED,
            ..record(None, &[], Flags::empty())
        };
        assert_eq!(points(profiler(0.0), &lost).len(), 1);
        assert!(!points(profiler(0.0), &lost)[0].is_good());
    }

    #[test]
    fn a_line_along_the_laser_says_that_the_axis_stood_still() {
        let line = Kinematics::Line(profiler(10.0));
        assert_eq!(line.stood_still(190.0), Some(("along", "constant_mm")));
        assert_eq!(line.stood_still(90.0), None);
    }
}

#[cfg(test)]
mod turning_tests;
