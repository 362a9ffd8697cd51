//! A gauge with Modbus, over TCP and over a serial line.

use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{Driver, Flags, Nanos, Output};
use asphera_modbus::FAMILY;

pub(crate) struct Modbus {
    pub(crate) is_tcp: bool,
}

const GAUGE: &str = "poll_interval_ms = 50\ntimeout_ms = 100\nlate_limit_ms = 200\n\
    [[field]]\nname = 'z'\nfunction = 'input'\naddress = 0\nkind = 'u32'\nunit = 'mm'\nscale = 0.0001\nvalid_range = [0, 10]";

impl Bench for Modbus {
    fn name(&self) -> &'static str {
        if self.is_tcp { "modbus, TCP" } else { "modbus, RTU" }
    }

    fn driver(&self) -> Box<dyn Driver> {
        let framing = if self.is_tcp { "tcp" } else { "rtu" };
        let text = format!("framing = '{framing}'\n{GAUGE}");
        let settings = FAMILY.parse("gauge", &text).expect("settings of a test are sound");
        settings.driver().expect("settings of a test are sound")
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        let unit = if model == Model::Right { 1 } else { 7 };
        Box::new(Gauge { is_tcp: self.is_tcp, unit, measured: 0, condition: Condition::Good })
    }

    fn proof_bytes(&self) -> u64 {
        if self.is_tcp { 0 } else { 9 }
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::{Absent, Marks};
        match fault {
            Fault::Saturated => Absent("the protocol has no word for it"),
            Fault::BusOff => Absent("it is on no bus"),
            Fault::Stall | Fault::Limit => Absent("it moves nothing"),
            Fault::Burst => Absent("it sends only when asked"),
            Fault::OutOfRange => Marks(&[Mark::Flagged(Flags::OUT_OF_RANGE)]),
            Fault::Repeated => Marks(&[Mark::Discarded]),
            Fault::Slow | Fault::ClockJump => Marks(&[]),
            _ if self.is_tcp => tcp(fault),
            _ => rtu(fault),
        }
    }
}

fn tcp(fault: Fault) -> Expectation {
    use Expectation::{Absent, Marks};
    const LATE: Mark = Mark::Reopened("no answer of unit 1 to read input registers 0 to 1 within");
    const STEP: Mark = Mark::Reopened("no Modbus TCP frame where one must begin");
    match fault {
        Fault::BadChecksum => Absent("the protocol has no checksum"),
        Fault::Silent | Fault::Restart | Fault::LateAnswer => Marks(&[LATE]),
        Fault::HalfFrame => Marks(&[Mark::Discarded, LATE]),
        Fault::WrongDevice => {
            Marks(&[Mark::Discarded, Mark::Reopened("; unit 7 answered: check unit_id")])
        }
        _ => Marks(&[Mark::Discarded, STEP]),
    }
}

fn rtu(fault: Fault) -> Expectation {
    use Expectation::Marks;
    const LATE: Mark = Mark::Fault(
        "no answer of unit 1 to read input registers 0 to 1 within 100 ms: check unit_id",
    );
    match fault {
        Fault::Unplugged | Fault::Garbage => Marks(&[Mark::Discarded]),
        Fault::Silent | Fault::Restart => Marks(&[LATE]),
        Fault::WrongDevice => {
            Marks(&[Mark::Discarded, Mark::Fault("; unit 7 answered: check unit_id")])
        }
        _ => Marks(&[Mark::Discarded, LATE]),
    }
}

struct Gauge {
    is_tcp: bool,
    unit: u8,
    measured: u32,
    condition: Condition,
}

impl Device for Gauge {
    /// Function 4, input registers 0 and 1; a device answers as the unit that it is.
    fn receive(&mut self, _: Nanos, parcel: &Output) -> Vec<Sent> {
        let Output::Bytes(asked) = parcel else { return Vec::new() };
        self.measured = self.measured % 90_000 + 1;
        let raw = if self.condition == Condition::OutOfRange { 200_000 } else { self.measured };
        let mut pdu = vec![4, 4];
        pdu.extend(raw.to_be_bytes());
        let bytes = if self.is_tcp {
            let mut frame = vec![asked[0], asked[1], 0, 0, 0, 7, self.unit];
            frame.extend(pdu);
            frame
        } else {
            let mut frame = vec![self.unit];
            frame.extend(pdu);
            let check = crc(&frame);
            frame.extend(check.to_le_bytes());
            frame
        };
        match (self.unit, self.condition) {
            (1, Condition::Good) => {
                vec![Sent::good(bytes, vec![Some(f64::from(raw) * 0.0001)])]
            }
            (1, _) => vec![Sent::bad(bytes)],
            _ => vec![Sent::answer(bytes)],
        }
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }
}

/// Serial Line Specification V1.02, section 6.2.2.
pub(crate) fn crc(bytes: &[u8]) -> u16 {
    let mut crc = 0xFFFF_u16;
    for byte in bytes {
        crc ^= u16::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xA001 } else { crc >> 1 };
        }
    }
    crc
}
