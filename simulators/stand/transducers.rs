//! Transducers after CiA 406, as nodes of a simulated bus.

use asphera_cia406::wire::object::{self, Address};
use asphera_cia406::wire::{Expedited, MappedObject, NmtCommand, NmtRequest, NodeId, SdoRequest};
use asphera_cia406::{Kind, PositionObject, Settings, Transmission};
use asphera_link::CanFrame;
use asphera_sim_cia406::NodeConfig;

/// Why a node by these settings is not simulated; `None` where it is.
pub(crate) fn refusal(settings: &Settings) -> Option<&'static str> {
    match settings.transmission {
        Transmission::Sync { every: 2.. } => {
            Some("it answers some of the SYNCs only: with every_sync = 1 it is simulated")
        }
        Transmission::Sync { .. } | Transmission::EventTimer { .. } => None,
    }
}

/// Length of a count in the unit of the channel.
fn step(settings: &Settings) -> f64 {
    match settings.kind {
        Kind::Linear { step_nm: Some(step_nm) } if settings.listen_only => step_nm / NM_PER_MM,
        Kind::Linear { .. } => f64::from(step_nm(settings)) / NM_PER_MM,
        Kind::Rotary { counts_per_turn } => std::f64::consts::TAU / f64::from(counts_per_turn),
        Kind::Counts => 1.0,
    }
}

/// Step that the node says it has, nm.
fn step_nm(settings: &Settings) -> u32 {
    match settings.kind {
        Kind::Linear { step_nm: Some(step_nm) } if step_nm >= 1.0 => step_nm.round() as u32,
        _ => NodeConfig::default().position_step_nm,
    }
}

/// The value that is read where this one is sent.
pub(crate) fn shown(settings: &Settings, value: f64) -> f64 {
    (value / step(settings)).round() * step(settings)
}

/// Counts that the node sends for a value. A rotary encoder without a sign stands in the middle of its turns.
pub(crate) fn counts(settings: &Settings, value: f64) -> i32 {
    let counts = (value / step(settings)).round() as i64;
    match (settings.kind, settings.position) {
        (Kind::Rotary { counts_per_turn }, PositionObject::SingleUnsigned) => {
            let turns = (1_i64 << 31) / i64::from(counts_per_turn.max(1));
            // The bits of an unsigned number.
            (counts + turns * i64::from(counts_per_turn)) as u32 as i32
        }
        _ => counts as i32,
    }
}

/// Whether a node sends at every SYNC, not by a timer of its own.
pub(crate) fn is_synchronous(settings: &Settings) -> bool {
    matches!(settings.transmission, Transmission::Sync { .. })
}

/// The node by these settings.
pub(crate) fn node(settings: &Settings) -> NodeConfig {
    NodeConfig {
        node_id: settings.node_id,
        vendor_id: settings.vendor_id.unwrap_or(NodeConfig::default().vendor_id),
        position: settings.position.address(),
        position_step_nm: step_nm(settings),
        ..NodeConfig::default()
    }
}

/// Frames of the other master, which sets up a node that the station only listens to.
pub(crate) fn other_master(settings: &Settings) -> Vec<CanFrame> {
    let Some(node) = NodeId::new(settings.node_id).ok().filter(|_| settings.listen_only) else {
        return Vec::new();
    };
    let write = |address, value| SdoRequest::Download(address, value).encode(node);
    let mapped = [
        Some(MappedObject { address: settings.position.address(), bits: 32 }),
        settings.map_velocity.then_some(MappedObject { address: object::VELOCITY_1, bits: 16 }),
        settings.map_status.then_some(MappedObject { address: object::AREA_STATE_1, bits: 8 }),
    ];
    let cob = u32::from(asphera_cia406::wire::Cob::Tpdo1(node).id()) | object::PDO_NO_REMOTE;
    let mut frames = vec![
        write(object::TPDO1_COB, Expedited::u32(cob | object::PDO_INVALID)),
        write(object::TPDO1_MAPPING, Expedited::u8(0)),
    ];
    let mut count = 0;
    for object in mapped.into_iter().flatten() {
        count += 1;
        let address = Address::new(object::TPDO1_MAPPING.index, count);
        frames.push(write(address, Expedited::u32(object.entry())));
    }
    frames.push(write(object::TPDO1_MAPPING, Expedited::u8(count)));
    match settings.transmission {
        Transmission::Sync { every } => {
            frames.push(write(object::TPDO1_TYPE, Expedited::u8(every)));
            let overflow = settings.sync_counter_overflow.unwrap_or(0);
            frames.push(write(object::SYNC_OVERFLOW, Expedited::u8(overflow)));
        }
        Transmission::EventTimer { period_ms } => {
            frames.push(write(object::TPDO1_TYPE, Expedited::u8(BY_TIMER)));
            frames.push(write(object::TPDO1_EVENT_TIMER, Expedited::u16(period_ms)));
        }
    }
    frames.push(write(object::HEARTBEAT_TIME, Expedited::u16(settings.heartbeat_ms)));
    frames.push(write(object::TPDO1_COB, Expedited::u32(cob)));
    frames.push(NmtRequest::to(node, NmtCommand::Start).encode());
    frames
}

const NM_PER_MM: f64 = 1e6;
/// Transmission type of a PDO that is sent by event timer (CiA 301).
const BY_TIMER: u8 = 254;
