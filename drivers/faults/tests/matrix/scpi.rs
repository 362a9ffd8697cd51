//! A thermometer with SCPI, as Fluke's 1529.

use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{Driver, Flags, Nanos, Output};
use asphera_scpi::FAMILY;

use crate::lines::{line, text};

pub(crate) struct Scpi;

const SETTINGS: &str = "identity = 'FLUKE,1529,.*'\nquery = 'FETC? 1'\nterminator = 'cr'\ninterval_ms = 50\n\
    timeout_ms = 100\nlate_limit_ms = 200\nfield = [{ name = 't', unit = 'degC' }]";

impl Bench for Scpi {
    fn name(&self) -> &'static str {
        "scpi"
    }

    fn driver(&self) -> Box<dyn Driver> {
        let settings = FAMILY.parse("meter", SETTINGS).expect("settings of a test are sound");
        settings.driver().expect("settings of a test are sound")
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Thermometer { model, measured: 0, condition: Condition::Good })
    }

    fn has_line_ends(&self) -> bool {
        true
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::{Absent, Marks};
        const LATE: Mark = Mark::Fault("no answer to `FETC? 1\\r` within 100 ms");
        const QUEUE: Mark = Mark::Fault("no answer to `SYST:ERR?\\r` within 100 ms");
        match fault {
            Fault::BadChecksum => Absent("the protocol has no checksum"),
            Fault::Saturated => Absent("the protocol has no word for it"),
            Fault::BusOff => Absent("it is on no bus"),
            Fault::Stall | Fault::Limit => Absent("it moves nothing"),
            Fault::Burst => Absent("it sends only when asked"),
            Fault::OutOfRange => Marks(&[Mark::Flagged(Flags::OUT_OF_RANGE)]),
            Fault::Unplugged | Fault::Repeated => Marks(&[Mark::Discarded]),
            Fault::HalfFrame | Fault::LateAnswer => Marks(&[Mark::Discarded, LATE]),
            Fault::Restart => Marks(&[LATE, QUEUE]),
            Fault::Silent => Marks(&[
                LATE,
                QUEUE,
                Mark::Reopened("no answer to `FETC? 1\\r` within 100 ms: check cable and power"),
                Mark::Reopened("no answer to `*IDN?\\r` within 100 ms, asked 2 times: check cable"),
            ]),
            Fault::Garbage => Marks(&[
                Mark::Discarded,
                LATE,
                QUEUE,
                Mark::Fault("has no number where a channel stands: check baud rate and settings"),
            ]),
            Fault::WrongDevice => Marks(&[
                Mark::Discarded,
                Mark::Reopened("is answered by `FLUKE, 45, 1234567, 1.0 D1.0`, expected"),
            ]),
            Fault::Slow | Fault::ClockJump => Marks(&[]),
        }
    }
}

struct Thermometer {
    model: Model,
    measured: u32,
    condition: Condition,
}

impl Device for Thermometer {
    fn receive(&mut self, _: Nanos, parcel: &Output) -> Vec<Sent> {
        match (text(parcel), self.model) {
            ("*IDN?", Model::Right) => line("FLUKE,1529,A09002,1.0"),
            ("*IDN?", Model::Stranger) => line("FLUKE, 45, 1234567, 1.0 D1.0"),
            ("SYST:ERR?", _) => line("0,\"No error\""),
            ("FETC? 1", _) => {
                self.measured = self.measured % 9000 + 1;
                if self.condition == Condition::OutOfRange {
                    return vec![Sent::bad("+9.90E+37\r\n")];
                }
                // 10.00 to 99.99, in as many signs as infinity has.
                let hundredths = 999 + self.measured;
                let text = format!("+{}.{:03}E+1\r\n", hundredths / 1000, hundredths % 1000);
                vec![Sent::good(text, vec![Some(f64::from(hundredths) / 100.0)])]
            }
            _ => Vec::new(),
        }
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }
}
