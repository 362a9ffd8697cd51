//! Answers that every instrument with SCPI gives.

use asphera_described::{Pattern, PatternError};

/// Question for the identity (IEEE 488.2).
pub(crate) const IDENTITY: &str = "*IDN?";

/// Question for the oldest error.
pub(crate) const ERROR: &str = "SYST:ERR?";

/// Number in place of one that is none (Agilent E4418B programming guide, page 1-96).
pub(crate) const NOT_A_NUMBER: f64 = 9.91e37;

/// Magnitude from which a number stands for infinity, which is sent as 9.9E+37.
pub(crate) const ENDLESS: f64 = 9.9e37;

/// Answer of an empty queue: `0,"No error"`, `+0,"No error"`, `0, No Error`.
pub(crate) fn no_error() -> Result<Pattern, PatternError> {
    Pattern::new(r"\s*[+-]?0+\s*(?:,.*)?")
}

/// Answer with an error: its number, and its words, with or without quotes.
///
/// Without quotes there is no comma in the words, so that no answer with several numbers is taken for an error.
pub(crate) fn error() -> Result<Pattern, PatternError> {
    Pattern::new(r#"\s*[+-]?\d{1,5}\s*,\s*(?:".*"|[^",]*[A-Za-z][^",]*)\s*"#)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fluke 1529 manual, page 113; Chroma 19020 manual, page 99; B&K Precision 5492 manual, page 84; pyvisa-sim.
    #[test]
    fn answers_of_manuals() {
        let (none, entry) = (no_error().unwrap(), error().unwrap());
        for empty in ["0,\"No error\"", "+0,\"No error\"", "0", "0, No Error", "+0, \"No error\""] {
            assert!(none.matches(empty.as_bytes()), "{empty}");
        }
        for found in [
            "-350,\"Queue overflow\"",
            "-113,\"Undefined header;FETC:POW\"",
            "1, Command error",
            "-104,\"Data type error\"",
            "+100,\"a comma, and \"\"quotes\"\"\"",
        ] {
            assert!(entry.matches(found.as_bytes()) && !none.matches(found.as_bytes()), "{found}");
        }
        for reading in ["1,2,0.0011,mV,14,5,35,2000,9,5", "+1.5E+00", "1.5,2.5", "12,34", "", "-"] {
            assert!(!entry.matches(reading.as_bytes()) && !none.matches(reading.as_bytes()));
        }
    }
}
