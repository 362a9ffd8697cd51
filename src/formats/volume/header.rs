//! Headers of lines with a key and a value.

use crate::error::quoted;
use crate::scan::{finite, lines};
use crate::{Format, Place, ReadError};

/// A line of a header.
#[derive(Clone, Debug)]
pub(super) struct Entry {
    pub(super) key: String,
    pub(super) value: String,
    pub(super) line: usize,
}

/// The entries of a header.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) format: Format,
    pub(super) entries: Vec<Entry>,
}

/// Most bytes of a header that are looked at.
pub(super) const MAX_HEADER: usize = 1 << 16;

impl Header {
    /// The value of a key, with its line; of several the last one.
    pub(super) fn find(&self, keys: &[&str]) -> Option<&Entry> {
        self.entries.iter().rev().find(|entry| keys.contains(&entry.key.as_str()))
    }

    /// The same where it must be there.
    pub(super) fn require(&self, keys: &[&str]) -> Result<&Entry, ReadError> {
        self.find(keys).ok_or_else(|| ReadError::Malformed {
            format: self.format,
            place: Place::Line { line: 1, column: 0 },
            expected: format!("a line {} in the header", keys[0]),
            found: "none".into(),
        })
    }

    /// Why a line is wrong.
    pub(super) fn malformed(&self, entry: &Entry, expected: impl Into<String>) -> ReadError {
        ReadError::Malformed {
            format: self.format,
            place: Place::Line { line: entry.line, column: 0 },
            expected: expected.into(),
            found: quoted(entry.value.as_bytes()),
        }
    }

    /// Why a line is not read, though it may be right.
    pub(super) fn unsupported(&self, entry: &Entry, expected: impl Into<String>) -> ReadError {
        ReadError::Unsupported {
            format: self.format,
            place: Place::Line { line: entry.line, column: 0 },
            expected: expected.into(),
            found: quoted(entry.value.as_bytes()),
        }
    }

    /// Whole numbers of a line, as many as asked for.
    pub(super) fn wholes<const N: usize>(&self, entry: &Entry) -> Result<[u64; N], ReadError> {
        let numbers: Option<Vec<u64>> =
            entry.value.split_whitespace().map(|word| word.parse().ok()).collect();
        numbers
            .and_then(|numbers| numbers.try_into().ok())
            .ok_or_else(|| self.malformed(entry, format!("{N} whole numbers, {}", entry.key)))
    }

    /// Numbers of a line, as many as asked for; separators are spaces, commas and brackets.
    pub(super) fn numbers<const N: usize>(&self, entry: &Entry) -> Result<[f64; N], ReadError> {
        let is_separator = |letter: char| letter.is_whitespace() || ",()".contains(letter);
        let words = entry.value.split(is_separator).filter(|word| !word.is_empty());
        let numbers: Option<Vec<f64>> = words.map(|word| finite(word.as_bytes())).collect();
        numbers
            .and_then(|numbers| numbers.try_into().ok())
            .ok_or_else(|| self.malformed(entry, format!("{N} numbers, {}", entry.key)))
    }

    /// A yes or no.
    pub(super) fn flag(&self, keys: &[&str]) -> Result<bool, ReadError> {
        let Some(entry) = self.find(keys) else { return Ok(false) };
        match entry.value.to_ascii_lowercase().as_str() {
            "true" | "t" | "1" | "yes" => Ok(true),
            "false" | "f" | "0" | "no" => Ok(false),
            _ => Err(self.malformed(entry, "True or False")),
        }
    }
}

/// The lines at the start of a file with where each ends, in bytes. Lines end with LF or CR LF.
pub(super) fn lines_with_ends(bytes: &[u8]) -> impl Iterator<Item = (usize, String, usize)> {
    let start = &bytes[..bytes.len().min(MAX_HEADER)];
    let mut end = 0;
    start.split_inclusive(|&byte| byte == b'\n').enumerate().map(move |(index, line)| {
        end += line.len();
        let text = String::from_utf8_lossy(line);
        (index + 1, text.trim_end_matches(['\n', '\r']).to_owned(), end)
    })
}

/// Whether one of the first lines is `key`, a separator and anything.
pub(super) fn has_key(bytes: &[u8], key: &str, separator: char) -> bool {
    let start = &bytes[..bytes.len().min(4096)];
    lines(start).any(|(_, line)| {
        let text = String::from_utf8_lossy(line);
        text.split_once(separator).is_some_and(|(found, _)| found.trim() == key)
    })
}
