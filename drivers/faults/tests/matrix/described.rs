//! Gauges that are described: one that sends lines with a check by itself, one that is asked.

use std::time::Duration;

use asphera_described::FAMILY;
use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{Driver, Flags, Nanos, Output};

use crate::lines::{line, text};
use crate::modbus::crc;

pub(crate) struct Described {
    pub(crate) gauge: Kind,
}

/// Ways in which gauges send.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Lines with a check, by itself.
    Guarded,
    /// The same in datagrams.
    Packets,
    /// Lines without one, by itself.
    Bare,
    /// Lines without one, when asked.
    Asked,
}

const GUARDED: &str = "gap_ms = 500\ncolumns = 2\nseparator = ','\nchecksum = { kind = 'crc16-modbus', form = 'hex', skip_last = 1 }\n\
    field = [{ name = 'n', column = 1 }, { name = 'z', column = 2, unit = 'mm', out_of_range = ['FFFF.FF'], saturated = ['SSSS.SS'] }]";

const BARE: &str = "gap_ms = 500\ncolumns = 1\n\
    field = [{ name = 'z', column = 1, unit = 'mm', out_of_range = ['FFFF.FF'], saturated = ['SSSS.SS'] }]";

const ASKED: &str = "columns = 1\npoll = { ask = 'M\\r', interval_ms = 50, timeout_ms = 100, late_limit_ms = 200 }\n\
    hello = { ask = 'I\\r', answer = 'ACME.*', timeout_ms = 100 }\n\
    field = [{ name = 'z', column = 1, unit = 'mm', out_of_range = ['FFFF.FF'], saturated = ['SSSS.SS'] }]";

impl Bench for Described {
    fn name(&self) -> &'static str {
        match self.gauge {
            Kind::Guarded => "described, checked",
            Kind::Packets => "described, UDP",
            Kind::Bare => "described, unchecked",
            Kind::Asked => "described, asked",
        }
    }

    fn driver(&self) -> Box<dyn Driver> {
        let text = match self.gauge {
            Kind::Guarded | Kind::Packets => GUARDED,
            Kind::Bare => BARE,
            Kind::Asked => ASKED,
        };
        let settings = FAMILY.parse("gauge", text).expect("settings of a test are sound");
        settings.driver().expect("settings of a test are sound")
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Gauge { model, kind: self.gauge, measured: 0, condition: Condition::Good })
    }

    fn has_datagrams(&self) -> bool {
        self.gauge == Kind::Packets
    }

    fn has_line_ends(&self) -> bool {
        true
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::Absent;
        match fault {
            Fault::BusOff => Absent("it is on no bus"),
            Fault::Stall | Fault::Limit => Absent("it moves nothing"),
            Fault::OutOfRange => Expectation::Marks(&[Mark::Flagged(Flags::OUT_OF_RANGE)]),
            Fault::Saturated => Expectation::Marks(&[Mark::Flagged(Flags::SATURATED)]),
            _ => match self.gauge {
                Kind::Guarded => guarded(fault),
                Kind::Packets => packets(fault),
                Kind::Bare => bare(fault),
                Kind::Asked => asked(fault),
            },
        }
    }
}

const GAP: Mark = Mark::Reopened("no frame for 500 ms: check cable and power");

fn guarded(fault: Fault) -> Expectation {
    use Expectation::{Absent, Marks};
    const WRONG: Mark = Mark::Fault("is wrong: check cable and baud rate");
    match fault {
        Fault::LateAnswer => Absent("it sends by itself"),
        Fault::Repeated => Absent("two equal lines are two measurements"),
        Fault::Unplugged => Marks(&[Mark::Discarded]),
        Fault::Silent | Fault::Restart => Marks(&[Mark::Discarded, GAP]),
        Fault::ClockJump => Marks(&[Mark::Discarded, Mark::Reopened("no frame for 3600000 ms")]),
        Fault::HalfFrame | Fault::Garbage | Fault::BadChecksum | Fault::WrongDevice => {
            Marks(&[Mark::Discarded, WRONG])
        }
        _ => Marks(&[]),
    }
}

/// A line is a datagram: it comes twice, or as two in one.
fn packets(fault: Fault) -> Expectation {
    guarded(fault)
}

fn bare(fault: Fault) -> Expectation {
    use Expectation::{Absent, Marks};
    const NONE: Mark = Mark::Fault(": check baud rate and settings");
    match fault {
        Fault::LateAnswer => Absent("it sends by itself"),
        Fault::Repeated => Absent("two equal lines are two measurements"),
        Fault::BadChecksum => Absent("none is described for this gauge"),
        Fault::HalfFrame => Marks(&[Mark::Flagged(Flags::SUSPECT)]),
        Fault::Garbage => Marks(&[Mark::Flagged(Flags::SUSPECT), Mark::Discarded, NONE]),
        Fault::WrongDevice => Marks(&[Mark::Discarded, NONE]),
        _ => guarded(fault),
    }
}

fn asked(fault: Fault) -> Expectation {
    use Expectation::{Absent, Marks};
    const LATE: Mark = Mark::Fault("no answer to `M\\r` within 100 ms");
    match fault {
        Fault::BadChecksum => Absent("none is described for this gauge"),
        Fault::Burst => Absent("it sends only when asked"),
        Fault::Unplugged | Fault::Repeated => Marks(&[Mark::Discarded]),
        Fault::HalfFrame | Fault::LateAnswer => Marks(&[Mark::Discarded, LATE]),
        Fault::Restart => Marks(&[LATE]),
        Fault::Silent => Marks(&[
            LATE,
            Mark::Reopened("no answer to `M\\r` within 100 ms: check cable and power"),
            Mark::Reopened("no answer to `I\\r` within 100 ms, asked 2 times: check cable"),
        ]),
        Fault::Garbage => Marks(&[
            Mark::Discarded,
            LATE,
            Mark::Fault("has no number where a channel stands: check baud rate and settings"),
        ]),
        Fault::WrongDevice => Marks(&[
            Mark::Discarded,
            Mark::Reopened("`I\\r` is answered by `OTHER 5`, expected `ACME.*`: check"),
        ]),
        _ => Marks(&[]),
    }
}

struct Gauge {
    model: Model,
    kind: Kind,
    measured: u32,
    condition: Condition,
}

impl Gauge {
    fn measure(&mut self) -> Sent {
        self.measured = self.measured % 9000 + 1;
        let n = self.measured;
        let number = match self.condition {
            Condition::OutOfRange => "FFFF.FF".to_owned(),
            Condition::Saturated => "SSSS.SS".to_owned(),
            _ => format!("{n:04}.25"),
        };
        let (mut values, body) = match self.kind {
            Kind::Guarded | Kind::Packets => (vec![Some(f64::from(n))], format!("{n:04},{number}")),
            Kind::Bare | Kind::Asked => (Vec::new(), number),
        };
        // The star is in the frame and not in the check.
        let check = crc(body.as_bytes());
        let check = if matches!(self.kind, Kind::Guarded | Kind::Packets) {
            format!("*{check:04X}")
        } else {
            String::new()
        };
        let bytes = format!("{body}{check}\r\n");
        if self.condition != Condition::Good {
            return Sent::bad(bytes);
        }
        values.push(Some(f64::from(n) + 0.25));
        Sent::good(bytes, values)
    }
}

impl Device for Gauge {
    fn receive(&mut self, _: Nanos, parcel: &Output) -> Vec<Sent> {
        match (text(parcel), self.model) {
            ("I", Model::Right) => line("ACME 7"),
            ("I", Model::Stranger) => line("OTHER 5"),
            ("M", _) => vec![self.measure()],
            _ => Vec::new(),
        }
    }

    fn period(&self) -> Option<Duration> {
        // Half a line is told from a whole one by the silence after it.
        match self.kind {
            Kind::Guarded | Kind::Packets => Some(Duration::from_millis(10)),
            Kind::Bare => Some(Duration::from_millis(100)),
            Kind::Asked => None,
        }
    }

    fn tick(&mut self, _: Nanos) -> Vec<Sent> {
        match self.model {
            Model::Right => vec![self.measure()],
            Model::Stranger => line("$GPGGA,123519,4807.038,N"),
        }
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }
}
