//! Answers from manuals, byte for byte, and faults, in virtual time. Sources: README.md, "What was tested".

use asphera_link::{Driver, Event, Fault, FaultKind, Flags, Input, Nanos, Output, Reading};
use asphera_scpi::FAMILY;
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

/// An instrument on a table: virtual time, no link.
struct Bench {
    driver: Box<dyn Driver>,
    now: Nanos,
    sent: Vec<String>,
    events: Vec<Event>,
}

impl Bench {
    fn new(settings: &str) -> Bench {
        let settings = FAMILY.parse("meter", settings).expect("settings of a test are sound");
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
            self.sent.push(String::from_utf8(bytes).expect("SCPI is ASCII"));
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

    fn faults(&self) -> Vec<(FaultKind, &str)> {
        let fault = |event: &'_ Event| match event {
            Event::Fault(Fault { kind, .. }) | Event::Reopen(Fault { kind, .. }) => Some(*kind),
            _ => None,
        };
        let detail = |event: &'_ Event| matches!(event, Event::Fault(_) | Event::Reopen(_));
        let kinds = self.events.iter().filter_map(fault);
        let details = self.events.iter().filter(|event| detail(event)).map(|event| match event {
            Event::Fault(fault) | Event::Reopen(fault) => fault.detail.as_str(),
            _ => "",
        });
        kinds.zip(details).collect()
    }
}

const THERMOMETER: &str = "identity = 'FLUKE,1529,.*'\nquery = 'FETC? 1'\nterminator = 'cr'\ninterval_ms = 100\n\
    timeout_ms = 50\nlate_limit_ms = 100\nfield = [{ name = 't', unit = 'degC' }]";

/// A thermometer that proved to be there, and whose queue is empty.
fn thermometer() -> Bench {
    let mut bench = Bench::new(THERMOMETER);
    bench.receive("FLUKE,1529,A09002,1.0\r\n");
    bench.receive("0,\"No error\"\r\n");
    bench
}

/// Fluke 1529 manual, pages 87 and 113: `FETC? 1` is answered by `0.0000011`, an empty queue by `0,"No error"`.
#[test]
fn fluke_1529() {
    let mut bench = thermometer();
    assert_eq!(bench.sent, ["*IDN?\r", "SYST:ERR?\r", "FETC? 1\r"]);
    bench.receive("0.0000011\r\n");
    assert_eq!(bench.readings()[0].values.get(0), Some(0.000_001_1));
    assert!(bench.faults().is_empty());
}

/// Answer with `FORM:STAM ON` (Fluke 1529 manual, page 87): new, channel, value, unit, time and day.
#[test]
fn fluke_1529_with_a_time_stamp() {
    let mut bench = Bench::new(
        "identity = 'FLUKE,.*'\nquery = 'FETC? 2'\ncolumns = 10\nfield = [{ name = 'mv', column = 3 }, { name = 'new' }]",
    );
    bench.receive("FLUKE,1529,A09002,1.0\n");
    bench.receive("0,\"No error\"\n");
    bench.receive("1,2,0.0011,mV,14,5,35,2000,9,5\n");
    let values: Vec<_> = bench.readings()[0].values.iter().collect();
    assert_eq!(values, [Some(0.0011), Some(1.0)]);
}

/// Bristol 671 manual, page 34, and 871A manual, page 59.
#[test]
fn bristol_671() {
    let mut bench = Bench::new(
        "identity = 'BRISTOL WAVELENGTH METER, 671, .*'\nquery = ':READ:WAV?'\n\
         field = [{ name = 'wavelength', unit = 'mm', scale = 1e-6 }]",
    );
    bench.receive("BRISTOL WAVELENGTH METER, 671, 1135, 1.03\n");
    bench.receive("-104, \"Data type error\"\n");
    assert_eq!(
        bench.faults(),
        [(
            FaultKind::Device,
            "the device reports the error `-104, \"Data type error\"`: see its manual"
        )]
    );
}

/// Agilent E4418B programming guide, page 1-96: 9.91 E37 is no number; infinity is 9.9E+37.
#[test]
fn numbers_that_are_none() {
    for (answer, flags) in [
        ("9.91E37", Flags::NO_SIGNAL),
        ("+9.91000000E+37", Flags::NO_SIGNAL),
        ("9.9E+37", Flags::OUT_OF_RANGE),
        ("-9.90000000E+37", Flags::OUT_OF_RANGE),
    ] {
        let mut bench = thermometer();
        bench.receive(format!("{answer}\r\n"));
        let reading = bench.readings()[0].clone();
        assert_eq!((reading.values.get(0), reading.flags), (None, flags), "{answer}");
    }
}

#[test]
fn another_instrument_is_found_out() {
    let mut bench = Bench::new(THERMOMETER);
    bench.receive("FLUKE, 45, 1234567, 1.0 D1.0\r\n");
    bench.next_timeout();
    bench.receive("FLUKE, 45, 1234567, 1.0 D1.0\r\n");
    bench.next_timeout();
    let Some(Event::Reopen(fault)) = bench.events.last() else { panic!("{:?}", bench.events) };
    assert!(fault.detail.contains("`FLUKE, 45, 1234567, 1.0 D1.0`, expected `FLUKE,1529,.*`"));
    assert!(bench.readings().is_empty());
}

/// Silence, half an answer, then the other half too late: neither half is a reading.
#[test]
fn half_an_answer_and_a_late_one_are_no_readings() {
    let mut bench = thermometer();
    bench.receive("0.00");
    bench.next_timeout();
    assert_eq!(bench.faults()[0].0, FaultKind::Timeout);
    bench.receive("00011\r\n");
    let asked = bench.sent.len();
    while bench.sent.len() == asked {
        bench.next_timeout();
    }
    bench.receive("0,\"No error\"\r\n");
    while bench.sent.last().is_some_and(|last| last != "FETC? 1\r") {
        bench.next_timeout();
    }
    bench.receive("20.5\r\n");
    let values: Vec<_> = bench.readings().iter().map(|reading| reading.values.get(0)).collect();
    assert_eq!(values, [Some(20.5)]);
}

#[test]
fn an_instrument_that_is_silent_or_was_switched_off_and_on_is_greeted_anew() {
    let mut bench = thermometer();
    while !bench.events.iter().any(|event| matches!(event, Event::Reopen(_))) {
        bench.next_timeout();
    }
    bench.driver.disconnected(bench.now);
    bench.sent.clear();
    bench.driver.connected(bench.now);
    bench.receive("FLUKE,1529,A09002,1.0\r\n");
    bench.receive("0,\"No error\"\r\n");
    bench.receive("1.5\r\n");
    assert_eq!(bench.sent, ["*IDN?\r", "SYST:ERR?\r", "FETC? 1\r"]);
    assert_eq!(bench.readings().len(), 1);
}

/// Events of an instrument that sends so, cut there; each answer comes after a question.
fn run(answers: &[Vec<u8>], cut: usize) -> Vec<Event> {
    let mut bench = thermometer();
    for answer in answers {
        let (first, second) = answer.split_at(cut.min(answer.len()));
        bench.receive(first);
        bench.receive(second);
        while bench.sent.last().is_some_and(|last| last == "SYST:ERR?\r") {
            bench.receive("0,\"No error\"\r\n");
        }
        bench.next_timeout();
    }
    bench.events
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    /// Cut at any byte, answers give the same readings, one each.
    #[test]
    fn chunks_change_nothing(values in proptest::collection::vec(-1000.0f64..1000.0, 1..8), cut in 0usize..20) {
        let answers: Vec<Vec<u8>> = values.iter().map(|value| format!("{value:+.8E}\r\n").into_bytes()).collect();
        let whole = run(&answers, 0);
        prop_assert_eq!(whole.iter().filter(|event| matches!(event, Event::Reading(_))).count(), values.len());
        prop_assert_eq!(whole, run(&answers, cut));
    }

    /// Garbage never gives a reading before the instrument proved to be there.
    #[test]
    fn garbage_is_no_reading(bytes: Vec<u8>) {
        let mut bench = Bench::new(THERMOMETER);
        bench.receive(&bytes);
        prop_assert_eq!(bench.readings().len(), 0);
    }
}
