//! Keyence LJ-X8000: answers on one connection, profiles on the other.

use std::time::Duration;

use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_keyence::wire::{Answer, ErrorCodes, Layout, NoHeight, Profile, Request, Unit};
use asphera_keyence::{Profiler, Settings};
use asphera_link::{Driver, Flags, Nanos, Output};

pub(crate) struct Keyence;

const SERIAL: &str = "1A230004";

/// Eight points 0.1 mm apart, in units of 80 nm.
const LAYOUT: Layout = Layout {
    start_code: 0xC0DE,
    kind: 1,
    points: 8,
    unit_10nm: 8,
    x_start_10nm: -35_000,
    x_pitch_10nm: 10_000,
};

impl Bench for Keyence {
    fn name(&self) -> &'static str {
        "keyence-lj"
    }

    fn driver(&self) -> Box<dyn Driver> {
        let settings =
            Settings { serial: Some(SERIAL.to_owned()), silence_ms: 500, ..Settings::default() };
        Box::new(Profiler::new(settings).expect("settings of a test are sound"))
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        let serial = if model == Model::Right { SERIAL } else { "1A239999" };
        Box::new(Controller { serial, trigger: 0, is_streaming: false, condition: Condition::Good })
    }

    fn restart_closes(&self) -> bool {
        true
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::{Absent, Marks};
        const DAMAGED: Mark = Mark::Fault("a profile was passed over: its sum is");
        match fault {
            Fault::Repeated => Absent("TCP delivers no byte twice"),
            Fault::Saturated => Absent("the protocol has no word for it"),
            Fault::BusOff => Absent("it is on no bus"),
            Fault::Stall | Fault::Limit => Absent("it moves nothing"),
            Fault::LateAnswer => Absent("it sends by itself"),
            Fault::OutOfRange => Marks(&[Mark::Flagged(Flags::NO_SIGNAL)]),
            Fault::Unplugged => Marks(&[Mark::Discarded]),
            Fault::Silent => Marks(&[
                Mark::Reopened("no profile for 500 ms: check laser, trigger and encoder"),
                Mark::Reopened("no answer to stop of the stream (48h) within 1000 ms: check cable"),
            ]),
            Fault::ClockJump => Marks(&[Mark::Reopened("no profile for 3600000 ms")]),
            Fault::HalfFrame => {
                Marks(&[Mark::Discarded, DAMAGED, Mark::Reopened("2 profiles in a row with a")])
            }
            Fault::Garbage => Marks(&[
                Mark::Discarded,
                DAMAGED,
                Mark::Reopened("2 profiles in a row with a wrong sum"),
                Mark::Reopened("an answer of "),
            ]),
            Fault::BadChecksum => Marks(&[
                Mark::Discarded,
                DAMAGED,
                Mark::Fault("1 profiles are missing before trigger 5, not sent or with a wrong"),
            ]),
            Fault::WrongDevice => {
                Marks(&[Mark::Reopened("the controller has the serial number \"1A239999\"")])
            }
            Fault::Slow | Fault::Burst | Fault::Restart => Marks(&[]),
        }
    }
}

struct Controller {
    serial: &'static str,
    trigger: u32,
    is_streaming: bool,
    condition: Condition,
}

impl Controller {
    fn content(&self, request: Request) -> Vec<u8> {
        match request {
            Request::Units => {
                Unit::encode_all(&[Unit { model: "LJ-X8000".into(), serial: self.serial.into() }])
            }
            Request::Errors => ErrorCodes::default().encode(),
            Request::Prepare => LAYOUT.encode(),
            _ => Vec::new(),
        }
    }
}

impl Device for Controller {
    fn opened(&mut self) {
        self.is_streaming = false;
    }

    fn receive(&mut self, _: Nanos, parcel: &Output) -> Vec<Sent> {
        let Output::Bytes(bytes) = parcel else { return Vec::new() };
        let Ok(Some((_, request, _))) = Request::decode(bytes) else { return Vec::new() };
        match request {
            Request::Start { .. } => self.is_streaming = true,
            Request::Stop => self.is_streaming = false,
            _ => {}
        }
        let content = self.content(request);
        let answer = Answer { command: request.command(), error: 0, content: &content };
        vec![Sent::answer(answer.encode())]
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_millis(10))
    }

    fn tick(&mut self, _: Nanos) -> Vec<Sent> {
        if !self.is_streaming {
            return Vec::new();
        }
        self.trigger += 1;
        let is_seen = self.condition == Condition::Good;
        let height = if is_seen { Ok(2_500) } else { Err(NoHeight::NoPeak) };
        let encoder = self.trigger.cast_signed() * 4;
        let bytes = Profile::encode(&LAYOUT, self.trigger, encoder, [height; 8]);
        let values = [f64::from(encoder), 8.0, 0.0, 0.0, 0.0, 0.0].map(Some).to_vec();
        vec![if is_seen { Sent::good(bytes, values) } else { Sent::bad(bytes) }.on_second()]
    }

    fn restart(&mut self) -> Vec<Sent> {
        (self.trigger, self.is_streaming) = (0, false);
        Vec::new()
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }
}
