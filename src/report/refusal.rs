//! Why a request has no answer.

use thiserror::Error;

/// Why a request makes no sense or has no answer, in words for whoever asked.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct Refusal(pub String);

impl Refusal {
    /// The refusal that says what an error says.
    pub fn new(error: impl std::error::Error) -> Refusal {
        Refusal(error.to_string())
    }
}
