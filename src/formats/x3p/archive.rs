//! The zip archive: entries read with a limit set beforehand, and checksums.

use std::fmt::Write as _;
use std::io::{Cursor, Read};

use md5::{Digest, Md5};
use zip::ZipArchive;
use zip::result::ZipError;

use super::MAIN_XML;
use crate::error::quoted;
use crate::{Format, Place, ReadError};

/// An X3P file as the archive it is.
pub(super) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
}

impl<'a> Archive<'a> {
    pub(super) fn open(bytes: &'a [u8]) -> Result<Archive<'a>, ReadError> {
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(|error| ReadError::Malformed {
            format: Format::X3p,
            place: Place::Byte(0),
            expected: "a complete zip archive".into(),
            found: error.to_string(),
        })?;
        Ok(Archive { zip })
    }

    /// The text of `main.xml`.
    pub(super) fn main_xml(&mut self) -> Result<Vec<u8>, ReadError> {
        self.entry(MAIN_XML, MAX_MAIN_XML)?
            .ok_or_else(|| malformed(MAIN_XML, "an entry of this name".into(), "none"))
    }

    /// Compares `main.xml` with its checksum. An archive without a checksum file has none to compare.
    pub(super) fn verify_main(&mut self, main: &[u8], file: &str) -> Result<(), ReadError> {
        let Some(text) = self.entry(file, MAX_CHECKSUM_FILE)? else {
            return Ok(());
        };
        // As `md5sum` writes it: checksum, blank, file name.
        let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let stated = words.next().unwrap_or_default();
        let stated = checksum(&String::from_utf8_lossy(stated))
            .ok_or_else(|| malformed(file, "32 hexadecimal digits".into(), quoted(&text)))?;
        verify(main, &stated, MAIN_XML)
    }

    /// The content of a binary file of exactly `len` bytes, verified against its checksum.
    pub(super) fn binary(
        &mut self,
        name: &str,
        len: usize,
        stated: Option<&str>,
    ) -> Result<Vec<u8>, ReadError> {
        let content = self
            .entry(name, len as u64)?
            .ok_or_else(|| malformed(name, "an entry of this name".into(), "none"))?;
        if content.len() != len {
            let expected = format!("{len} bytes for the points declared");
            return Err(malformed(name, expected, content.len()));
        }
        if let Some(stated) = stated {
            verify(&content, stated, name)?;
        }
        Ok(content)
    }

    /// The content of an entry of at most `limit` bytes, or `None` if there is no such entry.
    ///
    /// Memory grows with what is unpacked, never with the size that the archive claims, and
    /// unpacking stops at the limit.
    fn entry(&mut self, name: &str, limit: u64) -> Result<Option<Vec<u8>>, ReadError> {
        let broken = |error: &dyn std::fmt::Display| {
            malformed(name, "an entry that can be unpacked".into(), error)
        };
        // Archives written under Windows may separate folders by backslashes.
        let path = name.replace('\\', "/");
        let entry = match self.zip.by_name(path.trim_start_matches("./")) {
            Ok(entry) => entry,
            Err(ZipError::FileNotFound) => return Ok(None),
            Err(error) => return Err(broken(&error)),
        };
        let too_large = |found| ReadError::TooLarge {
            format: Format::X3p,
            place: Place::Entry(name.into()),
            unit: "bytes",
            limit,
            found,
        };
        if entry.size() > limit {
            return Err(too_large(entry.size()));
        }
        let mut content = Vec::new();
        entry.take(limit + 1).read_to_end(&mut content).map_err(|error| broken(&error))?;
        if content.len() as u64 > limit {
            return Err(too_large(content.len() as u64));
        }
        Ok(Some(content))
    }
}

/// The MD5 checksum as 32 lower-case hexadecimal digits.
pub(super) fn md5_hex(content: &[u8]) -> String {
    let digest = Md5::digest(content);
    digest.iter().fold(String::with_capacity(32), |mut hex, byte| {
        // Writing to a String cannot fail.
        let _ = write!(hex, "{byte:02x}");
        hex
    })
}

/// A stated checksum in lower case, or `None` if it is none.
pub(super) fn checksum(text: &str) -> Option<String> {
    let text = text.trim();
    let is_checksum = text.len() == 32 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    is_checksum.then(|| text.to_ascii_lowercase())
}

fn verify(content: &[u8], stated: &str, name: &str) -> Result<(), ReadError> {
    let found = md5_hex(content);
    if found == stated {
        return Ok(());
    }
    Err(ReadError::Checksum {
        format: Format::X3p,
        place: Place::Entry(name.into()),
        expected: stated.into(),
        found,
    })
}

fn malformed(name: &str, expected: String, found: impl ToString) -> ReadError {
    ReadError::Malformed {
        format: Format::X3p,
        place: Place::Entry(name.into()),
        expected,
        found: found.to_string(),
    }
}

/// Longest `main.xml` read: room for some 10⁶ points as text. The standard recommends binary files
/// for more than 10⁴.
const MAX_MAIN_XML: u64 = 64 << 20;

/// Longest checksum file read; `md5sum` writes 43 bytes.
const MAX_CHECKSUM_FILE: u64 = 4096;
