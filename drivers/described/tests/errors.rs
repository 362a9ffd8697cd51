//! A queue of errors that must be asked for, in virtual time.

#[expect(dead_code, reason = "each test file uses a part of it")]
mod common;

use asphera_link::{Command, Event, FaultKind};
use common::{Bench, driver};

const METER: &str = r#"
columns = 1
poll = { ask = 'M\n', interval_ms = 100, timeout_ms = 40, late_limit_ms = 60 }
hello = { ask = 'I\n', answer = 'ACME.*' }
errors = { ask = 'E\n', none = '0,.*', entry = '-?\d+,".*"', timeout_ms = 30, interval_ms = 1000 }
on_start = ['GO\n']
field = [{ name = 'z', column = 1, unit = 'mm', no_value = 9.91e37 }]
"#;

/// A meter that greeted and whose queue was empty.
fn meter() -> Bench {
    let mut bench = Bench::new(METER);
    bench.receive("ACME,1\n");
    bench.receive("0,\"No error\"\n");
    bench
}

#[test]
fn the_queue_is_read_to_its_end_before_the_first_question() {
    let mut bench = Bench::new(METER);
    bench.receive("ACME,1\n");
    bench.receive("-113,\"Undefined header\"\n");
    bench.receive("-222,\"Data out of range\"\n");
    bench.receive("0,\"No error\"\n");
    assert_eq!(bench.sent, ["I\\n", "E\\n", "E\\n", "E\\n", "M\\n"]);
    let details: Vec<String> = bench.faults().into_iter().map(|(_, detail)| detail).collect();
    assert_eq!(
        details,
        [
            "the device reports the error `-113,\"Undefined header\"`: see its manual",
            "the device reports the error `-222,\"Data out of range\"`: see its manual"
        ]
    );
    bench.receive("1.5\n");
    assert_eq!((bench.values(), bench.discarded()), (vec![Some(1.5)], 0));
}

/// The question comes at once, then at its times; the queue takes none of them.
#[test]
fn the_queue_is_read_again_between_two_questions() {
    let mut bench = meter();
    let mut sent = Vec::new();
    for _ in 0..21 {
        bench.receive("1\n");
        if bench.sent.last().is_some_and(|last| last == "E\\n") {
            sent.push(bench.now);
            bench.receive("0,\"No error\"\n");
        }
        bench.next_question();
    }
    assert_eq!(sent.iter().map(|at| at.as_nanos() / 1_000_000).collect::<Vec<_>>(), [1000, 2000]);
    assert_eq!(bench.readings().len(), 21, "no question was left out");
    assert_eq!(bench.now.as_nanos() / 1_000_000, 2100);
}

/// Agilent 86120C, programming guide page 3-26: without a measurement there is no answer, and an error is queued.
#[test]
fn a_question_without_an_answer_is_explained_by_the_queue() {
    let mut bench = meter();
    bench.next_timeout();
    assert_eq!(bench.sent.len(), 3, "silence first: an answer may be late");
    bench.next_question();
    assert_eq!(bench.sent.last().map(String::as_str), Some("E\\n"));
    bench.receive("-230,\"Data corrupt or stale\"\n0,\"No error\"\n");
    assert_eq!(bench.sent.len(), 5, "the second line came before it was asked for");
    assert_eq!(bench.discarded(), 13);
    bench.receive("0,\"No error\"\n");
    bench.next_question();
    bench.receive("2.5\n");
    assert_eq!(bench.values(), [Some(2.5)]);
    let kinds: Vec<FaultKind> = bench.faults().into_iter().map(|(kind, _)| kind).collect();
    assert_eq!(kinds, [FaultKind::Timeout, FaultKind::Device]);
}

#[test]
fn a_device_without_a_queue_measures_all_the_same() {
    let mut bench = Bench::new(METER);
    bench.receive("ACME,1\n");
    for _ in 0..30 {
        bench.next_question();
        if bench.sent.last().is_some_and(|last| last == "M\\n") {
            bench.receive("1\n");
        }
    }
    assert!(bench.readings().len() > 20, "{:?}", bench.sent);
    let expected =
        "no answer to `E\\n` within 30 ms; if the device has no queue of errors, do not ask for it";
    assert!(bench.faults().iter().all(|(_, detail)| detail == expected));
    assert!(!bench.events.iter().any(|event| matches!(event, Event::Reopen(_))));
}

#[test]
fn a_queue_without_an_end_does_not_stop_the_readings() {
    let mut bench = Bench::new(METER);
    bench.receive("ACME,1\n");
    for _ in 0..32 {
        bench.receive("-350,\"Queue overflow\"\n");
    }
    assert_eq!(bench.sent.last().map(String::as_str), Some("M\\n"));
    assert_eq!(bench.faults().len(), 33);
    assert!(bench.faults()[32].1.contains("more than 32 errors"));
}

#[test]
fn a_device_that_falls_silent_is_connected_anew_and_starts_afresh() {
    let mut bench = meter();
    bench.receive("1\n");
    while !bench.events.iter().any(|event| matches!(event, Event::Reopen(_))) {
        bench.next_timeout();
    }
    bench.receive("-113,\"Undefi");
    bench.driver.disconnected(bench.now);
    bench.sent.clear();
    bench.driver.connected(bench.now);
    bench.receive("ned header\"\n");
    bench.receive("ACME,1\n");
    bench.receive("0,\"No error\"\n");
    bench.receive("2\n");
    assert_eq!(bench.sent, ["I\\n", "E\\n", "M\\n"]);
    assert_eq!(bench.values(), [Some(1.0), Some(2.0)]);
    assert!(!bench.faults().iter().any(|(kind, _)| *kind == FaultKind::Device));
}

#[test]
fn what_is_said_at_the_start_is_checked_after_the_next_answer() {
    let mut bench = meter();
    bench.driver.command(bench.now, Command::Start);
    bench.receive("1\n");
    assert_eq!(bench.sent[3..], ["GO\\n", "E\\n"]);
    bench.receive("-200,\"Execution error\"\n");
    assert!(bench.faults()[0].1.contains("Execution error"));
}

#[test]
fn a_number_that_stands_for_none_is_a_gap() {
    let mut bench = meter();
    bench.receive("+9.91000000E+37\n");
    let reading = bench.readings()[0].clone();
    let names: Vec<_> = reading.flags.names().collect();
    assert_eq!((reading.values.get(0), names), (None, vec!["no_signal"]));
}

#[test]
fn a_queue_needs_a_greeting_and_a_question() {
    let alone = "errors = { ask = '', none = '0', entry = '1', interval_ms = 5 }\nfield = [{ name = 'z', column = 1 }]";
    let problems = driver(alone).err().expect("it cannot be used");
    let keys: Vec<_> = problems.0.iter().map(|problem| problem.key.as_str()).collect();
    assert_eq!(keys, ["errors.ask", "errors.interval_ms", "errors"]);
}
