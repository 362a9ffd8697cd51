//! A part of known shape under a probe that tilts: readings follow from where its beam meets the part.

use std::f64::consts::{FRAC_PI_2, TAU};

use asphera_calibrate::Machine;
use asphera_clocks::Spread;
use asphera_link::{Nanos, Reading, Values};
use proptest::prelude::*;

use super::super::kinematics::{Kinematics, Point, Source};
use super::*;

/// Channels are x, y, z, tilt, probe, rotary, in mm and rad.
fn axis(channel: usize) -> Axis {
    let source = Some(Source { stream: 0, channel });
    Axis { source, scale: 1.0, offset: 0.0, errors: None }
}

fn tilting(pivot_offset_mm: [f64; 2]) -> Tilting {
    Tilting {
        x: axis(0),
        y: axis(1),
        z: axis(2),
        tilt: axis(3),
        probe: axis(4),
        rotary: Some(axis(5)),
        pivot_offset_mm,
    }
}

fn record(channels: [f64; 6]) -> Record {
    let values: Values = channels.into_iter().map(Some).collect();
    let (host, flags) = (Nanos::ZERO, Flags::empty());
    let reading = Reading { host, device_time_ns: None, count: None, values, flags };
    Record { count: None, host, readings: vec![Some(reading)], flags, spreads: Vec::new() }
}

fn point(tilting: &Tilting, record: &Record) -> Point {
    let mut points = Vec::new();
    Kinematics::Tilting(Box::new(tilting.clone())).points(record, None, &mut points);
    let [point] = points[..] else { panic!("{} points", points.len()) };
    point
}

fn off_mm(found: [f64; 3], expected: [f64; 3]) -> f64 {
    found.iter().zip(expected).map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max)
}

/// Where a beam from `from_mm` along a unit vector meets a sphere first.
fn met(from_mm: Vector, along: Vector, centre_mm: Vector, radius_mm: f64) -> Option<f64> {
    let to: Vector = [0, 1, 2].map(|axis| centre_mm[axis] - from_mm[axis]);
    let middle: f64 = to.iter().zip(along).map(|(to, along)| to * along).sum();
    let beside: f64 = (0..3).map(|axis| (to[axis] - middle * along[axis]).powi(2)).sum::<f64>();
    let half = (radius_mm * radius_mm - beside).sqrt();
    half.is_finite().then_some(middle - half)
}

proptest! {
    /// The pivot stands off a ball, the beam is turned to it as an optical probe is, and the ball may sit off the axis.
    #[test]
    fn a_ball_gives_its_points(
        centre_mm in prop::array::uniform3(-2.0..2.0_f64),
        offset_mm in prop::array::uniform2(-3.0..3.0_f64),
        tilt_rad in -1.4..1.4_f64,
        angle_rad in -20.0..20.0_f64,
        aside_mm in prop::array::uniform2(-5.0..5.0_f64),
        away_mm in 60.0..150.0_f64,
    ) {
        let radius_mm = 30.0;
        // The probe hangs from the pivot at tilt 0 and measures downwards: against the direction of its reading.
        let (sin, cos) = tilt_rad.sin_cos();
        let down = [-sin, 0.0, -cos];
        let pivot_mm = [away_mm * sin + aside_mm[0], aside_mm[1], away_mm * cos];
        let [a, b] = offset_mm;
        let from_mm = [pivot_mm[0] + a * cos, pivot_mm[1] + b, pivot_mm[2] - a * sin];
        // The ball in the frame of the machine, before the part's angle is taken out.
        let (turn_sin, turn_cos) = angle_rad.sin_cos();
        let [x, y, z] = centre_mm;
        let turned_mm = [x * turn_cos + y * turn_sin, y * turn_cos - x * turn_sin, z];
        let distance_mm = met(from_mm, down, turned_mm, radius_mm).unwrap();
        let [x, y, z] = pivot_mm;
        let record = record([x, y, z, tilt_rad, -distance_mm, angle_rad]);
        let found = point(&tilting(offset_mm), &record);
        prop_assert!(found.is_good());
        let off: f64 = found.position_mm.iter().zip(centre_mm).map(|(at, of)| (at - of).powi(2)).sum();
        prop_assert!((off.sqrt() - radius_mm).abs() < 1e-12 * away_mm, "{off}");
    }

    /// u is that of small steps of each axis, added up.
    #[test]
    fn the_spread_is_that_of_small_steps(
        stand in prop::array::uniform6(-1.0..1.0_f64), offset_mm in prop::array::uniform2(-3.0..3.0_f64),
        u in prop::array::uniform6(0.0..1e-3_f64),
    ) {
        let tilting = tilting(offset_mm);
        let at = |stand: [f64; 6]| point(&tilting, &record(stand)).position_mm;
        let mut expected = [0.0; 3];
        for channel in 0..6 {
            let [mut less, mut more] = [stand; 2];
            (less[channel], more[channel]) = (stand[channel] - STEP, stand[channel] + STEP);
            let (less, more) = (at(less), at(more));
            for axis in 0..3 {
                expected[axis] += ((more[axis] - less[axis]) / (2.0 * STEP)).abs() * u[channel];
            }
        }
        let spread = |channel: usize| Spread { stream: 0, channel, u: u[channel] };
        let record = Record { spreads: (0..6).map(spread).collect(), ..record(stand) };
        prop_assert!(off_mm(point(&tilting, &record).u_mm, expected) < 1e-9);
    }
}

const STEP: f64 = 1e-4;

/// By hand: upright, the beam goes along z; at a quarter turn of the tilt along x; and the part's angle turns it.
#[test]
fn places_by_hand() {
    let tilting = tilting([0.5, 0.25]);
    for (stand, expected) in [
        ([10.0, 0.0, 100.0, 0.0, -80.0, 0.0], [10.5, 0.25, 20.0]),
        ([10.0, 1.0, 100.0, FRAC_PI_2, -80.0, 0.0], [-70.0, 1.25, 99.5]),
        ([10.0, 1.0, 100.0, FRAC_PI_2, -80.0, FRAC_PI_2], [-1.25, -70.0, 99.5]),
        ([10.0, 1.0, 100.0, -FRAC_PI_2, -80.0, 3.0 * TAU], [90.0, 1.25, 100.5]),
    ] {
        let found = point(&tilting, &record(stand)).position_mm;
        assert!(off_mm(found, expected) < 1e-12, "{found:?}, expected {expected:?}");
    }
}

#[test]
fn without_a_tilt_it_is_the_other_kinds() {
    let upright = tilting([0.0; 2]);
    let record = record([7.0, 0.0, 1.0, 0.0, 2.5, 1.25]);
    let (radial, probe) = (axis(0), Axis { offset: 1.0, ..axis(4) });
    let polar = Kinematics::Polar { rotary: axis(5), radial, probe };
    let mut points = Vec::new();
    polar.points(&record, None, &mut points);
    assert!(off_mm(point(&upright, &record).position_mm, points[0].position_mm) < 1e-15);
    let fixed = Tilting { rotary: None, ..upright };
    assert_eq!(point(&fixed, &record).position_mm, [7.0, 0.0, 3.5]);
    let [fixed, turning] = [fixed, tilting([0.0; 2])].map(|of| Kinematics::Tilting(Box::new(of)));
    assert_eq!((fixed.machine(), turning.machine()), (Machine::Cartesian, Machine::Polar));
    assert!(fixed.bare().is_some() && !turning.measures_along_z());
    assert!(turning.is_point_by_point() && turning.clone().bare().is_none());
    assert_eq!(turning.axes().len(), 6);
    assert_eq!(turning.stood_still(10.0), Some(("rotary", "constant_rad")));
}

#[test]
fn a_missing_tilt_is_flagged() {
    let mut record = record([0.0; 6]);
    record.readings[0].as_mut().unwrap().values =
        [Some(0.0), Some(0.0), Some(0.0), None, Some(0.0), Some(0.0)].into_iter().collect();
    assert_eq!(point(&tilting([0.0; 2]), &record).flags, Flags::NO_SIGNAL);
}
