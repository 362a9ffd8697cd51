//! Rows of heights: whole line profiles, in lines and records.

#[expect(dead_code, reason = "each test file uses a part of it")]
mod common;

use asphera_described::FAMILY;
use asphera_link::{Event, FaultKind, Flags, Profile};
use common::Bench;
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

/// `n,encoder,z z z z` of a program that writes into a pipe.
const ROWS: &str = r#"
separator = ","
begins_whole = true
profile = { column = 3, points = 4, x_first_mm = -0.3, pitch_mm = 0.2, no_signal = ["nan"], valid_range_mm = [-5, 5] }
field = [
    { name = "n", column = 1, role = "count", modulus = 1000 },
    { name = "encoder", column = 2, unit = "count" },
]
"#;

fn profiles(bench: &Bench) -> Vec<Vec<Option<[f64; 2]>>> {
    let points = |reading: &asphera_link::Reading| {
        reading.values.profile().map(Profile::points_mm).unwrap_or_default().to_vec()
    };
    bench.readings().iter().map(points).collect()
}

fn heights(bench: &Bench) -> Vec<Vec<Option<f64>>> {
    let height = |point: &Option<[f64; 2]>| point.map(|[_, z_mm]| z_mm);
    profiles(bench).iter().map(|points| points.iter().map(height).collect()).collect()
}

#[test]
fn a_line_is_a_profile_with_its_encoder_and_count() {
    let mut bench = Bench::new(ROWS);
    bench.receive("0,-250,1.5,nan,-2.25,9.0\n1,-200,1,2,3,4\n");
    let first = bench.readings()[0].clone();
    assert_eq!((first.count.map(|count| count.raw), first.values.get(0)), (Some(0), Some(-250.0)));
    assert_eq!(first.flags, Flags::empty(), "a gap in a profile is no fault of the others");
    let points = first.values.profile().unwrap().points_mm();
    let expected = [Some([-0.3, 1.5]), None, Some([-0.3 + 0.2 * 2.0, -2.25]), None];
    assert_eq!(points, expected);
    assert_eq!(bench.readings().len(), 2, "the first line is whole");
    assert_eq!(bench.discarded(), 0);
}

/// A row that lost a separator would put all heights behind it at wrong places.
#[test]
fn rows_of_another_length_are_no_profile() {
    let mut bench = Bench::new(ROWS);
    bench.receive("0,0,1,2,34\n1,0,1,2,3,4,5\n2,0,1,2,3,4\n");
    assert_eq!(bench.readings().len(), 1);
    assert_eq!(bench.readings()[0].flags, Flags::SUSPECT, "behind lines that nobody understands");
    assert_eq!(bench.faults()[0].0, FaultKind::Protocol);
    assert!(bench.faults()[0].1.contains("has 5 columns, expected 6"), "{:?}", bench.faults());
    assert_eq!(bench.discarded(), "0,0,1,2,34".len() as u64 + "1,0,1,2,3,4,5".len() as u64);
    // A height that is neither number nor marker makes the whole row suspect.
    bench.receive("3,0,1,2,x,4\n");
    assert_eq!(heights(&bench)[1], [Some(1.0), Some(2.0), None, Some(4.0)]);
    assert_eq!(bench.readings()[1].flags, Flags::SUSPECT);
}

#[test]
fn half_a_profile_at_the_end_is_counted() {
    let mut bench = Bench::new(ROWS);
    bench.receive("0,0,1,2,3,4\n1,0,1,2,");
    bench.driver.disconnected(bench.now);
    bench.drain();
    assert_eq!((bench.readings().len(), bench.discarded()), (1, 8));
}

/// Keyence LJ-X8000, command PFRF of the non-procedural communication: count of points, then heights in mm with four
/// decimals; -99999.9999 stands for no height (2D manual, page 9-9).
#[test]
fn profiles_of_a_device_that_is_asked() {
    let mut bench = Bench::new(
        r#"
separator = ","
poll = { ask = 'PFRF,1,0,4\r' }
profile = { column = 3, x_mm = [-1.5, -0.5, 0.5, 2], no_value = -99999.9999 }
field = [{ name = "points", column = 2, unit = "count" }]
refusal = [{ pattern = 'ER,PFRF,03', means = "the head is not connected, or there is no profile" }]
"#,
    );
    let answer = "PFRF,4,-0.1234,-99999.9999,0.0000,12.5000\r";
    bench.receive(answer);
    bench.next_question();
    bench.receive(answer);
    let expected = [Some([-1.5, -0.1234]), None, Some([0.5, 0.0]), Some([2.0, 12.5])];
    assert_eq!(profiles(&bench), [expected]);
    bench.next_question();
    bench.receive("ER,PFRF,03\r");
    assert!(bench.faults()[0].1.ends_with("or there is no profile"), "{:?}", bench.faults());
}

/// 16 bits with the lowest byte first, as arrays of numbers lie in memory.
#[test]
fn a_record_is_a_profile_and_the_last_one_of_a_file_counts() {
    let mut bench = Bench::new(
        r#"
frame = "record"
length = 12
begin = '\xAA\x55'
profile = { at = 6, points = 3, pitch_mm = 1, form = "i16", order = "little", scale = 1e-3, no_value = -32768 }
field = [{ name = "encoder", at = 2, form = "i32", order = "little", unit = "count" }]
"#,
    );
    let record = |z: [i16; 3]| {
        let mut bytes = vec![0xAA, 0x55, 0xFE, 0xFF, 0xFF, 0xFF];
        bytes.extend(z.iter().flat_map(|z| z.to_le_bytes()));
        bytes
    };
    bench.receive(record([1000, -500, i16::MIN]));
    bench.receive(record([0, 1, 2]));
    assert_eq!(profiles(&bench), [[Some([0.0, 1.0]), Some([1.0, -0.5]), None]]);
    assert_eq!(bench.values(), [Some(-2.0)]);
    bench.driver.disconnected(bench.now);
    bench.drain();
    assert_eq!(heights(&bench)[1], [Some(0.0), Some(0.001), Some(0.002)]);
    assert_eq!(bench.discarded(), 0);

    // One that lost bytes is none.
    bench.driver.connected(bench.now);
    bench.receive(&record([0, 1, 2])[..11]);
    bench.driver.disconnected(bench.now);
    bench.drain();
    assert_eq!((bench.readings().len(), bench.discarded()), (2, 11));
}

#[test]
fn what_cannot_be_used_is_named() {
    let keys = |text: &str| -> Vec<String> {
        let problems = FAMILY.parse("settings", text).unwrap_err();
        problems.0.into_iter().map(|problem| problem.key).collect()
    };
    let even = "points = 4, pitch_mm = 1";
    for (text, expected) in [
        ("profile = { column = 1, points = 4 }".to_owned(), &["profile.pitch_mm"][..]),
        ("profile = { points = 4, pitch_mm = 1 }".to_owned(), &["profile.column"]),
        (
            format!("profile = {{ column = 1, {even}, x_mm = [1, 2] }}"),
            &["profile.pitch_mm", "profile.points"],
        ),
        (format!("profile = {{ column = 0, {even} }}"), &["profile.column"]),
        (format!("columns = 4\nprofile = {{ column = 2, {even} }}"), &["profile.column"]),
        (format!("profile = {{ at = 0, {even} }}"), &["profile.at"]),
        ("profile = { column = 1, points = 200, pitch_mm = 1 }".to_owned(), &["profile.points"]),
        (
            "profile = { column = 1, points = 1, pitch_mm = 0 }".to_owned(),
            &["profile.pitch_mm", "profile.points"],
        ),
        (format!("profile = {{ column = 1, {even}, scale = 0 }}"), &["profile.scale"]),
        (format!("profile = {{ column = 1, {even}, form = \"u8\" }}"), &["profile.form"]),
        (format!("pattern = '.*'\nprofile = {{ column = 1, {even} }}"), &["profile.column"]),
        (
            format!(
                "frame = \"record\"\nlength = 4\nbegin = 'AB'\nprofile = {{ at = 2, {even}, form = \"u8\" }}"
            ),
            &["profile.at"],
        ),
        (
            format!(
                "begins_whole = true\npoll = {{ ask = 'M' }}\nprofile = {{ column = 1, {even} }}"
            ),
            &["begins_whole"],
        ),
    ] {
        let mut found = keys(&text);
        found.sort();
        assert_eq!(found, expected, "{text}");
    }
    let settings = FAMILY.parse("settings", ROWS).unwrap();
    assert!(settings.measures_profiles());
    let alone = "profile = { column = 1, points = 4, pitch_mm = 1 }";
    assert_eq!(FAMILY.parse("settings", alone).unwrap().channels(), []);
}

fn config() -> ProptestConfig {
    let persistence = FileFailurePersistence::WithSource("regressions");
    ProptestConfig { failure_persistence: Some(Box::new(persistence)), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config())]

    /// However the bytes were cut, the same profiles come, and every byte that is in none is counted.
    #[test]
    fn chunks_change_nothing(
        rows in prop::collection::vec(
            prop_oneof![
                4 => prop::collection::vec(-4.0_f64..4.0, 4),
                1 => prop::collection::vec(-4.0_f64..4.0, 0..9),
            ],
            0..30,
        ),
        cuts in prop::collection::vec(1_usize..40, 1..40),
    ) {
        let line = |(n, row): (usize, &Vec<f64>)| {
            let heights: Vec<String> = row.iter().map(|z| format!("{z:.6}")).collect();
            format!("{n},{},{}\n", n * 10, heights.join(","))
        };
        let text: String = rows.iter().enumerate().map(line).collect();
        let mut whole = Bench::new(ROWS);
        whole.receive(&text);
        let mut cut = Bench::new(ROWS);
        let mut rest = text.as_bytes();
        let mut cuts = cuts.iter().cycle();
        while !rest.is_empty() {
            let (chunk, left) = rest.split_at(rest.len().min(*cuts.next().unwrap()));
            cut.receive(chunk);
            rest = left;
        }
        let readings = |bench: &Bench| -> Vec<Event> {
            let is_reading = |event: &&Event| matches!(event, Event::Reading(_));
            bench.events.iter().filter(is_reading).cloned().collect()
        };
        prop_assert_eq!(readings(&whole), readings(&cut));
        prop_assert_eq!(whole.discarded(), cut.discarded());
        prop_assert_eq!(whole.readings().len(), rows.iter().filter(|row| row.len() == 4).count());
    }

    /// Bytes of no device give no profile that is not flagged, but for rows that look like one.
    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let mut bench = Bench::new(ROWS);
        bench.receive(&bytes);
        bench.driver.disconnected(bench.now);
        bench.drain();
        prop_assert!(bench.discarded() <= bytes.len() as u64);
    }
}
