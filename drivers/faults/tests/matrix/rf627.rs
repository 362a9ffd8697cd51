//! RIFTEK RF627: profiles in datagrams.

use std::time::Duration;

use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{Driver, Flags, Nanos, Output};
use asphera_rf627::wire::{Format, Header, RawPoint, encode};
use asphera_rf627::{Rf627 as Scanner, Settings};

pub(crate) struct Rf627;

impl Bench for Rf627 {
    fn name(&self) -> &'static str {
        "rf627"
    }

    fn driver(&self) -> Box<dyn Driver> {
        let settings = Settings { serial: Some(180_000), silence_ms: 500, reorder_ms: 20 };
        Box::new(Scanner::new(settings).expect("settings of a test are sound"))
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        let serial = if model == Model::Right { 180_000 } else { 5 };
        Box::new(Profiles { serial, since_start: 0, step: 0, condition: Condition::Good })
    }

    fn has_datagrams(&self) -> bool {
        true
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::{Absent, Marks};
        const SHORT: Mark = Mark::Fault("a datagram of 36 bytes, expected at least 64");
        match fault {
            Fault::BadChecksum => Absent("the protocol has no checksum"),
            Fault::Saturated => Absent("the protocol has no word for it"),
            Fault::BusOff => Absent("it is on no bus"),
            Fault::Stall | Fault::Limit => Absent("it moves nothing"),
            Fault::LateAnswer => Absent("it sends by itself"),
            Fault::OutOfRange => Marks(&[Mark::Flagged(Flags::NO_SIGNAL)]),
            Fault::Unplugged => Marks(&[
                Mark::Discarded,
                SHORT,
                Mark::Fault(
                    "a datagram of device type 0, expected 627: check that the scanner alone",
                ),
            ]),
            Fault::HalfFrame => Marks(&[
                Mark::Discarded,
                SHORT,
                Mark::Fault(
                    "1 profiles are missing before 5: datagrams were lost on the way, check",
                ),
            ]),
            Fault::Repeated => {
                Marks(&[Mark::Discarded, Mark::Fault("profile 4 came twice: the network repeats")])
            }
            Fault::Silent => Marks(&[Mark::Reopened("no profile for 500 ms: check cable, power")]),
            Fault::Restart => Marks(&[Mark::Reopened("no profile for 500 ms")]),
            Fault::Garbage => Marks(&[Mark::Discarded, Mark::Fault("a datagram of ")]),
            Fault::WrongDevice => Marks(&[
                Mark::Discarded,
                Mark::Fault("a profile of the scanner 5, expected 180000: set serial"),
            ]),
            Fault::ClockJump => Marks(&[Mark::Reopened("no profile for 3600000 ms")]),
            Fault::Slow | Fault::Burst => Marks(&[]),
        }
    }
}

struct Profiles {
    serial: u32,
    since_start: u32,
    step: u32,
    condition: Condition,
}

impl Device for Profiles {
    fn receive(&mut self, _: Nanos, _: &Output) -> Vec<Sent> {
        Vec::new()
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_millis(10))
    }

    fn tick(&mut self, _: Nanos) -> Vec<Sent> {
        self.since_start += 1;
        self.step += 1;
        let header = Header {
            format: Format::Profile,
            serial: self.serial,
            time_ns: 10_000_000 * u64::from(self.since_start),
            version: (1, 0),
            packet_count: self.since_start,
            measure_count: self.since_start,
            z_range_mm: 200,
            x_range_mm: 166,
            range_steps: 16_384,
            licence_hash: 0,
            exposure_ns: 100_000,
            laser: 42,
            step_count: self.step,
            direction: 0,
        };
        let z = if self.condition == Condition::OutOfRange { 0 } else { 8192 };
        let points = [RawPoint { x: -100, z }, RawPoint { x: 100, z }];
        let mut bytes = Vec::new();
        encode(&header, &points, None, &mut bytes).expect("two points fit into a datagram");
        let values = vec![Some(f64::from(self.step)), Some(1e-4), Some(2.0)];
        match (self.serial, self.condition) {
            (180_000, Condition::Good) => vec![Sent::good(bytes, values)],
            (180_000, _) => vec![Sent::bad(bytes)],
            _ => vec![Sent::answer(bytes)],
        }
    }

    fn restart(&mut self) -> Vec<Sent> {
        self.since_start = 0;
        Vec::new()
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }
}
