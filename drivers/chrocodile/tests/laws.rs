//! What holds for every stream.

mod common;

use asphera_chrocodile::{Chrocodile, Settings};
use asphera_link::{Command, Driver, Event, Input, Nanos, Reading};
use common::{FULL_SCALE_UM, stream, streaming};
use proptest::prelude::*;

fn settings() -> Settings {
    Settings { scale_um: Some(FULL_SCALE_UM), ..Settings::default() }
}

/// Readings and bytes passed over, all received at one time.
fn decode(bytes: &[u8], cuts: &[usize]) -> (Vec<Reading>, u64) {
    let mut driver = streaming(settings());
    let mut rest = bytes;
    for &cut in cuts.iter().cycle().take(if cuts.is_empty() { 0 } else { bytes.len() }) {
        let (piece, after) = rest.split_at(cut.min(rest.len()));
        driver.receive(Nanos::from_millis(1), Input::Bytes(piece));
        rest = after;
    }
    driver.receive(Nanos::from_millis(1), Input::Bytes(rest));
    if let Some(due) = driver.poll_timeout() {
        driver.timeout(due);
    }
    outcome(&mut driver)
}

fn outcome(driver: &mut Chrocodile) -> (Vec<Reading>, u64) {
    let mut readings = Vec::new();
    let mut discarded = 0;
    while let Some(event) = driver.poll_event() {
        match event {
            Event::Reading(reading) => readings.push(reading),
            Event::Discarded { bytes } => discarded += bytes,
            _ => {}
        }
    }
    (readings, discarded)
}

/// Telegrams, noise and dialogue text in any order.
fn stretches() -> impl Strategy<Value = Vec<u8>> {
    let telegrams = (0_u64..70_000, 1_u64..5)
        .prop_map(|(first, count)| stream(&Settings::default().signals, first..first + count));
    let noise = prop::collection::vec(any::<u8>(), 0..40);
    let syncs = prop::collection::vec(Just(0xFF_u8), 0..5);
    let text = Just(b"$STO\rready\r\n".to_vec());
    let stretch = prop_oneof![4 => telegrams, 2 => noise, 1 => syncs, 1 => text];
    prop::collection::vec(stretch, 0..8).prop_map(|stretches| stretches.concat())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn cuts_change_nothing(bytes in stretches(), cuts in prop::collection::vec(1_usize..30, 1..10)) {
        prop_assert_eq!(decode(&bytes, &cuts), decode(&bytes, &[]));
    }

    #[test]
    fn every_byte_is_a_reading_or_counted(bytes in stretches()) {
        let (readings, discarded) = decode(&bytes, &[]);
        prop_assert!(readings.len() as u64 * 18 + discarded <= bytes.len() as u64);
        // What is left is shorter than what could still become telegrams.
        prop_assert!(readings.len() as u64 * 18 + discarded + 3 * 18 > bytes.len() as u64);
    }

    #[test]
    fn whole_streams_come_out_whole(first in 0_u64..200_000, count in 1_u64..50) {
        let bytes = stream(&Settings::default().signals, first..first + count);
        let (readings, discarded) = decode(&bytes, &[7, 1, 40]);
        prop_assert_eq!(discarded, 0);
        let counts: Vec<u64> =
            readings.iter().map(|reading| reading.count.unwrap().raw.into()).collect();
        prop_assert_eq!(counts, (first..first + count).map(|count| count % 65536).collect::<Vec<_>>());
        prop_assert!(readings.iter().all(|reading| reading.flags.is_empty()));
    }

    #[test]
    fn any_calls_in_any_state_are_survived(
        steps in prop::collection::vec((0_u8..8, prop::collection::vec(any::<u8>(), 0..60)), 0..60),
    ) {
        let mut driver = Chrocodile::new(settings()).unwrap();
        let mut is_open = false;
        let mut now = Nanos::ZERO;
        for (step, bytes) in steps {
            now = now + std::time::Duration::from_millis(bytes.len() as u64);
            match step {
                0 if !is_open => { driver.connected(now); is_open = true; }
                1 if is_open && bytes.len() > 50 => { driver.disconnected(now); is_open = false; }
                2 => driver.command(now, Command::Start),
                3 => driver.command(now, Command::Stop),
                4 if is_open => if let Some(due) = driver.poll_timeout() {
                    now = now.max(due);
                    driver.timeout(now);
                },
                5 if is_open => driver.receive(now, Input::Bytes(&bytes)),
                _ if is_open => while let Some(asphera_link::Output::Bytes(mut sent)) = driver.poll_transmit() {
                    sent.extend(b"ready\r\n");
                    driver.receive(now, Input::Bytes(&sent));
                },
                _ => {}
            }
            prop_assert!(driver.poll_timeout().is_none_or(|due| due >= Nanos::ZERO));
            while driver.poll_event().is_some() {}
        }
    }

    #[test]
    fn nothing_is_decoded_across_a_reconnect(old in stretches(), split in 0_usize..400) {
        let new = stream(&Settings::default().signals, 500..503);
        let mut driver = streaming(settings());
        driver.receive(Nanos::from_millis(1), Input::Bytes(&old[..split.min(old.len())]));
        driver.disconnected(Nanos::from_millis(2));
        driver.connected(Nanos::from_millis(3));
        while driver.poll_event().is_some() {}
        while let Some(asphera_link::Output::Bytes(mut answer)) = driver.poll_transmit() {
            answer.extend(b"ready\r\n");
            driver.receive(Nanos::from_millis(4), Input::Bytes(&answer));
        }
        driver.receive(Nanos::from_millis(5), Input::Bytes(&new));
        driver.timeout(driver.poll_timeout().unwrap());
        let (readings, discarded) = outcome(&mut driver);
        let counts: Vec<u32> = readings.iter().map(|reading| reading.count.unwrap().raw).collect();
        prop_assert_eq!((counts, discarded), (vec![500, 501, 502], 0));
    }
}
