//! Micro-Epsilon optoNCDT: a sensor that sends by itself.

use std::time::Duration;

use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{Driver, Flags, Nanos, Output};
use asphera_optoncdt::wire::{Word, encode_three};
use asphera_optoncdt::{Extra, Optoncdt as Sensor, Series, Settings};

pub(crate) struct Optoncdt;

impl Bench for Optoncdt {
    fn name(&self) -> &'static str {
        "optoncdt"
    }

    fn driver(&self) -> Box<dyn Driver> {
        let settings = Settings {
            series: Series::Plain,
            range_mm: 10.0,
            extras: vec![Extra::Counter],
            triggered: false,
            silence_ms: 500,
        };
        Box::new(Sensor::new(settings).expect("settings of a test are sound"))
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Ild { model, measured: 0, condition: Condition::Good })
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::{Absent, Marks};
        match fault {
            Fault::BadChecksum => Absent("the protocol has no checksum"),
            Fault::BusOff => Absent("it is on no bus"),
            Fault::Stall | Fault::Limit => Absent("it moves nothing"),
            Fault::LateAnswer => Absent("it sends by itself"),
            Fault::OutOfRange => Marks(&[Mark::Flagged(Flags::OUT_OF_RANGE)]),
            Fault::Saturated => Marks(&[Mark::Flagged(Flags::SATURATED)]),
            Fault::Unplugged | Fault::WrongDevice => Marks(&[Mark::Discarded]),
            Fault::HalfFrame => Marks(&[Mark::Flagged(Flags::SUSPECT), Mark::Discarded]),
            Fault::Garbage => Marks(&[Mark::Flagged(Flags::SUSPECT), Mark::Discarded]),
            Fault::Repeated => Marks(&[Mark::Flagged(Flags::AMBIGUOUS_COUNT)]),
            Fault::Silent => {
                Marks(&[Mark::Reopened("no measurement for 500 ms: check cable, power and laser")])
            }
            Fault::Restart => Marks(&[Mark::Reopened("no measurement for 500 ms")]),
            Fault::ClockJump => Marks(&[Mark::Reopened("no measurement for 3600000 ms")]),
            Fault::Slow | Fault::Burst => Marks(&[]),
        }
    }
}

struct Ild {
    model: Model,
    measured: u32,
    condition: Condition,
}

impl Device for Ild {
    fn receive(&mut self, _: Nanos, _: &Output) -> Vec<Sent> {
        Vec::new()
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_millis(10))
    }

    /// (1.02 x / 65520 − 0.01) MR; errors in its place: ILD1420 manual, pages 65 and 66.
    fn tick(&mut self, _: Nanos) -> Vec<Sent> {
        if self.model == Model::Stranger {
            return vec![Sent::answer("+01.2345\r\n")];
        }
        self.measured = self.measured % 60_000 + 1;
        let value = match self.condition {
            Condition::OutOfRange => 262_078,
            Condition::Saturated => 262_081,
            _ => 1000 + self.measured,
        };
        let words =
            [Word { value, is_first: true }, Word { value: self.measured, is_first: false }];
        let bytes: Vec<u8> = words.into_iter().flat_map(encode_three).collect();
        let mm = (1.02 * f64::from(value) / 65_520.0 - 0.01) * 10.0;
        match self.condition {
            Condition::OutOfRange | Condition::Saturated => vec![Sent::bad(bytes)],
            _ => vec![Sent::good(bytes, vec![Some(mm)])],
        }
    }

    fn restart(&mut self) -> Vec<Sent> {
        // It goes on counting from anywhere.
        self.measured += 1000;
        Vec::new()
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }
}
