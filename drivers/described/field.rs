//! What stands in a frame.

use asphera_link::{Flags, Unit};

use crate::number::Form;

/// One number or word of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name, unique in the device: that of the channel, where it is one.
    pub name: String,
    /// Where it stands.
    pub place: Place,
    /// How it is written.
    pub form: Form,
    /// Worth of one: the value is number × scale + offset. Not zero.
    pub scale: f64,
    /// Value of the number 0.
    pub offset: f64,
    /// Unit of the value.
    pub unit: Unit,
    /// Smallest and largest value the device can measure. Outside, the value is missing and the reading flagged.
    pub valid_range: Option<(f64, f64)>,
    /// Number that stands for no value, before scale and offset. The value is missing and the reading without signal.
    pub no_value: Option<f64>,
    /// What it is for.
    pub role: Role,
    /// Words in place of a number, or states, each with what it says of the reading.
    pub flagged: Vec<Flagged>,
}

/// Where a field stands in a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Column of a line, from 1.
    Column(usize),
    /// Named group of the pattern.
    Group(String),
    /// First byte in a record, from 0, its beginning counted.
    At(usize),
}

/// What a field is for.
#[derive(Clone, Debug, PartialEq)]
pub enum Role {
    /// A measured value.
    Channel,
    /// A state of the reading. What is neither good nor flagged makes the reading suspect.
    Status {
        /// Texts of a good reading.
        good: Vec<String>,
    },
    /// A whole number whose bits are states; [`Flagged::texts`] are numbers of bits, the lowest 0.
    Bits,
    /// The shared trigger count.
    Count {
        /// The smallest number sent.
        first: u32,
        /// How many different numbers are sent.
        modulus: u32,
    },
    /// The device's clock, in the unit s after scale and offset.
    DeviceTime,
}

/// Texts that make a reading less than good.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Flagged {
    /// What they say of it.
    pub flag: Flags,
    /// The texts, without blanks about them. Of a binary field: the number in decimal digits.
    pub texts: Vec<String>,
    /// Meaning in words for a technician, which a message about an error of the device adds; may be empty.
    pub means: String,
}

/// Flags that a device can raise, with their keys in a configuration.
pub(crate) const FLAGS: [(&str, Flags); 8] = [
    ("no_signal", Flags::NO_SIGNAL),
    ("weak", Flags::WEAK),
    ("saturated", Flags::SATURATED),
    ("out_of_range", Flags::OUT_OF_RANGE),
    ("trigger_lost", Flags::TRIGGER_LOST),
    ("delayed", Flags::DELAYED),
    ("device_error", Flags::DEVICE_ERROR),
    ("suspect", Flags::SUSPECT),
];

impl Field {
    /// A channel in decimal digits, worth what it says.
    pub fn channel(name: &str, place: Place, unit: Unit) -> Field {
        Field {
            name: name.to_owned(),
            place,
            form: Form::Decimal,
            scale: 1.0,
            offset: 0.0,
            unit,
            valid_range: None,
            no_value: None,
            role: Role::Channel,
            flagged: Vec::new(),
        }
    }

    /// Meaning of a text that is an error of the device; empty where none is known.
    pub(crate) fn meaning_of(&self, text: &str) -> &str {
        let says = |flagged: &&Flagged| flagged.texts.iter().any(|known| known == text);
        self.flagged.iter().find(says).map_or("", |flagged| &flagged.means)
    }

    /// Value of a number as it was sent.
    pub(crate) fn scaled(&self, raw: f64) -> f64 {
        raw * self.scale + self.offset
    }

    /// What a text says of the reading; empty where it says nothing.
    pub(crate) fn flags_of(&self, text: &str) -> Flags {
        let says = |flagged: &&Flagged| flagged.texts.iter().any(|known| known == text);
        self.flagged.iter().filter(says).fold(Flags::empty(), |all, found| all | found.flag)
    }
}
