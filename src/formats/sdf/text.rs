//! Text SDF: three parts, each ended by an asterisk: header, heights, trailer.
//!
//! ```text
//! aISO-1.0
//! ManufacID = …          key, optional equals sign, value
//! *
//! 1.0 0.99 BAD …         NumPoints × NumProfiles heights, lines broken anywhere
//! *
//! < OperatorName > …     free text
//! *
//! ```
//!
//! A line of the header that starts with a semicolon is a comment, and keys not named in the
//! standard are passed over.

use super::{DataType, Header, check_plain, malformed, source};
use crate::error::quoted;
use crate::scan::{finite, lines, says_missing};
use crate::topography::joined;
use crate::{Place, ReadError, Topography};

pub(super) fn read(text: &[u8]) -> Result<Topography, ReadError> {
    let mut lines = lines(text);
    let first = lines.next().map_or(&b""[..], |(_, line)| line);
    if !matches!(first.trim_ascii(), b"aISO-1.0" | b"aBCR-1.0") {
        return Err(malformed(at(1, 0), "aISO-1.0 or aBCR-1.0", quoted(first)));
    }
    let mut fields = Fields::default();
    fields.read(&mut lines)?;
    let mut header = fields.header()?;
    let stored = heights(&mut lines, header.samples()?, header.data_type)?;
    header.source.comment = trailer(lines);
    header.into_topography(stored)
}

fn at(line: usize, column: usize) -> Place {
    Place::Line { line, column }
}

/// The `key = value` lines of the header.
#[derive(Default)]
struct Fields<'a> {
    found: Vec<(&'a [u8], &'a [u8], usize)>,
    /// The line that ends the header.
    end: usize,
}

impl<'a> Fields<'a> {
    fn read(
        &mut self,
        lines: &mut impl Iterator<Item = (usize, &'a [u8])>,
    ) -> Result<(), ReadError> {
        for (number, line) in lines {
            self.end = number;
            let line = line.trim_ascii();
            if line.starts_with(b"*") {
                return Ok(());
            }
            if line.is_empty() || line.starts_with(b";") {
                continue;
            }
            let is_end = |byte: &u8| byte.is_ascii_whitespace() || *byte == b'=';
            let key_len = line.iter().position(is_end).unwrap_or(line.len());
            let value = line[key_len..].trim_ascii_start();
            let value = value.strip_prefix(b"=").unwrap_or(value).trim_ascii_start();
            self.found.push((&line[..key_len], value, number));
        }
        Err(malformed(at(self.end, 0), "an asterisk after the header", "the end of the file"))
    }

    fn header(&self) -> Result<Header, ReadError> {
        let place = |key| self.get(key).map_or(at(self.end, 0), |(_, line)| at(line, 0));
        for key in ["Compression", "CheckType"] {
            if self.get(key).is_some() {
                check_plain(key, self.whole(key)?, place(key))?;
            }
        }
        let text = |key| {
            let value = self.get(key).map_or(&b""[..], |(value, _)| value);
            String::from_utf8_lossy(value).into_owned()
        };
        Ok(Header {
            points: (self.whole("NumPoints")?, place("NumPoints")),
            profiles: (self.whole("NumProfiles")?, place("NumProfiles")),
            x_scale_m: (self.scale("Xscale")?, place("Xscale")),
            y_scale_m: (self.scale("Yscale")?, place("Yscale")),
            z_scale_m: (self.scale("Zscale")?, place("Zscale")),
            data_type: DataType::from_code(self.whole("DataType")?, place("DataType"))?,
            source: source(&text("ManufacID"), &text("CreateDate")),
        })
    }

    /// Value and line of the only field of that name.
    fn get(&self, key: &str) -> Option<(&'a [u8], usize)> {
        let mut of_that_name = self.found.iter().filter(|(name, ..)| *name == key.as_bytes());
        of_that_name.next().map(|&(_, value, line)| (value, line))
    }

    fn required(&self, key: &str) -> Result<(&'a [u8], usize), ReadError> {
        if let Some((_, _, line)) =
            self.found.iter().filter(|(name, ..)| *name == key.as_bytes()).nth(1)
        {
            return Err(malformed(at(*line, 0), &format!("{key} only once"), "it again"));
        }
        self.get(key).ok_or_else(|| {
            malformed(at(self.end, 0), &format!("{key} before the end of the header"), "none")
        })
    }

    fn whole(&self, key: &str) -> Result<u64, ReadError> {
        let (value, line) = self.required(key)?;
        let number = std::str::from_utf8(value).ok().and_then(|text| text.parse().ok());
        number.ok_or_else(|| {
            malformed(at(line, 0), &format!("a whole number for {key}"), quoted(value))
        })
    }

    fn scale(&self, key: &str) -> Result<f64, ReadError> {
        let (value, line) = self.required(key)?;
        finite(value).ok_or_else(|| {
            malformed(at(line, 0), &format!("a number in metres for {key}"), quoted(value))
        })
    }
}

/// The stored heights up to the next asterisk or the end of the file.
fn heights<'a>(
    lines: &mut impl Iterator<Item = (usize, &'a [u8])>,
    samples: usize,
    data_type: DataType,
) -> Result<Vec<f64>, ReadError> {
    let is_whole = !matches!(data_type, DataType::F32 | DataType::F64);
    let mut stored = Vec::new();
    let mut end = 0;
    'data: for (number, line) in lines {
        end = number;
        let words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        for (column, word) in words.enumerate() {
            if word == b"*" {
                break 'data;
            }
            let place = || at(number, column + 1);
            if stored.len() == samples {
                let expected = format!("an asterisk after {samples} heights");
                return Err(malformed(place(), &expected, quoted(word)));
            }
            let value = if says_missing(word) { Some(f64::NAN) } else { finite(word) };
            let value = value.filter(|value| !is_whole || value.is_nan() || value.fract() == 0.0);
            stored.push(value.ok_or_else(|| {
                let kind = if is_whole { "a whole number or BAD" } else { "a number or BAD" };
                malformed(place(), kind, quoted(word))
            })?);
        }
    }
    if stored.len() < samples {
        let expected = format!("{samples} heights before here");
        return Err(malformed(at(end, 0), &expected, stored.len()));
    }
    Ok(stored)
}

/// The free text of the last part.
fn trailer<'a>(lines: impl Iterator<Item = (usize, &'a [u8])>) -> Option<String> {
    let text = lines
        .map(|(_, line)| String::from_utf8_lossy(line.trim_ascii()).into_owned())
        .take_while(|line| line != "*")
        .collect::<Vec<_>>();
    joined(&text.iter().map(String::as_str).collect::<Vec<_>>())
}
