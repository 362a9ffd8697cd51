//! CHRocodile on the dollar protocol, running free or by triggers of others.

use std::time::Duration;

use asphera_chrocodile::wire::{Layout, Part, Quantity, SYNC};
use asphera_chrocodile::{Chrocodile as Probe, Settings, Trigger};
use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{Driver, Flags, Nanos, Output};

use crate::lines::{line, text};

pub(crate) struct Chrocodile {
    pub(crate) is_triggered: bool,
}

/// Full scale of the probe in µm.
pub(crate) const FULL_SCALE_UM: f64 = 3000.0;

const SIGNALS: [u16; 4] = [75, 76, 256, 257];

impl Bench for Chrocodile {
    fn name(&self) -> &'static str {
        if self.is_triggered { "chrocodile, triggered" } else { "chrocodile, dollar" }
    }

    fn driver(&self) -> Box<dyn Driver> {
        let settings = Settings {
            signals: SIGNALS.to_vec(),
            sample_rate_hz: 100.0,
            trigger: if self.is_triggered { Trigger::Each } else { Trigger::Free },
            ready_timeout_ms: 200,
            ..Settings::default()
        };
        Box::new(Probe::new(settings).expect("settings of a test are sound"))
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Dollar { model, is_streaming: false, exposures: 0, condition: Condition::Good })
    }

    /// Over TCP. On a serial line a probe that restarted is as silent as one without triggers.
    fn restart_closes(&self) -> bool {
        self.is_triggered
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
            Fault::Unplugged | Fault::HalfFrame => Marks(&[Mark::Discarded]),
            // Neither of two with one count is believed.
            Fault::Repeated => Marks(&[Mark::Flagged(Flags::SUSPECT)]),
            // Without triggers it sends nothing either: silence is no fault.
            Fault::Silent | Fault::ClockJump if self.is_triggered => Marks(&[]),
            Fault::Restart if self.is_triggered => Marks(&[Mark::Discarded]),
            Fault::Silent => Marks(&[
                Mark::Discarded,
                Mark::Reopened("no data for 200 ms though free-running: check cable and power"),
                Mark::Reopened("no echo to $STO within 200 ms, asked 2 times: check cable"),
            ]),
            Fault::Restart => Marks(&[
                Mark::Reopened("no data for 200 ms though free-running"),
                Mark::Reopened("no echo to $STO"),
            ]),
            Fault::Garbage => Marks(&[
                Mark::Discarded,
                Mark::Reopened("bytes without a telegram as set up: check cable and baud rate"),
            ]),
            Fault::WrongDevice => Marks(&[
                Mark::Discarded,
                Mark::Reopened("asked 2 times: check cable, power, baud rate and protocol"),
            ]),
            Fault::ClockJump => Marks(&[Mark::Reopened("no data for 3600000 ms")]),
            Fault::Slow | Fault::Burst => Marks(&[]),
        }
    }
}

struct Dollar {
    model: Model,
    is_streaming: bool,
    exposures: u32,
    condition: Condition,
}

impl Device for Dollar {
    /// CLS manual, pages 47 to 49: the echo, what there is to say, and `ready`.
    fn receive(&mut self, _: Nanos, parcel: &Output) -> Vec<Sent> {
        if self.model == Model::Stranger {
            return line("what?");
        }
        let command = text(parcel);
        match command {
            "$STA" => self.is_streaming = true,
            "$STO" => self.is_streaming = false,
            _ => {}
        }
        let data = if command == "$SCA ?" { " 3000" } else { "\r" };
        vec![Sent::answer(format!("{command}{data}ready\r\n"))]
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_millis(10))
    }

    fn tick(&mut self, _: Nanos) -> Vec<Sent> {
        if !self.is_streaming {
            return Vec::new();
        }
        self.exposures += 1;
        let um = match self.condition {
            Condition::OutOfRange => 5000.0,
            // Steps that single precision holds.
            _ => 1000.0 + f64::from(self.exposures % 4000) * 0.25,
        };
        let flags = if self.condition == Condition::Saturated { 1.0 } else { 0.0 };
        let layout = Layout::new(SYNC, &SIGNALS).expect("signals of the manual");
        let mut bytes = Vec::new();
        let value = |quantity| match quantity {
            Quantity::ExposureCount => f64::from(self.exposures % 65_536),
            Quantity::ExposureFlags => flags,
            Quantity::Peak { part: Part::Intensity, .. } => 50.0,
            _ => um,
        };
        layout.encode(FULL_SCALE_UM, |signal| value(signal.quantity), &mut bytes);
        match self.condition {
            Condition::Good => vec![Sent::good(bytes, vec![Some(um / 1000.0), Some(50.0)])],
            _ => vec![Sent::bad(bytes)],
        }
    }

    fn restart(&mut self) -> Vec<Sent> {
        (self.is_streaming, self.exposures) = (false, 0);
        Vec::new()
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }
}
