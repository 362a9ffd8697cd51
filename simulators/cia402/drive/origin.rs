//! What a drive is before anyone talks to it, and what moves it beside itself.

use asphera_cia402::wire::{NmtState, object};
use asphera_link::Nanos;

use super::{Drive, HomingState};
use crate::profile::Profile;

/// What a drive is from the factory, and what its encoder knows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Origin {
    /// Object 1018.01h, where it is another than usual.
    vendor: Option<u32>,
    /// Position at the negative limit switch of an encoder that knows its place.
    at_switch: Option<i32>,
}

impl Drive {
    /// The same drive of another vendor (object 1018.01h).
    #[must_use]
    pub fn with_vendor(mut self, vendor: u32) -> Drive {
        self.origin.vendor = Some(vendor);
        self.apply_origin();
        self
    }

    /// The same drive with an encoder that knows its place from power-on: its position at the negative limit switch, in counts. It counts
    /// as homed.
    #[must_use]
    pub fn absolute(mut self, at_switch: i32) -> Drive {
        self.origin.at_switch = Some(at_switch);
        self.apply_origin();
        self
    }

    pub(super) fn apply_origin(&mut self) {
        if let Some(vendor) = self.origin.vendor {
            self.dictionary.set(object::VENDOR, vendor);
        }
        if let Some(at_switch) = self.origin.at_switch {
            self.zero = -f64::from(at_switch);
            self.homing = HomingState::Attained;
        }
    }

    /// Something else moves the axis to a place on the travel, in counts: a hand, or a machine that the drive is not told of.
    pub fn push(&mut self, now: Nanos, place: f64) {
        self.settle(now);
        self.profile = Profile::Still(place);
        self.settle(now);
    }

    /// Whether it is operational with its TPDO on and timed.
    pub fn is_sending(&self) -> bool {
        self.nmt == NmtState::Operational && self.event_due.is_some() && self.dictionary.has_tpdo()
    }
}
