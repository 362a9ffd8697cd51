//! A transducer on a CAN bus that is described, and sends by itself.

use std::time::Duration;

use asphera_described::FAMILY;
use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{CanFrame, CanId, Driver, Flags, Nanos, Output};

pub(crate) struct DescribedCan;

const SETTINGS: &str = "frame = 'can'\nid = 0x185\nlength = 5\ngap_ms = 500\nfield = [\n\
    { name = 'z', start_bit = 0, bits = 32, order = 'little', form = 'signed', unit = 'mm', scale = 1e-3 },\n\
    { name = 'state', start_bit = 32, bits = 8, order = 'little', role = 'bits', out_of_range = ['0'], saturated = ['1'] }]";

impl Bench for DescribedCan {
    fn name(&self) -> &'static str {
        "described, CAN"
    }

    fn driver(&self) -> Box<dyn Driver> {
        let settings = FAMILY.parse("gauge", SETTINGS).expect("settings of a test are sound");
        settings.driver().expect("settings of a test are sound")
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Transducer { model, measured: 0, condition: Condition::Good })
    }

    fn is_can(&self) -> bool {
        true
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::{Absent, Marks};
        const SHORT: Mark = Mark::Fault("has 2 bytes, expected 5: check identifier and length");
        const GAP: Mark = Mark::Reopened("no frame for 500 ms: check cable and power");
        match fault {
            Fault::BadChecksum => Absent("CAN checks each frame, and delivers no damaged one"),
            Fault::Stall | Fault::Limit => Absent("it moves nothing"),
            Fault::LateAnswer => Absent("it sends by itself"),
            Fault::Repeated => Absent("two equal frames are two measurements"),
            Fault::OutOfRange => Marks(&[Mark::Flagged(Flags::OUT_OF_RANGE)]),
            Fault::Saturated => Marks(&[Mark::Flagged(Flags::SATURATED)]),
            Fault::Unplugged | Fault::HalfFrame | Fault::WrongDevice => {
                Marks(&[Mark::Discarded, SHORT])
            }
            Fault::Silent | Fault::BusOff | Fault::Restart => Marks(&[GAP]),
            Fault::ClockJump => Marks(&[Mark::Reopened("no frame for 3600000 ms")]),
            // Frames of other nodes are none of its own.
            Fault::Garbage | Fault::Slow | Fault::Burst => Marks(&[]),
        }
    }
}

struct Transducer {
    model: Model,
    measured: i32,
    condition: Condition,
}

impl Device for Transducer {
    fn receive(&mut self, _: Nanos, _: &Output) -> Vec<Sent> {
        Vec::new()
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_millis(10))
    }

    fn tick(&mut self, _: Nanos) -> Vec<Sent> {
        self.measured += 1;
        let mut data = self.measured.to_le_bytes().to_vec();
        data.push(match self.condition {
            Condition::OutOfRange => 1,
            Condition::Saturated => 2,
            _ => 0,
        });
        let is_good = self.condition == Condition::Good && self.model == Model::Right;
        if self.model == Model::Stranger {
            data.truncate(2);
        }
        let frame = CanFrame::data_frame(CanId::Standard(0x185), &data).expect("five bytes");
        let values = is_good.then(|| vec![Some(f64::from(self.measured) * 1e-3)]);
        vec![Sent::carrying(Output::Frame(frame), self.model == Model::Right, values)]
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }
}
