//! Numbers as devices write them: the other way round of what the driver reads.

use asphera_described::{ByteOrder, Form};

/// A number in bytes: rounded and held within what the form can say. Empty for forms in text.
pub(crate) fn in_bytes(form: Form, raw: f64) -> Vec<u8> {
    match form {
        Form::Unsigned(width, order) => {
            let largest = (1_u64 << (8 * u32::from(width))) - 1;
            ordered(
                &(raw.round() as u64).min(largest).to_be_bytes()[8 - usize::from(width)..],
                order,
            )
        }
        Form::Signed(width, order) => {
            let half = 1_i64 << (8 * u32::from(width) - 1);
            let whole = (raw.round() as i64).clamp(-half, half - 1);
            ordered(&whole.to_be_bytes()[8 - usize::from(width)..], order)
        }
        Form::Single(order) => ordered(&(raw as f32).to_be_bytes(), order),
        Form::Double(order) => ordered(&raw.to_be_bytes(), order),
        Form::Decimal | Form::DecimalComma | Form::Hex => Vec::new(),
    }
}

/// A number in digits, as short as it can be without losing any.
pub(crate) fn in_digits(form: Form, raw: f64) -> String {
    match form {
        Form::Hex => format!("{:X}", raw.round().max(0.0) as u64),
        Form::DecimalComma => raw.to_string().replace('.', ","),
        _ => raw.to_string(),
    }
}

/// How a gauge prints a number: sign, least width and decimals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Print {
    has_sign: bool,
    width: usize,
    decimals: usize,
}

impl Print {
    /// Every print that a pattern may ask for, the finest first.
    pub(crate) fn all() -> impl Iterator<Item = Print> {
        let signs = |decimals| {
            [false, true].into_iter().flat_map(move |has_sign| {
                (0..=WIDEST).map(move |width| Print { has_sign, width, decimals })
            })
        };
        (0..=MOST_DECIMALS).rev().flat_map(signs)
    }

    /// The number in this print.
    pub(crate) fn text(self, form: Form, raw: f64) -> String {
        let Print { has_sign, width, decimals } = self;
        let text = match form {
            Form::Hex => format!("{:0width$X}", raw.round().max(0.0) as u64),
            _ if has_sign => format!("{raw:+0width$.decimals$}"),
            _ => format!("{raw:0width$.decimals$}"),
        };
        if form == Form::DecimalComma { text.replace('.', ",") } else { text }
    }
}

fn ordered(big: &[u8], order: ByteOrder) -> Vec<u8> {
    match order {
        ByteOrder::Big => big.to_vec(),
        ByteOrder::Little => big.iter().rev().copied().collect(),
    }
}

const WIDEST: usize = 12;
const MOST_DECIMALS: usize = 9;

#[cfg(test)]
mod tests {
    use super::*;

    /// Values printed in manuals, the other way round: an OM20 sends 69.743 mm as 428B7C37h.
    #[test]
    fn bytes_are_those_of_manuals() {
        assert_eq!(in_bytes(Form::Unsigned(2, ByteOrder::Little), 677.0), [0xA5, 0x02]);
        assert_eq!(in_bytes(Form::Signed(3, ByteOrder::Big), -8_388_608.0), [0x80, 0, 0]);
        assert_eq!(in_bytes(Form::Signed(2, ByteOrder::Big), -129.0), [0xFF, 0x7F]);
        assert_eq!(in_bytes(Form::Single(ByteOrder::Big), 69.742_607), [0x42, 0x8B, 0x7C, 0x37]);
        assert_eq!(in_bytes(Form::Unsigned(1, ByteOrder::Big), 300.0), [255], "held within");
    }

    #[test]
    fn digits_lose_nothing() {
        assert_eq!(in_digits(Form::Decimal, -0.1 - 0.2), "-0.30000000000000004");
        assert_eq!(in_digits(Form::DecimalComma, 1.25), "1,25");
        assert_eq!(in_digits(Form::Hex, 677.0), "2A5");
        let print = Print { has_sign: true, width: 7, decimals: 2 };
        assert_eq!(print.text(Form::Decimal, 21.3), "+021.30");
    }
}
