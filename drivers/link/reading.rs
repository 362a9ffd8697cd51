//! What a device said at one instant.

use bitflags::bitflags;

use crate::{Nanos, Profile};

/// Most channels one reading can carry.
pub const MAX_CHANNELS: usize = 16;

/// What one device said at one instant.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// When the last byte of it reached the host.
    pub host: Nanos,
    /// The device's own clock in ns, where it sends one. Its zero is the device's.
    pub device_time_ns: Option<u64>,
    /// The shared trigger count it belongs to, where the device sends one.
    pub count: Option<Count>,
    /// One value per channel of [`crate::Driver::channels`], in that order and in that unit; of a line scanner also
    /// its profile.
    pub values: Values,
    /// What is wrong with it. A flagged reading is kept, never dropped.
    pub flags: Flags,
}

/// A cyclic trigger count as a device sends it: `first, first + 1, … , first + modulus - 1, first, …`.
///
/// CHRocodile's exposure count is 0 to 65535 (`first` 0, `modulus` 65536); the counter of a CANopen
/// SYNC is 1 to at most 240 (`first` 1, `modulus` the configured overflow, CiA 301 object 1019h).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count {
    /// The number sent, `first` to `first + modulus - 1`.
    pub raw: u32,
    /// The smallest number sent.
    pub first: u32,
    /// How many different numbers are sent; at least 2.
    pub modulus: u32,
}

/// Up to [`MAX_CHANNELS`] values, each valid or missing, and the profile of a line scanner. Missing is a gap, never a
/// zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    len: u8,
    valid: u16,
    data: [f64; MAX_CHANNELS],
    profile: Option<Profile>,
}

impl Values {
    /// No value yet.
    #[inline]
    pub const fn new() -> Values {
        Values { len: 0, valid: 0, data: [0.0; MAX_CHANNELS], profile: None }
    }

    /// Appends the next channel's value; `None` or a value that is not finite is missing.
    ///
    /// # Panics
    ///
    /// When there are [`MAX_CHANNELS`] values already: drivers check their channel count when they
    /// are built.
    #[inline]
    pub fn push(&mut self, value: Option<f64>) {
        let index = usize::from(self.len);
        if let Some(value) = value.filter(|value| value.is_finite()) {
            self.data[index] = value;
            self.valid |= 1 << index;
        } else {
            self.data[index] = 0.0;
        }
        self.len += 1;
    }

    /// The value of the channel at `index`, or `None` where it is missing or there is no such channel.
    #[inline]
    pub fn get(&self, index: usize) -> Option<f64> {
        (index < self.len() && self.valid & (1 << index) != 0).then(|| self.data[index])
    }

    /// Adds the profile that was measured at the same instant.
    #[inline]
    #[must_use]
    pub fn with_profile(self, profile: Profile) -> Values {
        Values { profile: Some(profile), ..self }
    }

    /// The profile of a line scanner; `None` where the device measures none.
    pub fn profile(&self) -> Option<&Profile> {
        self.profile.as_ref()
    }

    /// How many channels there are, valid or missing.
    pub fn len(&self) -> usize {
        self.len.into()
    }

    /// Whether there is no channel at all.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The values in channel order.
    pub fn iter(&self) -> impl Iterator<Item = Option<f64>> + '_ {
        (0..self.len()).map(|index| self.get(index))
    }
}

impl Default for Values {
    fn default() -> Values {
        Values::new()
    }
}

impl FromIterator<Option<f64>> for Values {
    fn from_iter<I: IntoIterator<Item = Option<f64>>>(values: I) -> Values {
        let mut all = Values::new();
        values.into_iter().for_each(|value| all.push(value));
        all
    }
}

bitflags! {
    /// What is wrong with a reading or a point. None set means good.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct Flags: u32 {
        /// The device saw no signal: there is no distance.
        const NO_SIGNAL = 1;
        /// The signal is too weak to trust.
        const WEAK = 1 << 1;
        /// The detector was saturated.
        const SATURATED = 1 << 2;
        /// Outside the measuring range.
        const OUT_OF_RANGE = 1 << 3;
        /// The device lost a trigger before this reading.
        const TRIGGER_LOST = 1 << 4;
        /// The device answered its trigger late.
        const DELAYED = 1 << 5;
        /// The device reported an error of its own.
        const DEVICE_ERROR = 1 << 6;
        /// The bytes may have been damaged; the values are not to be used.
        const SUSPECT = 1 << 7;
        /// No companion reading with the same count arrived: there is no position.
        const UNJOINED = 1 << 8;
        /// The count could not be told apart from one a whole cycle away.
        const AMBIGUOUS_COUNT = 1 << 9;
        /// Outside the aperture.
        const OUTSIDE_APERTURE = 1 << 10;
        /// Not a finite number.
        const NOT_FINITE = 1 << 11;
        /// At the place of an earlier point, but at another height.
        const CONFLICT = 1 << 12;
        /// Its place between two readings of an axis is known less well than the limit.
        const UNCERTAIN_PLACE = 1 << 13;
        /// Not on a line or at a stop of the scan's plan, or nearer to the last point than it has points.
        const OFF_PLAN = 1 << 14;
        /// The temperature that its expansion needs is not known, or not since long.
        const NO_TEMPERATURE = 1 << 15;
    }
}

impl Flags {
    /// The name of each single flag that is set, in lower case, as reports write it.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        self.iter().map(|flag| match flag {
            Flags::NO_SIGNAL => "no_signal",
            Flags::WEAK => "weak",
            Flags::SATURATED => "saturated",
            Flags::OUT_OF_RANGE => "out_of_range",
            Flags::TRIGGER_LOST => "trigger_lost",
            Flags::DELAYED => "delayed",
            Flags::DEVICE_ERROR => "device_error",
            Flags::SUSPECT => "suspect",
            Flags::UNJOINED => "unjoined",
            Flags::AMBIGUOUS_COUNT => "ambiguous_count",
            Flags::OUTSIDE_APERTURE => "outside_aperture",
            Flags::NOT_FINITE => "not_finite",
            Flags::CONFLICT => "conflict",
            Flags::UNCERTAIN_PLACE => "uncertain_place",
            Flags::OFF_PLAN => "off_plan",
            Flags::NO_TEMPERATURE => "no_temperature",
            _ => "unnamed",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_values_are_gaps() {
        let values: Values = [Some(1.5), None, Some(f64::NAN), Some(0.0)].into_iter().collect();
        assert_eq!(values.iter().collect::<Vec<_>>(), [Some(1.5), None, None, Some(0.0)]);
        assert_eq!(values.get(4), None);
    }

    #[test]
    fn every_flag_has_a_name() {
        assert!(Flags::all().names().all(|name| name != "unnamed"));
        assert_eq!((Flags::WEAK | Flags::SUSPECT).names().collect::<Vec<_>>(), ["weak", "suspect"]);
    }
}
