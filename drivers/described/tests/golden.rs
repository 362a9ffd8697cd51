//! Frames from manuals, byte for byte. Sources: README.md, "What was tested".

#[expect(dead_code, reason = "each test file uses a part of it")]
mod common;

use asphera_link::Flags;
use common::Bench;

/// A device that answers each question with these bytes, after one that proves it is there.
fn asked(settings: &str, answer: &str) -> Bench {
    let mut bench = Bench::new(settings);
    bench.receive(answer);
    bench.next_question();
    bench.receive(answer);
    bench
}

/// Panasonic HL-G1, command RMD: the manual reads this answer as -12.3456 mm.
#[test]
fn panasonic_hl_g1() {
    let bench = asked(
        r"
pattern = '%03\$RMD(?<mm>[+-]\d{7})\*\*'
poll = { ask = '%03#RMD**\r' }
[[field]]
name = 'distance'
group = 'mm'
unit = 'mm'
scale = 1e-4
",
        "%03$RMD-0123456**\r",
    );
    assert_eq!(bench.sent, [r"%03#RMD**\r", r"%03#RMD**\r"]);
    let [Some(mm)] = bench.values()[..] else { panic!("{:?}", bench.events) };
    assert!((mm + 12.3456).abs() < 1e-12);
}

/// Keyence LS-7000: value and judgement of output 1. LK-G: words in place of a value.
#[test]
fn keyence_ls_and_lk() {
    let bench = asked(
        r#"
separator = ","
columns = 3
poll = { ask = 'Mq,1\r' }
[[field]]
name = "diameter"
column = 2
unit = "mm"
no_signal = ["XXXXXXX"]
out_of_range = ["+FFFFFFF", "-FFFFFFF"]
[[field]]
name = "judgement"
column = 3
role = "status"
good = ["GO", "HI", "LO"]
"#,
        "Mq,+01.3450,HI\r",
    );
    assert_eq!(bench.values(), [Some(1.345)]);
    let table = r#"
separator = ","
columns = 2
poll = { ask = 'MAIN,1\r' }
[[field]]
name = "distance"
column = 2
unit = "mm"
no_signal = ["XXXXXXX"]
out_of_range = ["+FFFFFFF", "-FFFFFFF"]
[[refusal]]
pattern = 'ER,MAIN,22'
means = "there is no such output"
"#;
    assert_eq!(asked(table, "MAIN,+01.2345\r").values(), [Some(1.2345)]);
    let far = asked(table, "MAIN,-FFFFFFF\r").readings()[0].clone();
    assert_eq!((far.values.get(0), far.flags), (None, Flags::OUT_OF_RANGE));
    let refused = asked(table, "ER,MAIN,22\r");
    assert_eq!(refused.readings(), []);
    assert_eq!(refused.faults()[0].1, "the device answers `ER,MAIN,22`: there is no such output");
}

/// Magnescale MG80: two digits of the axis, state, value.
#[test]
fn magnescale_mg80() {
    let mut bench = Bench::new(
        r"
pattern = '(?<axis>\d\d)(?<state>[A-Z]{3})(?<mm>[+-]\d\d\.\d{4})'
field = [
    { name = 'position', group = 'mm', unit = 'mm' },
    { name = 'state', group = 'state', role = 'status', good = ['NMG'] },
]
",
    );
    bench.receive("G-09.9999\r\n00NMG-09.9999\r\n");
    assert_eq!(bench.values(), [Some(-9.9999)]);
    assert_eq!(bench.discarded(), 10, "half a line and its CR");
}

/// Mitutoyo SJ-210, RDSTU00: 000 idle, 001 measuring.
#[test]
fn mitutoyo_sj_210() {
    let table = r"
pattern = 'OK(?<state>\d{3})'
poll = { ask = 'RDSTU00\r' }
field = [{ name = 'state', group = 'state' }]
refusal = [{ pattern = 'NG\d{3}', means = 'see the error codes of the manual' }]
";
    assert_eq!(asked(table, "OK000\r").values(), [Some(0.0)]);
    assert_eq!(asked(table, "OK001\r").values(), [Some(1.0)]);
    assert!(asked(table, "NG012\r").faults()[0].1.contains("`NG012`: see the error codes"));
}

/// Mitutoyo SJ-210, RDRES: a result of 7 digits, right-justified; 3.123 µm is the manual's example. SJ-410: 8 digits.
#[test]
fn mitutoyo_sj_210_results() {
    let table = r"
pattern = 'OK(?<ra>[ +\-.\d]{7,8})'
poll = { ask = 'RDRES00,01,00\r' }
field = [{ name = 'ra', group = 'ra', unit = 'mm', scale = 1e-3 }]
refusal = [{ pattern = 'NG\d{3}', means = 'there is no result' }]
";
    for answer in ["OK  3.123\r", "OK   3.123\r", "OK003.123\r"] {
        let bench = asked(table, answer);
        assert_eq!(bench.sent, [r"RDRES00,01,00\r", r"RDRES00,01,00\r"]);
        assert_eq!(bench.values(), [Some(3.123 * 1e-3)], "{answer}");
    }
    let refused = asked(table, "NG005\r");
    assert_eq!(refused.readings(), []);
    assert_eq!(refused.faults()[0].1, "the device answers `NG005`: there is no result");
    // Half an answer is none.
    assert_eq!(asked(table, "OK  3.1\r").readings(), []);
}

/// RIFTEK RF60x: 02A5h of 16384 parts of 50 mm is 2.066 mm. The manual's number in a record of bytes.
#[test]
fn parts_of_a_range() {
    let mut bench = Bench::new(
        r#"
frame = "record"
length = 4
begin = '\xAA\x55'
field = [{ name = "z", at = 2, form = "u16", order = "little", unit = "mm", scale = 0.0030517578125 }]
"#,
    );
    bench.receive([0xAA, 0x55, 0xA5, 0x02, 0xAA, 0x55]);
    let [Some(mm)] = bench.values()[..] else { panic!("{:?}", bench.events) };
    assert!((mm - 2.066).abs() < 1e-3);
}
