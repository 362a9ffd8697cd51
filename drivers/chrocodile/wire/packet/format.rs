//! Bodies of `DFT`: how samples are laid out.

use thiserror::Error;

use super::{Kind, encode, u16_at, u32_at};

/// Bytes before the signals, and bytes of a signal.
const FIXED_LEN: usize = 16;
const SIGNAL_LEN: usize = 8;

/// How a number stands in a sample, least significant byte first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberType {
    /// 8 bits without sign.
    U8,
    /// 8 bits, two's complement.
    S8,
    /// 16 bits without sign.
    U16,
    /// 16 bits, two's complement.
    S16,
    /// 32 bits without sign.
    U32,
    /// 32 bits, two's complement.
    S32,
    /// IEEE 754 single precision.
    F32,
}

impl NumberType {
    /// Every type, in the order of the codes.
    pub const ALL: [NumberType; 7] = [
        NumberType::U8,
        NumberType::S8,
        NumberType::U16,
        NumberType::S16,
        NumberType::U32,
        NumberType::S32,
        NumberType::F32,
    ];

    /// The code in a format, 0 to 6.
    pub fn code(self) -> u8 {
        self as u8
    }

    /// Bytes of a number.
    pub const fn size(self) -> usize {
        match self {
            NumberType::U8 | NumberType::S8 => 1,
            NumberType::U16 | NumberType::S16 => 2,
            NumberType::U32 | NumberType::S32 | NumberType::F32 => 4,
        }
    }

    /// The number at the start of `bytes`, exactly as sent.
    ///
    /// # Panics
    ///
    /// When there are fewer than [`NumberType::size`] bytes.
    #[inline]
    pub fn read(self, bytes: &[u8]) -> f64 {
        match self {
            NumberType::U8 => bytes[0].into(),
            NumberType::S8 => bytes[0].cast_signed().into(),
            NumberType::U16 => u16_at(bytes, 0).into(),
            NumberType::S16 => u16_at(bytes, 0).cast_signed().into(),
            NumberType::U32 => u32_at(bytes, 0).into(),
            NumberType::S32 => u32_at(bytes, 0).cast_signed().into(),
            NumberType::F32 => f32::from_bits(u32_at(bytes, 0)).into(),
        }
    }

    /// Appends `number`, rounded to the nearest that the type holds; NaN becomes 0 in an integer.
    pub fn write(self, number: f64, out: &mut Vec<u8>) {
        let rounded = number.round();
        match self {
            NumberType::U8 => out.push(rounded as u8),
            NumberType::S8 => out.extend((rounded as i8).to_le_bytes()),
            NumberType::U16 => out.extend((rounded as u16).to_le_bytes()),
            NumberType::S16 => out.extend((rounded as i16).to_le_bytes()),
            NumberType::U32 => out.extend((rounded as u32).to_le_bytes()),
            NumberType::S32 => out.extend((rounded as i32).to_le_bytes()),
            NumberType::F32 => out.extend((number as f32).to_le_bytes()),
        }
    }
}

/// A signal of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FormatSignal {
    /// How its numbers are sent.
    pub number: NumberType,
    /// How many points of the device it is sent of.
    pub points: u16,
    /// The first of these points.
    pub first_point: u16,
    /// Identifier, as `SODX` takes it.
    pub id: u16,
}

impl FormatSignal {
    /// Whether it is measured at each point of the device, and not once for a sample.
    pub const fn is_of_points(&self) -> bool {
        self.id & 0x0100 != 0
    }
}

/// How samples are laid out.
#[derive(Clone, Debug, PartialEq)]
pub struct Format {
    /// The stream: 1 for measurements.
    pub stream: u32,
    /// The number by which data refer to it.
    pub counter: i32,
    /// Samples per second, as the device gives it.
    pub sample_rate_hz: f32,
    /// Signals in the order of the device.
    pub signals: Vec<FormatSignal>,
}

/// Why a format cannot be used.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum FormatError {
    /// Fewer bytes than it has before its signals.
    #[error("a format of {0} bytes, expected at least {FIXED_LEN}")]
    Short(usize),
    /// A number of signals that the bytes do not hold.
    #[error("a format of {signals} signals in {bytes} bytes")]
    Signals {
        /// As sent.
        signals: i32,
        /// Bytes of the body.
        bytes: usize,
    },
    /// A type that CR does not describe.
    #[error("signal {id} has the number type {code}, expected 0 to 6")]
    NumberType {
        /// The signal.
        id: u16,
        /// As sent.
        code: u8,
    },
    /// A signal of the whole sample that is sent more than once.
    #[error("signal {id} is of a whole sample and comes for {points} points")]
    Global {
        /// The signal.
        id: u16,
        /// As sent.
        points: u16,
    },
    /// Two signals of different points.
    #[error("signal {id} is of other points than signal {other}")]
    Points {
        /// One signal.
        id: u16,
        /// The other one.
        other: u16,
    },
}

impl Format {
    /// Reads the body of a packet.
    ///
    /// # Errors
    ///
    /// Why it is no format.
    pub fn decode(body: &[u8]) -> Result<Format, FormatError> {
        let (fixed, rest) =
            body.split_at_checked(FIXED_LEN).ok_or(FormatError::Short(body.len()))?;
        let count = u32_at(fixed, 12).cast_signed();
        if usize::try_from(count).ok() != Some(rest.len() / SIGNAL_LEN)
            || !rest.len().is_multiple_of(SIGNAL_LEN)
        {
            return Err(FormatError::Signals { signals: count, bytes: body.len() });
        }
        let signals = rest.chunks_exact(SIGNAL_LEN).map(|bytes| {
            let id = u16_at(bytes, 6);
            let number = NumberType::ALL.get(usize::from(bytes[0])).copied();
            Ok(FormatSignal {
                number: number.ok_or(FormatError::NumberType { id, code: bytes[0] })?,
                points: u16_at(bytes, 2),
                first_point: u16_at(bytes, 4),
                id,
            })
        });
        Ok(Format {
            stream: u32_at(fixed, 0),
            counter: u32_at(fixed, 4).cast_signed(),
            sample_rate_hz: f32::from_bits(u32_at(fixed, 8)),
            signals: signals.collect::<Result<_, _>>()?,
        })
    }

    /// Appends the packet. The caller keeps the signals few enough for one.
    pub fn encode(&self, out: &mut Vec<u8>) {
        encode(Kind::Format, out, |out| {
            out.extend(self.stream.to_le_bytes());
            out.extend(self.counter.to_le_bytes());
            out.extend(self.sample_rate_hz.to_le_bytes());
            out.extend((self.signals.len() as u32).to_le_bytes());
            for signal in &self.signals {
                out.extend([signal.number.code(), 0]);
                for half in [signal.points, signal.first_point, signal.id] {
                    out.extend(half.to_le_bytes());
                }
            }
        });
    }

    /// Where each signal stands in a sample.
    ///
    /// # Errors
    ///
    /// When signals of points are not all of the same ones, or a signal of the sample comes more than once.
    pub fn layout(&self) -> Result<SampleLayout, FormatError> {
        let mut layout = SampleLayout::default();
        let mut first: Option<FormatSignal> = None;
        for signal in self.signals.iter().copied() {
            let size = signal.number.size();
            if !signal.is_of_points() {
                if signal.points > 1 {
                    return Err(FormatError::Global { id: signal.id, points: signal.points });
                }
                layout.globals.push((layout.globals_len, signal));
                layout.globals_len += size;
                continue;
            }
            let known = *first.get_or_insert(signal);
            if (known.points, known.first_point) != (signal.points, signal.first_point) {
                return Err(FormatError::Points { id: signal.id, other: known.id });
            }
            layout.of_points.push((layout.stride, signal));
            layout.stride += size;
        }
        if let Some(signal) = first {
            layout.points = usize::from(signal.points.max(1));
            layout.first_point = signal.first_point.into();
        }
        Ok(layout)
    }
}

/// Where each signal stands in a sample: those of the whole sample first, then point by point those of a point.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SampleLayout {
    /// Signals of the sample, each with its offset in the sample.
    pub globals: Vec<(usize, FormatSignal)>,
    /// Signals of a point, each with its offset in the point.
    pub of_points: Vec<(usize, FormatSignal)>,
    /// Bytes of the signals of the sample.
    pub globals_len: usize,
    /// Bytes of a point.
    pub stride: usize,
    /// How many points a sample has.
    pub points: usize,
    /// Number of the first of these points in the device.
    pub first_point: usize,
}

impl SampleLayout {
    /// Bytes of a sample.
    pub fn sample_len(&self) -> usize {
        self.globals_len + self.points * self.stride
    }

    /// Offset in a sample and number type of a signal, at a point counted from the first one sent.
    pub fn place(&self, id: u16, point: usize) -> Option<(usize, NumberType)> {
        let find = |signals: &[(usize, FormatSignal)]| {
            let found = signals.iter().find(|(_, signal)| signal.id == id);
            found.map(|(offset, signal)| (*offset, signal.number))
        };
        let of_point = || {
            let (offset, number) = find(&self.of_points).filter(|_| point < self.points)?;
            Some((self.globals_len + point * self.stride + offset, number))
        };
        find(&self.globals).or_else(of_point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::packet::HEADER_LEN;

    fn signal(id: u16, number: NumberType, points: u16) -> FormatSignal {
        FormatSignal { number, points, first_point: 0, id }
    }

    fn format(signals: Vec<FormatSignal>) -> Format {
        Format { stream: 1, counter: -3, sample_rate_hz: 1000.0, signals }
    }

    #[test]
    fn numbers_keep_their_value_and_code() {
        for (code, number) in (0_u8..).zip(NumberType::ALL) {
            assert_eq!(number.code(), code);
            let mut bytes = Vec::new();
            number.write(100.4, &mut bytes);
            assert_eq!(bytes.len(), number.size());
            assert!((number.read(&bytes) - 100.0).abs() <= 0.401);
        }
        assert!((NumberType::S16.read(&[0xFE, 0xFF]) + 2.0).abs() < 1e-12);
    }

    #[test]
    fn signals_of_the_sample_come_before_those_of_its_points() {
        let format = format(vec![
            signal(16640, NumberType::S16, 3),
            signal(65, NumberType::S32, 1),
            signal(257, NumberType::F32, 3),
            signal(75, NumberType::U16, 0),
        ]);
        let layout = format.layout().unwrap();
        assert_eq!((layout.globals_len, layout.stride, layout.points), (6, 6, 3));
        assert_eq!(layout.sample_len(), 24);
        assert_eq!(layout.place(65, 0), Some((0, NumberType::S32)));
        assert_eq!(layout.place(75, 0), Some((4, NumberType::U16)));
        assert_eq!(layout.place(16640, 2), Some((18, NumberType::S16)));
        assert_eq!(layout.place(257, 1), Some((14, NumberType::F32)));
        assert_eq!((layout.place(257, 3), layout.place(256, 0)), (None, None));
        let mut bytes = Vec::new();
        format.encode(&mut bytes);
        assert_eq!(Format::decode(&bytes[HEADER_LEN..]), Ok(format));
    }

    #[test]
    fn formats_that_cannot_be_are_named() {
        let several = format(vec![signal(65, NumberType::S32, 2)]).layout();
        assert_eq!(several, Err(FormatError::Global { id: 65, points: 2 }));
        let mixed = format(vec![signal(256, NumberType::F32, 2), signal(257, NumberType::F32, 3)]);
        assert_eq!(mixed.layout(), Err(FormatError::Points { id: 257, other: 256 }));
        let mut bytes = Vec::new();
        format(vec![signal(256, NumberType::F32, 1)]).encode(&mut bytes);
        let body = &mut bytes[HEADER_LEN..];
        assert_eq!(Format::decode(&body[..15]), Err(FormatError::Short(15)));
        assert_eq!(
            Format::decode(&body[..23]),
            Err(FormatError::Signals { signals: 1, bytes: 23 })
        );
        body[16] = 7;
        assert_eq!(Format::decode(body), Err(FormatError::NumberType { id: 256, code: 7 }));
        body[12..16].copy_from_slice(&[0xFF; 4]);
        let negative = FormatError::Signals { signals: -1, bytes: 24 };
        assert_eq!(Format::decode(body), Err(negative));
    }
}
