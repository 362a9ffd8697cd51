//! A coordinate measuring machine with I++ DME that runs a program.

use std::time::Duration;

use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_ippdme::FAMILY;
use asphera_link::{Driver, Motion, Nanos, Output};

use crate::lines::text;

pub(crate) struct Ippdme;

/// Points of the program.
const POINTS: usize = 50;

impl Bench for Ippdme {
    fn name(&self) -> &'static str {
        "ippdme"
    }

    fn driver(&self) -> Box<dyn Driver> {
        let commands = vec!["'PtMeas(X(1), Y(2), Z(3))'"; POINTS].join(", ");
        let text = format!("commands = [{commands}]\ntimeout_ms = 200\nsilence_s = 1");
        let settings = FAMILY.parse("cmm", &text).expect("settings of a test are sound");
        settings.driver().expect("settings of a test are sound")
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Server { model, measured: 0, condition: Condition::Good })
    }

    fn order(&self) -> Option<Motion> {
        Some(Motion::Run)
    }

    fn restart_closes(&self) -> bool {
        true
    }

    fn lateness(&self) -> Duration {
        Duration::from_millis(1500)
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::{Absent, Marks};
        const NO_LINE: Mark = Mark::Reopened("check address and port of the link");
        const NO_DATA: Mark = Mark::Fault("data of PtMeas that are no values with names");
        match fault {
            Fault::BadChecksum => Absent("the protocol has no checksum"),
            Fault::Saturated => Absent("the protocol has no word for it"),
            Fault::BusOff => Absent("it is on no bus"),
            Fault::Burst => Absent("it sends only when asked"),
            Fault::Repeated => Absent("TCP delivers no byte twice"),
            Fault::OutOfRange => Marks(&[Mark::Fault("check that the part is in its place")]),
            Fault::Unplugged => Marks(&[Mark::Discarded, NO_DATA, NO_LINE]),
            Fault::HalfFrame => Marks(&[
                Mark::Discarded,
                NO_DATA,
                Mark::Halted("for 1 s: check the machine and its controller"),
            ]),
            Fault::Silent => {
                Marks(&[Mark::Halted("no answer to `AbortE()`, sent 5 times: press the emergency")])
            }
            Fault::Garbage | Fault::WrongDevice => Marks(&[Mark::Discarded, NO_LINE]),
            Fault::LateAnswer => Marks(&[
                Mark::Discarded,
                Mark::Reopened("which no command under way has: increase silence_s, or check"),
            ]),
            Fault::Stall => Marks(&[
                Mark::Fault("error 2504 of severity 3"),
                Mark::Halted("Collision: take away what the probe ran into"),
            ]),
            Fault::Limit => Marks(&[
                Mark::Fault("error 1008 of severity 3"),
                Mark::Halted("keep the program within the machine's volume"),
            ]),
            Fault::Slow | Fault::Restart | Fault::ClockJump => Marks(&[]),
        }
    }
}

struct Server {
    model: Model,
    measured: u32,
    condition: Condition,
}

impl Server {
    /// Errors as in `errorResponses.res` of the NIST test suite.
    fn measure(&mut self, tag: &str) -> Vec<Sent> {
        let error = match self.condition {
            Condition::OutOfRange => Some("Error(2, 1006, \"PtMeas\", \"Surface not found\")"),
            Condition::Limit => {
                Some("Error(3, 1008, \"PtMeas\", \"Target position out of machine volume\")")
            }
            Condition::Stalled => Some("Error(3, 2504, \"PtMeas\", \"Collision\")"),
            _ => None,
        };
        let begin = Sent::answer(format!("{tag} &\r\n"));
        if let Some(error) = error {
            return vec![begin, Sent::answer(format!("{tag} ! {error}\r\n{tag} %\r\n"))];
        }
        self.measured = self.measured % 9000 + 1;
        let x = f64::from(self.measured);
        let point = format!("{tag} # X({:04}.5), Y(2), Z(3)\r\n", self.measured);
        let point = Sent::good(point, vec![Some(x + 0.5), Some(2.0), Some(3.0)]);
        vec![begin, point, Sent::answer(format!("{tag} %\r\n"))]
    }
}

impl Device for Server {
    fn receive(&mut self, _: Nanos, parcel: &Output) -> Vec<Sent> {
        if self.model == Model::Stranger {
            return vec![Sent::answer("HTTP/1.1 400 Bad Request\r\n")];
        }
        let (tag, command) = text(parcel).split_once(' ').unwrap_or_default();
        if command.starts_with("PtMeas") {
            return self.measure(tag);
        }
        vec![Sent::answer(format!("{tag} &\r\n{tag} %\r\n"))]
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }

    fn is_motion(&self, parcel: &Output) -> bool {
        text(parcel).contains("PtMeas(")
    }
}
