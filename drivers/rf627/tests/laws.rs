//! Any bytes: no panic, no reading that the bytes do not hold, and every byte in a reading or counted.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

use asphera_link::{Driver as _, Event, Input, Nanos, Reading};
use asphera_rf627::wire::{Format, Header, Packet, RawPoint, ServiceHeader, encode};
use asphera_rf627::{Rf627, Settings};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

fn config() -> ProptestConfig {
    ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    }
}

fn header(measure: u32, interpolated: bool) -> Header {
    Header {
        format: if interpolated { Format::Interpolated } else { Format::Profile },
        serial: 7,
        time_ns: 1_000_000 * u64::from(measure),
        version: (1, 1),
        packet_count: measure,
        measure_count: measure,
        z_range_mm: 100,
        x_range_mm: 80,
        range_steps: 16_384,
        licence_hash: 0,
        exposure_ns: 1000,
        laser: 1,
        step_count: measure.wrapping_mul(3),
        direction: 1,
    }
}

fn datagram(measure: u32, points: &[RawPoint]) -> Vec<u8> {
    let mut bytes = Vec::new();
    encode(&header(measure, false), points, None, &mut bytes).unwrap();
    bytes
}

fn points() -> impl Strategy<Value = Vec<RawPoint>> {
    prop::collection::vec((any::<i16>(), any::<u16>()).prop_map(|(x, z)| RawPoint { x, z }), 0..50)
}

/// Readings and discarded bytes of datagrams that come one after the other.
fn run(datagrams: &[Vec<u8>]) -> (Vec<Reading>, u64) {
    let mut driver = Rf627::new(Settings { reorder_ms: 5, ..Settings::default() }).unwrap();
    let mut now = Nanos::ZERO;
    driver.connected(now);
    let (mut readings, mut discarded) = (Vec::new(), 0);
    let mut drain = |driver: &mut Rf627| {
        while let Some(event) = driver.poll_event() {
            match event {
                Event::Reading(reading) => readings.push(reading),
                Event::Discarded { bytes } => discarded += bytes,
                _ => {}
            }
        }
    };
    for datagram in datagrams {
        now = now + std::time::Duration::from_millis(1);
        while let Some(due) = driver.poll_timeout().filter(|due| *due <= now) {
            driver.timeout(due);
        }
        driver.receive(now, Input::Bytes(datagram));
        drain(&mut driver);
    }
    driver.disconnected(now);
    drain(&mut driver);
    assert_eq!(driver.tally().discarded_bytes, discarded);
    assert_eq!(driver.tally().readings, readings.len() as u64);
    (readings, discarded)
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn bytes_of_anything_are_counted(datagrams in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..200), 0..20)) {
        let sent: usize = datagrams.iter().map(Vec::len).sum();
        for datagram in &datagrams {
            let _ = ServiceHeader::decode(datagram);
        }
        let (readings, discarded) = run(&datagrams);
        // A random datagram that is a profile is too improbable to be met.
        prop_assert_eq!((readings.len(), discarded), (0, sent as u64));
    }

    /// A byte anywhere has any value: what is read still lies in the datagram.
    #[test]
    fn damaged_profiles_hold_no_more_than_their_bytes(points in points(), at in 0_usize..64, byte in any::<u8>()) {
        let mut bytes = datagram(3, &points);
        bytes[at] = byte;
        if let Ok(packet) = Packet::decode(&bytes) {
            prop_assert!(packet.len() * 4 + packet.trailing() <= bytes.len());
            prop_assert_eq!(packet.points_mm().count(), packet.len());
        }
    }

    #[test]
    fn a_cut_datagram_is_discarded_whole(points in points(), cut in 1_usize..300) {
        let mut bytes = datagram(3, &points);
        bytes.truncate(bytes.len().saturating_sub(cut));
        let len = bytes.len() as u64;
        let (readings, discarded) = run(&[bytes]);
        prop_assert_eq!((readings.len(), discarded), (0, len));
    }

    #[test]
    fn profiles_survive_their_bytes(points in points(), interpolated in any::<bool>(), measure in any::<u32>()) {
        let header = header(measure, interpolated);
        let mut bytes = Vec::new();
        encode(&header, &points, None, &mut bytes).unwrap();
        let packet = Packet::decode(&bytes).unwrap();
        prop_assert_eq!(packet.header, header);
        prop_assert_eq!(packet.raw_points().collect::<Vec<_>>(), points);
    }

    /// Datagrams that overtake each other by a few places give the readings of those in order.
    #[test]
    fn an_order_that_is_slightly_wrong_changes_nothing(swaps in prop::collection::vec(1_usize..38, 0..10)) {
        let sorted: Vec<Vec<u8>> = (0..40).map(|n| datagram(n, &[RawPoint { x: 1, z: 1 }])).collect();
        let mut order: Vec<usize> = (0..40).collect();
        let mut taken = [false; 40];
        for at in swaps {
            if !taken[at] && !taken[at + 1] {
                order.swap(at, at + 1);
                (taken[at], taken[at + 1]) = (true, true);
            }
        }
        let mixed: Vec<Vec<u8>> = order.iter().map(|at| sorted[*at].clone()).collect();
        let without_time = |(readings, discarded): (Vec<Reading>, u64)| {
            let at_zero = |reading| Reading { host: Nanos::ZERO, ..reading };
            (readings.into_iter().map(at_zero).collect::<Vec<_>>(), discarded)
        };
        prop_assert_eq!(without_time(run(&mixed)), without_time(run(&sorted)));
    }

    /// Each profile that came is in one reading, whatever was lost.
    #[test]
    fn losses_cost_only_themselves(lost in prop::collection::btree_set(0_u32..60, 0..30)) {
        let came: Vec<u32> = (0..60).filter(|n| !lost.contains(n)).collect();
        let datagrams: Vec<_> = came.iter().map(|n| datagram(*n, &[RawPoint { x: 1, z: 1 }])).collect();
        let (readings, discarded) = run(&datagrams);
        let counts: Vec<u32> = readings.iter().map(|reading| reading.count.unwrap().raw).collect();
        prop_assert_eq!((counts, discarded), (came, 0));
    }
}
