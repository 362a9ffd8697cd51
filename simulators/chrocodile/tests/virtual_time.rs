//! The driver against the device in virtual time, without sockets.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

use std::time::Duration;

use asphera_chrocodile::{Chrocodile, Settings, Trigger};
use asphera_link::{Command, Driver, Event, FaultKind, Flags, Input, Nanos, Output, Reading};
use asphera_sim_chrocodile::{Device, Sample, TriggerMode};

const FULL_SCALE_UM: f64 = 3000.0;
const STEP: Duration = Duration::from_millis(1);

/// Driver and device with a wire between them that takes no time.
struct Pair {
    driver: Chrocodile,
    device: Device,
    now: Nanos,
    is_cut: bool,
    events: Vec<Event>,
}

impl Pair {
    fn connected(settings: Settings) -> Pair {
        let mut pair = Pair {
            driver: Chrocodile::new(settings).unwrap(),
            device: Device::new(FULL_SCALE_UM),
            now: Nanos::ZERO,
            is_cut: false,
            events: Vec::new(),
        };
        pair.driver.connected(pair.now);
        pair
    }

    fn measuring(settings: Settings) -> Pair {
        let mut pair = Pair::connected(settings);
        pair.driver.command(pair.now, Command::Start);
        pair.settle();
        assert_eq!(pair.take_events(), [Event::Online, Event::Ready]);
        assert!(pair.device.armed());
        pair
    }

    /// Carries bytes both ways until nobody has anything to say.
    fn settle(&mut self) {
        loop {
            let mut is_quiet = true;
            while let Some(output) = self.driver.poll_transmit() {
                let Output::Bytes(bytes) = output else { panic!("{output:?}") };
                is_quiet = false;
                if !self.is_cut {
                    self.device.receive(&bytes);
                }
            }
            let bytes = self.device.transmit();
            if !bytes.is_empty() && !self.is_cut {
                is_quiet = false;
                self.driver.receive(self.now, Input::Bytes(&bytes));
            }
            self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
            if is_quiet {
                return;
            }
        }
    }

    /// Lets time pass, with every timeout on the way.
    fn pass(&mut self, time: Duration) {
        let end = self.now + time;
        while let Some(due) = self.driver.poll_timeout().filter(|&due| due <= end) {
            self.now = self.now.max(due);
            self.driver.timeout(self.now);
            self.settle();
        }
        self.now = end;
    }

    /// Exposures of these numbers, one a ms.
    fn expose(&mut self, exposures: std::ops::Range<u64>) {
        for exposure in exposures {
            self.device.trigger(sample(exposure));
            self.settle();
            self.pass(STEP);
        }
    }

    fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    /// Readings so far; anything else that is not a passed-over byte is a failure.
    fn take_readings(&mut self) -> Vec<Reading> {
        self.take_events()
            .into_iter()
            .filter_map(|event| match event {
                Event::Reading(reading) => Some(reading),
                Event::Discarded { .. } => None,
                other => panic!("{other:?}"),
            })
            .collect()
    }
}

fn sample(exposure: u64) -> Sample {
    Sample {
        exposure_count: exposure,
        start_ns: exposure * 1_000_000,
        encoder: [exposure as i32 - 30, 0, 0, 0, 0],
        distance_um: Some(1000.0 + exposure as f64 * 0.25),
        ..Sample::default()
    }
}

fn counts(readings: &[Reading]) -> Vec<u64> {
    readings.iter().map(|reading| reading.count.unwrap().raw.into()).collect()
}

fn assert_true(readings: &[Reading]) {
    for reading in readings.iter().filter(|reading| !reading.flags.contains(Flags::SUSPECT)) {
        let exposure = u64::from(reading.count.unwrap().raw);
        let truth = sample(exposure);
        let expected = [f64::from(truth.encoder[0]), truth.distance_um.unwrap() / 1000.0, 100.0];
        assert!(reading.values.iter().eq(expected.map(Some)), "{reading:?}");
    }
}

#[test]
fn a_scan_comes_through_whole() {
    let mut pair = Pair::measuring(Settings::default());
    assert_eq!(pair.device.trigger_mode(), TriggerMode::Each);
    pair.expose(0..200);
    pair.pass(Duration::from_secs(1));
    let readings = pair.take_readings();
    assert_eq!(counts(&readings), (0..200).collect::<Vec<_>>());
    assert!(readings.iter().all(|reading| reading.flags.is_empty()));
    assert_true(&readings);
    assert_eq!(pair.device.dropped(), 0);
}

#[test]
fn single_steps_are_released_by_the_silence_after_each() {
    let mut pair = Pair::measuring(Settings::default());
    for exposure in 0..5 {
        pair.device.trigger(sample(exposure));
        pair.settle();
        assert_eq!(pair.take_events(), []);
        pair.pass(Duration::from_millis(60));
        let readings = pair.take_readings();
        assert_eq!(counts(&readings), [exposure]);
        assert!(readings[0].flags.is_empty());
        assert_eq!(readings[0].host.as_nanos(), exposure * 60_000_000, "when it arrived");
        pair.pass(Duration::from_secs(0));
    }
}

#[test]
fn stop_and_start_lose_nothing_that_was_sent() {
    let mut pair = Pair::measuring(Settings::default());
    for round in 0..3 {
        let first = round * 10;
        pair.expose(first..first + 10);
        pair.driver.command(pair.now, Command::Stop);
        pair.settle();
        assert!(!pair.device.armed());
        assert_eq!(counts(&pair.take_readings()), (first..first + 10).collect::<Vec<_>>());
        pair.driver.command(pair.now, Command::Start);
        pair.settle();
        assert_eq!(pair.take_events(), [Event::Ready]);
    }
}

#[test]
fn a_device_found_streaming_in_ascii_is_set_up() {
    let mut pair = Pair::connected(Settings { trigger: Trigger::Free, ..Settings::default() });
    for exposure in 0..20 {
        pair.device.trigger(sample(exposure));
    }
    pair.driver.command(pair.now, Command::Start);
    pair.settle();
    let events = pair.take_events();
    assert!(matches!(events[..], [Event::Discarded { .. }, Event::Online, Event::Ready]));
    pair.expose(20..30);
    assert_eq!(counts(&pair.take_readings()), (20..29).collect::<Vec<_>>());
}

#[test]
fn faults_of_the_link_never_make_values() {
    let mut pair = Pair::measuring(Settings::default());
    let mut next = 0;
    for seed in 0..300 {
        pair.expose(next..next + 5);
        next += 5;
        match seed % 3 {
            0 => pair.device.inject(1 + (seed as usize * 37) % 3000, seed),
            1 => pair.device.corrupt_next(),
            _ => pair.device.drop_next(),
        }
        pair.expose(next..next + 5);
        next += 5;
    }
    pair.pass(Duration::from_secs(1));
    let readings = pair.take_readings();
    assert_true(&readings);
    let sound = readings.iter().filter(|reading| !reading.flags.contains(Flags::SUSPECT)).count();
    // Each fault may cost the telegram it hits and its neighbour.
    assert!(sound >= 3000 - 2 * 300, "{sound} of 3000");
}

#[test]
fn a_cable_that_was_pulled_costs_its_time_only() {
    let mut pair = Pair::measuring(Settings::default());
    pair.expose(0..10);
    pair.is_cut = true;
    pair.expose(10..110);
    pair.is_cut = false;
    pair.expose(110..120);
    pair.pass(Duration::from_secs(1));
    let readings = pair.take_readings();
    assert_true(&readings);
    assert_eq!(counts(&readings), (0..10).chain(110..120).collect::<Vec<_>>());
    assert!(readings.iter().all(|reading| reading.flags.is_empty()));
}

#[test]
fn a_dead_link_is_reopened_and_measures_again() {
    let mut pair = Pair::measuring(Settings::default());
    pair.is_cut = true;
    pair.driver.command(pair.now, Command::Stop);
    pair.pass(Duration::from_secs(3));
    let events = pair.take_events();
    let [Event::Reopen(fault)] = &events[..] else { panic!("{events:?}") };
    assert_eq!(fault.kind, FaultKind::Timeout);
    pair.driver.disconnected(pair.now);
    pair.is_cut = false;
    pair.device.restart();
    pair.driver.command(pair.now, Command::Start);
    pair.driver.connected(pair.now);
    pair.settle();
    assert_eq!(pair.take_events(), [Event::Online, Event::Ready]);
    pair.expose(0..3);
    pair.pass(Duration::from_secs(1));
    assert_eq!(counts(&pair.take_readings()), [0, 1, 2]);
}

#[test]
fn a_device_that_restarted_is_reopened() {
    let mut pair = Pair::measuring(Settings::default());
    pair.expose(0..10);
    pair.device.restart();
    // It streams in ASCII now.
    pair.expose(10..2000);
    let events = pair.take_events();
    let readings = events.iter().filter(|event| matches!(event, Event::Reading(_))).count();
    assert!((9..=10).contains(&readings), "{readings}");
    let faults: Vec<_> = events
        .iter()
        .filter_map(|event| match event {
            Event::Reopen(fault) => Some(fault.kind),
            _ => None,
        })
        .collect();
    assert_eq!(faults, [FaultKind::Protocol]);
}

#[test]
fn a_rate_the_device_cannot_do_is_refused() {
    let mut pair = Pair::connected(Settings { sample_rate_hz: 100_000.0, ..Settings::default() });
    pair.driver.command(pair.now, Command::Start);
    pair.settle();
    let events = pair.take_events();
    let [Event::Online, Event::Fault(fault)] = &events[..] else { panic!("{events:?}") };
    assert_eq!(fault.kind, FaultKind::Refused);
    assert!(fault.detail.starts_with("$SHZ 100000: "), "{}", fault.detail);
}

#[test]
fn integer_encodings_agree_with_the_device() {
    // Distance 1 as 16 bits of full scale / 2^15, as nm, and as 32 bits of full scale / 2^31.
    for (id, step_um) in [(16640, FULL_SCALE_UM / 32768.0), (33024, 1e-3), (49408, 1e-3)] {
        let signals = vec![75, id, 93, 64, 69];
        let mut pair = Pair::measuring(Settings { signals, ..Settings::default() });
        pair.expose(4200..4300);
        pair.pass(Duration::from_secs(1));
        let readings = pair.take_readings();
        assert_eq!(counts(&readings), (4200..4300).collect::<Vec<_>>());
        for (reading, exposure) in readings.iter().zip(4200..) {
            let truth_mm = sample(exposure).distance_um.unwrap() / 1000.0;
            let error_um = (reading.values.get(0).unwrap() - truth_mm).abs() * 1000.0;
            assert!(error_um <= step_um / 2.0 + 1e-9, "signal {id}: {error_um} µm");
            assert_eq!(reading.values.get(1), Some(25.0));
            assert_eq!(reading.device_time_ns, Some(exposure * 1_000_000), "beyond 2^32 ns");
        }
    }
}
