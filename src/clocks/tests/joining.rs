//! Readings of two devices without a shared count, joined by time, against motions that are known.

use std::f64::consts::TAU;
use std::time::Duration;

use asphera_clocks::{Coordinate, Joined, TimeJoiner, TimeSettings, Timekeeping};
use asphera_link::{DeviceClock, Flags, Nanos, Reading};
use proptest::prelude::*;
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64Mcg;

/// A device: rate, clock, delays, and what it shows at a time in s.
struct Device<'a> {
    period_ns: u64,
    /// Its clock gains so much; `None` where it sends no time.
    drift_ppm: Option<f64>,
    /// Most of its delays.
    delay_ns: f64,
    shows: &'a dyn Fn(f64) -> f64,
    /// Its readings cease here, s.
    until_s: f64,
}

/// Readings of a device over a session of 6 s.
fn readings(device: &Device<'_>, seed: u64) -> Vec<Reading> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut last = Nanos::ZERO;
    let last_s = device.until_s.min(6.0);
    let numbers = 0..(last_s * 1e9) as u64 / device.period_ns;
    numbers
        .map(|n| {
            let true_ns = 1_000_000 + n * device.period_ns;
            let unit = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
            let host = Nanos::from_nanos(true_ns + (device.delay_ns * unit * unit) as u64);
            last = last.max(host);
            let device_ns =
                |ppm: f64| 40_000_000_000 + (true_ns as f64 * (1.0 + ppm * 1e-6)) as u64;
            Reading {
                host: last,
                device_time_ns: device.drift_ppm.map(device_ns),
                count: None,
                values: [Some((device.shows)(true_ns as f64 * 1e-9))].into_iter().collect(),
                flags: Flags::empty(),
            }
        })
        .collect()
}

fn settings(devices: &[&Device<'_>], turn: f64) -> TimeSettings {
    let timekeeping = |device: &&Device<'_>| Timekeeping {
        clock: device.drift_ppm.map(|_| DeviceClock::default()),
        ..Timekeeping::default()
    };
    TimeSettings {
        wait: Duration::from_secs(2),
        capacity: 10_000,
        gap: Duration::from_millis(100),
        devices: devices.iter().map(timekeeping).collect(),
        coordinates: vec![Coordinate { stream: 1, channel: 0, turn }],
    }
}

/// Readings of both in the order in which they arrive.
fn arrivals(primary: Vec<Reading>, companion: Vec<Reading>) -> Vec<(usize, Reading)> {
    let mut all: Vec<(usize, Reading)> = primary.into_iter().map(|reading| (0, reading)).collect();
    all.extend(companion.into_iter().map(|reading| (1, reading)));
    all.sort_by_key(|(_, reading)| reading.host);
    all
}

fn joined(settings: TimeSettings, all: Vec<(usize, Reading)>) -> (Vec<Joined>, TimeJoiner) {
    let (mut joiner, mut out) = (TimeJoiner::new(settings), Vec::new());
    for (stream, reading) in all {
        joiner.take(stream, reading, &mut out);
    }
    joiner.flush(&mut out);
    (out, joiner)
}

/// The primary shows the true time in s, so that a record tells what its companion must show.
const TIME: &dyn Fn(f64) -> f64 = &|t_s| t_s;

fn gauge() -> Device<'static> {
    Device { period_ns: 1_013_000, drift_ppm: Some(50.0), delay_ns: 2e6, shows: TIME, until_s: 6.0 }
}

fn value_of(record: &Joined, stream: usize) -> f64 {
    let reading = record.readings[stream].as_ref();
    reading.and_then(|reading| reading.values.get(0)).expect("a record that is complete")
}

/// Error and stated uncertainty of each record that was joined.
fn errors(out: &[Joined], shows: &dyn Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let complete = out.iter().filter(|record| record.is_complete());
    complete
        .map(|record| (value_of(record, 1) - shows(value_of(record, 0)), record.spreads[0].u))
        .collect()
}

#[test]
fn a_companion_on_a_ramp_and_a_sine_is_where_it_is_said_to_be() {
    let ramp = |t_s: f64| 3.0 + 20.0 * t_s;
    let sine = |t_s: f64| 5.0 * (TAU * 0.7 * t_s).sin();
    let motions: [&dyn Fn(f64) -> f64; 2] = [&ramp, &sine];
    for (motion, shows) in motions.into_iter().enumerate() {
        for seed in 0..6 {
            let stage = Device {
                period_ns: 9_700_000,
                drift_ppm: Some(-120.0),
                delay_ns: 4e6,
                shows,
                until_s: 6.0,
            };
            let all = arrivals(readings(&gauge(), seed), readings(&stage, 100 + seed));
            let (out, joiner) = joined(settings(&[&gauge(), &stage], 0.0), all);
            let found = errors(&out, shows);
            // All but those of the first three readings of the stage and after its last.
            assert!(found.len() + 60 > out.len(), "{motion}: {} of {}", found.len(), out.len());
            let within = found.iter().filter(|(error, u)| error.abs() <= 2.0 * u + 1e-9).count();
            assert!(
                within * 100 >= found.len() * 95,
                "{motion} {seed}: {within} of {}",
                found.len()
            );
            // 4 ms of delays at 20 mm/s would be 80 µm.
            let worst = found.iter().map(|(_, u)| *u).skip(1000).fold(0.0, f64::max);
            assert!(worst < 0.02, "{motion}: {worst} mm");
            assert!(joiner.clocks().all(|clock| clock.unwrap().jumps == 0));
        }
    }
}

#[test]
fn with_clocks_that_agree_the_error_on_a_sine_is_never_above_the_stated_one() {
    for hz in [0.1, 0.7, 2.0, 5.0] {
        let sine = move |t_s: f64| 5.0 * (TAU * hz * t_s).sin();
        let gauge = Device { drift_ppm: Some(0.0), delay_ns: 0.0, ..gauge() };
        let stage = Device {
            period_ns: 9_700_000,
            drift_ppm: Some(0.0),
            delay_ns: 0.0,
            shows: &sine,
            until_s: 6.0,
        };
        let all = arrivals(readings(&gauge, 1), readings(&stage, 2));
        let (out, _) = joined(settings(&[&gauge, &stage], 0.0), all);
        let found = errors(&out, &sine);
        assert!(found.len() > 5000);
        for (error, u) in &found {
            assert!(error.abs() <= u + 1e-7, "{hz} Hz: {error} beyond {u}");
        }
        // And it is no idle bound.
        let sum = |of: &dyn Fn(&(f64, f64)) -> f64| found.iter().map(of).sum::<f64>();
        assert!(
            sum(&|(_, u)| *u) < 4.0 * sum(&|(error, _)| error.abs()) + 1e-6 * found.len() as f64
        );
    }
}

#[test]
fn a_companion_that_goes_silent_gives_no_place_from_then_on() {
    let ramp = |t_s: f64| 20.0 * t_s;
    let stage = Device {
        period_ns: 9_700_000,
        drift_ppm: Some(0.0),
        delay_ns: 1e6,
        shows: &ramp,
        until_s: 3.0,
    };
    let primary = readings(&gauge(), 1);
    let count = primary.len();
    let (out, joiner) =
        joined(settings(&[&gauge(), &stage], 0.0), arrivals(primary, readings(&stage, 2)));
    assert_eq!(out.len(), count, "every reading of the primary is given");
    for record in &out {
        let t_s = record.readings[0].as_ref().unwrap().values.get(0).unwrap();
        assert!(t_s < 3.0 || !record.is_complete(), "{t_s}");
    }
    let fates: Vec<_> = joiner.fates().collect();
    let lacking = out.iter().filter(|record| !record.is_complete()).count() as u64;
    assert!(lacking > 2900);
    assert_eq!((fates[0].unjoined, fates[1].unjoined), (lacking, lacking));
}

#[test]
fn a_gap_is_not_bridged_and_joining_goes_on_after_it() {
    let ramp = |t_s: f64| 20.0 * t_s;
    let stage =
        Device { period_ns: 9_700_000, drift_ppm: None, delay_ns: 0.0, shows: &ramp, until_s: 6.0 };
    let mut companion = readings(&stage, 2);
    companion.retain(|reading| !(2.0..2.2).contains(&reading.host.as_secs_f64()));
    let (out, _) =
        joined(settings(&[&gauge(), &stage], 0.0), arrivals(readings(&gauge(), 1), companion));
    for record in &out {
        let t_s = record.readings[0].as_ref().unwrap().values.get(0).unwrap();
        let is_complete = record.is_complete();
        assert!(!(1.999..2.2).contains(&t_s) || !is_complete, "{t_s}");
        assert!(!(2.25..5.9).contains(&t_s) || is_complete, "{t_s}");
    }
}

#[test]
fn a_rotary_companion_is_followed_round() {
    let turning = |t_s: f64| (1.3 * 3600.0 * t_s).rem_euclid(3600.0);
    let stage = Device {
        period_ns: 9_700_000,
        drift_ppm: Some(0.0),
        delay_ns: 0.0,
        shows: &turning,
        until_s: 6.0,
    };
    let exact = Device { drift_ppm: Some(0.0), delay_ns: 0.0, ..gauge() };
    let all = arrivals(readings(&exact, 1), readings(&stage, 2));
    let (out, _) = joined(settings(&[&exact, &stage], 3600.0), all.clone());
    let found = errors(&out, &turning);
    assert!(found.len() > 5000);
    assert!(found.iter().all(|(error, u)| {
        let off = (error + 1800.0).rem_euclid(3600.0) - 1800.0;
        off.abs() <= u + 1e-4 && *u < 1e-2
    }));
    // As a length the same readings go back in one step: no uncertainty is small there, whichever limit there is.
    let (out, _) = joined(settings(&[&exact, &stage], 0.0), all);
    let wrong = errors(&out, &turning).into_iter().filter(|(error, _)| error.abs() > 1.0);
    let wrong: Vec<_> = wrong.collect();
    assert!(wrong.len() > 50 && wrong.iter().all(|(_, u)| *u > 500.0), "{wrong:?}");
}

#[test]
fn between_a_clock_before_and_after_a_jump_nothing_is_placed() {
    let ramp = |t_s: f64| 20.0 * t_s;
    let stage = Device {
        period_ns: 9_700_000,
        drift_ppm: Some(0.0),
        delay_ns: 5e5,
        shows: &ramp,
        until_s: 6.0,
    };
    let mut companion = readings(&stage, 2);
    for reading in companion.iter_mut().filter(|reading| reading.host.as_secs_f64() > 3.0) {
        reading.device_time_ns = reading.device_time_ns.map(|ns| ns + 700_000_000);
    }
    let (out, joiner) =
        joined(settings(&[&gauge(), &stage], 0.0), arrivals(readings(&gauge(), 1), companion));
    assert_eq!(joiner.clocks().nth(1).unwrap().unwrap().jumps, 1);
    let found = errors(&out, &ramp);
    assert!(found.len() > 5700, "{}", found.len());
    assert!(found.iter().all(|(error, u)| error.abs() <= 4.0 * u + 1e-6));
}

#[test]
fn several_readings_of_one_arrival_are_not_told_apart_without_a_clock() {
    let ramp = |t_s: f64| 20.0 * t_s;
    let stage =
        Device { period_ns: 9_700_000, drift_ppm: None, delay_ns: 0.0, shows: &ramp, until_s: 6.0 };
    let blind = Device { drift_ppm: None, delay_ns: 0.0, ..gauge() };
    // A port that is read every 16 ms.
    let late = |reading: &mut Reading| {
        let ms = reading.host.as_nanos() / 16_000_000 + 1;
        reading.host = Nanos::from_millis(16 * ms);
    };
    let mut primary = readings(&blind, 1);
    primary.iter_mut().for_each(late);
    let (out, joiner) =
        joined(settings(&[&blind, &stage], 0.0), arrivals(primary, readings(&stage, 2)));
    let found = errors(&out, &ramp);
    assert!((300..380).contains(&found.len()), "one of each read: {}", found.len());
    assert!(found.iter().all(|(error, _)| error.abs() <= 20.0 * 1.1e-3), "at most one period old");
    assert_eq!(joiner.fates().next().unwrap().unjoined as usize, out.len() - found.len());
}

#[test]
fn what_a_host_that_was_held_up_stamped_late_is_not_placed_by_arrival() {
    let ramp = |t_s: f64| 20.0 * t_s;
    let stage =
        Device { period_ns: 9_700_000, drift_ppm: None, delay_ns: 0.0, shows: &ramp, until_s: 6.0 };
    let (mut joiner, mut out) = (TimeJoiner::new(settings(&[&gauge(), &stage], 0.0)), Vec::new());
    for (stream, mut reading) in arrivals(readings(&gauge(), 1), readings(&stage, 2)) {
        // The process stood still from 3 s to 3.4 s.
        if (3.0..3.4).contains(&reading.host.as_secs_f64()) {
            joiner.held_up(Nanos::from_millis(3650));
            reading.host = Nanos::from_millis(3400);
        }
        joiner.take(stream, reading, &mut out);
    }
    joiner.flush(&mut out);
    let found = errors(&out, &ramp);
    assert!(found.len() > 4900 && found.len() < 5400, "{}", found.len());
    assert!(found.iter().all(|(error, u)| error.abs() <= 4.0 * u + 2e-4), "{found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Timers that run at any time between readings change nothing, and a second run gives the same bits.
    #[test]
    fn records_depend_on_the_readings_and_their_times_alone(seed in 0_u64..1000, every in 1_u64..40) {
        let sine = |t_s: f64| 5.0 * (TAU * 0.7 * t_s).sin();
        let stage = Device { period_ns: 9_700_000, drift_ppm: Some(-120.0), delay_ns: 4e6, shows: &sine, until_s: 4.0 };
        let gauge = Device { period_ns: 2_100_000, until_s: 5.0, ..gauge() };
        let all = arrivals(readings(&gauge, seed), readings(&stage, seed + 1));
        let (plain, _) = joined(settings(&[&gauge, &stage], 0.0), all.clone());
        let (mut joiner, mut out) = (TimeJoiner::new(settings(&[&gauge, &stage], 0.0)), Vec::new());
        for (number, (stream, reading)) in (0_u64..).zip(all) {
            if let Some(due) = joiner.poll_timeout().filter(|due| *due <= reading.host) {
                joiner.timeout(due, &mut out);
            }
            if number % every == 0 {
                joiner.timeout(reading.host, &mut out);
            }
            joiner.take(stream, reading, &mut out);
        }
        joiner.flush(&mut out);
        prop_assert_eq!(plain, out);
    }
}
