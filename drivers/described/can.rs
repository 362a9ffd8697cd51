//! Devices on a CAN bus, described by the place of each number in a frame.
//!
//! One frame is one reading. Its identifier tells the device; bits of its data are the numbers, counted as DBC files do.
//! The device sends by itself, or answers a frame.

use asphera_link::{CanFrame, CanId, Channel, Pace, Problem};

use crate::field::{Field, Role};

mod check;
mod device;
mod family;
mod signal;

pub use device::CanGauge;
pub(crate) use family::read;
pub use signal::{BitOrder, Signal, SignalForm};

/// A device on a bus: its frames, what stands in them, and what is sent to it.
#[derive(Clone, Debug, PartialEq)]
pub struct CanSettings {
    /// Identifier of the frames that are readings.
    pub id: CanId,
    /// Bits of the identifier that count; those of others may be anything.
    pub mask: u32,
    /// Whether the frames are CAN FD; else classic ones.
    pub fd: bool,
    /// Bytes that a frame must have; `None`: enough for the fields.
    pub length: Option<usize>,
    /// What stands in a frame; at least one channel.
    pub fields: Vec<CanField>,
    /// The question each reading answers; `None`: the device sends by itself.
    pub poll: Option<CanPoll>,
    /// Sent when the link opens, one after the other.
    pub on_connect: Vec<CanFrame>,
    /// Sent when measuring starts.
    pub on_start: Vec<CanFrame>,
    /// Sent when measuring stops.
    pub on_stop: Vec<CanFrame>,
    /// Longest time between two frames of a device that sends by itself, after which the link is opened anew: 10 to
    /// 3 600 000 ms; 0: any.
    pub gap_ms: u32,
}

/// One number of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct CanField {
    /// Its bits.
    pub signal: Signal,
    /// What they mean. Place and form of the field say nothing here: the signal does.
    pub meaning: Field,
}

/// A frame sent again and again, which the device answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CanPoll {
    /// The frame.
    pub ask: CanFrame,
    /// Time from one to the next, 1 to 3 600 000 ms.
    pub interval_ms: u32,
    /// Time the answer may take, 1 to 60 000 ms.
    pub timeout_ms: u32,
    /// Silence after which no late answer is expected any more, `timeout_ms` to 600 000 ms.
    pub late_limit_ms: u32,
}

impl CanPoll {
    fn pace(&self) -> Pace {
        let CanPoll { interval_ms, timeout_ms, late_limit_ms, .. } = *self;
        Pace { interval_ms, timeout_ms, late_limit_ms }
    }
}

impl CanSettings {
    /// Everything that cannot be used. Empty means that [`CanGauge::new`] takes the settings.
    pub fn problems(&self) -> Vec<Problem> {
        check::settings(self)
    }

    /// Channels of the readings, in the order of the fields.
    pub fn channels(&self) -> Vec<Channel> {
        let fields = self.fields.iter().map(|field| &field.meaning);
        let channels = fields.filter(|field| field.role == Role::Channel);
        channels.map(|field| Channel::new(field.name.clone(), field.unit)).collect()
    }

    /// Bytes that a frame has at least.
    fn needed_bytes(&self) -> usize {
        self.fields.iter().map(|field| field.signal.end_byte()).max().unwrap_or(0)
    }

    /// Whether a frame of this identifier is one of the device.
    fn is_own(&self, id: CanId) -> bool {
        match (self.id, id) {
            (CanId::Standard(own), CanId::Standard(id)) => {
                u32::from(own) & self.mask == u32::from(id) & self.mask
            }
            (CanId::Extended(own), CanId::Extended(id)) => own & self.mask == id & self.mask,
            _ => false,
        }
    }
}
