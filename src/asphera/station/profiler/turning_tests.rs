//! A part of known shape under a line scanner while it turns: readings are simulated from the part's own points.

use std::f64::consts::{FRAC_PI_2, TAU};

use asphera_calibrate::{Correction, HeightMap, Machine, Parameter};
use asphera_clocks::Spread;
use asphera_link::{Flags, Nanos, Profile, Reading, Values};
use proptest::prelude::*;

use super::super::kinematics::{Axis, Kinematics, Point, Source};
use super::super::synchronizer::Record;
use super::*;

/// Counts of the encoder of the rotary axis in one turn.
const COUNTS: f64 = 3600.0;

/// A scanner that hangs at `standoff_mm` from the plane z = 0 or from the axis of rotation, and measures distances.
#[derive(Clone, Copy, Debug)]
struct Bench {
    profile: ProfileDirection,
    tangential_mm: f64,
    skew_rad: f64,
    /// Place of the middle of the profile along the laser line.
    middle_mm: f64,
    standoff_mm: f64,
}

impl Bench {
    fn kinematics(self) -> Kinematics {
        let rotary = Axis {
            source: Some(Source { stream: 0, channel: 0 }),
            scale: TAU / COUNTS,
            offset: 0.25,
            errors: None,
        };
        let (profile, tangential_mm) = (self.profile, self.tangential_mm);
        Kinematics::Line(Profiler {
            stream: 0,
            across: Scaling { scale: 1.0, offset_mm: self.middle_mm },
            height: Scaling { scale: -1.0, offset_mm: self.standoff_mm },
            carriage: Carriage::Turning { rotary, profile, tangential_mm },
            skew_rad: self.skew_rad,
        })
    }

    /// Point of the machine's frame at `along_mm` of the laser line with this height.
    fn place_mm(self, along_mm: f64, height_mm: f64) -> [f64; 3] {
        let beside_mm = self.tangential_mm + along_mm * self.skew_rad.sin();
        let along_mm = along_mm * self.skew_rad.cos();
        match self.profile {
            ProfileDirection::Radial => [along_mm, beside_mm, height_mm],
            ProfileDirection::Axial => [height_mm, beside_mm, along_mm],
        }
    }

    /// Record of a profile whose points lie at (along, height), with the axis at `counts`.
    fn record(self, counts: f64, points_mm: &[[f64; 2]]) -> Record {
        let measured =
            |[along, height]: &[f64; 2]| Some([along - self.middle_mm, self.standoff_mm - height]);
        let profile: Profile = points_mm.iter().map(measured).collect();
        let values: Values = [Some(counts)].into_iter().collect();
        let values = values.with_profile(profile);
        let (host, flags) = (Nanos::ZERO, Flags::empty());
        let reading = Reading { host, device_time_ns: None, count: None, values, flags };
        Record { count: Some(0), host, readings: vec![Some(reading)], flags, spreads: Vec::new() }
    }

    fn points(self, record: &Record, correction: Option<&Correction>) -> Vec<Point> {
        let mut points = Vec::new();
        self.kinematics().points(record, correction, &mut points);
        points
    }
}

/// Height along the normal of the laser line at which a sphere is met, if it is.
///
/// The sphere has its centre in the part's frame. The part has turned back by θ, so its centre has, too.
fn height_of_sphere(
    bench: Bench,
    centre_mm: [f64; 3],
    radius_mm: f64,
    turn_rad: f64,
    along_mm: f64,
) -> Option<f64> {
    let (sin, cos) = turn_rad.sin_cos();
    let [x, y, z] = centre_mm;
    let centre_mm = [x * cos + y * sin, y * cos - x * sin, z];
    let foot_mm = bench.place_mm(along_mm, 0.0);
    let axis = if bench.profile == ProfileDirection::Radial { 2 } else { 0 };
    let across = (0..3).filter(|other| *other != axis);
    let off: f64 = across.map(|other| (foot_mm[other] - centre_mm[other]).powi(2)).sum();
    let root = (radius_mm * radius_mm - off).sqrt();
    root.is_finite().then_some(centre_mm[axis] + root)
}

fn any_bench() -> impl Strategy<Value = Bench> {
    let profile = prop_oneof![Just(ProfileDirection::Radial), Just(ProfileDirection::Axial)];
    (profile, -2.0..2.0_f64, -0.5..0.5_f64, -30.0..30.0_f64, 50.0..200.0_f64).prop_map(
        |(profile, tangential_mm, skew_rad, middle_mm, standoff_mm)| Bench {
            profile,
            tangential_mm,
            skew_rad,
            middle_mm,
            standoff_mm,
        },
    )
}

proptest! {
    /// A ball that sits anywhere on the axis gives its own points, whichever way the scanner looks.
    #[test]
    fn a_ball_gives_its_points(
        bench in any_bench(),
        centre_mm in prop::array::uniform3(-3.0..3.0_f64),
        counts in -7200.0..7200.0_f64,
    ) {
        let radius_mm = 25.0;
        let turn_rad = counts * (TAU / COUNTS) + 0.25;
        let along = (-10..=10).map(|step| 2.0 * f64::from(step));
        let met: Vec<[f64; 2]> = along
            .filter_map(|along_mm| {
                let height = height_of_sphere(bench, centre_mm, radius_mm, turn_rad, along_mm)?;
                Some([along_mm, height])
            })
            .collect();
        prop_assert!(met.len() >= 8, "{}", met.len());
        let points = bench.points(&bench.record(counts, &met), None);
        prop_assert_eq!(points.len(), met.len());
        for point in points {
            prop_assert!(point.is_good());
            let off: f64 =
                point.position_mm.iter().zip(centre_mm).map(|(at, of)| (at - of).powi(2)).sum();
            // The heights have some 200 mm of standoff in them.
            prop_assert!((off.sqrt() - radius_mm).abs() < 1e-12 * 200.0, "{off}");
        }
    }

    /// A whole turn comes back to the same place; the turn of a part turns its points.
    #[test]
    fn the_turn_of_the_axis_turns_the_points(
        bench in any_bench(), along_mm in -20.0..20.0_f64, height_mm in 1.0..30.0_f64, quarter in 0..4_u32,
    ) {
        let at = |counts: f64| {
            bench.points(&bench.record(counts, &[[along_mm, height_mm]]), None)[0].position_mm
        };
        let [x, y, z] = at(0.0);
        let (sin, cos) = (f64::from(quarter) * FRAC_PI_2).sin_cos();
        let [turned_x, turned_y, turned_z] = at(COUNTS * (3.0 + f64::from(quarter) / 4.0));
        prop_assert!((turned_x - (x * cos - y * sin)).abs() < 1e-11);
        prop_assert!((turned_y - (x * sin + y * cos)).abs() < 1e-11);
        prop_assert_eq!(turned_z, z);
    }
}

fn upright(profile: ProfileDirection) -> Bench {
    Bench { profile, tangential_mm: 0.0, skew_rad: 0.0, middle_mm: 0.0, standoff_mm: 100.0 }
}

/// A quarter turn, by hand: with 899.999… counts the offset of 0.25 rad would hide it.
#[test]
fn places_by_hand() {
    let counts = (FRAC_PI_2 - 0.25) * COUNTS / TAU;
    let at = |profile| {
        let bench = Bench { tangential_mm: 0.5, ..upright(profile) };
        bench.points(&bench.record(counts, &[[7.0, 3.0]]), None)[0].position_mm
    };
    let close = |found: [f64; 3], expected: [f64; 3]| {
        found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-13)
    };
    assert!(close(at(ProfileDirection::Radial), [-0.5, 7.0, 3.0]));
    assert!(close(at(ProfileDirection::Axial), [-0.5, 3.0, 7.0]));
}

/// An error of the turn moves a point in the sense of the turn, by its distance from the axis.
#[test]
fn an_uncertain_turn_is_an_uncertain_place() {
    let bench = upright(ProfileDirection::Axial);
    let counts = -0.25 * COUNTS / TAU;
    let mut record = bench.record(counts, &[[7.0, 20.0]]);
    record.spreads = vec![Spread { stream: 0, channel: 0, u: 0.5 }];
    let [x, y, z] = bench.points(&record, None)[0].u_mm;
    assert!(x < 1e-15 && z == 0.0 && (y - 20.0 * 0.5 * TAU / COUNTS).abs() < 1e-12);
}

#[test]
fn a_calibration_of_a_polar_machine_corrects_it_and_a_linear_one_does_not() {
    let bench = upright(ProfileDirection::Radial);
    assert_eq!(bench.kinematics().machine(), Machine::Polar);
    let values = vec![(Parameter::OffsetRadial, 0.5)];
    let map = HeightMap::new(10.0, vec![(2, 0, 0.0)]);
    let correction = Correction::new(Machine::Polar, values, map).unwrap();
    let record = bench.record(-0.25 * COUNTS / TAU, &[[7.0, 3.0], [11.0, 3.0]]);
    let points = bench.points(&record, Some(&correction));
    let [x, y, z] = points[0].position_mm;
    assert!((x - 7.5).abs() < 1e-13 && y.abs() < 1e-13 && (z - 3.0).abs() < 1e-13);
    assert!(points[0].is_good() && points[1].flags == Flags::OUT_OF_RANGE);
    assert!(bench.kinematics().measures_along_z());
    assert!(!upright(ProfileDirection::Axial).kinematics().measures_along_z());
    assert!(bench.kinematics().bare().is_none());
}

#[test]
fn a_part_that_did_not_turn_is_named() {
    let turning = upright(ProfileDirection::Radial).kinematics();
    assert_eq!(turning.stood_still(12.0), Some(("rotary", "constant_rad")));
    assert_eq!(turning.turning(), Some(turning.axes()[0].clone()));
}
