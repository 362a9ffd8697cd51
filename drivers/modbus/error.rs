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
    #[error("{}", short(.0))]
    Library(tokio_modbus::Error),
    #[error("{found} values, expected {expected}")]
    Length { expected: usize, found: usize },
    #[error("the frame ends before its data")]
    Incomplete,
}

/// The library's words, but for the answers that they would quote whole.
fn short(error: &tokio_modbus::Error) -> String {
    use tokio_modbus::{Error, ProtocolError};
    match error {
        Error::Protocol(ProtocolError::FunctionCodeMismatch { request, .. }) => {
            format!("it answers another function than the one asked, {}", request.value())
        }
        Error::Protocol(ProtocolError::HeaderMismatch { message, .. }) => {
            format!("its header is that of another request: {message}")
        }
        error => error.to_string(),
    }
}
