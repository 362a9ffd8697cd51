//! The sensor's stream, in virtual time.

use asphera_link::{Driver as _, Event, FaultKind, Flags, Input, Nanos, Reading};
use asphera_optoncdt::wire::{Word, encode_three, encode_two};
use asphera_optoncdt::{Extra, Optoncdt, Series, Settings};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

fn settings(extras: &[Extra]) -> Settings {
    Settings {
        series: Series::Plain,
        range_mm: 10.0,
        extras: extras.to_vec(),
        triggered: false,
        silence_ms: 0,
    }
}

/// A block: the first word, then the others.
fn block(words: &[u32]) -> Vec<u8> {
    let word =
        |(index, value): (usize, &u32)| encode_three(Word { value: *value, is_first: index == 0 });
    words.iter().enumerate().flat_map(word).collect()
}

fn run(settings: Settings, chunks: &[&[u8]]) -> Vec<Event> {
    let mut driver = Optoncdt::new(settings).expect("settings of a test are sound");
    driver.connected(Nanos::ZERO);
    for chunk in chunks {
        driver.receive(Nanos::from_millis(5), Input::Bytes(chunk));
    }
    driver.disconnected(Nanos::from_millis(9));
    std::iter::from_fn(|| driver.poll_event()).collect()
}

fn readings(events: &[Event]) -> Vec<Reading> {
    let reading = |event: &Event| match event {
        Event::Reading(reading) => Some(reading.clone()),
        _ => None,
    };
    events.iter().filter_map(reading).collect()
}

fn discarded(events: &[Event]) -> u64 {
    let bytes = |event: &Event| match event {
        Event::Discarded { bytes } => *bytes,
        _ => 0,
    };
    events.iter().map(bytes).sum()
}

/// ILD1420-10: 32760 is 5 mm (manual, page 65). Three blocks prove that it is there; none of them is lost.
#[test]
fn distances_become_readings() {
    let events = run(settings(&[]), &[&block(&[32_760]).repeat(4)]);
    assert_eq!(events[..2], [Event::Online, Event::Ready]);
    let values: Vec<_> = readings(&events).iter().map(|reading| reading.values.get(0)).collect();
    assert_eq!(values.len(), 4);
    assert!(values.iter().all(|mm| (mm.unwrap() - 5.0).abs() < 1e-12));
    assert_eq!((discarded(&events), readings(&events)[0].host), (0, Nanos::from_millis(5)));
}

#[test]
fn extras_are_taken_in_their_order() {
    let extras = [
        Extra::Timestamp,
        Extra::Shutter,
        Extra::Counter,
        Extra::Intensity,
        Extra::State,
        Extra::RawDistance,
    ];
    let words = [32_760, 0x1234, 2, 2500, 262_143, 65_472, 1 << 6, 77];
    let events = run(settings(&extras), &[&block(&words).repeat(3)]);
    let reading = readings(&events)[0].clone();
    assert_eq!(reading.device_time_ns, Some((2 * 65_536 + 0x1234) * 10_000));
    assert_eq!(reading.values.get(1), Some(2500.0 * 1e-7));
    assert_eq!(reading.values.get(2), Some(100.0));
    assert_eq!(reading.count.map(|count| (count.raw, count.modulus)), Some((262_143, 262_144)));
    assert_eq!(reading.flags, Flags::OUT_OF_RANGE);
}

#[test]
fn errors_are_gaps_with_their_reason_and_trouble_is_told_once() {
    let bytes: Vec<u8> = [262_076, 262_081, 262_082, 262_082, 32_760, 262_075]
        .iter()
        .flat_map(|w| block(&[*w]))
        .collect();
    let events = run(settings(&[]), &[&bytes]);
    let found: Vec<_> =
        readings(&events).iter().map(|r| (r.values.get(0).is_some(), r.flags)).collect();
    let (none, bad) = (Flags::NO_SIGNAL, Flags::DEVICE_ERROR);
    assert_eq!(
        found,
        [
            (false, none),
            (false, Flags::SATURATED),
            (false, none),
            (false, none),
            (true, Flags::empty()),
            (false, bad)
        ]
    );
    let told: Vec<_> = events
        .iter()
        .filter_map(|event| match event {
            Event::Fault(fault) => Some((fault.kind, fault.detail.as_str())),
            _ => None,
        })
        .collect();
    assert_eq!(told.len(), 2);
    assert_eq!(
        told[0],
        (
            FaultKind::Device,
            "the sensor reports: the laser is off: check its key switch and its input"
        )
    );
    assert!(told[1].1.contains("baud rate"));
}

#[test]
fn other_extras_than_described_are_found_out() {
    let more = run(settings(&[]), &[&block(&[32_760, 5]).repeat(30)]);
    let fewer = run(settings(&[Extra::Counter]), &[&block(&[32_760]).repeat(30)]);
    let detail = |events: &[Event]| {
        events.iter().find_map(|event| match event {
            Event::Fault(fault) => Some(fault.detail.clone()),
            _ => None,
        })
    };
    assert!(detail(&more).unwrap().contains("more words than the 1 described"));
    assert!(detail(&fewer).unwrap().contains("fewer words than the 2 described"));
    assert_eq!((readings(&fewer).len(), discarded(&fewer)), (0, 90));
    assert_eq!(
        (readings(&more).len(), discarded(&more)),
        (0, 180),
        "what does not fit is not believed"
    );
}

#[test]
fn a_lost_byte_costs_its_block() {
    let extras = [Extra::Counter];
    let bytes: Vec<u8> = (0..14).flat_map(|n| block(&[32_760, n])).collect();
    for lost in 18..10 * 6 {
        let events = run(settings(&extras), &[&bytes[..lost], &bytes[lost + 1..]]);
        let counts: Vec<_> = readings(&events).iter().map(|r| r.count.unwrap().raw).collect();
        let damaged = lost as u32 / 6;
        let expected: Vec<u32> = (0..14).filter(|n| *n != damaged).collect();
        assert_eq!((counts, discarded(&events)), (expected, 5), "byte {lost}");
        let readings = readings(&events);
        let flagged = readings.iter().filter(|reading| reading.flags == Flags::SUSPECT);
        let flagged: Vec<u32> = flagged.map(|reading| reading.count.unwrap().raw).collect();
        assert_eq!(flagged, [damaged - 1], "noise may begin before it shows");
    }
}

#[test]
fn a_legacy_sensor_has_words_of_two_bytes() {
    let settings = Settings { series: Series::Legacy, ..settings(&[]) };
    let bytes: Vec<u8> =
        [8184, 8184, 10_261, 16_374].iter().flat_map(|word| encode_two(*word)).collect();
    let events = run(settings, &[&bytes]);
    let found = readings(&events);
    assert!((found[2].values.get(0).unwrap() - 6.294).abs() < 5e-4);
    assert_eq!((found[3].values.get(0), found[3].flags), (None, Flags::OUT_OF_RANGE));
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    #[test]
    fn chunks_change_nothing(bytes: Vec<u8>, values in proptest::collection::vec(0u32..70_000, 0..20), cut in 0usize..300) {
        let extras = [Extra::Counter];
        let mut all: Vec<u8> = values.iter().flat_map(|value| block(&[*value, 1])).collect();
        all.extend(bytes);
        let cut = cut.min(all.len());
        let (whole, parts) = (run(settings(&extras), &[&all]), run(settings(&extras), &[&all[..cut], &all[cut..]]));
        prop_assert_eq!(readings(&whole), readings(&parts));
        prop_assert_eq!(discarded(&whole), discarded(&parts));
        prop_assert_eq!(readings(&whole).len() as u64 * 6 + discarded(&whole), all.len() as u64);
    }
}

/// Bytes that look like one block after a good one, and like one before it, are no good readings.
#[test]
fn blocks_beside_noise_are_flagged_or_discarded() {
    let good = block(&[32_760]).repeat(3);
    let events =
        run(settings(&[]), &[&good, &block(&[1000]), b"\x7F", &block(&[2000]), b"\x7F", &good]);
    let found: Vec<Flags> = readings(&events).iter().map(|reading| reading.flags).collect();
    let good = Flags::empty();
    assert_eq!(found, [good, good, good, Flags::SUSPECT, good, good, good]);
    assert_eq!(discarded(&events), 2 + 3);
}

#[test]
fn the_newest_block_waits_for_another_or_for_silence() {
    let mut driver = Optoncdt::new(settings(&[])).expect("settings of a test are sound");
    driver.connected(Nanos::ZERO);
    driver.receive(Nanos::from_millis(5), Input::Bytes(&block(&[32_760]).repeat(4)));
    let events: Vec<Event> = std::iter::from_fn(|| driver.poll_event()).collect();
    assert_eq!(readings(&events).len(), 3);
    assert_eq!(driver.poll_timeout(), Some(Nanos::from_millis(55)));
    driver.timeout(Nanos::from_millis(55));
    let events: Vec<Event> = std::iter::from_fn(|| driver.poll_event()).collect();
    assert_eq!((readings(&events).len(), readings(&events)[0].host), (1, Nanos::from_millis(5)));
    assert_eq!(driver.poll_timeout(), None, "a sensor that waits for triggers may be silent");
}

#[test]
fn a_sensor_that_falls_silent_is_connected_anew() {
    let watched = Settings { silence_ms: 200, ..settings(&[]) };
    let mut driver = Optoncdt::new(watched).expect("settings of a test are sound");
    driver.connected(Nanos::ZERO);
    assert_eq!(driver.poll_timeout(), None, "one that never spoke is told by its link");
    driver.receive(Nanos::from_millis(5), Input::Bytes(&block(&[32_760]).repeat(4)));
    driver.timeout(Nanos::from_millis(55));
    // Noise is no sign of life.
    driver.receive(Nanos::from_millis(150), Input::Bytes(b"\x7F"));
    assert_eq!(driver.poll_timeout(), Some(Nanos::from_millis(205)));
    driver.timeout(Nanos::from_millis(205));
    let last = std::iter::from_fn(|| driver.poll_event()).last();
    assert!(
        matches!(last, Some(Event::Reopen(fault)) if fault.detail.contains("for 200 ms: check"))
    );
    assert_eq!(driver.poll_timeout(), None);
}
