//! What the simulated sensor says is what the manuals print, and what the driver reads.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

use std::time::Duration;

use asphera_link::{Driver as _, Event, Input, Nanos, Output, Reading};
use asphera_riftek::{Mode, Riftek, Settings};
use asphera_sim_riftek::Sensor;
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

fn settings(mode: Mode) -> Settings {
    let (timeout_ms, late_limit_ms) = (40, 60);
    Settings { address: 1, mode, range_mm: 50, serial: None, timeout_ms, late_limit_ms }
}

const STREAM: Mode = Mode::Stream { silence_ms: 500 };

/// Requests and answers of the RF602 manual, pages 16 and 17.
#[test]
fn answers_are_those_of_the_manual() {
    let mut sensor = Sensor::new(&settings(STREAM));
    let identity = [
        0x9F, 0x93, 0x90, 0x99, 0x91, 0x92, 0x93, 0x94, 0x90, 0x95, 0x90, 0x90, 0x92, 0x93, 0x90,
        0x90,
    ];
    assert_eq!(sensor.receive(&[0x01, 0x81]), identity);
    sensor.measure(Some(1.0));
    assert_eq!(sensor.receive(&[0x01, 0x86]).len(), 4, "answer 2");
    sensor.measure(Some(2.066));
    assert_eq!(sensor.receive(&[0x01, 0x86]), [0xF5, 0xFA, 0xF2, 0xF0]);
    // The same result again: SB is 0, and answers count on.
    assert_eq!(sensor.receive(&[0x01, 0x86]), [0x85, 0x8A, 0x82, 0x80]);
    assert!(sensor.receive(&[0x02, 0x86]).is_empty(), "another address");
}

#[test]
fn a_stream_ends_with_any_request() {
    let mut sensor = Sensor::new(&settings(STREAM));
    assert_eq!(sensor.stream(), None);
    assert!(sensor.receive(&[0x01, 0x87]).is_empty() && sensor.is_streaming());
    assert!(sensor.stream().is_some());
    assert!(sensor.receive(&[0x01]).is_empty() && sensor.is_streaming(), "half a request");
    sensor.disconnected();
    assert!(sensor.receive(&[0x81]).is_empty() && sensor.is_streaming(), "its other half is lost");
    assert!(!sensor.receive(&[0x00, 0x81]).is_empty() && !sensor.is_streaming());
}

/// A driver and a sensor, joined without a line between.
struct Pair {
    driver: Riftek,
    sensor: Sensor,
    now: Nanos,
    readings: Vec<Reading>,
    discarded: u64,
}

impl Pair {
    fn new(settings: Settings) -> Pair {
        let sensor = Sensor::new(&settings);
        let driver = Riftek::new(settings).unwrap();
        let mut pair =
            Pair { driver, sensor, now: Nanos::ZERO, readings: Vec::new(), discarded: 0 };
        pair.driver.connected(pair.now);
        pair.exchange();
        pair
    }

    fn exchange(&mut self) {
        while let Some(Output::Bytes(bytes)) = self.driver.poll_transmit() {
            let answer = self.sensor.receive(&bytes);
            self.driver.receive(self.now, Input::Bytes(&answer));
        }
        while let Some(event) = self.driver.poll_event() {
            match event {
                Event::Reading(reading) => self.readings.push(reading),
                Event::Discarded { bytes } => self.discarded += bytes,
                _ => {}
            }
        }
    }

    fn pass(&mut self, time: Duration) {
        let until = self.now + time;
        while let Some(due) = self.driver.poll_timeout().filter(|due| *due <= until) {
            self.now = self.now.max(due);
            self.driver.timeout(self.now);
            self.exchange();
        }
        self.now = until;
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    /// Each measured distance is one reading to half a step, and results sent twice are none.
    #[test]
    fn a_stream_is_read(distances in proptest::collection::vec(0.01f64..49.9, 1..60)) {
        let mut pair = Pair::new(settings(STREAM));
        pair.pass(Duration::from_millis(60));
        prop_assert!(pair.sensor.is_streaming());
        for mm in &distances {
            pair.sensor.measure(Some(*mm));
            for _ in 0..2 {
                let bytes = pair.sensor.stream().unwrap();
                pair.driver.receive(pair.now, Input::Bytes(&bytes));
                pair.exchange();
            }
        }
        pair.pass(Duration::from_millis(30));
        prop_assert_eq!((pair.readings.len(), pair.discarded), (distances.len(), 0));
        for (reading, mm) in pair.readings.iter().zip(&distances) {
            prop_assert!(reading.flags.is_empty());
            prop_assert!((reading.values.get(0).unwrap() - mm).abs() <= 0.5001 * 50.0 / 16_384.0);
        }
    }
}

/// A sensor that is asked gives a reading for each new measurement.
#[test]
fn questions_are_answered() {
    let mut pair = Pair::new(settings(Mode::Poll { interval_ms: 100 }));
    for n in 0..5 {
        pair.sensor.measure(Some(f64::from(n) + 1.0));
        pair.pass(Duration::from_millis(100));
    }
    pair.pass(Duration::from_millis(30));
    assert!((4..=5).contains(&pair.readings.len()) && pair.discarded == 0, "{:?}", pair.readings);
}
