//! Errors for people.

use std::error::Error;

/// An error and its causes in one line: `what failed: why: why that`. Errors of this project do not repeat
/// their cause, so the chain is put together once, where it is printed.
pub fn error_chain(error: &dyn Error) -> String {
    let mut words = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        words.push_str(": ");
        words.push_str(&cause.to_string());
        source = cause.source();
    }
    words
}
