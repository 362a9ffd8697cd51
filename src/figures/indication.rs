//! The indication `3/A(B/C) RMSt<…; RMSi<…; RMSa<…; λ=…` of ISO 10110-5:2015.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::{Definition, Irregularity};

/// Unit of the numbers of an indication.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LengthUnit {
    /// Nanometres of surface height, the preferred unit.
    Nanometres,
    /// Fringe spacings, of half the wavelength each.
    Fringes {
        /// The wavelength in nm.
        wavelength_nm: f64,
    },
}

impl LengthUnit {
    /// One of it in nm.
    pub fn nm(self) -> f64 {
        match self {
            LengthUnit::Nanometres => 1.0,
            LengthUnit::Fringes { wavelength_nm } => 0.5 * wavelength_nm,
        }
    }
}

/// Limits of the form deviation, in nm; `None` where the drawing states none.
///
/// Read from text by [`FromStr`]: spaces do not matter, a dash stands for no limit, a decimal comma is
/// taken for a point. A number followed by `nm` is in nm. A bare one is in fringe spacings if a wavelength is
/// stated, else in nm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indication {
    /// A: range of the approximating sphere.
    pub a_nm: Option<f64>,
    /// B: range of the irregularity.
    pub b_nm: Option<f64>,
    /// C: range of the rotationally invariant irregularity.
    pub c_nm: Option<f64>,
    /// RMSt: of the total deviation.
    pub rms_total_nm: Option<f64>,
    /// RMSi: of the irregularity.
    pub rms_irregularity_nm: Option<f64>,
    /// RMSa: of the rotationally variant part.
    pub rms_variant_nm: Option<f64>,
    /// The unit the indication is written in.
    pub unit: LengthUnit,
}

/// Why a text is no indication of surface form. `at` is the place of what is wrong, in characters from 1.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum IndicationError {
    /// It does not begin with the code 3.
    #[error("{text:?} does not begin with \"3/\", the code of surface form")]
    Code {
        /// The whole text.
        text: String,
    },
    /// What follows the code is not A, A(B) or A(B/C).
    #[error("expected {expected} at character {at}, found {}", or_end(found))]
    Limits {
        /// Text that should stand there.
        expected: &'static str,
        /// Text that stands there; empty at the end.
        found: String,
        /// Where.
        at: usize,
    },
    /// A number is not one, or negative.
    #[error("expected a number not below 0, or a dash, at character {at}, found {}", or_end(found))]
    Number {
        /// Text in its place; empty at the end.
        found: String,
        /// Where.
        at: usize,
    },
    /// Something that is neither an RMS limit nor a wavelength.
    #[error("expected RMSt<…, RMSi<…, RMSa<… or λ=… at character {at}, found {found:?}")]
    Item {
        /// Text that stands there.
        found: String,
        /// Where.
        at: usize,
    },
    /// Something is stated twice.
    #[error("{name} is stated a second time at character {at}")]
    Twice {
        /// Text that stands there.
        name: &'static str,
        /// Where the second time begins.
        at: usize,
    },
    /// The wavelength is not a positive number.
    #[error("expected a wavelength above 0 in nm at character {at}, found {}", or_end(found))]
    Wavelength {
        /// Text in its place; empty at the end.
        found: String,
        /// Where.
        at: usize,
    },
}

fn or_end(found: &str) -> String {
    if found.is_empty() { "the end".to_owned() } else { format!("{found:?}") }
}

/// A figure held against its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Which figure.
    pub definition: Definition,
    /// Its value in nm.
    pub value_nm: f64,
    /// The largest permitted value in nm.
    pub limit_nm: f64,
}

impl Comparison {
    /// Whether the value does not exceed the limit. Its uncertainty is not regarded.
    pub fn holds(&self) -> bool {
        self.value_nm <= self.limit_nm
    }
}

impl Indication {
    /// An indication without limits.
    pub fn new(unit: LengthUnit) -> Indication {
        Indication {
            a_nm: None,
            b_nm: None,
            c_nm: None,
            rms_total_nm: None,
            rms_irregularity_nm: None,
            rms_variant_nm: None,
            unit,
        }
    }

    /// Every figure that has a limit, with that in nm, in the order of the indication.
    pub fn limits(&self) -> Vec<(Definition, f64)> {
        let limits = [
            (Definition::Sagitta, self.a_nm),
            (Definition::Irregularity, self.b_nm),
            (Definition::InvariantIrregularity, self.c_nm),
            (Definition::RmsTotal, self.rms_total_nm),
            (Definition::RmsIrregularity, self.rms_irregularity_nm),
            (Definition::RmsVariant, self.rms_variant_nm),
        ];
        limits.into_iter().filter_map(|(definition, limit)| Some((definition, limit?))).collect()
    }

    /// Every figure that has a limit, in the order of the indication.
    pub fn compare(&self, found: &Irregularity) -> Vec<Comparison> {
        let figures = found.figures();
        let compared = self.limits().into_iter().filter_map(|(definition, limit_nm)| {
            let figure = figures.iter().find(|figure| figure.definition == definition)?;
            Some(Comparison { definition, value_nm: figure.value, limit_nm })
        });
        compared.collect()
    }
}

impl FromStr for Indication {
    type Err = IndicationError;

    fn from_str(text: &str) -> Result<Indication, IndicationError> {
        let mut reader = Reader { whole: text, rest: text };
        if !(reader.takes("3") && reader.takes("/")) {
            return Err(IndicationError::Code { text: text.to_owned() });
        }
        let [a, b, c] = reader.heights()?;
        let mut stated = Stated::default();
        while !reader.is_at_end() {
            // No semicolon is needed before the first RMS limit, and more of them do no harm.
            if !reader.takes(";") {
                stated.item(&mut reader)?;
            }
        }
        let unit = match stated.wavelength_nm {
            Some(wavelength_nm) => LengthUnit::Fringes { wavelength_nm },
            None => LengthUnit::Nanometres,
        };
        let nm = |number: Option<Number>| {
            number.map(|Number { value, in_nm }| if in_nm { value } else { value * unit.nm() })
        };
        let [rms_total_nm, rms_irregularity_nm, rms_variant_nm] =
            stated.rms.map(|stated| nm(stated.flatten()));
        let (a_nm, b_nm, c_nm) = (nm(a), nm(b), nm(c));
        Ok(Indication { a_nm, b_nm, c_nm, rms_total_nm, rms_irregularity_nm, rms_variant_nm, unit })
    }
}

/// A number as it is written.
#[derive(Clone, Copy)]
struct Number {
    value: f64,
    /// Whether `nm` follows it.
    in_nm: bool,
}

/// Items after the limits A, B and C.
#[derive(Default)]
struct Stated {
    /// Of each RMS whether it is stated, and its limit.
    rms: [Option<Option<Number>>; 3],
    wavelength_nm: Option<f64>,
}

impl Stated {
    fn item(&mut self, reader: &mut Reader<'_>) -> Result<(), IndicationError> {
        let (at, found) = (reader.place(), reader.word(|c| c != ';'));
        let item = || IndicationError::Item { found, at };
        for (slot, name) in RMS.into_iter().enumerate() {
            if reader.takes(name) {
                if !(reader.takes("<") || reader.takes("≤")) {
                    return Err(item());
                }
                return match self.rms[slot].replace(reader.limit()?) {
                    None => Ok(()),
                    Some(_) => Err(IndicationError::Twice { name, at }),
                };
            }
        }
        if !((reader.takes("λ") || reader.takes("lambda")) && reader.takes("=")) {
            return Err(item());
        }
        let (at_number, found) = (reader.place(), reader.word(|c| c != ';'));
        let number = reader.number().filter(|number| number.value > 0.0);
        let Some(Number { value, .. }) = number else {
            return Err(IndicationError::Wavelength { found, at: at_number });
        };
        match self.wavelength_nm.replace(value) {
            None => Ok(()),
            Some(_) => Err(IndicationError::Twice { name: "λ", at }),
        }
    }
}

/// Remainder of a text. Spaces are passed over wherever they stand, but for those within a number.
struct Reader<'a> {
    whole: &'a str,
    rest: &'a str,
}

impl<'a> Reader<'a> {
    fn is_at_end(&mut self) -> bool {
        self.rest = self.rest.trim_start();
        self.rest.is_empty()
    }

    /// Where the rest begins, in characters from 1.
    fn place(&mut self) -> usize {
        self.rest = self.rest.trim_start();
        self.whole[..self.whole.len() - self.rest.len()].chars().count() + 1
    }

    /// What stands next, as long as it is of these characters; it is not taken.
    fn word(&mut self, of: impl Fn(char) -> bool) -> String {
        self.rest
            .trim_start()
            .chars()
            .take_while(|&c| of(c))
            .collect::<String>()
            .trim_end()
            .to_owned()
    }

    /// Takes these characters if they stand next, whatever spaces are before and between them.
    fn takes(&mut self, characters: &str) -> bool {
        let mut rest = self.rest;
        for c in characters.chars() {
            match rest.trim_start().strip_prefix(c) {
                Some(after) => rest = after,
                None => return false,
            }
        }
        self.rest = rest;
        true
    }

    /// A, A(B) or A(B/C).
    fn heights(&mut self) -> Result<[Option<Number>; 3], IndicationError> {
        let a = self.limit()?;
        if !self.takes("(") {
            let ends = self.is_at_end() || self.rest.starts_with([';', 'R', 'λ', 'l']);
            return if ends { Ok([a, None, None]) } else { Err(self.expected("\"(\" or \";\"")) };
        }
        let b = self.limit()?;
        let c = if self.takes("/") { self.limit()? } else { None };
        if self.takes(")") { Ok([a, b, c]) } else { Err(self.expected("\")\"")) }
    }

    fn expected(&mut self, expected: &'static str) -> IndicationError {
        let at = self.place();
        IndicationError::Limits { expected, found: self.rest.chars().take(1).collect(), at }
    }

    /// A limit; `None` for a dash.
    fn limit(&mut self) -> Result<Option<Number>, IndicationError> {
        let before = self.rest;
        if ["-", "–", "—"].into_iter().any(|dash| self.takes(dash)) {
            if !self.is_digit() {
                return Ok(None);
            }
            self.rest = before;
        }
        let at = self.place();
        let found = self.word(|c| !";()/".contains(c));
        self.number().map(Some).ok_or(IndicationError::Number { found, at })
    }

    fn is_digit(&self) -> bool {
        self.rest.trim_start().starts_with(|c: char| c.is_ascii_digit() || ".,".contains(c))
    }

    /// A finite number that is not negative, with a decimal point or comma, and `nm` if that follows.
    fn number(&mut self) -> Option<Number> {
        let mut digits = String::new();
        let mut rest = self.rest.trim_start();
        while let Some(c) = rest.chars().next() {
            let after_e = digits.ends_with(['e', 'E']);
            let is_part = c.is_ascii_digit()
                || ".,".contains(c)
                || (!digits.is_empty() && "eE".contains(c))
                || (after_e && "+-".contains(c));
            if !is_part {
                break;
            }
            digits.push(if c == ',' { '.' } else { c });
            rest = &rest[c.len_utf8()..];
        }
        let value = digits.parse().ok().filter(|value: &f64| value.is_finite())?;
        self.rest = rest;
        Some(Number { value, in_nm: self.takes("nm") })
    }
}

/// As a drawing states it; numbers to nine digits.
impl fmt::Display for Indication {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = |nm: Option<f64>| match (nm, self.unit) {
            (None, _) => "–".to_owned(),
            (Some(nm), LengthUnit::Nanometres) => format!("{} nm", nine_digits(nm)),
            (Some(nm), unit) => nine_digits(nm / unit.nm()).to_string(),
        };
        write!(f, "3/{}", number(self.a_nm))?;
        match (self.b_nm, self.c_nm) {
            (None, None) => {}
            (b, None) => write!(f, "({})", number(b))?,
            (b, c) => write!(f, "({}/{})", number(b), number(c))?,
        }
        let limits = [self.rms_total_nm, self.rms_irregularity_nm, self.rms_variant_nm];
        for (name, limit) in RMS.into_iter().zip(limits) {
            if limit.is_some() {
                write!(f, "; {name}<{}", number(limit))?;
            }
        }
        match self.unit {
            LengthUnit::Nanometres => Ok(()),
            LengthUnit::Fringes { wavelength_nm } => write!(f, "; λ={wavelength_nm} nm"),
        }
    }
}

/// The number with what conversion has added behind the ninth digit taken away.
fn nine_digits(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

const RMS: [&str; 3] = ["RMSt", "RMSi", "RMSa"];

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn read(text: &str) -> Indication {
        text.parse().unwrap()
    }

    fn near(found: Option<f64>, expected: f64) -> bool {
        found.is_some_and(|found| (found - expected).abs() < 1e-10)
    }

    /// The examples of layertec.de, "Surface form tolerances".
    #[test]
    fn published_examples_have_the_published_meaning() {
        let found = read("3/ 2(1/0.5); λ = 632.8 nm");
        assert!(near(found.a_nm, 632.8) && near(found.b_nm, 316.4) && near(found.c_nm, 158.2));
        assert_eq!(found.to_string(), "3/2(1/0.5); λ=632.8 nm");
        let found = read("3/ – (1); RMSa < 0.1; λ = 546");
        assert_eq!((found.a_nm, found.c_nm), (None, None));
        assert!(near(found.b_nm, 273.0) && near(found.rms_variant_nm, 27.3));
        assert_eq!(found.to_string(), "3/–(1); RMSa<0.1; λ=546 nm");
        let found = read("3/ –; RMSt < 100 nm; RMSi < 30 nm; λ = 546 nm");
        assert!(near(found.rms_total_nm, 100.0) && near(found.rms_irregularity_nm, 30.0));
    }

    #[test]
    fn without_a_wavelength_numbers_are_nanometres() {
        let found = read("3/500(100/-) RMSt<80,5;RMSa<3nm");
        assert_eq!((found.a_nm, found.b_nm, found.c_nm), (Some(500.0), Some(100.0), None));
        assert_eq!((found.rms_total_nm, found.rms_variant_nm), (Some(80.5), Some(3.0)));
        assert_eq!(found.to_string(), "3/500 nm(100 nm); RMSt<80.5 nm; RMSa<3 nm");
        let only_c = Indication { c_nm: Some(5.0), ..Indication::new(LengthUnit::Nanometres) };
        assert_eq!(read(&only_c.to_string()), only_c);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_place() {
        let error = |text: &str| text.parse::<Indication>().unwrap_err();
        assert_eq!(error("4/2'"), IndicationError::Code { text: "4/2'".into() });
        for (text, at) in [("3/2(1", 6), ("3/2(1]", 6), ("3/1(1/0.5/2)", 10), ("3/ 2 x", 6)] {
            let found = error(text);
            assert!(
                matches!(found, IndicationError::Limits { at: place, .. } if place == at),
                "{found}"
            );
        }
        for (text, at) in [
            ("3/", 3),
            ("3/(1)", 3),
            ("3/ -5", 4),
            ("3/x", 3),
            ("3/2()", 5),
            ("3/2(1/)", 7),
            ("3/2(NaN)", 5),
            ("3/inf", 3),
            ("3/1e999", 3),
            ("3/;λ=546", 3),
            ("3/–(– 1)", 5),
            ("3/1; RMSt<", 11),
        ] {
            let found = error(text);
            assert!(
                matches!(found, IndicationError::Number { at: place, .. } if place == at),
                "{found}"
            );
        }
        assert_eq!(error("3/1;RMSx<2"), IndicationError::Item { found: "RMSx<2".into(), at: 5 });
        assert_eq!(error("3/1;RMSt<2;RMSt<2"), IndicationError::Twice { name: "RMSt", at: 12 });
        assert_eq!(error("3/1;λ=5;λ=5"), IndicationError::Twice { name: "λ", at: 9 });
        assert_eq!(error("3/1;λ=-5"), IndicationError::Wavelength { found: "-5".into(), at: 7 });
        assert_eq!(
            error("3/0.5(0.1/x) RMSi<0.05; λ=546.07 nm").to_string(),
            "expected a number not below 0, or a dash, at character 11, found \"x\""
        );
        assert_eq!(error("3/2(1").to_string(), "expected \")\" at character 6, found the end");
    }

    #[test]
    fn spaces_commas_and_signs_do_not_matter() {
        let plain = read("3/0.5(0.1/0.05); RMSi<0.02; λ=546.07");
        for text in [
            "3 / 0,5 ( 0,1 / 0,05 ) RMSi < 0,02; lambda = 546,07 nm",
            " 3/0.5(0.1/0.05);;RMSi≤0.02;λ=546.07nm;",
            "3/5e-1(1E-1/0.05) λ=546.07; RMSi<0.02",
        ] {
            assert_eq!(read(text), plain, "{text}");
        }
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_again(
            limits in prop::array::uniform6(prop::option::of(0.0..1e4f64)),
            wavelength_nm in prop::option::of(300.0..11_000.0f64),
        ) {
            let unit = wavelength_nm.map_or(LengthUnit::Nanometres, |wavelength_nm| {
                LengthUnit::Fringes { wavelength_nm }
            });
            let written = Indication {
                a_nm: limits[0],
                b_nm: limits[1],
                c_nm: limits[2],
                rms_total_nm: limits[3],
                rms_irregularity_nm: limits[4],
                rms_variant_nm: limits[5],
                unit,
            };
            let found = read(&written.to_string());
            prop_assert_eq!(found.unit, unit);
            let found = [
                found.a_nm,
                found.b_nm,
                found.c_nm,
                found.rms_total_nm,
                found.rms_irregularity_nm,
                found.rms_variant_nm,
            ];
            for (found, limit) in found.into_iter().zip(limits) {
                prop_assert_eq!(found.is_some(), limit.is_some());
                let (found, limit) = (found.unwrap_or(0.0), limit.unwrap_or(0.0));
                prop_assert!((found - limit).abs() <= 1e-8 * limit, "{} {}", found, limit);
            }
        }

        #[test]
        fn no_text_breaks_it(text in "(3/)?[-–—0-9.(/); RMStia<λ=nm]{0,24}") {
            if let Ok(found) = text.parse::<Indication>() {
                prop_assert_eq!(found.to_string().parse::<Indication>().map(|i| i.unit), Ok(found.unit));
            }
        }
    }
}
