//! Lens files of Zemax (OpticStudio), `.zmx`: the surfaces of a sequential lens.
//!
//! The files are text, in UTF-16 (as OpticStudio writes them), UTF-8 or Latin-1. There is no public definition. A line is a keyword and its values;
//! `SURF n` begins a surface, whose lines follow until the next one:
//!
//! | line | meaning |
//! |---|---|
//! | `UNIT MM …` | lens unit: MM, CM, IN, METER |
//! | `TYPE STANDARD` | kind of surface; STANDARD if there is none |
//! | `CURV c …` | curvature at the vertex, 1/unit |
//! | `CONI k` | conic constant |
//! | `DIAM s …` | semi-diameter |
//! | `CLAP r1 r2 …` | aperture between two radii |
//! | `SQAP x y …` | rectangular aperture of these half widths |
//! | `OBDC x y` | decentre of the aperture |
//! | `PARM i v` | parameter i of the kind |
//! | `XDAT i v …` | extra datum i of the kind: the help's parameter i + 12 |
//! | `COMM text` | comment |
//!
//! What parameters and extra data mean is in OpticStudio's help, under Sequential Surfaces. Everything else (glasses, thicknesses, fields,
//! solves, tolerances) is passed over. Values stay in lens units.

use std::collections::BTreeMap;

use thiserror::Error;

use crate::error::{quoted, shown};
use crate::scan::{decoded, finite, lines};

/// The surfaces of a lens file.
#[derive(Clone, Debug, PartialEq)]
pub struct Lens {
    /// Its name, if it says one.
    pub name: Option<String>,
    /// One lens unit in mm.
    pub unit_mm: f64,
    /// How many configurations it has. With more than one, values may differ from those of the surfaces.
    pub configurations: u32,
    /// Its surfaces in the order of the file; the first is the object.
    pub surfaces: Vec<LensSurface>,
}

/// A surface, as the file has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LensSurface {
    /// Its number.
    pub number: u32,
    /// Line of the file on which it begins.
    pub line: usize,
    /// Its kind: `STANDARD`, `EVENASPH` ….
    pub kind: String,
    /// Its comment, if it has one.
    pub comment: Option<String>,
    /// Curvature at the vertex in 1/unit, positive where the centre lies in the sense of the light; 0 of a plane.
    pub curvature: f64,
    /// Conic constant.
    pub conic: f64,
    /// Semi-diameter in lens units; 0 where none is said.
    pub semi_diameter: f64,
    /// Its aperture, if it has one of its own.
    pub aperture: Option<LensAperture>,
    /// Where the middle of the aperture lies, x and y in lens units.
    pub aperture_centre: [f64; 2],
    /// Parameters by number, those that are given.
    pub parameters: BTreeMap<u32, f64>,
    /// Extra data by number, those that are given.
    pub extra: BTreeMap<u32, f64>,
}

/// The aperture of a surface, in lens units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LensAperture {
    /// A disc, or a ring, of this outer radius.
    Round {
        /// Outer radius.
        radius: f64,
    },
    /// A rectangle along x and y.
    Rectangle {
        /// Half of the width along x.
        half_x: f64,
        /// Half of the width along y.
        half_y: f64,
    },
}

/// Why a lens file cannot be read.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("Zemax file, line {line}: expected {expected}, found {}", shown(.found))]
pub struct LensError {
    /// Line of the file, from 1 on.
    pub line: usize,
    /// Content expected there.
    pub expected: &'static str,
    /// Content found there.
    pub found: String,
}

impl Lens {
    /// The surface of this number.
    pub fn surface(&self, number: u32) -> Option<&LensSurface> {
        self.surfaces.iter().find(|surface| surface.number == number)
    }
}

impl LensSurface {
    /// A parameter; 0 where it is not given, as the program has it.
    pub fn parameter(&self, number: u32) -> f64 {
        self.parameters.get(&number).copied().unwrap_or(0.0)
    }

    /// An extra datum; 0 where it is not given.
    pub fn extra(&self, number: u32) -> f64 {
        self.extra.get(&number).copied().unwrap_or(0.0)
    }
}

/// Whether a file is one: the first line has a keyword that lens files begin with, and before long a surface follows.
/// The text may be UTF-16, UTF-8 or Latin-1.
pub fn is_zemax(bytes: &[u8]) -> bool {
    const LOOKED_AT: usize = 65_536;
    let text = decoded(&bytes[..bytes.len().min(LOOKED_AT)]);
    let mut lines = lines(text.as_bytes()).map(|(_, line)| line.trim_ascii());
    let begins = |line: &[u8], keywords: &[&[u8]]| {
        let word = line.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        word.len() < line.len() && keywords.contains(&word)
    };
    let first = lines.by_ref().find(|line| !line.is_empty()).unwrap_or_default();
    let is_surface = |line: &[u8]| {
        let number = line.strip_prefix(b"SURF ").unwrap_or_default();
        !number.is_empty() && number.iter().all(u8::is_ascii_digit)
    };
    begins(first, &[b"VERS", b"MODE", b"NAME", b"UNIT"]) && lines.any(is_surface)
}

/// Reads a lens file. `O(bytes)`.
///
/// # Errors
///
/// A file without `UNIT` or without `SURF`, a unit that is not known, and a value that is no number, with its line.
///
/// # Example
///
/// ```
/// let file = b"UNIT MM X W X CM MR CPMM\nSURF 0\nSURF 1\n  TYPE EVENASPH\n  CURV 0.02 0 0 0 0\n  PARM 2 1e-6\n";
/// let lens = asphera_formats::zemax::read(file)?;
/// assert_eq!(lens.surfaces[1].kind, "EVENASPH");
/// assert_eq!(lens.surfaces[1].parameter(2), 1e-6);
/// # Ok::<(), asphera_formats::zemax::LensError>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<Lens, LensError> {
    let text = decoded(bytes);
    let mut unit_mm = None;
    let mut lens = Lens { name: None, unit_mm: 1.0, configurations: 1, surfaces: Vec::new() };
    // After the surfaces come tolerances and configurations, whose keywords may be the same.
    let mut is_over = false;
    for (line, content) in lines(text.as_bytes()) {
        let content = content.trim_ascii();
        let (keyword, rest) = match content.iter().position(u8::is_ascii_whitespace) {
            Some(end) => (&content[..end], content[end..].trim_ascii()),
            None => (content, &[][..]),
        };
        match keyword {
            b"UNIT" => unit_mm = Some(unit(line, rest)?),
            b"NAME" if lens.surfaces.is_empty() => lens.name = told(rest),
            b"MNUM" => {
                is_over = true;
                lens.configurations = whole(line, field(rest, 0))?;
            }
            b"TOL" => is_over = true,
            b"SURF" if !is_over => lens.surfaces.push(LensSurface {
                number: whole(line, field(rest, 0))?,
                line,
                kind: STANDARD.to_owned(),
                ..LensSurface::default()
            }),
            _ => {
                if let Some(surface) = lens.surfaces.last_mut().filter(|_| !is_over) {
                    surface.take(line, keyword, rest)?;
                }
            }
        }
    }
    let nothing = |expected| malformed(1, expected, "none");
    lens.unit_mm = unit_mm.ok_or_else(|| nothing("a line UNIT with the lens unit"))?;
    if lens.surfaces.is_empty() {
        return Err(nothing("at least one line SURF"));
    }
    Ok(lens)
}

impl LensSurface {
    fn take(&mut self, line: usize, keyword: &[u8], rest: &[u8]) -> Result<(), LensError> {
        match keyword {
            b"TYPE" => self.kind = String::from_utf8_lossy(field(rest, 0)).into_owned(),
            b"COMM" => self.comment = told(rest),
            b"CURV" => self.curvature = number(line, field(rest, 0))?,
            b"CONI" => self.conic = number(line, field(rest, 0))?,
            b"DIAM" => self.semi_diameter = number(line, field(rest, 0))?,
            b"CLAP" => {
                self.aperture = Some(LensAperture::Round { radius: number(line, field(rest, 1))? });
            }
            b"SQAP" => {
                self.aperture = Some(LensAperture::Rectangle {
                    half_x: number(line, field(rest, 0))?,
                    half_y: number(line, field(rest, 1))?,
                });
            }
            b"OBDC" => {
                self.aperture_centre =
                    [number(line, field(rest, 0))?, number(line, field(rest, 1))?];
            }
            b"PARM" | b"XDAT" => {
                let (index, value) = (whole(line, field(rest, 0))?, number(line, field(rest, 1))?);
                let data = if keyword == b"PARM" { &mut self.parameters } else { &mut self.extra };
                data.insert(index, value);
            }
            _ => {}
        }
        Ok(())
    }
}

fn unit(line: usize, rest: &[u8]) -> Result<f64, LensError> {
    match field(rest, 0).to_ascii_uppercase().as_slice() {
        b"MM" => Ok(1.0),
        b"CM" => Ok(10.0),
        b"IN" | b"INCH" => Ok(25.4),
        b"M" | b"METER" => Ok(1000.0),
        found => Err(malformed(line, "a unit MM, CM, IN or METER", quoted(found))),
    }
}

/// A text without the quotes around it; `None` if nothing is left.
fn told(rest: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(rest);
    let text = text.trim().trim_matches('"').trim();
    (!text.is_empty()).then(|| text.to_owned())
}

fn field(rest: &[u8], index: usize) -> &[u8] {
    let is_space = |byte: &u8| byte.is_ascii_whitespace();
    rest.split(is_space).filter(|field| !field.is_empty()).nth(index).unwrap_or_default()
}

fn number(line: usize, field: &[u8]) -> Result<f64, LensError> {
    finite(field).ok_or_else(|| malformed(line, "a finite number", quoted(field)))
}

fn whole(line: usize, field: &[u8]) -> Result<u32, LensError> {
    let value = std::str::from_utf8(field).ok().and_then(|field| field.parse().ok());
    value.ok_or_else(|| malformed(line, "a whole number", quoted(field)))
}

fn malformed(line: usize, expected: &'static str, found: impl Into<String>) -> LensError {
    LensError { line, expected, found: found.into() }
}

/// The kind of a surface that does not say one.
const STANDARD: &str = "STANDARD";

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "VERS 210913 1 1 L1\nMODE SEQ\nNAME \"Gr\u{fc}n\"\nUNIT IN X W X CM MR CPMM\n\
        SURF 0\n  TYPE STANDARD\n  CURV 0.0 0 0 0 0 \"\"\n  DISZ INFINITY\n  DIAM 0 0 0 0 1 \"\"\n\
        SURF 1\n  COMM front\n  TYPE QED_TYPE\n  CURV 5.0E-002 0 0 0 0 \"\"\n  CONI -1.5\n\
          DIAM 0.5 1 0 0 1 \"\"\n  CLAP 0 0.25 0\n  OBDC 0 -1.5\n  PARM 1 2.5\n  XDAT 1 1.000000000000E+000 0 0 1.0 0.0 0\n  XDAT 12 -3e-4 0 0 1 0 0\n\
        TOL TOFF   0   0\nMNUM 2 1\nCURV 99\n";

    #[test]
    fn surfaces_are_read_as_they_stand() {
        let lens = read(FILE.as_bytes()).unwrap();
        assert_eq!(
            (lens.name.as_deref(), lens.unit_mm, lens.configurations),
            (Some("Gr\u{fc}n"), 25.4, 2)
        );
        let expected = LensSurface {
            number: 1,
            line: 10,
            kind: "QED_TYPE".to_owned(),
            comment: Some("front".to_owned()),
            curvature: 0.05,
            conic: -1.5,
            semi_diameter: 0.5,
            aperture: Some(LensAperture::Round { radius: 0.25 }),
            aperture_centre: [0.0, -1.5],
            parameters: [(1, 2.5)].into(),
            extra: [(1, 1.0), (12, -3e-4)].into(),
        };
        assert_eq!(lens.surface(1), Some(&expected));
        assert_eq!(lens.surfaces.len(), 2);
        assert_eq!(
            (expected.parameter(1), expected.parameter(2), expected.extra(2)),
            (2.5, 0.0, 0.0)
        );
    }

    #[test]
    fn every_encoding_gives_the_same_lens() {
        let expected = read(FILE.as_bytes()).unwrap();
        let wide = |join: fn(u16) -> [u8; 2], mark: &[u8]| {
            let units = FILE.encode_utf16().flat_map(join);
            mark.iter().copied().chain(units).collect::<Vec<u8>>()
        };
        let latin_1: Vec<u8> = FILE.chars().map(|letter| letter as u8).collect();
        let files = [
            wide(u16::to_le_bytes, b"\xFF\xFE"),
            wide(u16::to_be_bytes, b"\xFE\xFF"),
            wide(u16::to_le_bytes, b""),
            wide(u16::to_be_bytes, b""),
            [b"\xEF\xBB\xBF", FILE.as_bytes()].concat(),
            latin_1,
            FILE.replace('\n', "\r\n").into_bytes(),
        ];
        for file in files {
            assert_eq!(read(&file).as_ref(), Ok(&expected));
        }
    }

    #[test]
    fn mistakes_are_told_with_their_line() {
        let cases: [(&[u8], &str); 6] = [
            (b"", "Zemax file, line 1: expected a line UNIT with the lens unit, found none"),
            (b"UNIT MM\n", "Zemax file, line 1: expected at least one line SURF, found none"),
            (
                b"UNIT FT\nSURF 0\n",
                "Zemax file, line 1: expected a unit MM, CM, IN or METER, found \"FT\"",
            ),
            (b"UNIT MM\nSURF x\n", "Zemax file, line 2: expected a whole number, found \"x\""),
            (
                b"UNIT MM\nSURF 0\nPARM 1\n",
                "Zemax file, line 3: expected a finite number, found \"\"",
            ),
            (
                b"UNIT MM\nSURF 0\nCURV inf\n",
                "Zemax file, line 3: expected a finite number, found \"inf\"",
            ),
        ];
        for (file, expected) in cases {
            assert_eq!(read(file).unwrap_err().to_string(), expected);
        }
    }

    proptest::proptest! {
        #[test]
        fn no_bytes_make_it_panic(bytes: Vec<u8>) {
            let _ = read(&bytes);
            let _ = read(&[b"UNIT MM\nSURF 0\n", bytes.as_slice()].concat());
        }
    }
}
