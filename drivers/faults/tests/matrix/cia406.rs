//! An encoder with CANopen that answers each SYNC, or sends by its event timer.

use std::time::Duration;

use asphera_cia406::wire::object;
use asphera_cia406::wire::{
    Expedited, NmtCommand, NmtRequest, NmtState, NodeId, SdoRequest, SdoResponse, heartbeat_frame,
    sync_frame,
};
use asphera_cia406::{Cia406 as Encoder, Settings, Transmission};
use asphera_faults::{Bench, Condition, Device, Expectation, Fault, Mark, Model, Sent};
use asphera_link::{CanFrame, CanId, Driver, Flags, Nanos, Output};

pub(crate) struct Cia406 {
    pub(crate) is_timed: bool,
}

impl Bench for Cia406 {
    fn name(&self) -> &'static str {
        if self.is_timed { "cia406, timer" } else { "cia406" }
    }

    fn driver(&self) -> Box<dyn Driver> {
        let mut settings =
            Settings { node_id: 5, map_status: true, sdo_timeout_ms: 100, ..Settings::default() };
        if self.is_timed {
            settings.transmission = Transmission::EventTimer { period_ms: 10 };
            settings.sync_counter_overflow = None;
        }
        Box::new(Encoder::new(settings).expect("settings of a test are sound"))
    }

    fn device(&self, model: Model) -> Box<dyn Device> {
        Box::new(Node {
            is_timed: self.is_timed,
            id: NodeId::new(5).expect("1 to 127"),
            // Profile 401 is that of inputs and outputs.
            device_type: if model == Model::Right { 0x0008_0196 } else { 0x0001_0191 },
            state: NmtState::PreOperational,
            syncs: 0,
            position: 0,
            condition: Condition::Good,
        })
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
        const MISSING: Mark = Mark::Fault("node 5 sent no position for SYNC 6: check the load");
        const TWICE: Mark = Mark::Fault("a position twice after one SYNC");
        const SHORT: Mark = Mark::Fault("TPDO1 of node 5 has 2 bytes, its mapping 5");
        match fault {
            Fault::BadChecksum => Absent("CAN checks each frame, and delivers no damaged one"),
            Fault::Saturated => Absent("the protocol has no word for it"),
            Fault::Stall | Fault::Limit => Absent("it moves nothing"),
            Fault::OutOfRange => Marks(&[Mark::Flagged(Flags::OUT_OF_RANGE)]),
            Fault::Unplugged => Marks(&[Mark::Discarded, SHORT]),
            Fault::HalfFrame if self.is_timed => Marks(&[Mark::Discarded, SHORT]),
            Fault::Repeated if self.is_timed => Absent("two equal positions are two measurements"),
            Fault::LateAnswer if self.is_timed => Absent("it sends by itself"),
            Fault::HalfFrame => {
                Marks(&[Mark::Flagged(Flags::TRIGGER_LOST), Mark::Discarded, SHORT, MISSING])
            }
            Fault::Silent | Fault::BusOff => Marks(&[Mark::Discarded, LOST, SILENT]),
            Fault::Repeated => Marks(&[Mark::Flagged(Flags::DELAYED), TWICE]),
            Fault::LateAnswer => Marks(&[
                Mark::Flagged(Flags::TRIGGER_LOST),
                Mark::Flagged(Flags::DELAYED),
                TWICE,
                MISSING,
            ]),
            Fault::Restart => {
                Marks(&[Mark::Fault("node 5 restarted, and is set up anew: check its power")])
            }
            Fault::WrongDevice => Marks(&[Mark::Fault("node 5 follows profile 401")]),
            Fault::ClockJump => Marks(&[Mark::Discarded, LOST]),
            // Frames of other nodes are none of its own.
            Fault::Garbage | Fault::Slow | Fault::Burst => Marks(&[]),
        }
    }
}

struct Node {
    is_timed: bool,
    id: NodeId,
    device_type: u32,
    state: NmtState,
    syncs: u32,
    position: u32,
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
            CanId::Standard(0x605) => {
                let value = match SdoRequest::decode(self.id, asked.data()) {
                    Ok(SdoRequest::Download(address, _)) => {
                        return vec![frame(SdoResponse::Downloaded(address).encode(self.id))];
                    }
                    Ok(SdoRequest::Upload(address)) => (address, self.object(address)),
                    _ => return Vec::new(),
                };
                vec![frame(SdoResponse::Uploaded(value.0, value.1).encode(self.id))]
            }
            _ => Vec::new(),
        }
    }

    fn period(&self) -> Option<Duration> {
        Some(Duration::from_millis(10))
    }

    /// The SYNC of another node, the position that answers it, and each tenth time the heartbeat.
    fn tick(&mut self, _: Nanos) -> Vec<Sent> {
        self.syncs += 1;
        let mut sent = Vec::new();
        if !self.is_timed {
            sent.push(frame(sync_frame(Some((self.syncs % 240 + 1) as u8))));
        }
        if self.state == NmtState::Operational {
            self.position += 1;
            let outside = self.condition == Condition::OutOfRange;
            let mut data = self.position.to_le_bytes().to_vec();
            data.push(u8::from(outside));
            let position = CanFrame::data_frame(CanId::Standard(0x185), &data);
            let position = position.expect("five bytes");
            // A step is 1 µm.
            let values = vec![Some(f64::from(self.position) / 1000.0), Some(0.0)];
            let values = (!outside).then_some(values);
            sent.push(Sent::carrying(Output::Frame(position), true, values));
        }
        if self.syncs.is_multiple_of(10) {
            sent.push(frame(heartbeat_frame(self.id, self.state)));
        }
        sent
    }

    fn restart(&mut self) -> Vec<Sent> {
        self.state = NmtState::PreOperational;
        vec![frame(heartbeat_frame(self.id, NmtState::BootUp))]
    }

    fn condition(&mut self, condition: Condition) {
        self.condition = condition;
    }
}

impl Node {
    fn object(&self, address: object::Address) -> Expedited {
        match (address.index, address.sub) {
            (0x1000, 0) => Expedited::u32(self.device_type),
            (0x1001, 0) => Expedited::u8(0),
            (0x1800, 1) => Expedited::u32(0x4000_0185),
            (0x1A00, 0) => Expedited::u8(2),
            (0x1A00, 1) => Expedited::u32(0x6020_0120),
            (0x1A00, 2) => Expedited::u32(0x6400_0108),
            _ => Expedited::u32(1000),
        }
    }
}
