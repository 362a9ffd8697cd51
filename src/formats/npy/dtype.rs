//! Types of the items of an array.

use super::literal::Literal;

/// An item of an array.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Item {
    Number(Number),
    Record {
        /// Bytes of a record.
        size: usize,
        fields: Vec<Field>,
    },
}

/// A field of a record that is a single number; texts, times, arrays and padding are none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Field {
    pub(super) name: String,
    /// Its first byte in the record.
    pub(super) at: usize,
    pub(super) number: Number,
}

/// A type of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Number {
    kind: Kind,
    is_big: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Signed(usize),
    Unsigned(usize),
    F32,
    F64,
}

impl Number {
    /// Bytes of a number.
    pub(super) const fn size(self) -> usize {
        match self.kind {
            Kind::Signed(size) | Kind::Unsigned(size) => size,
            Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }

    /// The number at a byte of `data`; whole numbers above 2⁵³ are rounded. NaN beyond the data.
    pub(super) fn at(self, data: &[u8], at: usize) -> f64 {
        let Some(found) = data.get(at..at + self.size()) else { return f64::NAN };
        let mut bytes = [0; 8];
        let taken = &mut bytes[..found.len()];
        taken.copy_from_slice(found);
        if self.is_big {
            taken.reverse();
        }
        let whole = u64::from_le_bytes(bytes);
        match self.kind {
            // Moved up and down again, the sign fills what is above it.
            Kind::Signed(size) => {
                let unused = 64 - 8 * size;
                ((whole << unused) as i64 >> unused) as f64
            }
            Kind::Unsigned(_) => whole as f64,
            Kind::F32 => f64::from(f32::from_bits(whole as u32)),
            Kind::F64 => f64::from_bits(whole),
        }
    }
}

/// The type that a description names. `Err` holds what is not read.
pub(super) fn item(descr: &Literal) -> Result<Item, String> {
    match descr {
        Literal::Text(text) => {
            let (number, _) = simple(text)?;
            number.map(Item::Number).ok_or_else(|| format!("an array of type {text}"))
        }
        Literal::List(fields) => {
            let (size, fields) = record(fields)?;
            Ok(Item::Record { size, fields })
        }
        _ => Err("an array of an unknown type".into()),
    }
}

/// Bytes and fields of a record.
fn record(parts: &[Literal]) -> Result<(usize, Vec<Field>), String> {
    let (mut at, mut fields) = (0_usize, Vec::new());
    for part in parts {
        let Literal::List(part) = part else { return Err("a record of unknown fields".into()) };
        let (name, descr, shape) = match &part[..] {
            [name, descr] => (name, descr, None),
            [name, descr, Literal::List(shape)] => (name, descr, Some(shape)),
            _ => return Err("a record of unknown fields".into()),
        };
        let name = match name {
            Literal::Text(name) => name.clone(),
            // A title stands before the name.
            Literal::List(names) => match &names[..] {
                [_, Literal::Text(name)] => name.clone(),
                _ => return Err("a record of unknown fields".into()),
            },
            _ => return Err("a record of unknown fields".into()),
        };
        let (number, size) = match descr {
            Literal::Text(text) => simple(text)?,
            Literal::List(parts) => (None, record(parts)?.0),
            _ => return Err(format!("a field {name} of unknown type")),
        };
        let many = shape.map_or(Some(1), |shape| {
            shape.iter().try_fold(1_usize, |product, size| match size {
                Literal::Whole(size) => product.checked_mul(usize::try_from(*size).ok()?),
                _ => None,
            })
        });
        let len = many.and_then(|many| many.checked_mul(size));
        let end = len.and_then(|len| at.checked_add(len));
        let end = end.ok_or_else(|| format!("a field {name} of impossible size"))?;
        if let Some(number) = number.filter(|_| shape.is_none() && !name.is_empty()) {
            fields.push(Field { name, at, number });
        }
        at = end;
    }
    Ok((at, fields))
}

/// A type such as `<f8`: the number, if it is one that is read, and its bytes.
fn simple(text: &str) -> Result<(Option<Number>, usize), String> {
    let unknown = || format!("the type {text}");
    let bare = text.strip_prefix(['<', '>', '|', '=']).unwrap_or(text);
    let kind = bare.chars().next().ok_or_else(unknown)?;
    let digits = &bare[kind.len_utf8()..];
    let digits = digits.split('[').next().unwrap_or(digits);
    let size: usize = match kind {
        'O' => return Err("an array of Python objects".into()),
        // Letters of 4 bytes.
        'U' => digits.parse().ok().and_then(|count: usize| count.checked_mul(4)),
        _ => digits.parse().ok(),
    }
    .ok_or_else(unknown)?;
    let kind = match (kind, size) {
        ('i', 1 | 2 | 4 | 8) => Some(Kind::Signed(size)),
        ('u', 1 | 2 | 4 | 8) => Some(Kind::Unsigned(size)),
        ('f', 4) => Some(Kind::F32),
        ('f', 8) => Some(Kind::F64),
        _ => None,
    };
    Ok((kind.map(|kind| Number { kind, is_big: text.starts_with('>') }), size))
}
