//! Replies of Zaber's documentation and of zproto, byte for byte, and faults, in virtual time.
//!
//! Sources: README.md, "What was tested".

use asphera_link::{Driver, Event, Fault, FaultKind, Flags, Input, Nanos, Output, Reading};
use asphera_zaber::FAMILY;
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

/// A stage on a table: virtual time, no link.
struct Bench {
    driver: Box<dyn Driver>,
    now: Nanos,
    sent: Vec<String>,
    events: Vec<Event>,
}

impl Bench {
    fn new(settings: &str) -> Bench {
        let settings = FAMILY.parse("stage", settings).expect("settings of a test are sound");
        let driver = settings.driver().expect("settings of a test are sound");
        let mut bench = Bench { driver, now: Nanos::ZERO, sent: Vec::new(), events: Vec::new() };
        bench.driver.connected(bench.now);
        bench.drain();
        bench
    }

    fn receive(&mut self, bytes: impl AsRef<[u8]>) {
        self.driver.receive(self.now, Input::Bytes(bytes.as_ref()));
        self.drain();
    }

    fn next_timeout(&mut self) {
        self.now = self.driver.poll_timeout().expect("the driver waits for something");
        self.driver.timeout(self.now);
        self.drain();
    }

    fn drain(&mut self) {
        while let Some(Output::Bytes(bytes)) = self.driver.poll_transmit() {
            self.sent.push(String::from_utf8(bytes).expect("the protocol is ASCII"));
        }
        self.events.extend(std::iter::from_fn(|| self.driver.poll_event()));
    }

    fn readings(&self) -> Vec<Reading> {
        let reading = |event: &Event| match event {
            Event::Reading(reading) => Some(reading.clone()),
            _ => None,
        };
        self.events.iter().filter_map(reading).collect()
    }

    fn faults(&self) -> Vec<&Fault> {
        let fault = |event: &'_ Event| matches!(event, Event::Fault(_) | Event::Reopen(_));
        self.events
            .iter()
            .filter(|event| fault(event))
            .map(|event| match event {
                Event::Fault(fault) | Event::Reopen(fault) => fault,
                _ => unreachable!("only faults are left"),
            })
            .collect()
    }

    fn discarded(&self) -> u64 {
        let bytes = |event: &Event| match event {
            Event::Discarded { bytes } => *bytes,
            _ => 0,
        };
        self.events.iter().map(bytes).sum()
    }
}

const STAGE: &str = "number = 1\naxis = [{ name = 'x', microstep_um = 0.15625 }]";
const TWO: &str =
    "axis = [{ name = 'x', microstep_um = 0.5 }, { name = 'phi', microstep_deg = 90 }]";

/// A stage that proved to be there and was asked for the first position.
fn stage() -> Bench {
    let mut bench = Bench::new(STAGE);
    bench.receive("@01 1 OK IDLE -- 0\r\n");
    bench
}

/// zproto, packet tests and documentation: `/1 3 get pos`; replies with BUSY, with a number of a message.
#[test]
fn positions_become_readings() {
    let mut bench = stage();
    assert_eq!(bench.sent, ["/1 1 get pos\n", "/1 1 get pos\n"]);
    for reply in
        ["@01 1 OK BUSY -- 12345\r\n", "@01 1 12 OK IDLE -- -64\r\n", "@01 1 OK IDLE NI 1.5\r\n"]
    {
        bench.receive(reply);
        bench.next_timeout();
    }
    let values: Vec<_> = bench.readings().iter().map(|reading| reading.values.get(0)).collect();
    let mm = |steps: f64| Some(steps * (0.15625 * 1e-3));
    assert_eq!(values, [mm(12_345.0), mm(-64.0), mm(1.5)]);
    assert!(bench.readings().iter().all(|reading| reading.flags.is_empty()));
    assert_eq!((bench.faults().len(), bench.discarded()), (0, 0));
}

/// A controller answers for all its axes at once; one position fewer or more is no reading.
#[test]
fn a_controller_has_a_position_for_each_axis() {
    let mut bench = Bench::new(TWO);
    bench.receive("@01 0 OK IDLE -- 20 1\r\n");
    assert_eq!(bench.sent, ["/1 0 get pos\n", "/1 0 get pos\n"]);
    bench.receive("@01 0 OK IDLE -- 20 1\r\n");
    let values: Vec<_> = bench.readings()[0].values.iter().map(Option::unwrap).collect();
    assert_eq!(values, [0.01, std::f64::consts::FRAC_PI_2]);
    bench.next_timeout();
    bench.receive("@01 0 OK IDLE -- 20\r\n@01 0 OK IDLE -- 20 1 7\r\n");
    assert_eq!(bench.readings().len(), 1);
    assert!(bench.faults()[0].detail.contains("does not match"));
}

/// zproto's check tests: FF is a fault, WH a warning, NI a notice; `zaber-motion` names them.
#[test]
fn warnings_that_spoil_a_position() {
    let mut bench = stage();
    for (letters, is_bad) in
        [("FF", true), ("WH", true), ("NI", false), ("WR", true), ("WT", false)]
    {
        bench.receive(format!("@01 1 OK IDLE {letters} 0\r\n"));
        let flags = bench.readings().last().expect("each reply is a reading").flags;
        assert_eq!(flags.contains(Flags::DEVICE_ERROR), is_bad, "{letters}");
        bench.next_timeout();
    }
    let details: Vec<&str> = bench.faults().iter().map(|fault| fault.detail.as_str()).collect();
    assert_eq!(
        details,
        [
            "the device reports warning `FF`: critical system error; see Zaber's manual, then home the stage",
            "the device reports warning `WR`: no reference position; home the stage, with home = true in [scan.plan] or with Zaber Launcher"
        ],
        "once a run"
    );
    bench.receive("@01 1 OK IDLE ZZ 0\r\n");
    assert_eq!(bench.readings()[5].flags, Flags::SUSPECT, "a flag nobody knows");
}

/// zproto: `RJ … BADCOMMAND`.
#[test]
fn a_rejected_question_is_reported() {
    let mut bench = stage();
    bench.receive("@01 1 12 RJ IDLE -- BADCOMMAND\r\n");
    assert_eq!(bench.faults()[0].kind, FaultKind::Refused);
    assert!(
        bench.faults()[0].detail.starts_with("the device answers `@01 1 12 RJ IDLE -- BADCOMMAND`")
    );
    assert!(bench.readings().is_empty());
}

/// Alerts, information and replies of other devices of the same line lie between; none of them is ours.
#[test]
fn other_messages_are_passed_by() {
    let mut bench = stage();
    bench.receive("!01 1 IDLE --\r\n#01 0 text\r\n@02 0 OK IDLE -- 2\r\n@01 1 OK IDLE -- 3\r\n");
    assert_eq!(bench.readings().len(), 1);
    assert!(bench.faults().is_empty());
}

/// Written and read by zproto 0.4.2: it sends `/1 1 get pos:AC` and accepts a reply with the check 52.
#[test]
fn checked_replies() {
    let mut bench = Bench::new(&format!("checksum = true\n{STAGE}"));
    assert_eq!(bench.sent, ["/1 1 get pos:AC\n"]);
    bench.receive("@01 1 OK IDLE -- 64:52\r\n");
    bench.receive("@01 1 OK IDLE -- 65:52\r\n");
    assert!(bench.readings().is_empty());
    assert!(bench.faults()[0].detail.contains("checksum"));
    bench.receive("@01 1 OK IDLE -- 64:52\r\n");
    assert_eq!(bench.readings()[0].values.get(0), Some(0.01));
}

#[test]
fn another_device_is_found_out() {
    let mut bench = Bench::new(STAGE);
    for _ in 0..2 {
        bench.receive("+01.2345\r\n");
        bench.next_timeout();
    }
    let Some(Event::Reopen(fault)) = bench.events.last() else { panic!("{:?}", bench.events) };
    assert!(fault.detail.contains("is answered by `+01.2345`"), "{}", fault.detail);
    assert!(bench.readings().is_empty());
}

/// Silence, half a reply, then the other half too late; at last a stage that was switched off and on.
#[test]
fn a_late_reply_and_a_restart() {
    let mut bench = stage();
    bench.receive("@01 1 OK IDLE -- 10");
    bench.next_timeout();
    assert_eq!(bench.faults()[0].kind, FaultKind::Timeout);
    bench.receive("00\r\n");
    let asked = bench.sent.len();
    while bench.sent.len() == asked {
        bench.next_timeout();
    }
    bench.receive("@01 1 OK IDLE WR 0\r\n");
    let reading = bench.readings()[0].clone();
    assert_eq!((reading.values.get(0), reading.flags), (Some(0.0), Flags::DEVICE_ERROR));
    while !bench.events.iter().any(|event| matches!(event, Event::Reopen(_))) {
        bench.next_timeout();
    }
    assert_eq!(bench.readings().len(), 1);
}

/// Events of replies with garbage lines between, cut at one byte.
fn run(replies: &[(i64, Vec<u8>)], cut: usize) -> Vec<Event> {
    let mut bench = stage();
    for (steps, garbage) in replies {
        let mut bytes = garbage.clone();
        bytes.extend(format!("\n@01 1 OK IDLE -- {steps}\r\n").bytes());
        let (first, second) = bytes.split_at(cut.min(bytes.len()));
        bench.receive(first);
        bench.receive(second);
        bench.next_timeout();
    }
    bench.events
}

fn values(events: &[Event]) -> Vec<Option<f64>> {
    let value = |event: &Event| match event {
        Event::Reading(reading) => Some(reading.values.get(0)),
        _ => None,
    };
    events.iter().filter_map(value).collect()
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    /// Garbage lines before a reply and a cut at any byte change no reading; every byte of garbage is counted.
    #[test]
    fn garbage_and_chunks_change_nothing(
        replies in proptest::collection::vec((-1_000_000_000i64..1_000_000_000, proptest::collection::vec(0x80u8.., 0..30)), 1..6),
        cut in 0usize..60,
    ) {
        let events = run(&replies, cut);
        let expected: Vec<_> = replies.iter().map(|(steps, _)| Some(*steps as f64 * (0.15625 * 1e-3))).collect();
        prop_assert_eq!(values(&events), expected);
        let garbage: u64 = replies.iter().map(|(_, garbage)| garbage.len() as u64).sum();
        let discarded: u64 = events.iter().map(|event| if let Event::Discarded { bytes } = event { *bytes } else { 0 }).sum();
        prop_assert_eq!(discarded, garbage);
    }

    #[test]
    fn garbage_is_no_reading(bytes: Vec<u8>) {
        let mut bench = Bench::new(STAGE);
        bench.receive(&bytes);
        prop_assert_eq!(bench.readings().len(), 0);
    }
}
