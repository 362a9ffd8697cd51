//! Answers of a server.

use super::call::{self, Call, items};
use super::{ServerError, Tag};

/// One line of a server.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// Command it belongs to.
    pub tag: Tag,
    /// Content.
    pub kind: Kind,
}

/// Content of an answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// `&`: the command is acknowledged; the next may be sent.
    Acknowledged,
    /// `%`: the command is complete.
    Complete,
    /// `#`: data.
    Data(Data),
    /// `!`: an error.
    Error(ServerError),
}

/// Data of an answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// Bare numbers, as scans have them.
    Numbers(Vec<f64>),
    /// Values with names, as `PtMeas` has them.
    Items(Vec<Call>),
    /// Other data, as they stand.
    Other(String),
}

impl Answer {
    /// The answer in a line without its end; `None` where it is none.
    pub fn parse(line: &[u8]) -> Option<Answer> {
        let (tag, rest) = line.split_at_checked(5)?;
        let tag = Tag::parse(tag)?;
        let (sign, rest) = rest.strip_prefix(b" ")?.split_first()?;
        let text = std::str::from_utf8(rest).ok()?.trim_matches(' ');
        let kind = match sign {
            b'&' if text.is_empty() => Kind::Acknowledged,
            b'%' if text.is_empty() => Kind::Complete,
            b'#' if !text.is_empty() => Kind::Data(Data::parse(text)),
            b'!' => Kind::Error(ServerError::parse(text)?),
            _ => return None,
        };
        Some(Answer { tag, kind })
    }
}

impl Data {
    fn parse(text: &str) -> Data {
        if let Some(numbers) = numbers(text) {
            return Data::Numbers(numbers);
        }
        match items(text) {
            Some(items) => Data::Items(items),
            None => Data::Other(text.to_owned()),
        }
    }
}

/// Bare numbers between commas; `None` where something else stands among them.
pub fn numbers(text: &str) -> Option<Vec<f64>> {
    text.split(',').map(|text| call::number(text.trim_matches(' '))).collect()
}
