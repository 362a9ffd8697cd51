//! What a node is asked and told before it may measure.

use asphera_link::{Fault, FaultKind};

use crate::wire::object::{self, Address};
use crate::wire::{AbortCode, Cob, Expedited, MappedObject, NodeId, SdoRequest};
use crate::{Kind, Settings, Transmission};

/// The sequence of requests that sets a node up, one in flight at a time.
///
/// The order of the mapping is the one CiA 301 asks for: switch the PDO off, its count to 0, the
/// entries, the count, switch it on. A mapping that is already right is left alone: some devices
/// have a fixed one.
#[derive(Clone, Debug)]
pub(super) struct Setup {
    node: NodeId,
    step: Step,
    /// Identifier and flags of the TPDO, without the bit that switches it off.
    tpdo_cob: u32,
    learned: Learned,
}

/// What the node told about itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct Learned {
    /// Step of the position in nm; of use for linear encoders only.
    pub(super) step_nm: f64,
    /// Step of the velocity in mm/s; of use where the velocity is mapped only.
    pub(super) velocity_step_mm_s: f64,
    /// Whether its error register is not empty.
    pub(super) error: bool,
}

/// Where the sequence goes after an answer.
#[derive(Debug)]
pub(super) enum Progress {
    /// To the next request; a person may have to know something.
    Next(Option<Fault>),
    /// To its end.
    Done(Learned),
    /// Nowhere.
    Failed(Fault),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    DeviceType,
    Vendor(u32),
    ErrorRegister,
    TpdoCob,
    TpdoOff,
    TpdoType,
    EventTimer(u16),
    MapCount,
    MapEntry(u8),
    MapClear,
    MapWrite(u8),
    MapClose,
    LinearScale,
    SensorScale,
    SpeedScale,
    SyncOverflow(u8),
    HeartbeatTime,
    TpdoOn,
}

impl Setup {
    pub(super) fn new(node: NodeId, settings: &Settings) -> Setup {
        let step_nm = match settings.kind {
            Kind::Linear { step_nm: Some(step) } => step,
            _ => 0.0,
        };
        Setup {
            node,
            step: Step::DeviceType,
            tpdo_cob: 0,
            learned: Learned {
                step_nm,
                velocity_step_mm_s: settings.velocity_step_mm_s.unwrap_or(0.0),
                error: false,
            },
        }
    }

    /// Whether the node is known to be what it should be.
    pub(super) fn is_identified(&self) -> bool {
        !matches!(self.step, Step::DeviceType | Step::Vendor(_))
    }

    /// The request to send now.
    pub(super) fn request(&self, settings: &Settings) -> SdoRequest {
        let entry = |index| settings.layout().object(index).map_or(0, MappedObject::entry);
        let sub = |index| Address::new(object::TPDO1_MAPPING.index, index + 1);
        let write = SdoRequest::Download;
        match self.step {
            Step::DeviceType => SdoRequest::Upload(object::DEVICE_TYPE),
            Step::Vendor(_) => SdoRequest::Upload(object::VENDOR),
            Step::ErrorRegister => SdoRequest::Upload(object::ERROR_REGISTER),
            Step::TpdoCob => SdoRequest::Upload(object::TPDO1_COB),
            Step::TpdoOff => {
                write(object::TPDO1_COB, Expedited::u32(self.tpdo_cob | object::PDO_INVALID))
            }
            Step::TpdoType => {
                let kind = match settings.transmission {
                    Transmission::Sync { every } => every,
                    Transmission::EventTimer { .. } => EVENT_DRIVEN,
                };
                write(object::TPDO1_TYPE, Expedited::u8(kind))
            }
            Step::EventTimer(period_ms) => {
                write(object::TPDO1_EVENT_TIMER, Expedited::u16(period_ms))
            }
            Step::MapCount => SdoRequest::Upload(object::TPDO1_MAPPING),
            Step::MapEntry(index) => SdoRequest::Upload(sub(index)),
            Step::MapClear => write(object::TPDO1_MAPPING, Expedited::u8(0)),
            Step::MapWrite(index) => write(sub(index), Expedited::u32(entry(index))),
            Step::MapClose => {
                write(object::TPDO1_MAPPING, Expedited::u8(settings.layout().count()))
            }
            Step::LinearScale => SdoRequest::Upload(object::POSITION_STEP),
            Step::SensorScale => SdoRequest::Upload(object::MEASURING_STEP),
            Step::SpeedScale => SdoRequest::Upload(object::VELOCITY_STEP),
            Step::SyncOverflow(overflow) => write(object::SYNC_OVERFLOW, Expedited::u8(overflow)),
            Step::HeartbeatTime => {
                write(object::HEARTBEAT_TIME, Expedited::u16(settings.heartbeat_ms))
            }
            Step::TpdoOn => write(object::TPDO1_COB, Expedited::u32(self.tpdo_cob)),
        }
    }

    /// Takes the answer to [`Setup::request`]: the value read (0 after a write), or the refusal.
    pub(super) fn answered(
        &mut self,
        settings: &Settings,
        answer: Result<u32, AbortCode>,
    ) -> Progress {
        let value = match answer {
            Ok(value) => value,
            Err(code) => return self.refused(settings, code),
        };
        let count = settings.layout().count();
        let mut told = None;
        let next = match self.step {
            Step::DeviceType if value as u16 != object::PROFILE_406 => {
                return self.failed(format!(
                    "node {} follows profile {} (device type {value:08X}h), expected 406: set node_id, or connect an encoder",
                    self.node, value as u16
                ));
            }
            Step::DeviceType => settings.vendor_id.map_or(Step::ErrorRegister, Step::Vendor),
            Step::Vendor(vendor) if value != vendor => {
                return self.failed(format!(
                    "node {} has vendor {value:X}h, expected {vendor:X}h: set vendor_id, or connect the right node",
                    self.node
                ));
            }
            Step::Vendor(_) => Step::ErrorRegister,
            Step::ErrorRegister => {
                self.learned.error = value != 0;
                told = self.learned.error.then(|| Fault {
                    kind: FaultKind::Device,
                    detail: format!(
                        "node {} has error register {value:02X}h: see its manual",
                        self.node
                    ),
                });
                Step::TpdoCob
            }
            Step::TpdoCob => {
                self.tpdo_cob = self.usable_cob(value);
                Step::TpdoOff
            }
            Step::TpdoOff => Step::TpdoType,
            Step::TpdoType => match settings.transmission {
                Transmission::EventTimer { period_ms } => Step::EventTimer(period_ms),
                Transmission::Sync { .. } => Step::MapCount,
            },
            Step::EventTimer(_) => Step::MapCount,
            Step::MapCount if value == u32::from(count) => Step::MapEntry(0),
            Step::MapCount => Step::MapClear,
            Step::MapEntry(index)
                if settings.layout().object(index).map(MappedObject::entry) != Some(value) =>
            {
                Step::MapClear
            }
            Step::MapEntry(index) if index + 1 < count => Step::MapEntry(index + 1),
            Step::MapEntry(_) => after_mapping(settings),
            Step::MapClear => Step::MapWrite(0),
            Step::MapWrite(index) if index + 1 < count => Step::MapWrite(index + 1),
            Step::MapWrite(_) => Step::MapClose,
            Step::MapClose => after_mapping(settings),
            Step::LinearScale | Step::SensorScale | Step::SpeedScale if value == 0 => {
                let detail = format!(
                    "node {} says its {} is 0: set step_nm",
                    self.node,
                    self.address(settings)
                );
                return Progress::Failed(Fault { kind: FaultKind::Protocol, detail });
            }
            Step::LinearScale | Step::SensorScale => {
                // 0.001 µm is 1 nm.
                self.learned.step_nm = value.into();
                after_linear_scale(settings)
            }
            Step::SpeedScale => {
                self.learned.velocity_step_mm_s = f64::from(value) / 100.0;
                after_speed_scale(settings)
            }
            Step::SyncOverflow(_) => Step::HeartbeatTime,
            Step::HeartbeatTime => Step::TpdoOn,
            Step::TpdoOn => return Progress::Done(self.learned),
        };
        self.step = next;
        Progress::Next(told)
    }

    fn refused(&mut self, settings: &Settings, code: AbortCode) -> Progress {
        let address = self.address(settings);
        let verb = match self.request(settings) {
            SdoRequest::Download(_, value) => format!("writing {:X}h to", value.number()),
            _ => "reading".to_owned(),
        };
        let detail = format!("node {} refused {verb} {address}: {code}; see its manual", self.node);
        let fault = Fault { kind: FaultKind::Refused, detail };
        self.step = match self.step {
            // Mandatory, but nothing depends on it: emergencies tell the same.
            Step::ErrorRegister if code.is_absent() => Step::TpdoCob,
            Step::LinearScale if code.is_absent() => {
                self.step = Step::SensorScale;
                return Progress::Next(None);
            }
            // A node may answer a counted SYNC all the same. If not, its positions will be missing
            // and the fault says why.
            Step::SyncOverflow(_) => Step::HeartbeatTime,
            _ => return Progress::Failed(fault),
        };
        Progress::Next(Some(fault))
    }

    fn address(&self, settings: &Settings) -> Address {
        self.request(settings).address()
    }

    fn failed(&self, detail: String) -> Progress {
        Progress::Failed(Fault { kind: FaultKind::Refused, detail })
    }

    /// What to write as identifier of the TPDO: what the node has, if that is the one of the
    /// predefined set, since some nodes refuse any other flags; else that one.
    fn usable_cob(&self, found: u32) -> u32 {
        const EXTENDED: u32 = 1 << 29;
        let predefined = u32::from(Cob::Tpdo1(self.node).id());
        if found & (EXTENDED | 0x1FFF_FFFF) == predefined {
            found & !object::PDO_INVALID
        } else {
            predefined | object::PDO_NO_REMOTE
        }
    }
}

/// Transmission type "by events of the device profile", the event timer among them (MTS p.36).
const EVENT_DRIVEN: u8 = 254;

fn after_mapping(settings: &Settings) -> Step {
    match settings.kind {
        Kind::Linear { step_nm: None } => Step::LinearScale,
        _ => after_linear_scale(settings),
    }
}

fn after_linear_scale(settings: &Settings) -> Step {
    if settings.map_velocity && settings.velocity_step_mm_s.is_none() {
        Step::SpeedScale
    } else {
        after_speed_scale(settings)
    }
}

fn after_speed_scale(settings: &Settings) -> Step {
    match (settings.transmission, settings.sync_counter_overflow) {
        (Transmission::Sync { .. }, Some(overflow)) => Step::SyncOverflow(overflow),
        _ => Step::HeartbeatTime,
    }
}
