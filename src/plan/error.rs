//! Refusals of a plan.

use thiserror::Error;

/// A plan that cannot be run: which key, where, expected, found, and the cure.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{key}: expected {expected}, found {found}: {cure}")]
pub struct PlanError {
    /// The key that is wrong, or whose limit is exceeded.
    pub key: &'static str,
    /// The values allowed, in words.
    pub expected: String,
    /// The value found, with its place where it has one.
    pub found: String,
    /// The cure, in words.
    pub cure: String,
}

impl PlanError {
    pub(crate) fn new(
        key: &'static str,
        expected: impl Into<String>,
        found: impl Into<String>,
        cure: impl Into<String>,
    ) -> PlanError {
        PlanError { key, expected: expected.into(), found: found.into(), cure: cure.into() }
    }
}

/// The value, if it is a positive finite number.
pub(crate) fn positive(
    key: &'static str,
    value: f64,
    cure: &'static str,
) -> Result<f64, PlanError> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(PlanError::new(key, "a positive number", value.to_string(), cure))
}
