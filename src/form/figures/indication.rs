//! The indication `3/A(B/C) RMSt<…; RMSi<…; RMSa<…; λ=…` of ISO 10110-5:2015.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use super::{Definition, Irregularity};

/// What the numbers of an indication count.
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

/// Why a text is no indication of surface form.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum IndicationError {
    /// It does not begin with the code 3.
    #[error("{text:?} does not begin with \"3/\", the code of surface form")]
    Code {
        /// The whole text.
        text: String,
    },
    /// What follows the code is not A, A(B) or A(B/C).
    #[error("{text:?} is not of the form A, A(B) or A(B/C)")]
    Limits {
        /// What follows the code.
        text: String,
    },
    /// A number is not one, or negative.
    #[error("{text:?} is no limit: expected a number not below 0, or a dash")]
    Number {
        /// What stands in its place.
        text: String,
    },
    /// Something that is neither an RMS limit nor a wavelength.
    #[error("{text:?} is neither RMSt<…, RMSi<…, RMSa<… nor λ=…")]
    Item {
        /// The part between semicolons.
        text: String,
    },
    /// Something is stated twice.
    #[error("{name} is stated twice")]
    Twice {
        /// What.
        name: &'static str,
    },
    /// The wavelength is not a positive number.
    #[error("wavelength {text:?} is not a positive number of nanometres")]
    Wavelength {
        /// What stands in its place.
        text: String,
    },
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

    /// Every figure that has a limit, in the order of the indication.
    pub fn compare(&self, found: &Irregularity) -> Vec<Comparison> {
        let limits = [
            self.a_nm,
            self.b_nm,
            self.c_nm,
            self.rms_total_nm,
            self.rms_irregularity_nm,
            self.rms_variant_nm,
        ];
        let pairs = found.figures().into_iter().zip(limits);
        let compared = pairs.filter_map(|(figure, limit_nm)| {
            let (definition, value_nm) = (figure.definition, figure.value);
            limit_nm.map(|limit_nm| Comparison { definition, value_nm, limit_nm })
        });
        compared.collect()
    }
}

impl FromStr for Indication {
    type Err = IndicationError;

    fn from_str(text: &str) -> Result<Indication, IndicationError> {
        let dense: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let dense = dense.replace(',', ".").replace("lambda", "λ");
        let after = dense
            .strip_prefix("3/")
            .ok_or_else(|| IndicationError::Code { text: text.to_owned() })?;
        // No semicolon is needed before the first RMS limit.
        let (head, rest) =
            after.split_at(after.find("RMS").or(after.find(';')).unwrap_or(after.len()));
        let (head, between) = head.split_once(';').unwrap_or((head, ""));
        let items = between.split(';').chain(rest.split(';')).filter(|item| !item.is_empty());
        let mut stated = Stated::default();
        for item in items {
            stated.item(item)?;
        }
        let unit = match stated.wavelength_nm {
            Some(wavelength_nm) => LengthUnit::Fringes { wavelength_nm },
            None => LengthUnit::Nanometres,
        };
        let (a, b, c) = limits(head)?;
        let rms = |slot: usize| stated.rms[slot].as_deref().map_or(Ok(None), |t| limit(t, unit));
        Ok(Indication {
            a_nm: limit(a, unit)?,
            b_nm: limit(b, unit)?,
            c_nm: limit(c, unit)?,
            rms_total_nm: rms(0)?,
            rms_irregularity_nm: rms(1)?,
            rms_variant_nm: rms(2)?,
            unit,
        })
    }
}

/// Items after the limits A, B and C.
#[derive(Default)]
struct Stated {
    rms: [Option<String>; 3],
    wavelength_nm: Option<f64>,
}

impl Stated {
    fn item(&mut self, item: &str) -> Result<(), IndicationError> {
        for (slot, name) in RMS.into_iter().enumerate() {
            if let Some(number) = item.strip_prefix(name).and_then(|rest| rest.strip_prefix('<')) {
                if self.rms[slot].replace(number.to_owned()).is_some() {
                    return Err(IndicationError::Twice { name });
                }
                return Ok(());
            }
        }
        let Some(number) = item.strip_prefix("λ=") else {
            return Err(IndicationError::Item { text: item.to_owned() });
        };
        let value: Option<f64> = number.strip_suffix("nm").unwrap_or(number).parse().ok();
        let value = value.filter(|value| value.is_finite() && *value > 0.0);
        let wavelength_nm =
            value.ok_or_else(|| IndicationError::Wavelength { text: number.to_owned() })?;
        if self.wavelength_nm.replace(wavelength_nm).is_some() {
            return Err(IndicationError::Twice { name: "λ" });
        }
        Ok(())
    }
}

/// The texts of A, B and C; a dash where one is not there.
fn limits(head: &str) -> Result<(&str, &str, &str), IndicationError> {
    let wrong = || IndicationError::Limits { text: head.to_owned() };
    let Some((a, bracket)) = head.split_once('(') else {
        return if head.is_empty() { Err(wrong()) } else { Ok((head, "-", "-")) };
    };
    let inner = bracket.strip_suffix(')').ok_or_else(wrong)?;
    let (b, c) = inner.split_once('/').unwrap_or((inner, "-"));
    if a.is_empty() || b.is_empty() || c.is_empty() {
        return Err(wrong());
    }
    Ok((a, b, c))
}

/// A limit in nm; `None` for a dash.
fn limit(text: &str, unit: LengthUnit) -> Result<Option<f64>, IndicationError> {
    if matches!(text, "-" | "–" | "—") {
        return Ok(None);
    }
    let (number, scale) = match text.strip_suffix("nm") {
        Some(number) => (number, 1.0),
        None => (text, unit.nm()),
    };
    let value: Option<f64> = number.parse().ok().filter(|v: &f64| v.is_finite() && *v >= 0.0);
    let value = value.ok_or_else(|| IndicationError::Number { text: text.to_owned() })?;
    Ok(Some(value * scale))
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
    fn what_is_wrong_is_named() {
        let error = |text: &str| text.parse::<Indication>().unwrap_err();
        assert_eq!(error("4/2'"), IndicationError::Code { text: "4/2'".into() });
        for text in ["3/", "3/(1)", "3/2(1", "3/2()", "3/2(1/)", "3/;λ=546"] {
            assert!(matches!(error(text), IndicationError::Limits { .. }), "{text}");
        }
        for text in ["3/-5", "3/x", "3/2(NaN)", "3/1(1/0.5/2)", "3/inf", "3/1;RMSt<"] {
            assert!(matches!(error(text), IndicationError::Number { .. }), "{text}");
        }
        assert_eq!(error("3/1;RMSx<2"), IndicationError::Item { text: "RMSx<2".into() });
        assert_eq!(error("3/1;RMSt<2;RMSt<2"), IndicationError::Twice { name: "RMSt" });
        assert_eq!(error("3/1;λ=5;λ=5"), IndicationError::Twice { name: "λ" });
        assert_eq!(error("3/1;λ=-5"), IndicationError::Wavelength { text: "-5".into() });
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
