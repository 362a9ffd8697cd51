//! Bytes as a person writes them.

use std::fmt::Write as _;

use thiserror::Error;

/// Why a text stands for no bytes.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum BytesError {
    /// A backslash before something that means nothing.
    #[error("`\\{0}` means nothing: write \\r, \\n, \\t, \\\\ or \\xHH")]
    Escape(String),
    /// A sign beyond ASCII: nobody knows which bytes the device takes for it.
    #[error("{0:?} is no ASCII sign: write its bytes as \\xHH")]
    NotAscii(char),
}

/// Bytes of a text in which `\r`, `\n`, `\t`, `\\` and `\xHH` stand for one byte each.
///
/// # Errors
///
/// The first sign that stands for no byte.
pub fn bytes_of(text: &str) -> Result<Vec<u8>, BytesError> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut signs = text.chars();
    while let Some(sign) = signs.next() {
        if sign != '\\' {
            bytes.push(ascii(sign)?);
            continue;
        }
        bytes.push(match signs.next() {
            Some('r') => b'\r',
            Some('n') => b'\n',
            Some('t') => b'\t',
            Some('\\') => b'\\',
            Some('x') => {
                let digits: String = signs.by_ref().take(2).collect();
                let is_hex = digits.len() == 2 && digits.bytes().all(|b| b.is_ascii_hexdigit());
                let byte = is_hex.then(|| u8::from_str_radix(&digits, 16).ok()).flatten();
                byte.ok_or_else(|| BytesError::Escape(format!("x{digits}")))?
            }
            other => return Err(BytesError::Escape(other.map_or(String::new(), String::from))),
        });
    }
    Ok(bytes)
}

fn ascii(sign: char) -> Result<u8, BytesError> {
    u8::try_from(sign).ok().filter(u8::is_ascii).ok_or(BytesError::NotAscii(sign))
}

/// Text that [`bytes_of`] reads back.
pub fn text_of(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    for byte in bytes {
        match byte {
            b'\r' => text.push_str("\\r"),
            b'\n' => text.push_str("\\n"),
            b'\t' => text.push_str("\\t"),
            b'\\' => text.push_str("\\\\"),
            0x20..0x7F => text.push(char::from(*byte)),
            other => {
                // Writing to a string cannot fail.
                let _ = write!(text, "\\x{other:02X}");
            }
        }
    }
    text
}

/// Bytes of a device as a message shows them: at most 60 signs, then `…`.
pub fn shown(bytes: &[u8]) -> String {
    const LONGEST: usize = 60;
    let mut text: String = text_of(bytes).chars().take(LONGEST + 1).collect();
    if text.len() > LONGEST {
        text.truncate(LONGEST);
        text.push('…');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_stand_for_bytes() {
        assert_eq!(bytes_of(r"MAIN\r\n"), Ok(b"MAIN\r\n".to_vec()));
        assert_eq!(bytes_of(r"\x02\xfF\\\t"), Ok(vec![2, 0xFF, b'\\', b'\t']));
        assert_eq!(bytes_of("a\r"), Ok(b"a\r".to_vec()), "TOML may have put it there already");
        assert_eq!(bytes_of(r"\q"), Err(BytesError::Escape("q".into())));
        assert_eq!(bytes_of(r"\x+1"), Err(BytesError::Escape("x+1".into())));
        assert_eq!(bytes_of(r"\x1"), Err(BytesError::Escape("x1".into())));
        assert_eq!(bytes_of("\\"), Err(BytesError::Escape(String::new())));
        assert_eq!(bytes_of("µ"), Err(BytesError::NotAscii('µ')));
    }

    #[test]
    fn long_bytes_are_shown_shortened() {
        assert_eq!(shown(b"ER,MAIN,22\r"), "ER,MAIN,22\\r");
        assert_eq!(shown(&[b'7'; 100]).chars().count(), 61);
    }

    #[test]
    fn every_byte_can_be_written() {
        let bytes: Vec<u8> = (0..=255).collect();
        assert_eq!(bytes_of(&text_of(&bytes)), Ok(bytes));
    }
}
