//! What can go wrong between a map and a device.

use thiserror::Error;

use crate::map::Kind;

/// A word of the configuration that means nothing.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("unknown word `{word}`, expected {expected}")]
pub struct WordError {
    word: String,
    expected: &'static str,
}

impl WordError {
    pub(crate) fn new(word: &str, expected: &'static str) -> WordError {
        WordError { word: word.to_owned(), expected }
    }
}

/// A value that the registers of a field cannot hold.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{value} does not fit registers of kind {kind:?}")]
pub struct ValueError {
    /// The raw value, after offset and scale.
    pub value: f64,
    /// The kind of the field.
    pub kind: Kind,
}

/// Why a frame that addresses the request is no answer to it.
#[derive(Debug, Error)]
pub(crate) enum AnswerError {
    #[error("{0}")]
    Library(tokio_modbus::Error),
    #[error("{found} values, expected {expected}")]
    Length { expected: usize, found: usize },
    #[error("the frame ends before its data")]
    Incomplete,
}
