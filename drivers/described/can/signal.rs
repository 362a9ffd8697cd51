//! Numbers in the bits of a frame, as DBC files place them.
//!
//! Bit `n` of a frame is bit `n mod 8` of byte `n / 8`, the lowest bit of a byte being 0.
//!
//! ```text
//!             bit  7  6  5  4  3  2  1  0
//!  byte 0          7  6  5  4  3  2  1  0
//!  byte 1         15 14 13 12 11 10  9  8
//!  byte 2         23 22 21 20 19 18 17 16
//! ```
//!
//! | order | `start_bit` | the next bit |
//! |---|---|---|
//! | little (Intel, `@1` of a DBC file) | lowest bit of the number | one higher |
//! | big (Motorola, `@0` of a DBC file) | highest bit of the number | one lower; after bit 0 of a byte, bit 7 of the next byte |

/// Order of the bits of a number over its bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BitOrder {
    /// Intel: the lowest byte first.
    Little,
    /// Motorola: the highest byte first.
    Big,
}

/// How bits are a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SignalForm {
    /// Whole number without sign.
    Unsigned,
    /// Whole number in two's complement.
    Signed,
    /// IEEE 754 number of 32 bits.
    Single,
    /// IEEE 754 number of 64 bits.
    Double,
}

/// Bits of a frame that are one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Signal {
    /// First bit, 0 to 511: the lowest for [`BitOrder::Little`], the highest for [`BitOrder::Big`].
    pub start_bit: u16,
    /// Number of bits, 1 to 64.
    pub bits: u8,
    /// Order of the bits.
    pub order: BitOrder,
    /// How they are a number.
    pub form: SignalForm,
}

impl Signal {
    /// Places of its bits, the highest first.
    fn places(self) -> impl Iterator<Item = usize> {
        let (start, bits) = (usize::from(self.start_bit), usize::from(self.bits));
        // Counted from the highest bit of byte 0 on, a Motorola number is one run.
        let run = start / 8 * 8 + 7 - start % 8;
        (0..bits).map(move |index| match self.order {
            BitOrder::Little => start + bits - 1 - index,
            BitOrder::Big => (run + index) / 8 * 8 + 7 - (run + index) % 8,
        })
    }

    /// Bytes that a frame must have for it.
    pub fn end_byte(self) -> usize {
        self.places().max().map_or(0, |place| place / 8 + 1)
    }

    /// Its bits in the data of a frame; `None` where the frame is too short.
    pub fn raw(self, data: &[u8]) -> Option<u64> {
        self.places().try_fold(0, |raw, place| {
            let byte = data.get(place / 8)?;
            Some(raw << 1 | u64::from(byte >> (place % 8) & 1))
        })
    }

    /// The number, before scale and offset; `None` where the frame is too short. Whole numbers beyond 2⁵³ are rounded.
    pub fn read(self, data: &[u8]) -> Option<f64> {
        let raw = self.raw(data)?;
        Some(match self.form {
            SignalForm::Unsigned => raw as f64,
            SignalForm::Signed => {
                // The highest bit to the top, then down again with its sign.
                let shift = 64 - u32::from(self.bits).clamp(1, 64);
                ((raw << shift).cast_signed() >> shift) as f64
            }
            SignalForm::Single => f32::from_bits(raw as u32).into(),
            SignalForm::Double => f64::from_bits(raw),
        })
    }

    /// Bits of a number before scale and offset, the other way round of [`Signal::read`]. A whole number is rounded, and limited to what the
    /// bits can say.
    pub fn raw_of(self, number: f64) -> u64 {
        let bits = u32::from(self.bits).clamp(1, 64);
        match self.form {
            SignalForm::Unsigned => (number.round() as u64).min(u64::MAX >> (64 - bits)),
            SignalForm::Signed => {
                let most = i64::MAX >> (64 - bits);
                (number.round() as i64).clamp(-most - 1, most).cast_unsigned()
            }
            SignalForm::Single => (number as f32).to_bits().into(),
            SignalForm::Double => number.to_bits(),
        }
    }

    /// Writes the lowest bits of `raw` into the data of a frame. Bits beyond its end are left out.
    pub fn write(self, raw: u64, data: &mut [u8]) {
        for (index, place) in self.places().enumerate() {
            let bit = (raw >> (usize::from(self.bits) - 1 - index) & 1) as u8;
            if let Some(byte) = data.get_mut(place / 8) {
                *byte = *byte & !(1 << (place % 8)) | bit << (place % 8);
            }
        }
    }
}
