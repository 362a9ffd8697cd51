//! Settings of one node.

use asphera_link::{Channel, Problem, Unit, check_range};

use crate::wire::object::{self, Address};
use crate::wire::{NodeId, TpdoLayout};

/// Settings of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Number of the node on the bus, 1 to 127.
    pub node_id: u8,
    /// CiA number the vendor must have (object 1018.01h), if that matters: MTS is 0x40.
    pub vendor_id: Option<u32>,
    /// Where the node keeps its position.
    pub position: PositionObject,
    /// What the position is.
    pub kind: Kind,
    /// Whether nothing is sent to the node: another master has set it up, or its frames come from a log. Steps and mapping
    /// are then those of these settings.
    pub listen_only: bool,
    /// Whether the velocity is sent too (linear encoders only): channel `velocity`, mm/s.
    pub map_velocity: bool,
    /// Step of the velocity in mm/s, above 0. `None`: read from object 6005.02h.
    pub velocity_step_mm_s: Option<f64>,
    /// Whether the state of the work area (object 6400.01h) is sent too: channel `status`, and
    /// readings outside are flagged out of range.
    pub map_status: bool,
    /// When positions are sent.
    pub transmission: Transmission,
    /// Highest number of the SYNC counter, 2 to 240, as the producer of SYNC has it in its object
    /// 1019h; written to the node too, which may refuse a SYNC of one byte without. `None`: SYNC has
    /// no counter, and readings have no count.
    pub sync_counter_overflow: Option<u8>,
    /// How long after a SYNC, in µs, a position may reach the host and still be its answer; later ones
    /// get no count. Set it between the longest time the node and the adapter take and the period of
    /// SYNC: it is what tells a late position from a prompt one. `None`: any time until the next SYNC.
    pub sync_window_us: Option<u32>,
    /// Time between the node's heartbeats in ms, 10 to 32767. The node counts as lost after twice
    /// that: one heartbeat may be missed, two may not.
    pub heartbeat_ms: u16,
    /// How long the node may take to answer one SDO in ms, 1 to 60000. Asked three times.
    pub sdo_timeout_ms: u32,
}

/// Where a node keeps its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PositionObject {
    /// 6020.01h, INTEGER32: linear transducers with one or more sensors (MTS p.32, TR p.165).
    MultiSensor,
    /// 6004h, INTEGER32: linear encoders with one sensor (TR p.165).
    Single,
    /// 6004h, UNSIGNED32: rotary encoders.
    SingleUnsigned,
}

/// What a position is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A length: channel `position` in mm.
    Linear {
        /// Step in nm, above 0. `None`: read from object 6005.01h, or 6501h where there is no 6005h.
        step_nm: Option<f64>,
    },
    /// An angle: channel `position` in rad.
    Rotary {
        /// Counts of one turn, at least 1 (object 6001h, or the nameplate).
        counts_per_turn: u32,
    },
    /// Counts, whose worth the kinematics knows: channel `position`.
    Counts,
}

/// When positions are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transmission {
    /// At every n-th SYNC, 1 to 240.
    Sync {
        /// n.
        every: u8,
    },
    /// At intervals the node keeps itself, in ms, 1 to 65535. Such readings have no count.
    EventTimer {
        /// The interval.
        period_ms: u16,
    },
}

impl Default for Settings {
    /// Node 1, a linear transducer that answers every SYNC and tells the step itself.
    fn default() -> Settings {
        Settings {
            node_id: 1,
            vendor_id: None,
            position: PositionObject::MultiSensor,
            kind: Kind::Linear { step_nm: None },
            listen_only: false,
            map_velocity: false,
            velocity_step_mm_s: None,
            map_status: false,
            transmission: Transmission::Sync { every: 1 },
            sync_counter_overflow: Some(240),
            sync_window_us: None,
            heartbeat_ms: 500,
            sdo_timeout_ms: 200,
        }
    }
}

impl Settings {
    /// All that is wrong with them; empty if they can be used.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        check_range(&mut problems, "node_id", self.node_id, 1, 127);
        match self.kind {
            Kind::Linear { step_nm: Some(step) } if !(step > 0.0 && step.is_finite()) => {
                problems.push(Problem::new("step_nm", "a length above 0", step));
            }
            Kind::Rotary { counts_per_turn: 0 } => {
                problems.push(Problem::new("counts_per_turn", "1 or more", 0));
            }
            _ => {}
        }
        if self.map_velocity && !matches!(self.kind, Kind::Linear { .. }) {
            problems.push(Problem::new("map_velocity", "false unless the kind is linear", true));
        }
        if let Some(step) =
            self.velocity_step_mm_s.filter(|step| !(*step > 0.0 && step.is_finite()))
        {
            problems.push(Problem::new("velocity_step_mm_s", "a speed above 0", step));
        }
        if self.listen_only {
            self.unknown_to_a_listener(&mut problems);
        }
        match self.transmission {
            Transmission::Sync { every } => {
                check_range(&mut problems, "every_sync", every, 1, 240);
            }
            Transmission::EventTimer { period_ms } => {
                check_range(&mut problems, "event_timer_ms", period_ms, 1, u16::MAX);
            }
        }
        if let Some(overflow) = self.sync_counter_overflow {
            check_range(&mut problems, "sync_counter_overflow", overflow, 2, 240);
        }
        if self.sync_window_us == Some(0) {
            problems.push(Problem::new("sync_window_us", "1 or more", 0));
        }
        check_range(&mut problems, "heartbeat_ms", self.heartbeat_ms, 10, 32_767);
        check_range(&mut problems, "sdo_timeout_ms", self.sdo_timeout_ms, 1, 60_000);
        problems
    }

    /// Settings that the node cannot be asked for.
    fn unknown_to_a_listener(&self, problems: &mut Vec<Problem>) {
        let nothing = "nothing, and listen_only = true asks no node";
        if matches!(self.kind, Kind::Linear { step_nm: None }) {
            problems.push(Problem::new("step_nm", "the step of the position in nm", nothing));
        }
        if self.map_velocity && self.velocity_step_mm_s.is_none() {
            let expected = "the step of the velocity in mm/s";
            problems.push(Problem::new("velocity_step_mm_s", expected, nothing));
        }
        if let Some(vendor) = self.vendor_id {
            let expected = "no vendor: listen_only = true asks no node";
            problems.push(Problem::new("vendor_id", expected, format!("{vendor:X}h")));
        }
    }

    /// The node, where its number is one.
    pub(crate) fn node(&self) -> Option<NodeId> {
        NodeId::new(self.node_id).ok()
    }

    /// The channels of the readings.
    pub(crate) fn channels(&self) -> Vec<Channel> {
        let unit = match self.kind {
            Kind::Linear { .. } => Unit::Millimetre,
            Kind::Rotary { .. } => Unit::Radian,
            Kind::Counts => Unit::Count,
        };
        let mut channels = vec![Channel::new("position", unit)];
        if self.map_velocity {
            channels.push(Channel::new("velocity", Unit::MillimetrePerSecond));
        }
        if self.map_status {
            channels.push(Channel::new("status", Unit::One));
        }
        channels
    }

    /// What TPDO1 is to hold.
    pub(crate) fn layout(&self) -> TpdoLayout {
        TpdoLayout {
            position: self.position.address(),
            velocity: self.map_velocity,
            area_state: self.map_status,
        }
    }
}

impl PositionObject {
    /// The object.
    pub const fn address(self) -> Address {
        match self {
            PositionObject::MultiSensor => object::POSITION_1,
            PositionObject::Single | PositionObject::SingleUnsigned => object::POSITION,
        }
    }

    /// The number of counts the four bytes of a position mean.
    pub const fn counts(self, raw: u32) -> i64 {
        match self {
            PositionObject::MultiSensor | PositionObject::Single => raw.cast_signed() as i64,
            PositionObject::SingleUnsigned => raw as i64,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_can_be_used() {
        assert_eq!(Settings::default().problems(), []);
    }

    #[test]
    fn all_that_is_wrong_is_told_at_once() {
        let settings = Settings {
            node_id: 128,
            kind: Kind::Rotary { counts_per_turn: 0 },
            map_velocity: true,
            transmission: Transmission::Sync { every: 241 },
            sync_counter_overflow: Some(1),
            sync_window_us: Some(0),
            heartbeat_ms: 0,
            sdo_timeout_ms: 0,
            ..Settings::default()
        };
        let keys: Vec<_> = settings.problems().into_iter().map(|problem| problem.key).collect();
        let expected = [
            "node_id",
            "counts_per_turn",
            "map_velocity",
            "every_sync",
            "sync_counter_overflow",
            "sync_window_us",
            "heartbeat_ms",
            "sdo_timeout_ms",
        ];
        assert_eq!(keys, expected);
        for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let kind = Kind::Linear { step_nm: Some(step) };
            assert_eq!(Settings { kind, ..Settings::default() }.problems().len(), 1, "{step}");
        }
    }

    #[test]
    fn a_position_below_zero_is_signed_where_the_object_is() {
        let raw = (-7_i32).cast_unsigned();
        assert_eq!(PositionObject::MultiSensor.counts(raw), -7);
        assert_eq!(PositionObject::Single.counts(raw), -7);
        assert_eq!(PositionObject::SingleUnsigned.counts(raw), 4_294_967_289);
    }
}
