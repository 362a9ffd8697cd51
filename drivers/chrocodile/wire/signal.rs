//! Signals: what an identifier of `SODX` stands for, and its number in a telegram.
//!
//! ```text
//! bit 15 14 │ 13 12 11 │ 10  9 │ 8 │ 7 … 3 │ 2 1 0      CR and C p. 55, command SODX
//!  encoding │statistics│ mode  │ 1 │ peak  │ part       peak signal
//!     0     │    0     │   0   │ 0 │    identifier      global signal, the same for every peak
//! ```

use asphera_link::{Channel, Unit};
use thiserror::Error;

/// How a number stands in a binary telegram. 16-bit numbers are big-endian, 32-bit numbers
/// little-endian (CR, binary mode).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueType {
    /// 16 bits without sign, most significant byte first.
    U16,
    /// 16 bits, two's complement, most significant byte first.
    S16,
    /// 32 bits without sign, least significant byte first.
    U32,
    /// 32 bits, two's complement, least significant byte first.
    S32,
    /// IEEE 754 single precision, least significant byte first.
    F32,
}

impl ValueType {
    /// Bytes in a telegram: 2 or 4.
    pub const fn size(self) -> usize {
        match self {
            ValueType::U16 | ValueType::S16 => 2,
            ValueType::U32 | ValueType::S32 | ValueType::F32 => 4,
        }
    }

    /// The type's number in the answer to `DTF` (CR, command DTF).
    pub const fn dtf_code(self) -> u8 {
        match self {
            ValueType::U16 => 2,
            ValueType::S16 => 3,
            ValueType::U32 => 4,
            ValueType::S32 => 5,
            ValueType::F32 => 6,
        }
    }

    /// The number at the start of `bytes`, exactly as sent.
    ///
    /// # Panics
    ///
    /// When there are fewer than [`ValueType::size`] bytes.
    pub fn read(self, bytes: &[u8]) -> f64 {
        match self {
            ValueType::U16 => u16::from_be_bytes([bytes[0], bytes[1]]).into(),
            ValueType::S16 => i16::from_be_bytes([bytes[0], bytes[1]]).into(),
            ValueType::U32 => u32::from_le_bytes(four(bytes)).into(),
            ValueType::S32 => i32::from_le_bytes(four(bytes)).into(),
            ValueType::F32 => f32::from_le_bytes(four(bytes)).into(),
        }
    }

    /// Appends `number`, rounded to the nearest that the type holds; NaN becomes 0 in an integer.
    pub fn write(self, number: f64, out: &mut Vec<u8>) {
        match self {
            ValueType::U16 => out.extend((number.round() as u16).to_be_bytes()),
            ValueType::S16 => out.extend((number.round() as i16).to_be_bytes()),
            ValueType::U32 => out.extend((number.round() as u32).to_le_bytes()),
            ValueType::S32 => out.extend((number.round() as i32).to_le_bytes()),
            ValueType::F32 => out.extend((number as f32).to_le_bytes()),
        }
    }
}

fn four(bytes: &[u8]) -> [u8; 4] {
    [bytes[0], bytes[1], bytes[2], bytes[3]]
}

/// Axes of the encoder inputs, in the order of their identifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// First input.
    X,
    /// Second input.
    Y,
    /// Third input.
    Z,
    /// Fourth input.
    U,
    /// Fifth input.
    V,
}

impl Axis {
    /// Every axis, in the order of the identifiers.
    pub const ALL: [Axis; 5] = [Axis::X, Axis::Y, Axis::Z, Axis::U, Axis::V];

    const fn letter(self) -> char {
        match self {
            Axis::X => 'x',
            Axis::Y => 'y',
            Axis::Z => 'z',
            Axis::U => 'u',
            Axis::V => 'v',
        }
    }
}

/// What a peak is measured for (bits 10 and 9).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The distance of one surface.
    Distance,
    /// The thickness between two.
    Thickness,
}

/// Which number of a peak (bits 2 to 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The distance or thickness itself.
    Value,
    /// Height of the peak. 0 where there is no peak (C p. 61, command THR).
    Intensity,
    /// Saturation of the detector.
    Saturation,
    /// Position of the peak on the detector.
    Position,
    /// Median of the peak.
    Median,
    /// Width of the peak.
    Width,
}

/// How a peak's number is encoded (bits 15 and 14).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Float, lengths in µm.
    Float,
    /// 16 bits, D = d / 2¹⁵ · full scale (CLS p. 47, command SCA).
    Int16,
    /// 32 bits, lengths in nm.
    Int32Nm,
    /// 32 bits, D = d / 2³¹ · full scale.
    Int32,
}

/// What a signal measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Start of the exposure in ns on the device's clock; wraps after 2³² ns (CLS p. 50).
    StartTime,
    /// Encoder at the start of the exposure.
    EncoderStart(Axis),
    /// Encoder at the end of the exposure.
    EncoderStop(Axis),
    /// Number of the exposure; wraps after 65535.
    ExposureCount,
    /// Bit 0 saturation, 1 a trigger was lost, 2 the exposure was delayed.
    ExposureFlags,
    /// The global signal 82 of CR, named intensity there; not that of a peak.
    GlobalIntensity,
    /// Number of the sample; wraps after 65535.
    SampleCounter,
    /// Temperature of the device in hundredths of °C.
    Temperature,
    /// A number of one peak; `number` is 0 to 31.
    Peak {
        /// Distance or thickness.
        mode: Mode,
        /// 0 for the first peak.
        number: u8,
        /// Which of its numbers.
        part: Part,
    },
}

/// Why an identifier is no signal this crate can decode.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum SignalError {
    /// A global signal without a documented number format.
    #[error("global signal {0} is not supported")]
    Global(u16),
    /// Statistics over several exposures.
    #[error("signal {0} has statistics bits set, which is not supported")]
    Statistics(u16),
    /// Measuring mode 2 or 3, or part 6 or 7.
    #[error("signal {0} is neither a distance nor a thickness signal")]
    Kind(u16),
    /// An integer encoding of something other than a length or a 16-bit intensity.
    #[error("signal {0} is documented as a float only")]
    Encoding(u16),
}

/// One signal of a telegram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    /// The identifier as `SODX` takes it.
    pub id: u16,
    /// How its number is sent.
    pub value_type: ValueType,
    /// Channels that it measures.
    pub quantity: Quantity,
    /// How its number is to be read; [`Encoding::Float`] for a global signal, whose unit is fixed.
    pub encoding: Encoding,
}

impl Signal {
    /// The signal of an identifier, or why there is none.
    pub fn from_id(id: u16) -> Result<Signal, SignalError> {
        if id & 0x0100 == 0 { Signal::global(id) } else { Signal::peak(id) }
    }

    fn global(id: u16) -> Result<Signal, SignalError> {
        let axis = |first: u16| Axis::ALL[usize::from(id - first)];
        let (value_type, quantity) = match id {
            64 => (ValueType::U32, Quantity::StartTime),
            65..=69 => (ValueType::S32, Quantity::EncoderStart(axis(65))),
            70..=74 => (ValueType::S32, Quantity::EncoderStop(axis(70))),
            75 => (ValueType::U16, Quantity::ExposureCount),
            76 => (ValueType::U16, Quantity::ExposureFlags),
            82 => (ValueType::F32, Quantity::GlobalIntensity),
            83 => (ValueType::U16, Quantity::SampleCounter),
            93 => (ValueType::S16, Quantity::Temperature),
            _ => return Err(SignalError::Global(id)),
        };
        Ok(Signal { id, value_type, quantity, encoding: Encoding::Float })
    }

    fn peak(id: u16) -> Result<Signal, SignalError> {
        if id & 0x3800 != 0 {
            return Err(SignalError::Statistics(id));
        }
        let mode = match id >> 9 & 3 {
            0 => Mode::Distance,
            1 => Mode::Thickness,
            _ => return Err(SignalError::Kind(id)),
        };
        let part = match id & 7 {
            0 => Part::Value,
            1 => Part::Intensity,
            2 => Part::Saturation,
            3 => Part::Position,
            4 => Part::Median,
            5 => Part::Width,
            _ => return Err(SignalError::Kind(id)),
        };
        let (encoding, value_type) = match (id >> 14, part) {
            (0, _) => (Encoding::Float, ValueType::F32),
            (1, Part::Value | Part::Intensity) => (Encoding::Int16, ValueType::S16),
            (2, Part::Value) => (Encoding::Int32Nm, ValueType::S32),
            (3, Part::Value) => (Encoding::Int32, ValueType::S32),
            _ => return Err(SignalError::Encoding(id)),
        };
        let number = (id >> 3 & 31) as u8;
        Ok(Signal { id, value_type, quantity: Quantity::Peak { mode, number, part }, encoding })
    }

    /// Whether this is a distance or a thickness.
    pub const fn is_length(&self) -> bool {
        matches!(self.quantity, Quantity::Peak { part: Part::Value, .. })
    }

    /// Multiplier and divisor that turn the number sent into µm (lengths), °C (temperature) or
    /// itself (everything else): `value = number * multiplier / divisor`.
    pub fn scale(&self, full_scale_um: f64) -> (f64, f64) {
        match (self.quantity, self.encoding) {
            (Quantity::Temperature, _) => (1.0, 100.0),
            (Quantity::Peak { part: Part::Value, .. }, Encoding::Int16) => (full_scale_um, 32768.0),
            (Quantity::Peak { part: Part::Value, .. }, Encoding::Int32Nm) => (1.0, 1000.0),
            (Quantity::Peak { part: Part::Value, .. }, Encoding::Int32) => {
                (full_scale_um, 2_147_483_648.0)
            }
            _ => (1.0, 1.0),
        }
    }

    /// Appends `value`, given in µm, °C, ns, counts or as it is, as the device would send it.
    pub fn write(&self, value: f64, full_scale_um: f64, out: &mut Vec<u8>) {
        let (multiplier, divisor) = self.scale(full_scale_um);
        self.value_type.write(value / multiplier * divisor, out);
    }

    /// The channel the driver makes of it. `None` for the start time, the exposure count and the
    /// exposure flags, which have their own places in a reading.
    pub fn channel(&self) -> Option<Channel> {
        let (name, unit) = match self.quantity {
            Quantity::StartTime | Quantity::ExposureCount | Quantity::ExposureFlags => return None,
            Quantity::EncoderStart(axis) => (format!("encoder_{}", axis.letter()), Unit::Count),
            Quantity::EncoderStop(axis) => (format!("encoder_{}_stop", axis.letter()), Unit::Count),
            Quantity::GlobalIntensity => ("intensity".into(), Unit::One),
            Quantity::SampleCounter => ("sample_count".into(), Unit::Count),
            Quantity::Temperature => ("temperature".into(), Unit::DegreeCelsius),
            Quantity::Peak { mode, number, part } => {
                let (length, prefix) = match mode {
                    Mode::Distance => ("distance", ""),
                    Mode::Thickness => ("thickness", "thickness_"),
                };
                let number = number + 1;
                match part {
                    Part::Value => (format!("{length}{number}"), Unit::Millimetre),
                    Part::Intensity => (format!("{prefix}intensity{number}"), Unit::One),
                    Part::Saturation => (format!("{prefix}saturation{number}"), Unit::One),
                    Part::Position => (format!("{prefix}position{number}"), Unit::One),
                    Part::Median => (format!("{prefix}median{number}"), Unit::One),
                    Part::Width => (format!("{prefix}width{number}"), Unit::One),
                }
            }
        };
        Some(Channel::new(name, unit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Identifiers with their meanings as CR and C p. 55 to 60 name them.
    #[test]
    fn documented_identifiers() {
        for (id, value_type, name) in [
            (256, ValueType::F32, "distance1"),
            (257, ValueType::F32, "intensity1"),
            (264, ValueType::F32, "distance2"),
            (768, ValueType::F32, "thickness1"),
            (16640, ValueType::S16, "distance1"),
            (16641, ValueType::S16, "intensity1"),
            (65, ValueType::S32, "encoder_x"),
            (69, ValueType::S32, "encoder_v"),
            (70, ValueType::S32, "encoder_x_stop"),
            (83, ValueType::U16, "sample_count"),
            (93, ValueType::S16, "temperature"),
        ] {
            let signal = Signal::from_id(id).unwrap();
            assert_eq!(signal.value_type, value_type, "{id}");
            assert_eq!(signal.channel().unwrap().name, name, "{id}");
        }
        for id in [64, 75, 76] {
            assert_eq!(Signal::from_id(id).unwrap().channel(), None);
        }
    }

    #[test]
    fn undocumented_identifiers_are_refused() {
        for (id, error) in [
            (0, SignalError::Global(0)),
            (79, SignalError::Global(79)),
            (256 + 0x0800, SignalError::Statistics(256 + 0x0800)),
            (256 + 0x0400, SignalError::Kind(256 + 0x0400)),
            (256 + 7, SignalError::Kind(263)),
            (16640 + 5, SignalError::Encoding(16645)),
            (0x8101, SignalError::Encoding(0x8101)),
        ] {
            assert_eq!(Signal::from_id(id), Err(error));
        }
    }

    #[test]
    fn every_accepted_identifier_keeps_its_value_within_half_a_step() {
        for signal in (0..=u16::MAX).filter_map(|id| Signal::from_id(id).ok()) {
            let (multiplier, divisor) = signal.scale(1000.0);
            let mut bytes = Vec::new();
            signal.write(123.0, 1000.0, &mut bytes);
            assert_eq!(bytes.len(), signal.value_type.size());
            let value = signal.value_type.read(&bytes) * multiplier / divisor;
            assert!((value - 123.0).abs() <= 0.5 * multiplier / divisor, "{signal:?}: {value}");
        }
    }
}
