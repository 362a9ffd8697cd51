//! Laws that hold for any bytes.

use asphera_chrocodile::wire::packet::{Data, Format, HEADER_LEN, Header, Message};
use asphera_chrocodile::{PacketChrocodile, PacketSettings};
use asphera_link::{Command, Driver as _, Event, Input, Nanos, Output, Reading};
use proptest::prelude::*;

use crate::device::{answer, bytes_of, data, format, outcome, streaming};

const SIGNALS: [u16; 4] = [75, 76, 65, 256];

fn settings() -> PacketSettings {
    PacketSettings { signals: SIGNALS.to_vec(), ..PacketSettings::default() }
}

/// Values that follow from the sample alone; no flags.
fn value(sample: u32, id: u16, _: u16) -> f64 {
    match id {
        75 => f64::from(sample % 65_536),
        76 => 0.0,
        65 => f64::from(sample) - 1000.0,
        _ => 1.0 + f64::from(sample % 1024),
    }
}

/// Whether a reading says what the sample of its count says.
fn is_right(reading: &Reading) -> bool {
    let sample = reading.count.unwrap().raw;
    let expected = [Some(f64::from(sample) - 1000.0), Some(value(sample, 256, 0) / 1000.0)];
    reading.values.iter().eq(expected) && reading.flags.is_empty()
}

/// Readings and bytes passed over, the bytes cut at these lengths again and again.
fn decode(bytes: &[u8], cuts: &[usize]) -> (Vec<Reading>, u64) {
    let mut driver = streaming(settings(), &format(&SIGNALS, 1, 1));
    let mut waiting = bytes;
    for &cut in cuts.iter().cycle() {
        let (piece, after) = waiting.split_at(cut.min(waiting.len()));
        driver.receive(Nanos::from_millis(1), Input::Bytes(piece));
        waiting = after;
        if waiting.is_empty() {
            break;
        }
    }
    driver.disconnected(Nanos::from_millis(1));
    outcome(&mut driver)
}

/// Data, other formats, answers of nobody and noise in any order, and how many samples of the format there are.
fn stretches() -> impl Strategy<Value = (Vec<u8>, usize)> {
    let samples = (0_u32..60_000, 0_u32..9).prop_map(|(first, count)| {
        (data(&format(&SIGNALS, 1, 1), first..first + count, value), count as usize)
    });
    let unknown =
        (2_i32..9).prop_map(|counter| (data(&format(&SIGNALS, counter, 1), 0..2, value), 0));
    let other = (10_i32..20).prop_map(|counter| (bytes_of(&format(&[256], counter, 1)), 0));
    let noise = prop::collection::vec(any::<u8>(), 0..60).prop_map(|noise| (noise, 0));
    let begun = Just((vec![0x55, 0xAA, 0x55], 0));
    let stretch = prop_oneof![4 => samples, 1 => unknown, 1 => other, 2 => noise, 1 => begun];
    prop::collection::vec(stretch, 0..10).prop_map(|stretches| {
        let samples = stretches.iter().map(|(_, samples)| samples).sum();
        (stretches.into_iter().flat_map(|(bytes, _)| bytes).collect(), samples)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn cuts_change_nothing((bytes, _) in stretches(), cuts in prop::collection::vec(1_usize..40, 1..10)) {
        prop_assert_eq!(decode(&bytes, &cuts), decode(&bytes, &[usize::MAX]));
    }

    /// Noise between packets costs no sample and gives none.
    #[test]
    fn every_sample_comes_and_is_right((bytes, samples) in stretches()) {
        let (readings, discarded) = decode(&bytes, &[usize::MAX]);
        prop_assert_eq!(readings.len(), samples);
        prop_assert!(readings.iter().all(is_right));
        prop_assert!(discarded <= bytes.len() as u64);
    }

    #[test]
    fn random_bytes_give_nothing_and_are_counted(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        let _ = (Header::decode(&bytes), Message::decode(&bytes), Format::decode(&bytes));
        if let Ok(data) = Data::decode(&bytes) {
            for sample_len in 0..20 {
                let _ = data.split(sample_len).map(Iterator::count);
            }
        }
        prop_assert_eq!(decode(&bytes, &[usize::MAX]), (Vec::new(), bytes.len() as u64));
    }

    /// A byte of a packet has any value: no panic, and no more readings than the bytes hold.
    #[test]
    fn damaged_packets_hold_no_more_than_their_bytes(at in 0_usize..110, byte in any::<u8>()) {
        let mut bytes = bytes_of(&format(&SIGNALS, 1, 1));
        bytes.extend(data(&format(&SIGNALS, 1, 1), 0..3, value));
        if let Some(place) = bytes.get_mut(at) {
            *place = byte;
        }
        prop_assert!(decode(&bytes, &[usize::MAX]).0.len() <= 3);
    }

    #[test]
    fn any_calls_in_any_state_are_survived(
        steps in prop::collection::vec((0_u8..9, prop::collection::vec(any::<u8>(), 0..60)), 0..60),
    ) {
        let mut driver = PacketChrocodile::new(settings()).unwrap();
        let format = format(&SIGNALS, 1, 1);
        let (mut is_open, mut is_online) = (false, false);
        let mut now = Nanos::ZERO;
        for (step, bytes) in steps {
            now = now + std::time::Duration::from_millis(bytes.len() as u64);
            match step {
                0 if !is_open => { driver.connected(now); (is_open, is_online) = (true, false); }
                1 if is_open && bytes.len() > 50 => { driver.disconnected(now); is_open = false; }
                2 => driver.command(now, Command::Start),
                3 => driver.command(now, Command::Stop),
                4 if is_open => if let Some(due) = driver.poll_timeout() {
                    now = now.max(due);
                    driver.timeout(now);
                },
                5 if is_open => driver.receive(now, Input::Bytes(&bytes)),
                6 if is_open => driver.receive(now, Input::Bytes(&data(&format, 0..2, value))),
                _ if is_open => while let Some(Output::Bytes(sent)) = driver.poll_transmit() {
                    prop_assert!(sent.len() > HEADER_LEN);
                    driver.receive(now, Input::Bytes(&answer(&sent, &format)));
                },
                _ => {}
            }
            while let Some(event) = driver.poll_event() {
                match event {
                    Event::Online => {
                        prop_assert!(!is_online);
                        is_online = true;
                    }
                    Event::Reading(reading) => prop_assert!(is_online && is_right(&reading)),
                    _ => {}
                }
            }
        }
    }
}
