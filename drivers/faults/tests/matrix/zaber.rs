//! A stage of Zaber, with checks.

use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{AxisMove, Driver, Flags, Motion, Nanos, Output};
use asphera_zaber::FAMILY;

use crate::lines::text;

pub(crate) struct Zaber;

const STAGE: &str = "checksum = true\ninterval_ms = 50\ntimeout_ms = 100\nlate_limit_ms = 200\n\
    axis = [{ name = 'x', microstep_um = 0.2 }]";

impl Bench for Zaber {
    fn name(&self) -> &'static str {
        "zaber"
    }

    fn driver(&self) -> Box<dyn Driver> {
        let settings = FAMILY.parse("stage", STAGE).expect("settings of a test are sound");
        settings.driver().expect("settings of a test are sound")
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Stage { model, place: 0, is_moving: false, condition: Condition::Good })
    }

    fn movement(&self) -> Option<Motion> {
        let axis = "x".to_owned();
        Some(Motion::Move(vec![AxisMove { axis, to: 5.0, speed: 1.0, acceleration: None }]))
    }

    fn has_line_ends(&self) -> bool {
        true
    }

    /// The greeting is a question for the position.
    fn proof_bytes(&self) -> u64 {
        29
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::{Absent, Marks};
        const LATE: Mark = Mark::Fault("no answer to `/1 0 get pos:AD\\n` within 100 ms");
        const WRONG: Mark = Mark::Fault("is wrong: check cable and baud rate");
        const ERROR: Mark = Mark::Flagged(Flags::DEVICE_ERROR);
        match fault {
            Fault::OutOfRange | Fault::Saturated => Absent("a stage measures its own place"),
            Fault::BusOff => Absent("it is on no bus"),
            Fault::Burst => Absent("it sends only when asked"),
            Fault::Unplugged | Fault::Repeated => Marks(&[Mark::Discarded]),
            Fault::HalfFrame | Fault::BadChecksum => Marks(&[Mark::Discarded, WRONG, LATE]),
            Fault::LateAnswer => Marks(&[Mark::Discarded, LATE]),
            Fault::Restart => Marks(&[LATE]),
            Fault::Silent => Marks(&[
                LATE,
                Mark::Reopened("within 100 ms: check cable and power"),
                Mark::Reopened("asked 2 times: check cable, power, baud rate"),
            ]),
            Fault::Garbage => Marks(&[
                Mark::Discarded,
                WRONG,
                LATE,
                Mark::Reopened("came: check cable and power"),
            ]),
            Fault::WrongDevice => {
                Marks(&[Mark::Discarded, Mark::Reopened("is answered by `ERR`, expected")])
            }
            Fault::Stall => Marks(&[
                ERROR,
                Mark::Fault("`FS`: stalled and stopped; take away what blocks the stage"),
                Mark::Halted("FS, stalled and stopped: take away what blocks the stage"),
            ]),
            Fault::Limit => Marks(&[
                ERROR,
                Mark::Fault("`FE`: limit error; move the stage away from its end"),
                Mark::Halted("FE, limit error: move the stage away from its end"),
            ]),
            Fault::Slow | Fault::ClockJump => Marks(&[]),
        }
    }
}

struct Stage {
    model: Model,
    place: u32,
    is_moving: bool,
    condition: Condition,
}

/// The message, its check and its end: all from the second sign on adds up to 0.
fn checked(message: &str) -> Vec<u8> {
    let sum: u32 = message.bytes().skip(1).map(u32::from).sum();
    format!("{message}:{:02X}\r\n", (256 - sum % 256) % 256).into_bytes()
}

impl Device for Stage {
    fn receive(&mut self, _: Nanos, parcel: &Output) -> Vec<Sent> {
        if self.model == Model::Stranger {
            return vec![Sent::answer("ERR\r\n")];
        }
        let (message, _) = text(parcel).split_once(':').unwrap_or_default();
        let words: Vec<&str> = message.split(' ').collect();
        let flag = match self.condition {
            Condition::Stalled => "FS",
            Condition::Limit => "FE",
            _ => "--",
        };
        let state = if self.is_moving && flag == "--" { "BUSY" } else { "IDLE" };
        match words[..] {
            [_, axis, "get", "pos"] => {
                self.place += 1;
                let place = self.place;
                let bytes = checked(&format!("@01 {axis} OK {state} {flag} {place:07}"));
                match flag {
                    "--" => vec![Sent::good(bytes, vec![Some(f64::from(place) * 0.0002)])],
                    _ => vec![Sent::bad(bytes)],
                }
            }
            [_, axis, number, ref order @ ..] => {
                self.is_moving |= order.first() == Some(&"move");
                self.is_moving &= order.first() != Some(&"stop");
                let data = if order == ["warnings"] { "00" } else { "0" };
                let number: u8 = number.parse().unwrap_or_default();
                // A stage notes a stall or a limit when it moves.
                let text = format!("@01 {axis} {number:02} OK {state} -- {data}");
                vec![Sent::answer(checked(&text))]
            }
            _ => Vec::new(),
        }
    }

    fn restart(&mut self) -> Vec<Sent> {
        self.is_moving = false;
        Vec::new()
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }

    fn is_motion(&self, parcel: &Output) -> bool {
        text(parcel).contains(" move ")
    }
}
