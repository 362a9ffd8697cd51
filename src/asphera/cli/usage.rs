//! Wrong use of the command line that its parser cannot see.

use super::output::Failure;

/// Options, values or kinds of files that do not go together. The process ends with [`Exit::Misused`](super::exit::Exit::Misused).
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Misuse(String);

/// The failure of a command line that does not go together.
pub(super) fn misused(words: impl ToString) -> Failure {
    Box::new(Misuse(words.to_string()))
}

/// Whether a command failed for its command line.
pub(super) fn is_misuse(failure: &Failure) -> bool {
    failure.is::<Misuse>()
}
