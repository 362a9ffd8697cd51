//! A drive after CiA 402 with an absolute encoder, which sends its position by itself.

use std::time::Duration;

use asphera_cia402::wire::{
    Address, Expedited, NmtCommand, NmtRequest, NmtState, NodeId, SdoRequest, SdoResponse,
    Statusword, encode_tpdo, heartbeat_frame, object,
};
use asphera_cia402::{Cia402 as Drive, Reference, Settings};
use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{AxisMove, CanFrame, CanId, Driver, Motion, Nanos, Output};

pub(crate) struct Cia402;

impl Bench for Cia402 {
    fn name(&self) -> &'static str {
        "cia402"
    }

    fn driver(&self) -> Box<dyn Driver> {
        let settings = Settings {
            node_id: 5,
            sdo_timeout_ms: 100,
            reference: Reference::Absolute,
            ..Settings::default()
        };
        Box::new(Drive::new(settings).expect("settings of a test are sound"))
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Node {
            id: NodeId::new(5).expect("1 to 127"),
            // Profile 401 is that of inputs and outputs.
            device_type: if model == Model::Right { 0x0002_0192 } else { 0x0001_0191 },
            state: NmtState::PreOperational,
            control: 0,
            mode: 0,
            ticks: 0,
            position: 0,
            condition: Condition::Good,
        })
    }

    fn movement(&self) -> Option<Motion> {
        let axis = "position".to_owned();
        Some(Motion::Move(vec![AxisMove { axis, to: 5.0, speed: 1.0, acceleration: None }]))
    }

    fn is_can(&self) -> bool {
        true
    }

    fn lateness(&self) -> Duration {
        Duration::from_millis(25)
    }

    fn recovery(&self) -> Duration {
        Duration::from_secs(15)
    }

    fn expects(&self, fault: Fault) -> Expectation {
        use Expectation::{Absent, Marks};
        const LOST: Mark = Mark::Fault("no heartbeat of node 5 within 1000 ms: check its power");
        const SILENT: Mark =
            Mark::Fault("node 5 did not answer for 1000.00h within 3 times 100 ms");
        const UNHALTED: &str =
            "the drive does not stand after a quick stop, sent 5 times: press the";
        const SHORT: Mark = Mark::Fault("TPDO1 of node 5 has 3 bytes, its mapping 6");
        match fault {
            Fault::BadChecksum => Absent("CAN checks each frame, and delivers no damaged one"),
            Fault::Saturated | Fault::OutOfRange => Absent("a stage measures its own place"),
            Fault::Unplugged | Fault::HalfFrame => Marks(&[Mark::Discarded, SHORT]),
            Fault::BusOff => Marks(&[Mark::Discarded, LOST, SILENT]),
            Fault::Silent => Marks(&[Mark::Discarded, SILENT, Mark::Halted(UNHALTED)]),
            Fault::Restart => {
                Marks(&[Mark::Fault("node 5 restarted, and is set up anew: check its power")])
            }
            Fault::WrongDevice => Marks(&[Mark::Fault("node 5 follows profile 401")]),
            Fault::ClockJump => Marks(&[Mark::Discarded, LOST]),
            Fault::Repeated => Absent("two equal positions are two measurements"),
            Fault::LateAnswer => Absent("it sends by itself"),
            Fault::Stall => {
                Marks(&[Mark::Halted("following error): look whether something blocks")])
            }
            Fault::Limit => Marks(&[Mark::Halted("a limit of the drive: move it away from there")]),
            // Frames of other nodes are none of its own.
            Fault::Garbage | Fault::Slow | Fault::Burst => Marks(&[]),
        }
    }
}

struct Node {
    id: NodeId,
    device_type: u32,
    state: NmtState,
    control: u16,
    mode: u8,
    ticks: u32,
    position: i32,
    condition: Condition,
}

fn frame(frame: CanFrame) -> Sent {
    Sent::carrying(Output::Frame(frame), false, None)
}

impl Device for Node {
    fn receive(&mut self, _: Nanos, parcel: &Output) -> Vec<Sent> {
        let Output::Frame(asked) = parcel else { return Vec::new() };
        match asked.id() {
            CanId::Standard(0) => {
                if let Ok(NmtRequest { command, .. }) = NmtRequest::decode(asked.data()) {
                    self.state = match command {
                        NmtCommand::Start => NmtState::Operational,
                        _ => NmtState::PreOperational,
                    };
                }
                Vec::new()
            }
            CanId::Standard(0x605) => match SdoRequest::decode(self.id, asked.data()) {
                Ok(SdoRequest::Download(address, value)) => {
                    match address {
                        object::CONTROLWORD => self.control = value.number() as u16,
                        object::MODE => self.mode = value.number() as u8,
                        _ => {}
                    }
                    vec![frame(SdoResponse::Downloaded(address).encode(self.id))]
                }
                Ok(SdoRequest::Upload(address)) => {
                    let value = self.object(address);
                    vec![frame(SdoResponse::Uploaded(address, value).encode(self.id))]
                }
                _ => Vec::new(),
            },
            _ => Vec::new(),
        }
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_millis(10))
    }

    /// The position, and each tenth time the heartbeat.
    fn tick(&mut self, _: Nanos) -> Vec<Sent> {
        self.ticks += 1;
        let mut sent = Vec::new();
        if self.state == NmtState::Operational {
            self.position += 1;
            let data = encode_tpdo(self.status(), self.position);
            let position = CanFrame::data_frame(CanId::Standard(0x185), &data);
            let position = position.expect("six bytes");
            let values = vec![Some(f64::from(self.position) / 1000.0)];
            sent.push(Sent::carrying(Output::Frame(position), true, Some(values)));
        }
        if self.ticks.is_multiple_of(10) {
            sent.push(frame(heartbeat_frame(self.id, self.state)));
        }
        sent
    }

    fn restart(&mut self) -> Vec<Sent> {
        self.state = NmtState::PreOperational;
        self.control = 0;
        vec![frame(heartbeat_frame(self.id, NmtState::BootUp))]
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }

    fn is_motion(&self, parcel: &Output) -> bool {
        let Output::Frame(sent) = parcel else { return false };
        let request = SdoRequest::decode(self.id, sent.data());
        matches!(request, Ok(SdoRequest::Download(object::CONTROLWORD, word)) if word.number() & 0x10 != 0)
    }
}

impl Node {
    /// A drive that follows its controlword at once, and never arrives.
    fn status(&self) -> Statusword {
        let state = match self.control & 0x0F {
            0x06 => 0x21,
            0x07 => 0x23,
            0x0F => 0x27,
            // It stands in quick stop.
            0x02 => 0x07 | 1 << 10,
            _ => 0x40,
        };
        let acknowledged = (self.control & 0x10) << 8;
        let trouble = match self.condition {
            Condition::Stalled => 1 << 13,
            Condition::Limit => 1 << 11,
            _ => 0,
        };
        Statusword(state | acknowledged | trouble)
    }

    fn object(&self, address: Address) -> Expedited {
        match address {
            object::DEVICE_TYPE => Expedited::u32(self.device_type),
            object::ERROR_REGISTER => Expedited::u8(0),
            object::SUPPORTED_MODES => Expedited::u32(0x21),
            object::STATUSWORD => Expedited::u16(self.status().0),
            object::MODE_DISPLAY => Expedited::u8(self.mode),
            _ => Expedited::u32(0),
        }
    }
}
