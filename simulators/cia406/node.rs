//! One simulated node.

use std::time::Duration;

use asphera_cia406::wire::object::{self, Address};
use asphera_cia406::wire::{
    Cob, Emergency, NmtCommand, NmtState, NodeId, SdoRequest, SdoResponse, heartbeat_frame,
};
use asphera_link::{CanFrame, CanId, Nanos};

use crate::dictionary::Dictionary;

/// What a simulated node is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NodeConfig {
    /// Its number, 1 to 127.
    pub node_id: u8,
    /// Object 1000h; the low word is the profile.
    pub device_type: u32,
    /// Object 1018.01h.
    pub vendor_id: u32,
    /// Where it keeps its position: 6020.01h or 6004h.
    pub position: Address,
    /// Object 6005.01h and 6501h, in nm.
    pub position_step_nm: u32,
    /// Object 6005.02h, in 0.01 mm/s.
    pub velocity_step_10_um_s: u32,
    /// Work area in counts, both ends inside; the position is reported as out of range beyond.
    pub work_area: Option<(i32, i32)>,
    /// Whether the mapping of the TPDO cannot be changed.
    pub fixed_mapping: bool,
    /// Indexes it does not have, as older devices lack 1019h or 6005h.
    pub absent: Vec<u16>,
}

impl Default for NodeConfig {
    /// A linear transducer with one sensor after the MTS E-Series manual, pages 32 and 33: node 1,
    /// steps of 1 µm, TPDO of seven bytes every ms.
    fn default() -> NodeConfig {
        NodeConfig {
            node_id: 1,
            device_type: 0x0008_0196,
            vendor_id: 0x40,
            position: object::POSITION_1,
            position_step_nm: 1000,
            velocity_step_10_um_s: 100,
            work_area: None,
            fixed_mapping: false,
            absent: Vec::new(),
        }
    }
}

/// One node: what it is, and what it is doing.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    id: NodeId,
    config: NodeConfig,
    dictionary: Dictionary,
    state: NmtState,
    heartbeat_due: Option<Nanos>,
    event_due: Option<Nanos>,
    /// SYNCs since the TPDO was last sent.
    syncs: u8,
    position: i32,
    velocity: i16,
    /// TPDOs still to be lost.
    drop_tpdos: u32,
    bad_sync_told: bool,
}

impl Node {
    pub(crate) fn new(id: NodeId, config: NodeConfig) -> Node {
        let dictionary = Dictionary::new(&config, Cob::Tpdo1(id));
        Node {
            id,
            config,
            dictionary,
            state: NmtState::PreOperational,
            heartbeat_due: None,
            event_due: None,
            syncs: 0,
            position: 0,
            velocity: 0,
            drop_tpdos: 0,
            bad_sync_told: false,
        }
    }

    pub(crate) fn id(&self) -> NodeId {
        self.id
    }

    pub(crate) fn is_armed(&self) -> bool {
        self.state == NmtState::Operational && self.dictionary.tpdo_enabled()
    }

    /// Starts as after power-on and says so.
    pub(crate) fn boot(&mut self) -> CanFrame {
        let (position, velocity) = (self.position, self.velocity);
        *self = Node { position, velocity, ..Node::new(self.id, self.config.clone()) };
        heartbeat_frame(self.id, NmtState::BootUp)
    }

    pub(crate) fn set_motion(&mut self, position: i32, velocity: i16) {
        self.position = position;
        self.velocity = velocity;
    }

    pub(crate) fn set_position(&mut self, position: i32) {
        self.position = position;
    }

    pub(crate) fn drop_next_tpdo(&mut self) {
        self.drop_tpdos += 1;
    }

    /// Has an error, or none any more (`code` 0).
    pub(crate) fn emergency(&mut self, code: u16, register: u8) -> CanFrame {
        self.dictionary.set(object::ERROR_REGISTER, register.into());
        Emergency { code, register, manufacturer: [0; 5] }.encode(self.id)
    }

    pub(crate) fn command(&mut self, now: Nanos, command: NmtCommand) -> Option<CanFrame> {
        match command {
            NmtCommand::Start => {
                self.state = NmtState::Operational;
                self.syncs = 0;
                self.event_due = self.event_period().map(|period| now + period);
            }
            NmtCommand::Stop => self.leave(NmtState::Stopped),
            NmtCommand::EnterPreOperational => self.leave(NmtState::PreOperational),
            NmtCommand::ResetNode | NmtCommand::ResetCommunication => return Some(self.boot()),
        }
        None
    }

    pub(crate) fn request(&mut self, now: Nanos, data: &[u8]) -> Option<CanFrame> {
        if self.state == NmtState::Stopped {
            return None;
        }
        let response = match SdoRequest::decode(self.id, data) {
            Ok(SdoRequest::Upload(address)) => match self.dictionary.upload(address) {
                Ok(value) => SdoResponse::Uploaded(address, value),
                Err(code) => SdoResponse::Aborted(address, code),
            },
            Ok(SdoRequest::Download(address, value)) => {
                match self.dictionary.download(address, value) {
                    Ok(()) => {
                        self.written(now, address);
                        SdoResponse::Downloaded(address)
                    }
                    Err(code) => SdoResponse::Aborted(address, code),
                }
            }
            Ok(SdoRequest::Abort(..)) => return None,
            Err(_) => {
                let &[_, low, high, sub, ..] = data else { return None };
                let address = Address::new(u16::from_le_bytes([low, high]), sub);
                let code = asphera_cia406::wire::AbortCode::UNKNOWN_COMMAND;
                SdoResponse::Aborted(address, code)
            }
        };
        Some(response.encode(self.id))
    }

    /// Takes a SYNC: the TPDO, or the emergency 8240h "unexpected SYNC data length".
    pub(crate) fn sync(&mut self, data: &[u8]) -> Option<CanFrame> {
        if self.state != NmtState::Operational {
            return None;
        }
        let counted = self.dictionary.value(object::SYNC_OVERFLOW) != 0;
        if data.len() != usize::from(counted) {
            let told = std::mem::replace(&mut self.bad_sync_told, true);
            return (!told).then(|| self.emergency(0x8240, 0x11));
        }
        self.bad_sync_told = false;
        let every = self.dictionary.value(object::TPDO1_TYPE);
        if !(1..=240).contains(&every) {
            return None;
        }
        self.syncs += 1;
        if u32::from(self.syncs) < every {
            return None;
        }
        self.syncs = 0;
        self.tpdo()
    }

    pub(crate) fn poll_timeout(&self) -> Option<Nanos> {
        self.heartbeat_due.into_iter().chain(self.event_due).min()
    }

    pub(crate) fn timeout(&mut self, now: Nanos, out: &mut Vec<CanFrame>) {
        if self.heartbeat_due.is_some_and(|due| due <= now) {
            out.push(heartbeat_frame(self.id, self.state));
            self.heartbeat_due = self.heartbeat_period().map(|period| now + period);
        }
        if self.event_due.is_some_and(|due| due <= now) {
            out.extend(self.tpdo());
            self.event_due = self.event_period().map(|period| now + period);
        }
    }

    fn leave(&mut self, state: NmtState) {
        self.state = state;
        self.event_due = None;
    }

    fn written(&mut self, now: Nanos, address: Address) {
        if address == object::HEARTBEAT_TIME {
            self.heartbeat_due = self.heartbeat_period().map(|period| now + period);
        }
    }

    fn heartbeat_period(&self) -> Option<Duration> {
        period(self.dictionary.value(object::HEARTBEAT_TIME))
    }

    fn event_period(&self) -> Option<Duration> {
        let by_event = self.dictionary.value(object::TPDO1_TYPE) >= 254;
        period(self.dictionary.value(object::TPDO1_EVENT_TIMER)).filter(|_| by_event)
    }

    /// The TPDO with what is mapped now, unless it is off or to be lost.
    fn tpdo(&mut self) -> Option<CanFrame> {
        if !self.is_armed() {
            return None;
        }
        if self.drop_tpdos > 0 {
            self.drop_tpdos -= 1;
            return None;
        }
        self.dictionary.set(self.config.position, self.position.cast_unsigned());
        self.dictionary.set(object::VELOCITY_1, self.velocity.cast_unsigned().into());
        self.dictionary.set(object::AREA_STATE_1, self.area_state());
        let mut data = Vec::with_capacity(8);
        for object in self.dictionary.mapped() {
            let value = self.dictionary.value(object.address).to_le_bytes();
            data.extend(&value[..usize::from(object.bits / 8)]);
        }
        CanFrame::data_frame(CanId::Standard(Cob::Tpdo1(self.id).id()), &data).ok()
    }

    /// Bits of object 6400h: out of range, overflow, underflow.
    fn area_state(&self) -> u32 {
        match self.config.work_area {
            Some((_, high)) if self.position > high => 0b011,
            Some((low, _)) if self.position < low => 0b101,
            _ => 0,
        }
    }
}

fn period(time_ms: u32) -> Option<Duration> {
    (time_ms > 0).then(|| Duration::from_millis(time_ms.into()))
}
