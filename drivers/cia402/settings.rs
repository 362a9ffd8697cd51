//! Settings of one drive.

use std::f64::consts::{PI, TAU};

use asphera_canopen::NodeId;
use asphera_link::{Channel, Problem, Unit, check_range};

/// Settings of one drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Number of the node on the bus, 1 to 127.
    pub node_id: u8,
    /// CiA number that the vendor must have, if that matters.
    pub vendor_id: Option<u32>,
    /// Name of the axis and of its channel.
    pub axis: String,
    /// Worth of a position count (objects 6064h and 607Ah).
    pub step: Step,
    /// Number of object 6081h for one position count per second.
    pub velocity_scale: f64,
    /// Number of objects 6083h, 6084h and 609Ah for one position count per second squared.
    pub acceleration_scale: f64,
    /// How it is known that positions count from home.
    pub reference: Reference,
    /// How the drive homes; `None`: it is never told to.
    pub homing: Option<Homing>,
    /// Time between two positions in ms, 1 to 65535.
    pub period_ms: u16,
    /// Time between the node's heartbeats in ms, 10 to 32767; it counts as lost after twice that.
    pub heartbeat_ms: u16,
    /// Time that an answer to one SDO may take in ms, 1 to 60000.
    pub sdo_timeout_ms: u32,
    /// Time that the drive may take to change its state or mode in ms, 10 to 60000.
    pub state_timeout_ms: u32,
}

/// Worth of a position count, larger than 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Of a linear axis, in nm.
    Nanometres(f64),
    /// Of a rotary axis, as counts a turn.
    CountsPerTurn(f64),
}

/// How it is known that positions count from home.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// Homed since the drive started: bit 12 of the statusword in homing mode says so.
    Homing,
    /// The encoder is absolute: it always does.
    Absolute,
}

/// How a drive homes. Speeds and accelerations are in mm or rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Homing {
    /// Homing method (object 6098h), −128 to 127, but not 0.
    pub method: i8,
    /// Speed of the search for the switch, and of that for zero (object 6099h), a second.
    pub speeds: [f64; 2],
    /// Acceleration (object 609Ah), a second squared; `None`: that which the drive has.
    pub acceleration: Option<f64>,
    /// Place of home (object 607Ch).
    pub offset: f64,
}

impl Step {
    /// Unit of the channel, and a count in it.
    pub(crate) fn in_channel(self) -> (Unit, f64) {
        match self {
            Step::Nanometres(nm) => (Unit::Millimetre, nm * 1e-6),
            Step::CountsPerTurn(counts) => (Unit::Radian, TAU / counts),
        }
    }
}

impl Default for Settings {
    /// Node 1, a linear axis with counts of 1 µm, velocities in counts a second, that is never homed.
    fn default() -> Settings {
        Settings {
            node_id: 1,
            vendor_id: None,
            axis: "position".to_owned(),
            step: Step::Nanometres(1000.0),
            velocity_scale: 1.0,
            acceleration_scale: 1.0,
            reference: Reference::Homing,
            homing: None,
            period_ms: 10,
            heartbeat_ms: 500,
            sdo_timeout_ms: 200,
            state_timeout_ms: 2000,
        }
    }
}

impl Settings {
    /// All that is wrong with them; empty if they can be used.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        check_range(&mut problems, "node_id", self.node_id, 1, 127);
        if self.axis.trim().is_empty() {
            problems.push(Problem::new("axis", "a name of the axis", "an empty text"));
        }
        let positive = |problems: &mut Vec<Problem>, key: &str, value: f64| {
            if !(value > 0.0 && value.is_finite()) {
                problems.push(Problem::new(key, "a number above 0", value));
            }
        };
        match self.step {
            Step::Nanometres(nm) => positive(&mut problems, "step_nm", nm),
            Step::CountsPerTurn(counts) => positive(&mut problems, "counts_per_turn", counts),
        }
        positive(&mut problems, "velocity_scale", self.velocity_scale);
        positive(&mut problems, "acceleration_scale", self.acceleration_scale);
        if let Some(homing) = &self.homing {
            let keys = self.homing_keys();
            if homing.method == 0 {
                let expected = "a method that the drive has, not 0";
                problems.push(Problem::new("homing.method", expected, 0));
            }
            for (key, speed) in keys.iter().zip(homing.speeds) {
                positive(&mut problems, key, speed);
            }
            if let Some(acceleration) = homing.acceleration {
                positive(&mut problems, keys[2], acceleration);
            }
            if self.counts(homing.offset).is_none() {
                problems.push(Problem::new(
                    keys[3],
                    "a place within 32 bits of counts",
                    homing.offset,
                ));
            }
        }
        check_range(&mut problems, "period_ms", self.period_ms, 1, u16::MAX);
        check_range(&mut problems, "heartbeat_ms", self.heartbeat_ms, 10, 32_767);
        check_range(&mut problems, "sdo_timeout_ms", self.sdo_timeout_ms, 1, 60_000);
        check_range(&mut problems, "state_timeout_ms", self.state_timeout_ms, 10, 60_000);
        problems
    }

    /// Keys of homing: both speeds, acceleration, offset.
    pub(crate) fn homing_keys(&self) -> [&'static str; 4] {
        match self.step {
            Step::Nanometres(_) => [
                "homing.switch_mm_s",
                "homing.zero_mm_s",
                "homing.acceleration_mm_s2",
                "homing.offset_mm",
            ],
            Step::CountsPerTurn(_) => [
                "homing.switch_deg_s",
                "homing.zero_deg_s",
                "homing.acceleration_deg_s2",
                "homing.offset_deg",
            ],
        }
    }

    /// Worth of a key of homing in the unit of the channel.
    pub(crate) fn homing_unit(&self) -> f64 {
        match self.step {
            Step::Nanometres(_) => 1.0,
            Step::CountsPerTurn(_) => PI / 180.0,
        }
    }

    /// The node, where its number is one.
    pub(crate) fn node(&self) -> Option<NodeId> {
        NodeId::new(self.node_id).ok()
    }

    /// Channels of the readings.
    pub fn channels(&self) -> Vec<Channel> {
        vec![Channel::new(self.axis.clone(), self.step.in_channel().0)]
    }

    /// Counts of a place in mm or rad; `None` beyond what the object holds.
    pub(crate) fn counts(&self, place: f64) -> Option<i32> {
        let counts = (place / self.step.in_channel().1).round();
        (counts.abs() <= f64::from(i32::MAX)).then_some(counts as i32)
    }

    /// Number of object 6081h for a speed in mm/s or rad/s, above 0.
    pub(crate) fn velocity(&self, speed: f64) -> Option<u32> {
        above_zero(speed / self.step.in_channel().1 * self.velocity_scale)
    }

    /// Number of object 6083h for an acceleration in mm/s² or rad/s², above 0.
    pub(crate) fn acceleration(&self, value: f64) -> Option<u32> {
        above_zero(value / self.step.in_channel().1 * self.acceleration_scale)
    }
}

fn above_zero(number: f64) -> Option<u32> {
    let number = number.round();
    (number >= 1.0 && number <= f64::from(u32::MAX)).then_some(number as u32)
}
