//! RIFTEK RF60x: streaming by itself, or asked for each result.

use std::time::Duration;

use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{Driver, Flags, Nanos, Output};
use asphera_riftek::wire::encode_answer;
use asphera_riftek::{Mode, Riftek as Sensor, Settings};

pub(crate) struct Riftek {
    pub(crate) is_stream: bool,
}

impl Bench for Riftek {
    fn name(&self) -> &'static str {
        if self.is_stream { "riftek, stream" } else { "riftek, asked" }
    }

    fn driver(&self) -> Box<dyn Driver> {
        let mode = match self.is_stream {
            true => Mode::Stream { silence_ms: 500 },
            false => Mode::Poll { interval_ms: 50 },
        };
        let settings = Settings {
            address: 1,
            mode,
            range_mm: 50,
            serial: None,
            timeout_ms: 100,
            late_limit_ms: 200,
        };
        Box::new(Sensor::new(settings).expect("settings of a test are sound"))
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Rf60x {
            range_mm: if model == Model::Right { 50 } else { 100 },
            is_streaming: false,
            answers: 0,
            measured: 0,
            condition: Condition::Good,
        })
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::Absent;
        match fault {
            Fault::BadChecksum => Absent("the protocol has no checksum"),
            Fault::Saturated => Absent("the protocol has no word for it"),
            Fault::BusOff => Absent("it is on no bus"),
            Fault::Stall | Fault::Limit => Absent("it moves nothing"),
            Fault::OutOfRange => Expectation::Marks(&[Mark::Flagged(Flags::OUT_OF_RANGE)]),
            Fault::WrongDevice => Expectation::Marks(&[Mark::Reopened(
                "range of 100 mm, expected 50 mm: set range_mm",
            )]),
            _ if self.is_stream => stream(fault),
            _ => asked(fault),
        }
    }
}

const GREETING: Mark = Mark::Reopened("address 1 does not say who it is within 100 ms");

fn stream(fault: Fault) -> Expectation {
    use Expectation::{Absent, Marks};
    match fault {
        Fault::LateAnswer => Absent("it sends by itself"),
        Fault::Unplugged => Marks(&[Mark::Discarded]),
        Fault::Silent => {
            Marks(&[Mark::Reopened("no result of the stream for 500 ms: check cable"), GREETING])
        }
        Fault::HalfFrame => Marks(&[
            Mark::Flagged(Flags::SUSPECT),
            Mark::Discarded,
            Mark::Fault("1 or more results of the stream were lost on the line: check cable"),
        ]),
        Fault::Garbage => Marks(&[
            Mark::Flagged(Flags::SUSPECT),
            Mark::Discarded,
            Mark::Fault("more results of the stream were lost on the line: check cable"),
            Mark::Reopened("a stream goes on after it was stopped: check that no other program"),
            Mark::Reopened("results of the stream have more than 2 bytes, or come twice"),
        ]),
        // Nothing tells it from a longer answer.
        Fault::Repeated => Marks(&[
            Mark::Flagged(Flags::SUSPECT),
            Mark::Discarded,
            Mark::Reopened("results of the stream have more than 2 bytes, or come twice: check"),
        ]),
        Fault::Restart => Marks(&[Mark::Reopened("no result of the stream for 500 ms")]),
        Fault::ClockJump => Marks(&[Mark::Reopened("no result of the stream for 3600000 ms")]),
        _ => Marks(&[]),
    }
}

fn asked(fault: Fault) -> Expectation {
    use Expectation::{Absent, Marks};
    const LATE: Mark = Mark::Fault("no answer to the question for a result within 100 ms: check");
    match fault {
        Fault::Burst => Absent("it sends only when asked"),
        Fault::Unplugged => Marks(&[Mark::Discarded]),
        Fault::Repeated => Marks(&[Mark::Flagged(Flags::SUSPECT), Mark::Discarded]),
        Fault::HalfFrame | Fault::LateAnswer => Marks(&[Mark::Discarded, LATE]),
        Fault::Garbage => Marks(&[Mark::Flagged(Flags::SUSPECT), Mark::Discarded]),
        Fault::Restart => Marks(&[LATE]),
        Fault::Silent => Marks(&[
            LATE,
            Mark::Reopened("no answer to the question for a result within 100 ms"),
            GREETING,
        ]),
        _ => Marks(&[]),
    }
}

struct Rf60x {
    range_mm: u16,
    is_streaming: bool,
    answers: u8,
    measured: u16,
    condition: Condition,
}

impl Rf60x {
    fn answer(&mut self, is_new: bool, bytes: &[u8]) -> Vec<u8> {
        self.answers = self.answers.wrapping_add(1);
        encode_answer(is_new, self.answers, bytes)
    }

    /// X = D · S / 16384: RF602 manual, page 15.
    fn result(&mut self) -> Sent {
        self.measured = self.measured % 15_000 + 1;
        if self.condition == Condition::OutOfRange {
            return Sent::bad(self.answer(true, &0x4000_u16.to_le_bytes()));
        }
        let mm = f64::from(self.measured) * 50.0 / 16_384.0;
        let bytes = self.measured.to_le_bytes();
        Sent::good(self.answer(true, &bytes), vec![Some(mm)])
    }
}

impl Device for Rf60x {
    fn receive(&mut self, _: Nanos, parcel: &Output) -> Vec<Sent> {
        let Output::Bytes(bytes) = parcel else { return Vec::new() };
        match bytes[..] {
            [1, 0x81] => {
                let mut identity = vec![0x3F, 0x90, 0x21, 0x43, 80, 0];
                identity.extend(self.range_mm.to_le_bytes());
                vec![Sent::answer(self.answer(false, &identity))]
            }
            [1, 0x86] => vec![self.result()],
            [1, 0x87] => {
                self.is_streaming = true;
                Vec::new()
            }
            _ => {
                self.is_streaming = false;
                Vec::new()
            }
        }
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_millis(10))
    }

    fn tick(&mut self, _: Nanos) -> Vec<Sent> {
        if self.is_streaming { vec![self.result()] } else { Vec::new() }
    }

    fn restart(&mut self) -> Vec<Sent> {
        (self.is_streaming, self.answers) = (false, 0);
        Vec::new()
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }
}
