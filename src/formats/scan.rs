//! Numbers, lines and points counted safely: what several readers share.

use std::borrow::Cow;

use crate::{Format, MAX_POINTS, Place, ReadError};

/// A number as these formats write it: decimal, a point, an optional exponent. Not finite numbers,
/// which Rust would also take, are `None`.
pub(crate) fn finite(text: &[u8]) -> Option<f64> {
    let value: f64 = std::str::from_utf8(text).ok()?.trim().parse().ok()?;
    value.is_finite().then_some(value)
}

/// Whether a field says that nothing was measured: `NaN` as any program writes it, `BAD`, `NA`, `null` or asterisks.
pub(crate) fn says_missing(field: &[u8]) -> bool {
    let bare = field.strip_prefix(b"-").or(field.strip_prefix(b"+")).unwrap_or(field);
    let words: [&[u8]; 9] =
        [b"nan", b"bad", b"na", b"n/a", b"null", b"nan(ind)", b"1.#qnan", b"1.#ind", b"1.#snan"];
    words.iter().any(|word| bare.eq_ignore_ascii_case(word))
        || (!field.is_empty() && field.iter().all(|&byte| byte == b'*'))
}

/// Lines with their numbers, counted from 1. A line ends with LF, CR LF or CR.
pub(crate) fn lines(text: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let mut rest = Some(text);
    let mut number = 0;
    std::iter::from_fn(move || {
        let text = rest?;
        number += 1;
        let Some(end) = text.iter().position(|&byte| byte == b'\n' || byte == b'\r') else {
            rest = None;
            return Some((number, text));
        };
        let ending = if text[end..].starts_with(b"\r\n") { 2 } else { 1 };
        rest = Some(&text[end + ending..]);
        Some((number, &text[..end]))
    })
}

/// The text without a UTF-8 byte order mark.
pub(crate) fn without_bom(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(text)
}

/// Whether a text begins with a byte order mark of UTF-16.
pub(crate) fn is_utf16(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xFF, 0xFE]) || bytes.starts_with(&[0xFE, 0xFF])
}

/// The text in UTF-8. Programs begin UTF-16 with a byte order mark; where that was lost, every other byte of the ASCII at its start is
/// 0. What is neither UTF-16 nor UTF-8 is Latin-1.
pub(crate) fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    let wide = |bytes: &[u8], join: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| join([pair[0], pair[1]])).collect();
        Cow::Owned(String::from_utf16_lossy(&units))
    };
    match bytes {
        [0xFF, 0xFE, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => wide(rest, u16::from_be_bytes),
        [first, 0, ..] if *first != 0 => wide(bytes, u16::from_le_bytes),
        [0, second, ..] if *second != 0 => wide(bytes, u16::from_be_bytes),
        _ => match std::str::from_utf8(without_bom(bytes)) {
            Ok(text) => Cow::Borrowed(text),
            // Every byte is a letter of Latin-1, of the same number as in Unicode.
            Err(_) => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
        },
    }
}

/// How many samples a grid has: at least one, at most [`MAX_POINTS`].
pub(crate) fn grid_len(format: Format, place: Place, nx: u64, ny: u64) -> Result<usize, ReadError> {
    if nx == 0 || ny == 0 {
        return Err(ReadError::Malformed {
            format,
            place,
            expected: "at least one column and one row".into(),
            found: format!("{nx} × {ny}"),
        });
    }
    let len = nx.saturating_mul(ny);
    match usize::try_from(len) {
        Ok(samples) if len <= MAX_POINTS => Ok(samples),
        _ => Err(ReadError::TooLarge {
            format,
            place,
            unit: "points",
            limit: MAX_POINTS,
            found: len,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_three_ways() {
        let found: Vec<_> = lines(b"a\r\nb\rc\n\nd").collect();
        let expected: [(usize, &[u8]); 5] = [(1, b"a"), (2, b"b"), (3, b"c"), (4, b""), (5, b"d")];
        assert_eq!(found, expected);
        assert_eq!(lines(b"").collect::<Vec<_>>(), [(1, &b""[..])]);
    }

    #[test]
    fn only_finite_numbers_count() {
        assert_eq!(finite(b" -1.27E-007 "), Some(-1.27e-7));
        for text in ["", "inf", "NaN", "1e999", "1,5", "0x10", "1.5m", "\u{665}"] {
            assert_eq!(finite(text.as_bytes()), None, "{text}");
        }
    }

    #[test]
    fn grids_are_bounded_without_overflow() {
        let place = || Place::Byte(0);
        assert_eq!(grid_len(Format::Sdf, place(), 7, 4), Ok(28));
        assert!(grid_len(Format::Sdf, place(), 0, 4).is_err());
        assert!(grid_len(Format::Sdf, place(), u64::MAX, u64::MAX).is_err());
        assert!(grid_len(Format::Sdf, place(), MAX_POINTS, 1).is_ok());
        assert!(grid_len(Format::Sdf, place(), MAX_POINTS + 1, 1).is_err());
    }
}
