//! Numbers as devices write them.

/// How a number is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Decimal digits with a point: `+01.2345`, `-12`, `3.5e-3`.
    Decimal,
    /// Decimal digits with a comma: `1,25`.
    DecimalComma,
    /// Hexadecimal digits, no sign, at most 13.
    Hex,
    /// Unsigned whole number of so many bytes, 1 to 4.
    Unsigned(u8, ByteOrder),
    /// Whole number in two's complement of so many bytes, 1 to 4.
    Signed(u8, ByteOrder),
    /// IEEE 754 number of 4 bytes.
    Single(ByteOrder),
    /// IEEE 754 number of 8 bytes.
    Double(ByteOrder),
}

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ByteOrder {
    /// The highest byte first.
    #[default]
    Big,
    /// The lowest byte first.
    Little,
}

impl Form {
    /// Words of the forms in text.
    pub const TEXT: [(&'static str, Form); 3] =
        [("decimal", Form::Decimal), ("decimal-comma", Form::DecimalComma), ("hex", Form::Hex)];

    /// Words of the forms in bytes.
    pub const BINARY: [&'static str; 10] =
        ["u8", "i8", "u16", "i16", "u24", "i24", "u32", "i32", "f32", "f64"];

    /// The form in bytes of a word of [`Form::BINARY`].
    pub fn binary(word: &str, order: ByteOrder) -> Option<Form> {
        let place = Form::BINARY.iter().position(|known| *known == word)?;
        Some(match place {
            8 => Form::Single(order),
            9 => Form::Double(order),
            whole if whole % 2 == 0 => Form::Unsigned(whole as u8 / 2 + 1, order),
            whole => Form::Signed(whole as u8 / 2 + 1, order),
        })
    }

    /// Bytes of a number, or `None` for text.
    pub fn width(self) -> Option<usize> {
        match self {
            Form::Decimal | Form::DecimalComma | Form::Hex => None,
            Form::Unsigned(width, _) | Form::Signed(width, _) => Some(width.into()),
            Form::Single(_) => Some(4),
            Form::Double(_) => Some(8),
        }
    }

    /// The number that these bytes are; `None` where they are none. May be infinite or no number (binary forms).
    pub fn read(self, bytes: &[u8]) -> Option<f64> {
        match self {
            Form::Decimal => decimal(bytes, b'.'),
            Form::DecimalComma => decimal(bytes, b','),
            Form::Hex => hex(bytes),
            Form::Unsigned(width, order) => whole(bytes, width, order).map(f64::from),
            Form::Signed(width, order) => {
                let shift = 32 - 8 * u32::from(width);
                // The highest byte to the top, then down again with its sign.
                whole(bytes, width, order).map(|raw| f64::from((raw << shift) as i32 >> shift))
            }
            Form::Single(order) => ordered::<4>(bytes, order).map(|b| f32::from_be_bytes(b).into()),
            Form::Double(order) => ordered::<8>(bytes, order).map(f64::from_be_bytes),
        }
    }
}

fn whole(bytes: &[u8], width: u8, order: ByteOrder) -> Option<u32> {
    if bytes.len() != usize::from(width) || bytes.len() > 4 {
        return None;
    }
    let join = |all: u32, byte: &u8| all << 8 | u32::from(*byte);
    Some(match order {
        ByteOrder::Big => bytes.iter().fold(0, join),
        ByteOrder::Little => bytes.iter().rev().fold(0, join),
    })
}

fn ordered<const N: usize>(bytes: &[u8], order: ByteOrder) -> Option<[u8; N]> {
    let mut bytes: [u8; N] = bytes.try_into().ok()?;
    if order == ByteOrder::Little {
        bytes.reverse();
    }
    Some(bytes)
}

fn hex(bytes: &[u8]) -> Option<f64> {
    let digits = bytes.trim_ascii();
    // 13 digits are 52 bits: every such number is exact in an f64.
    if digits.is_empty() || digits.len() > 13 || !digits.iter().all(u8::is_ascii_hexdigit) {
        return None;
    }
    let text = std::str::from_utf8(digits).ok()?;
    u64::from_str_radix(text, 16).ok().map(|whole| whole as f64)
}

/// Blanks may stand about the number and between its sign and its digits, as gauges with a fixed width print it.
/// Words such as `nan` and `inf` are no numbers of a device.
fn decimal(bytes: &[u8], point: u8) -> Option<f64> {
    const LONGEST: usize = 40;
    let bytes = bytes.trim_ascii();
    let (sign, digits) = match bytes {
        [sign @ (b'+' | b'-'), digits @ ..] => (Some(*sign), digits.trim_ascii_start()),
        digits => (None, digits),
    };
    let has_digit = digits.first().is_some_and(|b| b.is_ascii_digit() || *b == point);
    if digits.len() > LONGEST || !has_digit {
        return None;
    }
    let mut text = String::with_capacity(LONGEST + 1);
    text.extend(sign.map(char::from));
    for byte in digits {
        match *byte {
            byte if byte == point => text.push('.'),
            b'0'..=b'9' | b'e' | b'E' | b'+' | b'-' => text.push(char::from(*byte)),
            _ => return None,
        }
    }
    text.parse().ok().filter(|value: &f64| value.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals_of_gauges() {
        let read = |text: &str| Form::Decimal.read(text.as_bytes());
        assert_eq!(read("+01.2345"), Some(1.2345));
        assert_eq!(read("-00.0120"), Some(-0.012));
        assert_eq!(read(" - 12.5 "), Some(-12.5));
        assert_eq!(read(".5"), Some(0.5));
        assert_eq!(read("5."), Some(5.0));
        assert_eq!(read("1.5E-03"), Some(0.0015));
        for none in [
            "", "-", "nan", "inf", "-inf", "1e999", "1,2", "12mm", "--1", "XXXXXXX", "1 2", "+-3",
            "e5", ".",
        ] {
            assert_eq!(read(none), None, "{none}");
        }
        assert_eq!(read(&"1".repeat(41)), None);
        assert_eq!(Form::DecimalComma.read(b"-1,25"), Some(-1.25));
        assert_eq!(Form::DecimalComma.read(b"-1.25"), None, "a point is no comma");
    }

    #[test]
    fn whole_numbers_of_every_width() {
        let of = |word: &str, order| Form::binary(word, order).unwrap();
        use ByteOrder::{Big, Little};
        assert_eq!(of("u8", Big).read(&[255]), Some(255.0));
        assert_eq!(of("i8", Big).read(&[255]), Some(-1.0));
        assert_eq!(of("u16", Little).read(&[0xA5, 0x02]), Some(677.0));
        assert_eq!(of("i16", Big).read(&[0xFF, 0x7F]), Some(-129.0));
        assert_eq!(of("i24", Big).read(&[0x80, 0, 0]), Some(-8_388_608.0));
        assert_eq!(of("u24", Little).read(&[1, 0, 0x80]), Some(8_388_609.0));
        assert_eq!(of("i32", Big).read(&[0xFF, 0xFF, 0xFF, 0xFE]), Some(-2.0));
        assert_eq!(of("u32", Big).read(&[0xFF, 0xFF, 0xFF, 0xFE]), Some(4_294_967_294.0));
        // Baumer OM20's manual: 428B 7C37h is 69.743 mm.
        let millimetres = of("f32", Big).read(&[0x42, 0x8B, 0x7C, 0x37]).unwrap();
        assert!((millimetres - 69.743).abs() < 1e-3);
        assert_eq!(of("f64", Little).read(&1.5f64.to_le_bytes()), Some(1.5));
        assert_eq!(of("u16", Big).read(&[1]), None);
        assert_eq!(Form::binary("u64", Big), None);
    }

    #[test]
    fn hexadecimal_digits() {
        assert_eq!(Form::Hex.read(b"02A5"), Some(677.0));
        assert_eq!(Form::Hex.read(b"fFfFf"), Some(1_048_575.0));
        for none in [&b""[..], b"-1", b"0x1", b"12345678901234", b"G"] {
            assert_eq!(Form::Hex.read(none), None);
        }
    }
}
