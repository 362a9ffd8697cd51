//! The driver against the simulator in virtual time: faults of scanner and network, and what is told of them.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

use std::time::Duration;

use asphera_link::{Driver as _, Event, Input, Nanos, Reading};
use asphera_rf627::{Rf627, Settings, Tally};
use asphera_sim_rf627::{Fault, Optics, Part, Scan, Scanner};

const PART: Part =
    Part { radius_mm: Some(40.0), wave_um: 3.0, wave_length_mm: 3.0, half_width_mm: 4.0 };

fn scan() -> Scan {
    Scan { part: PART, first_y_mm: -5.0, steps: 20, step_mm: 0.005, profiles: 100 }
}

fn run(faults: &[(u32, Fault)]) -> (Vec<Reading>, Tally) {
    let optics = Optics { points: 50, ..Optics::default() };
    let departures = scan().departures(&mut Scanner::new(optics, 1), faults, 9).unwrap();
    let mut driver = Rf627::new(Settings { silence_ms: 1000, ..Settings::default() }).unwrap();
    let mut readings = Vec::new();
    driver.connected(Nanos::ZERO);
    let end = departures.last().unwrap().at_ns + 100_000_000;
    let last = std::iter::once((end, &[][..]));
    let all = departures.iter().map(|departure| (departure.at_ns, &departure.datagram[..]));
    for (at_ns, datagram) in all.chain(last) {
        let until = Nanos::from_nanos(at_ns);
        while let Some(due) = driver.poll_timeout().filter(|due| *due <= until) {
            driver.timeout(due);
            drain(&mut driver, due, &mut readings);
        }
        if !datagram.is_empty() {
            driver.receive(until, Input::Bytes(datagram));
        }
        drain(&mut driver, until, &mut readings);
    }
    (readings, driver.tally())
}

fn drain(driver: &mut Rf627, now: Nanos, readings: &mut Vec<Reading>) {
    while let Some(event) = driver.poll_event() {
        match event {
            Event::Reading(reading) => readings.push(reading),
            Event::Reopen(_) => {
                driver.disconnected(now);
                driver.connected(now);
            }
            _ => {}
        }
    }
}

/// Places of all points: x and z of the profile, y by the step count.
fn places(readings: &[Reading]) -> Vec<[f64; 3]> {
    let of_one = |reading: &Reading| {
        let y_mm = -5.0 + 0.005 * reading.values.get(0).unwrap();
        let points = reading.values.profile().unwrap().points_mm().to_vec();
        points.into_iter().flatten().map(move |[x, z]| [x, y_mm, 5.0 - z])
    };
    readings.iter().flat_map(of_one).collect()
}

#[test]
fn every_point_lies_on_the_part() {
    let (readings, tally) = run(&[]);
    assert_eq!((tally.readings, tally.points, tally.missing), (100, 5000, 0));
    assert_eq!(tally.empty_points, 1000, "a fifth of the line is beside the part");
    let places = places(&readings);
    assert_eq!(places.len(), 4000);
    let half_step_mm = 0.5 * 10.0 / 16_384.0 + 1e-9;
    for [x, y, z] in places {
        assert!((PART.height_mm(x, y).unwrap() - z).abs() < half_step_mm, "{x} {y} {z}");
    }
}

#[test]
fn faults_cost_what_they_must_and_are_counted() {
    let (whole, _) = run(&[]);
    let faults = [
        (10, Fault::Lose),
        (11, Fault::Lose),
        (20, Fault::Repeat),
        (30, Fault::Swap),
        (40, Fault::Garbage(700)),
        (50, Fault::Cut(100)),
        (60, Fault::Skip),
        (70, Fault::Silence(1500)),
    ];
    let (readings, tally) = run(&faults);
    let without = |lost: &[usize]| {
        let kept = whole.iter().enumerate().filter(|(index, _)| !lost.contains(index));
        places(&kept.map(|(_, reading)| reading.clone()).collect::<Vec<_>>())
    };
    // The scanner that skips one goes on with its steps, so only that one is missing.
    let expected = without(&[10, 11, 50, 60]);
    assert_eq!(places(&readings).len(), expected.len());
    assert!(places(&readings) == expected, "points of another profile");
    assert_eq!((tally.missing, tally.repeated, tally.overtaken), (4, 1, 1));
    // The garbage and the cut datagram.
    assert_eq!(tally.refused, 2);
    assert_eq!(tally.discarded_bytes, 700 + 100 + 264);
}

#[test]
fn a_restart_is_counted() {
    let (readings, tally) = run(&[(50, Fault::Restart)]);
    assert_eq!((readings.len(), tally.restarts, tally.missing), (100, 1, 0));
    assert_eq!(readings[50].count.unwrap().raw, 0);
}

#[test]
fn the_time_of_the_scanner_is_regular() {
    let (readings, _) = run(&[(3, Fault::Lose)]);
    let times: Vec<u64> = readings.iter().filter_map(|reading| reading.device_time_ns).collect();
    let period = Duration::from_millis(2).as_nanos() as u64;
    assert!(times.windows(2).all(|pair| [period, 2 * period].contains(&(pair[1] - pair[0]))));
}
