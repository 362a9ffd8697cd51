//! The register map: what stands at which address of a device, and what it means.

use std::fmt;
use std::str::FromStr;

use asphera_link::{Channel, Unit};

use crate::error::WordError;

/// What a device offers and how it is to be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Map {
    /// Name for reports: maker and model.
    pub name: String,
    /// The fields, in any order. Those of role [`Role::Channel`] become the channels, in this order.
    pub fields: Vec<Field>,
    /// Blocks that must be read whole, by one request. Fields outside of them are gathered into
    /// requests by [`crate::Settings::max_gap_words`] and [`crate::Settings::max_words`].
    pub blocks: Vec<Block>,
}

impl Map {
    /// The channels of the readings: the fields of role [`Role::Channel`], in their order.
    pub fn channels(&self) -> Vec<Channel> {
        let fields = self.fields.iter().filter(|field| field.role == Role::Channel);
        fields.map(|field| Channel::new(field.name.clone(), field.unit)).collect()
    }

    /// The field of a name, if there is one.
    pub fn field(&self, name: &str) -> Option<&Field> {
        self.fields.iter().find(|field| field.name == name)
    }
}

/// One quantity of a device.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name, unique within the map; the name of the channel if it is one.
    pub name: String,
    /// The function that reads it.
    pub function: Function,
    /// Zero-based protocol address of its first register or bit: what is sent, not the "4xxxx" or
    /// one-based number some manuals print.
    pub address: u16,
    /// How the registers are to be read.
    pub kind: Kind,
    /// In which order the bytes of a number lie.
    pub word_order: WordOrder,
    /// What a raw unit is worth, in [`Field::unit`]; not zero.
    pub scale: f64,
    /// Added after scaling, in [`Field::unit`].
    pub offset: f64,
    /// Unit of `raw · scale + offset`.
    pub unit: Unit,
    /// What it is for.
    pub role: Role,
    /// Smallest and largest value that is a measurement, in [`Field::unit`]. A value outside is
    /// missing and flags the reading as out of range. `None`: every finite value is good.
    pub valid_range: Option<(f64, f64)>,
}

impl Field {
    /// A channel: big-endian, raw value as it is, no valid range.
    pub fn channel(
        name: impl Into<String>,
        function: Function,
        address: u16,
        kind: Kind,
        unit: Unit,
    ) -> Field {
        Field {
            name: name.into(),
            function,
            address,
            kind,
            word_order: WordOrder::Abcd,
            scale: 1.0,
            offset: 0.0,
            unit,
            role: Role::Channel,
            valid_range: None,
        }
    }

    /// The registers or bits it occupies.
    pub fn block(&self) -> Block {
        Block { function: self.function, address: self.address, len: self.kind.words() }
    }
}

/// Registers or bits that follow each other, as one request reads them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Block {
    /// The function that reads them.
    pub function: Function,
    /// Zero-based protocol address of the first.
    pub address: u16,
    /// How many registers (16 bits each) or, for coils and discrete inputs, bits.
    pub len: u16,
}

impl Block {
    /// The address after the last; up to 65536.
    pub fn end(&self) -> u32 {
        u32::from(self.address) + u32::from(self.len)
    }

    /// Whether all of `other` lies inside.
    pub fn contains(&self, other: &Block) -> bool {
        self.function == other.function
            && self.address <= other.address
            && other.end() <= self.end()
    }

    /// Whether any register or bit lies in both.
    pub fn overlaps(&self, other: &Block) -> bool {
        self.function == other.function
            && u32::from(self.address) < other.end()
            && u32::from(other.address) < self.end()
    }

    /// Bytes of data in an answer.
    pub(crate) fn byte_count(&self) -> u8 {
        let bytes = if self.function.reads_bits() { self.len.div_ceil(8) } else { self.len * 2 };
        u8::try_from(bytes).expect("blocks hold at most 125 registers or 2000 bits")
    }
}

/// `input registers 200 to 212`.
impl fmt::Display for Block {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.function.table(), self.address)?;
        if self.len == 1 { Ok(()) } else { write!(f, " to {}", self.end().saturating_sub(1)) }
    }
}

/// The function that reads a field. MODBUS Application Protocol Specification V1.1b3, section 6.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Function {
    /// Function 01, section 6.1: single bits the device lets one set. Word `coil`.
    ReadCoils,
    /// Function 02, section 6.2: single bits the device only shows. Word `discrete`.
    ReadDiscrete,
    /// Function 03, section 6.3: registers the device lets one set. Word `holding`.
    ReadHolding,
    /// Function 04, section 6.4: registers the device only shows. Word `input`.
    ReadInput,
}

impl Function {
    /// The function code sent.
    pub const fn code(self) -> u8 {
        match self {
            Function::ReadCoils => 1,
            Function::ReadDiscrete => 2,
            Function::ReadHolding => 3,
            Function::ReadInput => 4,
        }
    }

    /// Whether it reads bits, not registers.
    pub const fn reads_bits(self) -> bool {
        matches!(self, Function::ReadCoils | Function::ReadDiscrete)
    }

    /// Most registers (sections 6.3 and 6.4: 125) or bits (sections 6.1 and 6.2: 2000) of a request.
    pub const fn max_len(self) -> u16 {
        if self.reads_bits() { 2000 } else { 125 }
    }

    /// What it reads, for people.
    pub const fn table(self) -> &'static str {
        match self {
            Function::ReadCoils => "coils",
            Function::ReadDiscrete => "discrete inputs",
            Function::ReadHolding => "holding registers",
            Function::ReadInput => "input registers",
        }
    }
}

impl FromStr for Function {
    type Err = WordError;

    fn from_str(word: &str) -> Result<Function, WordError> {
        match word {
            "coil" => Ok(Function::ReadCoils),
            "discrete" => Ok(Function::ReadDiscrete),
            "holding" => Ok(Function::ReadHolding),
            "input" => Ok(Function::ReadInput),
            _ => Err(WordError::new(word, "coil, discrete, holding or input")),
        }
    }
}

/// How registers are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// One register, 0 to 65535. Word `u16`.
    U16,
    /// One register, two's complement. Word `i16`.
    I16,
    /// Two registers, unsigned. Word `u32`.
    U32,
    /// Two registers, two's complement. Word `i32`.
    I32,
    /// Two registers, IEEE 754 single precision. Word `f32`.
    F32,
    /// Four registers, IEEE 754 double precision. Word `f64`.
    F64,
    /// Bit 0 (least significant) to 15 of a register, or a coil or discrete input as `Bit(0)`.
    /// Words `bit0` to `bit15`.
    Bit(u8),
}

impl Kind {
    /// Registers (or bits, for coils and discrete inputs) it occupies.
    pub const fn words(self) -> u16 {
        match self {
            Kind::U16 | Kind::I16 | Kind::Bit(_) => 1,
            Kind::U32 | Kind::I32 | Kind::F32 => 2,
            Kind::F64 => 4,
        }
    }

    /// Whether it is a whole number that is never negative.
    pub const fn is_unsigned(self) -> bool {
        matches!(self, Kind::U16 | Kind::U32 | Kind::Bit(_))
    }
}

impl FromStr for Kind {
    type Err = WordError;

    fn from_str(word: &str) -> Result<Kind, WordError> {
        let unknown = || WordError::new(word, "u16, i16, u32, i32, f32, f64 or bit0 to bit15");
        match word {
            "u16" => Ok(Kind::U16),
            "i16" => Ok(Kind::I16),
            "u32" => Ok(Kind::U32),
            "i32" => Ok(Kind::I32),
            "f32" => Ok(Kind::F32),
            "f64" => Ok(Kind::F64),
            _ => {
                let digits = word.strip_prefix("bit").ok_or_else(unknown)?;
                let plain = digits.bytes().all(|digit| digit.is_ascii_digit());
                let bit = digits.parse().ok().filter(|bit| plain && *bit < 16);
                bit.map(Kind::Bit).ok_or_else(unknown)
            }
        }
    }
}

/// In which order the bytes of a number lie in the registers.
///
/// `A` is the most significant byte; each pair is a register, the lower address first. For four
/// registers the pattern goes on: `Cdab` puts the least significant register at the lowest address,
/// `Badc` swaps the bytes within each register, `Dcba` does both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum WordOrder {
    /// Big-endian, as the specification sends single registers (V1.1b3, section 4.2). Word `ABCD`.
    #[default]
    Abcd,
    /// Less significant register at the lower address. Word `CDAB`.
    Cdab,
    /// Bytes within a register swapped. Word `BADC`.
    Badc,
    /// Little-endian throughout. Word `DCBA`.
    Dcba,
}

impl FromStr for WordOrder {
    type Err = WordError;

    fn from_str(word: &str) -> Result<WordOrder, WordError> {
        match word {
            "ABCD" => Ok(WordOrder::Abcd),
            "CDAB" => Ok(WordOrder::Cdab),
            "BADC" => Ok(WordOrder::Badc),
            "DCBA" => Ok(WordOrder::Dcba),
            _ => Err(WordError::new(word, "ABCD, CDAB, BADC or DCBA")),
        }
    }
}

/// What a field is for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Role {
    /// A value of the reading.
    #[default]
    Channel,
    /// The device's judgement of its own measurement, by raw value.
    Quality {
        /// Nothing to say.
        good: Vec<u32>,
        /// Flags the reading as weak.
        weak: Vec<u32>,
        /// Flags the reading as without signal; the judged channels are missing. A raw value in none
        /// of the three lists flags the reading as suspect.
        bad: Vec<u32>,
        /// Names of the channels that are missing when it is bad; empty: all.
        judges: Vec<String>,
    },
    /// Flags the reading as a device error while it is not zero.
    Alarm,
    /// Whole seconds of the device's clock.
    DeviceTimeSeconds,
    /// Microseconds of the device's clock: within the second if there is a field of whole seconds.
    DeviceTimeMicros,
    /// A cyclic trigger count, `first` to `first + modulus - 1`.
    Count {
        /// The smallest number sent.
        first: u32,
        /// How many different numbers are sent; at least 2.
        modulus: u32,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_the_configuration_are_read() {
        assert_eq!("holding".parse(), Ok(Function::ReadHolding));
        assert_eq!("input".parse(), Ok(Function::ReadInput));
        assert_eq!("coil".parse(), Ok(Function::ReadCoils));
        assert_eq!("discrete".parse(), Ok(Function::ReadDiscrete));
        assert_eq!("CDAB".parse(), Ok(WordOrder::Cdab));
        assert_eq!("f32".parse(), Ok(Kind::F32));
        assert_eq!("bit15".parse(), Ok(Kind::Bit(15)));
        for word in ["bit16", "bit", "bit+1", "F32", ""] {
            assert!(word.parse::<Kind>().is_err(), "{word}");
        }
        let error = "cdab".parse::<WordOrder>().unwrap_err().to_string();
        assert_eq!(error, "unknown word `cdab`, expected ABCD, CDAB, BADC or DCBA");
    }

    #[test]
    fn block_reads_as_a_person_would_say_it() {
        let block = Block { function: Function::ReadInput, address: 200, len: 13 };
        assert_eq!(block.to_string(), "input registers 200 to 212");
        let last = Block { function: Function::ReadCoils, address: 65535, len: 1 };
        assert_eq!((last.to_string().as_str(), last.end()), ("coils 65535", 65536));
    }
}
