//! Patterns that whole frames must have.

use std::ops::Range;

use regex::bytes::{Regex, RegexBuilder};
use thiserror::Error;

/// Regular expression that a whole frame must match. Over bytes; classes such as `\d` are ASCII.
///
/// Each matches in time proportional to the frame: there is no expression that hangs.
#[derive(Clone, Debug)]
pub struct Pattern {
    text: String,
    expression: Regex,
}

/// Why a text is no pattern.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{0}")]
pub struct PatternError(String);

impl Pattern {
    /// The pattern of this text, in the syntax of the crate regex.
    ///
    /// # Errors
    ///
    /// Where it is no regular expression, or one too large to keep.
    pub fn new(text: &str) -> Result<Pattern, PatternError> {
        once(text, Pattern::compiled)
    }

    fn compiled(text: &str) -> Result<Pattern, PatternError> {
        let compiled =
            |whole: &str| RegexBuilder::new(whole).unicode(false).size_limit(LARGEST).build();
        // Alone first: an unbalanced bracket must not close ours.
        let short = |error: regex::Error| {
            let text = error.to_string();
            let last = text.lines().last().unwrap_or_default();
            PatternError(last.trim_start_matches("error: ").to_owned())
        };
        compiled(text).map_err(short)?;
        let expression = compiled(&format!(r"\A(?:{text})\z")).map_err(short)?;
        Ok(Pattern { text: text.to_owned(), expression })
    }

    /// The text it was made of.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether a frame matches.
    pub fn matches(&self, frame: &[u8]) -> bool {
        self.expression.is_match(frame)
    }

    /// Names of its groups.
    pub fn groups(&self) -> impl Iterator<Item = &str> {
        self.expression.capture_names().flatten()
    }

    /// Number of the group of a name, for [`Pattern::places`].
    pub(crate) fn group(&self, name: &str) -> Option<usize> {
        self.expression.capture_names().position(|known| known == Some(name))
    }

    /// Where each group stands in a frame that matches.
    pub(crate) fn places(&self, frame: &[u8]) -> Option<Vec<Option<Range<usize>>>> {
        let found = self.expression.captures(frame)?;
        Some(found.iter().map(|group| group.map(|group| group.range())).collect())
    }
}

impl PartialEq for Pattern {
    fn eq(&self, other: &Pattern) -> bool {
        self.text == other.text
    }
}

#[cfg(not(feature = "fuzzing"))]
fn once(
    text: &str,
    make: fn(&str) -> Result<Pattern, PatternError>,
) -> Result<Pattern, PatternError> {
    make(text)
}

/// Makes each pattern once: a fuzz target starts a driver for every input, and spent nearly all of its time here.
#[cfg(feature = "fuzzing")]
fn once(
    text: &str,
    make: fn(&str) -> Result<Pattern, PatternError>,
) -> Result<Pattern, PatternError> {
    use std::collections::HashMap;

    thread_local! {
        static KNOWN: std::cell::RefCell<HashMap<String, Result<Pattern, PatternError>>> =
            std::cell::RefCell::default();
    }
    KNOWN.with_borrow_mut(|known| {
        if known.len() > 256 {
            known.clear();
        }
        known.entry(text.to_owned()).or_insert_with(|| make(text)).clone()
    })
}

/// Most bytes of a compiled expression.
const LARGEST: usize = 1 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_frame_must_match() {
        let pattern = Pattern::new(r"OK(?<state>\d{3})|NG").unwrap();
        assert!(pattern.matches(b"OK000") && pattern.matches(b"NG"));
        assert!(
            !pattern.matches(b"xOK000")
                && !pattern.matches(b"OK0000")
                && !pattern.matches(b"OK000\n")
        );
        assert_eq!(pattern.groups().collect::<Vec<_>>(), ["state"]);
        let places = pattern.places(b"OK004").unwrap();
        assert_eq!(places[pattern.group("state").unwrap()], Some(2..5));
        assert_eq!(pattern.group("value"), None);
    }

    #[test]
    fn errors_are_short() {
        for (text, part) in [("(", "unclosed"), ("a)|(b", "unopened"), ("a{1000000000}", "")] {
            let error = Pattern::new(text).unwrap_err().to_string();
            assert!(error.contains(part) && error.lines().count() == 1, "{error}");
        }
    }

    #[test]
    fn bytes_beyond_ascii_are_bytes() {
        assert!(Pattern::new(r"\xFF.").unwrap().matches(&[0xFF, 0x80]));
        assert!(!Pattern::new(r"\d").unwrap().matches("٣".as_bytes()));
    }
}
