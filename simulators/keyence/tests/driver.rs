//! The driver with the simulated controller, in virtual time.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

use std::f64::consts::TAU;
use std::time::Duration;

use asphera_keyence::wire::Series;
use asphera_keyence::{Profiler, Settings, Tally};
use asphera_link::{Command, Driver as _, Event, Fault as Trouble, Input, Nanos, Output, Reading};
use asphera_sim_keyence::{Controller, Fault, Optics, Scan, ScanSettings, Surface};

const PROFILES: u32 = 60;
const STEP_MM: f64 = 0.05;
const FIRST_MM: f64 = -6.0;

fn height_mm([x, y]: [f64; 2]) -> Option<f64> {
    let wave = |place: f64| (TAU * place / 4.0).sin();
    (x.abs() < 8.0).then(|| 1.5 - 0.01 * (x * x + y * y) + 0.02 * wave(x) * wave(y))
}

/// Everything that a whole scan gave.
struct Run {
    readings: Vec<Reading>,
    faults: Vec<Trouble>,
    tally: Tally,
    reconnects: u32,
}

/// Lets driver and controller talk until the scan is complete. The link is opened anew where either side wants that.
fn run(settings: Settings, optics: Optics, faults: &[(u32, Fault)]) -> Run {
    let surface = Surface::new(height_mm);
    let scan = ScanSettings {
        surface,
        first_y_mm: FIRST_MM,
        steps: 4,
        step_mm: STEP_MM,
        profiles: PROFILES,
        rate_hz: 1000.0,
    };
    let (mut controller, mut scan) = (Controller::new(optics, 1), Scan::new(scan, faults));
    let mut driver = Profiler::new(settings).unwrap();
    let mut now = Nanos::ZERO;
    let (mut readings, mut troubles, mut reconnects) = (Vec::new(), Vec::new(), 0);
    driver.connected(now);
    driver.command(now, Command::Start);
    for _ in 0..4000 {
        now = now + Duration::from_millis(1);
        while let Some(due) = driver.poll_timeout().filter(|due| *due <= now) {
            driver.timeout(due);
        }
        while let Some(Output::Bytes(bytes)) = driver.poll_transmit() {
            let answers = controller.receive(&bytes);
            driver.receive(now, Input::Bytes(&answers));
        }
        let mut is_over = false;
        if controller.is_streaming() && !scan.is_complete() {
            match scan.advance(&mut controller) {
                Some(bytes) => driver.receive(now, Input::Second(&bytes)),
                None => is_over = true,
            }
        }
        while let Some(event) = driver.poll_event() {
            match event {
                Event::Reading(reading) => readings.push(reading),
                Event::Fault(fault) => troubles.push(fault),
                Event::Reopen(fault) => {
                    troubles.push(fault);
                    is_over = true;
                }
                _ => {}
            }
        }
        if is_over {
            reconnects += 1;
            driver.disconnected(now);
            controller.disconnected();
            driver.connected(now);
        }
    }
    assert!(scan.is_complete(), "{troubles:?}");
    Run { readings, faults: troubles, tally: driver.tally(), reconnects }
}

/// Every point lies on the part to half a unit of the heights, at the place that the encoder tells.
fn assert_on_part(readings: &[Reading]) {
    for reading in readings {
        let y = FIRST_MM + STEP_MM * reading.values.get(0).unwrap();
        for [x, z] in reading.values.profile().unwrap().points_mm().iter().flatten() {
            let found = (z - height_mm([*x, y]).unwrap()).abs();
            assert!(found <= 0.000_04 + 1e-9, "{found} mm at {x}, {y}");
        }
    }
}

fn triggers(readings: &[Reading]) -> Vec<u32> {
    readings.iter().map(|reading| reading.count.unwrap().raw).collect()
}

fn all_but(lost: &[u32]) -> Vec<u32> {
    (0..PROFILES).filter(|trigger| !lost.contains(trigger)).collect()
}

#[test]
fn every_point_lies_on_the_part() {
    for (settings, optics) in [
        (Settings::default(), Optics::default()),
        (
            Settings { batch: true, ..Settings::default() },
            Optics { luminances: true, ..Optics::default() },
        ),
        (Settings::default(), Optics { hides_unit: true, points: 401, ..Optics::default() }),
        (
            Settings { series: Series::LjV7000, ..Settings::default() },
            Optics { series: Series::LjV7000, ..Optics::default() },
        ),
    ] {
        let run = run(settings, optics, &[]);
        assert_eq!(triggers(&run.readings), all_but(&[]));
        assert_on_part(&run.readings);
        // 16 mm of 20 mm: 320 of 400 points, one each 0.05 mm.
        let valid = run.tally.points - run.tally.empty_points;
        assert!(valid.abs_diff(320 * u64::from(PROFILES)) <= u64::from(PROFILES), "{valid}");
        assert_eq!((run.faults.len(), run.reconnects, run.tally.discarded_bytes), (0, 0, 0));
        assert_eq!(run.tally.batches, 1);
    }
}

#[test]
fn faults_cost_what_they_must_and_are_counted() {
    let faults = [
        (10, Fault::BadSum),
        (20, Fault::Lost(3)),
        (30, Fault::Stop(2)),
        (40, Fault::Error(0x0055)),
    ];
    let run =
        run(Settings { watch_ms: Some(100), ..Settings::default() }, Optics::default(), &faults);
    // Triggers 20 to 22 have no profile, and 60 profiles come all the same.
    let expected: Vec<u32> =
        (0..63).filter(|trigger| ![10, 20, 21, 22].contains(trigger)).collect();
    assert_eq!(triggers(&run.readings), expected);
    assert_on_part(&run.readings);
    let tally = run.tally;
    assert_eq!((tally.damaged, tally.missing, tally.stops), (1, 1 + 3, 1));
    assert_eq!(tally.discarded_bytes, 24 + 1000 + 4);
    assert_eq!(run.reconnects, 0);
    assert!(run.faults.iter().any(|fault| fault.detail.contains("0055h")), "{:?}", run.faults);
}

#[test]
fn a_profile_cut_short_costs_three_and_a_new_connection() {
    let run = run(Settings::default(), Optics::default(), &[(10, Fault::Cut(100))]);
    // The cut one, the two whose beginning nobody found; the fragment of the last is thrown away.
    assert_eq!(triggers(&run.readings), all_but(&[10, 11, 12]));
    assert_on_part(&run.readings);
    assert_eq!((run.tally.damaged, run.reconnects), (2, 1));
}

#[test]
fn both_connections_come_back() {
    let run = run(Settings::default(), Optics::default(), &[(25, Fault::Unplug)]);
    assert_eq!(triggers(&run.readings), all_but(&[]));
    assert_eq!((run.reconnects, run.faults.len()), (1, 0));
}

#[test]
fn the_wrong_series_is_never_online() {
    let optics = Optics { series: Series::LjV7000, ..Optics::default() };
    let mut controller = Controller::new(optics, 1);
    let mut driver = Profiler::new(Settings::default()).unwrap();
    driver.connected(Nanos::ZERO);
    let Some(Output::Bytes(bytes)) = driver.poll_transmit() else { panic!("nothing asked") };
    assert_eq!(controller.receive(&bytes), []);
    driver.timeout(Nanos::from_millis(1000));
    assert!(matches!(driver.poll_event(), Some(Event::Reopen(_))));
}

#[test]
fn noise_follows_from_the_seed() {
    let optics = Optics { noise_um: 1.0, ..Optics::default() };
    let profile = |seed| Controller::new(optics, seed).measure(3, |x| height_mm([x, 0.0]));
    assert_eq!(profile(5), profile(5));
    assert_ne!(profile(5), profile(6));
}
