//! Why a driver cannot be made.

use asphera_link::Problem;
use thiserror::Error;

/// Why a driver cannot be made.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum Error {
    /// Settings that cannot be used; never empty.
    #[error("unusable settings: {}", list(.0))]
    Settings(Vec<Problem>),
}

fn list(problems: &[Problem]) -> String {
    problems
        .iter()
        .map(|problem| {
            format!("{} is {}, expected {}", problem.key, problem.found, problem.expected)
        })
        .collect::<Vec<_>>()
        .join("; ")
}
