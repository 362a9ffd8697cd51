//! Proposed settings read what they were made of.

#[expect(dead_code, reason = "each test file uses a part of it")]
mod common;

use asphera_described::FAMILY;
use asphera_link::{Capture, Flags, Proposal, Reading};
use common::Bench;

fn propose(bytes: &[u8]) -> Proposal {
    let capture = Capture { received: bytes.to_vec(), asked: None };
    (FAMILY.propose.expect("it proposes settings"))(&capture)
}

/// Proposed settings, and what they make of the bytes they were proposed for.
fn proposed(bytes: impl AsRef<[u8]>) -> (String, Vec<Reading>, Vec<String>) {
    let proposal = propose(bytes.as_ref());
    let text = proposal.settings.unwrap_or_else(|| panic!("{:?}", proposal.remarks));
    let mut bench = Bench::new(&text);
    bench.receive(bytes.as_ref());
    if bench.driver.poll_timeout().is_some() {
        bench.next_timeout();
    }
    (text, bench.readings(), proposal.remarks)
}

fn first(readings: &[Reading]) -> Vec<Option<f64>> {
    readings.iter().map(|reading| reading.values.get(0)).collect()
}

#[test]
fn numbers_alone() {
    let (text, readings, remarks) = proposed("5\r\n1.5\r\n-2.25\r\n3.0\r\n");
    assert_eq!(first(&readings), [Some(1.5), Some(-2.25), Some(3.0)], "{text}");
    assert!(
        remarks.iter().any(|remark| remark.contains("the device sends no unit")),
        "{remarks:?}"
    );
}

#[test]
fn units_beside_numbers_are_obeyed() {
    let (text, readings, _) =
        proposed("\n+1.500 um LO\n+1.750 um OK\n+2.000 um OK\n+1.000 um OK\n");
    assert!(text.contains("unit = \"mm\"") && text.contains("scale = 0.001"), "{text}");
    let values: Vec<_> = first(&readings).into_iter().flatten().collect();
    for (value, mm) in values.iter().zip([1.5e-3, 1.75e-3, 2e-3, 1e-3]) {
        assert!((value - mm).abs() < 1e-15);
    }
    let flags: Vec<_> = readings.iter().map(|reading| reading.flags).collect();
    assert_eq!(flags, [Flags::SUSPECT, Flags::empty(), Flags::empty(), Flags::empty()], "{text}");
}

#[test]
fn decimal_commas_counters_and_words() {
    let lines = ["\n97;1,25\n98;-,---\n99;1,5\n", "1;1,75\n2;2,0\n3;-0,5\n"].concat();
    let (text, readings, remarks) = proposed(&lines);
    assert_eq!(
        first(&readings),
        [Some(1.25), None, Some(1.5), Some(1.75), Some(2.0), Some(-0.5)],
        "{text}"
    );
    assert_eq!(readings[1].flags, Flags::NO_SIGNAL);
    let counts: Vec<_> = readings.iter().filter_map(|reading| reading.count).collect();
    assert_eq!((counts.len(), counts[0].first, counts[0].modulus), (6, 1, 99), "{remarks:?}");
}

/// The answer of a Magnescale MG80, of its manual's width.
#[test]
fn numbers_within_text() {
    let lines = "\r\n00NMG-09.9999\r\n00NMG-09.9998\r\n00NMG+00.0012\r\n";
    let (text, readings, _) = proposed(lines);
    assert_eq!(first(&readings), [Some(-9.9999), Some(-9.9998), Some(0.0012)], "{text}");
    let mut bench = Bench::new(&text);
    bench.receive("\r\n00NMG-9.9999\r\n");
    assert_eq!(bench.readings(), [], "a digit is missing");
}

/// GGA sentences of NMEA 0183: the check is found and obeyed.
#[test]
fn checks_are_found() {
    let sentence = |time: &str, check: &str| {
        format!("$GPGGA,{time},4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*{check}\r\n")
    };
    let lines =
        [sentence("123519", "47"), sentence("123518", "46"), sentence("123517", "49")].concat();
    let (text, readings, _) = proposed(format!("\r\n{lines}"));
    assert!(
        text.contains("kind = \"xor8\", form = \"hex\", skip_first = 1, skip_last = 1"),
        "{text}"
    );
    assert_eq!(readings.len(), 3);
}

#[test]
fn records_with_a_check() {
    let record = |value: i16| {
        let [high, low] = value.to_be_bytes();
        let mut record = vec![0x02, 0x01, 0x64, 0x06, high, low];
        record.push(record.iter().fold(0u8, |sum, byte| sum.wrapping_add(*byte)));
        record
    };
    let values: Vec<i16> = (0..40).map(|step| step * 97 - 1500).collect();
    let bytes: Vec<u8> =
        [0x06, 0x00].into_iter().chain(values.iter().flat_map(|value| record(*value))).collect();
    let (text, readings, _) = proposed(&bytes);
    assert!(text.contains("kind = \"sum8\"") && text.contains("length = 7"), "{text}");
    let expected: Vec<_> = values.iter().map(|value| Some(f64::from(*value))).collect();
    assert_eq!(first(&readings), expected, "{text}");
}

#[test]
fn records_with_a_beginning_alone() {
    let mut bytes = vec![9, 9];
    for step in 0..30_i32 {
        bytes.extend([0xAA, 0x55]);
        bytes.extend((step * 70_001 - 900_000).to_le_bytes());
    }
    let (text, readings, _) = proposed(&bytes);
    assert!(text.contains(r"begin = '\xAAU'") && text.contains("order = \"little\""), "{text}");
    assert_eq!(first(&readings)[29], Some(f64::from(29 * 70_001 - 900_000)), "{text}");
}

#[test]
fn what_cannot_be_described_is_said() {
    let remark = |bytes: &[u8]| {
        let proposal = propose(bytes);
        assert_eq!(proposal.settings, None);
        proposal.remarks.last().cloned().unwrap_or_default()
    };
    assert!(remark(b"").contains("needs its question"));
    assert!(remark(b"12.5\r\n").contains("Listen longer"));
    assert!(remark(b"\nready\nok\nready\nok\n").contains("no number"));
    let noise: Vec<u8> = (0..500u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    assert!(remark(&noise).contains("baud rate"));
}

/// A device that was asked is asked by the proposed settings, too; its answers are whole from the first on.
#[test]
fn questions_become_polls() {
    let received = b"MAIN,+01.2345\rMAIN,+01.2350\rMAIN,+01.2355\r".to_vec();
    let capture = Capture { received, asked: Some((b"MAIN,1\r".to_vec(), 250)) };
    let text = (FAMILY.propose.unwrap())(&capture).settings.unwrap();
    let mut bench = Bench::new(&text);
    bench.receive("MAIN,+01.2345\r");
    bench.next_question();
    bench.receive("MAIN,+01.2350\r");
    assert_eq!((bench.values(), &bench.sent[0][..]), (vec![Some(1.235)], "MAIN,1\\r"));
    assert!(text.contains("interval_ms = 250"), "{text}");
}

/// Texts of digits and points that are no numbers were a state alone, and settings without a reading cannot be used.
#[test]
fn nothing_is_proposed_without_a_reading() {
    let lines = "0\r\n00NMG-09.9058339058.08\r\n00NMG+00.001999\r\n00NMG-09.9058339058.08\r\n";
    let proposal = propose(lines.as_bytes());
    assert_eq!(proposal.settings, None);
    assert_eq!(proposal.remarks[1..], ["they have no number at the same place"]);
}
