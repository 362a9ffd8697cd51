//! What a driver measures.

use std::fmt;

/// One channel of a device: a name, unique within the device, and the unit of its values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name as it appears in configuration, recordings and reports: `distance1`, `position`.
    pub name: String,
    /// Unit of every value of the channel.
    pub unit: Unit,
}

impl Channel {
    /// A channel of the given name and unit.
    pub fn new(name: impl Into<String>, unit: Unit) -> Channel {
        Channel { name: name.into(), unit }
    }
}

/// Units of channel values. Lengths are mm and angles rad everywhere behind the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unit {
    /// Length in mm.
    Millimetre,
    /// Speed in mm/s.
    MillimetrePerSecond,
    /// Angle in rad.
    Radian,
    /// Temperature in °C.
    DegreeCelsius,
    /// Duration in s.
    Second,
    /// Frequency in Hz.
    Hertz,
    /// Encoder or event counts; the kinematics knows what a count is worth.
    Count,
    /// A number without unit: intensity, quality, state.
    One,
}

impl Unit {
    /// Symbol as written in configuration and JSON.
    pub const fn symbol(self) -> &'static str {
        match self {
            Unit::Millimetre => "mm",
            Unit::MillimetrePerSecond => "mm/s",
            Unit::Radian => "rad",
            Unit::DegreeCelsius => "degC",
            Unit::Second => "s",
            Unit::Hertz => "Hz",
            Unit::Count => "count",
            Unit::One => "1",
        }
    }

    /// Every unit, in the order of the documentation.
    pub const ALL: [Unit; 8] = [
        Unit::Millimetre,
        Unit::MillimetrePerSecond,
        Unit::Radian,
        Unit::DegreeCelsius,
        Unit::Second,
        Unit::Hertz,
        Unit::Count,
        Unit::One,
    ];
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())
    }
}
