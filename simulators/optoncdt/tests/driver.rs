//! What the simulated sensor sends is what the driver reads, and what the manual prints.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

use asphera_link::{Driver as _, Event, Flags, Input, Nanos, Reading};
use asphera_optoncdt::{Extra, Optoncdt, Series, Settings};
use asphera_sim_optoncdt::{Measurement, Sensor};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

fn settings(series: Series, extras: &[Extra]) -> Settings {
    let triggered = extras.contains(&Extra::Counter);
    Settings { series, range_mm: 10.0, extras: extras.to_vec(), triggered, silence_ms: 0 }
}

fn measurement(count: u64, distance_mm: Option<f64>) -> Measurement {
    Measurement { distance_mm, count, clock_ns: 1_230_000 * count }
}

/// Readings of the driver, and bytes that it passed over.
fn readings(settings: &Settings, bytes: &[u8]) -> (Vec<Reading>, u64) {
    let mut driver = Optoncdt::new(settings.clone()).unwrap();
    driver.connected(Nanos::ZERO);
    driver.receive(Nanos::ZERO, Input::Bytes(bytes));
    driver.disconnected(Nanos::ZERO);
    let (mut readings, mut discarded) = (Vec::new(), 0);
    while let Some(event) = driver.poll_event() {
        match event {
            Event::Reading(reading) => readings.push(reading),
            Event::Discarded { bytes } => discarded += bytes,
            _ => {}
        }
    }
    (readings, discarded)
}

/// 5 mm of an ILD1420-10 are the word 32760 (its manual, page 65), in the bits of page 84.
#[test]
fn a_block_is_that_of_the_manual() {
    let sensor = Sensor::new(&settings(Series::Plain, &[]));
    assert_eq!(sensor.block(measurement(0, Some(5.0))), [0b0011_1000, 0b0111_1111, 0b1000_0111]);
    // 262076: no peak. 262076 = 111111 111110 111100b, the lowest bits first.
    assert_eq!(sensor.block(measurement(0, None)), [0b0011_1100, 0b0111_1110, 0b1011_1111]);
    // ILD1700-10, page 58: 8184 is 5 mm.
    let sensor = Sensor::new(&settings(Series::Legacy, &[]));
    assert_eq!(sensor.block(measurement(0, Some(5.0))), [0b1011_1111, 0b0111_1000]);
}

#[test]
fn extras_are_read_with_their_block() {
    let extras = [
        Extra::Shutter,
        Extra::Counter,
        Extra::Timestamp,
        Extra::Intensity,
        Extra::State,
        Extra::RawDistance,
    ];
    let settings = settings(Series::Plain, &extras);
    let sensor = Sensor::new(&settings);
    // The counter begins again after 2^18.
    let counts = [262_142, 262_143, 262_144, 262_145];
    let blocks = counts.map(|count| sensor.block(measurement(count, Some(2.5)))).concat();
    let (found, discarded) = readings(&settings, &blocks);
    assert_eq!((found.len(), discarded), (4, 0));
    for (count, reading) in counts.iter().zip(&found) {
        assert_eq!(reading.flags, Flags::empty(), "{reading:?}");
        assert_eq!(reading.count.unwrap().raw, (count % 262_144) as u32);
        assert_eq!(reading.device_time_ns, Some(count * 1_230_000));
        assert_eq!(reading.values.get(0), sensor.shown_mm(2.5));
        let (exposure_s, percent) =
            (reading.values.get(1).unwrap(), reading.values.get(2).unwrap());
        assert!((exposure_s - 1e-4).abs() < 1e-12 && (percent - 60.0).abs() < 1e-3);
    }
}

/// Without a peak, and out of range, there is no value but a flag.
#[test]
fn errors_are_flags() {
    let settings = settings(Series::Plain, &[Extra::State]);
    let sensor = Sensor::new(&settings);
    let places = [None, Some(-1.0), Some(11.0), Some(5.0)];
    let blocks = places.map(|mm| sensor.block(measurement(0, mm))).concat();
    let (found, _) = readings(&settings, &blocks);
    let flags: Vec<Flags> = found.iter().map(|reading| reading.flags).collect();
    let outside = Flags::OUT_OF_RANGE;
    assert_eq!(flags, [Flags::NO_SIGNAL, outside, outside, Flags::empty()]);
    assert!(found[..3].iter().all(|reading| reading.values.get(0).is_none()));
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    /// Every distance within the range is read to half a step, whatever the series.
    #[test]
    fn distances_are_read_to_half_a_step(
        distances in proptest::collection::vec(0.02f64..9.98, 3..40),
        series in prop_oneof![
            Just(Series::Plain), Just(Series::Mastered), Just(Series::Wide), Just(Series::Legacy),
        ],
    ) {
        let settings = settings(series, &[]);
        let sensor = Sensor::new(&settings);
        let block = |mm: &f64| sensor.block(measurement(0, Some(*mm)));
        let blocks: Vec<u8> = distances.iter().flat_map(block).collect();
        let (found, discarded) = readings(&settings, &blocks);
        prop_assert_eq!((found.len(), discarded), (distances.len(), 0));
        let step_mm = if series == Series::Legacy { 10.2 / 16_368.0 } else { 10.2 / 65_520.0 };
        for (reading, mm) in found.iter().zip(&distances) {
            prop_assert_eq!(reading.values.get(0), sensor.shown_mm(*mm));
            prop_assert!((reading.values.get(0).unwrap() - mm).abs() <= 0.5001 * step_mm);
        }
    }
}
