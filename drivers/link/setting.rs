//! What can be wrong with a driver's settings.

use std::fmt;

/// One setting that cannot be used. The reader of the configuration adds file and line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The key as a person writes it, relative to the table of the settings: `node_id`, `field[3].scale`.
    pub key: String,
    /// Value that would do.
    pub expected: String,
    /// Content found there.
    pub found: String,
}

impl Problem {
    /// A problem with the setting at `key`.
    pub fn new(
        key: impl Into<String>,
        expected: impl Into<String>,
        found: impl fmt::Display,
    ) -> Problem {
        Problem { key: key.into(), expected: expected.into(), found: found.to_string() }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: expected {}, found {}", self.key, self.expected, self.found)
    }
}

/// Adds a problem unless `low <= value <= high`.
pub fn check_range<T: PartialOrd + fmt::Display>(
    problems: &mut Vec<Problem>,
    key: &str,
    value: T,
    low: T,
    high: T,
) {
    if !(value >= low && value <= high) {
        problems.push(Problem::new(key, format!("{low} to {high}"), value));
    }
}
