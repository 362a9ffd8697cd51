//! What is wrong with a file a person wrote, and where.

use std::borrow::Cow;
use std::fmt;

/// One thing that is wrong: place, expected, found.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Problem {
    /// The file, as it was named.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// The key, with the tables it is in: `link.probe.baud_bd`. Empty for a syntax error.
    pub key: String,
    /// Value that would do.
    pub expected: String,
    /// Content found there.
    pub found: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}: ", self.file, self.line)?;
        if !self.key.is_empty() {
            write!(f, "{}: ", shown(&self.key))?;
        }
        write!(f, "expected {}, found {}", shown(&self.expected), shown(&self.found))
    }
}

/// Everything that is wrong with a configuration, in the order of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problems(pub Vec<Problem>);

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.0.iter().take(MOST_SHOWN).enumerate() {
            if index > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{problem}")?;
        }
        match self.0.len().saturating_sub(MOST_SHOWN) {
            0 => Ok(()),
            more => write!(f, "\n… and {more} more of the same file"),
        }
    }
}

impl std::error::Error for Problems {}

/// A text that a file holds, as a message shows it: in one line, control characters escaped, the middle of a long
/// one left out. Readers of topography files have the same rule; a driver does not link them for it.
fn shown(text: &str) -> Cow<'_, str> {
    let is_long = text.len() > LONGEST_SHOWN;
    if !is_long && !text.contains(char::is_control) {
        return Cow::Borrowed(text);
    }
    let mut signs: Vec<char> = text.chars().collect();
    if is_long && signs.len() > LONGEST_SHOWN {
        signs.splice(LONGEST_SHOWN / 2..signs.len() - LONGEST_SHOWN / 4, " … ".chars());
    }
    let escaped = signs.into_iter().map(|sign| match sign.is_control() {
        true => sign.escape_default().to_string(),
        false => sign.to_string(),
    });
    Cow::Owned(escaped.collect())
}

/// Most signs of a text that a message shows whole.
const LONGEST_SHOWN: usize = 400;

/// Problems that a person is told at once: more are most often one, such as a file of another kind.
const MOST_SHOWN: usize = 40;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_beyond_what_a_person_reads_are_counted() {
        let problem = |line| Problem {
            file: "a.toml".to_owned(),
            line,
            key: "\u{1b}[2J".to_owned(),
            expected: "a number".to_owned(),
            found: "s".repeat(if line == 1 { 1_000_000 } else { 1000 }),
        };
        let all = Problems((1..=50_000).map(problem).collect()).to_string();
        assert!(all.starts_with("a.toml:1: \\u{1b}[2J: expected a number, found sss"), "{all}");
        assert!(all.ends_with("… and 49960 more of the same file"));
        assert_eq!(all.lines().count(), 41);
        assert!(all.len() < 50_000, "{} bytes", all.len());
    }
}
