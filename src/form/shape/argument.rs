//! Checks of the numbers a shape is made of, and the names and units of its parameters.

use super::{ShapeError, ShapeParameter};

/// Range of a radius.
pub(super) const RADIUS: &str =
    "a number other than 0, at most 1e307 in size (what is flat has no radius)";
/// Range of a coefficient.
pub(super) const FINITE: &str = "a finite number";

/// The error about one value.
pub(super) fn refused(
    kind: &'static str,
    parameter: impl Into<String>,
    found: f64,
    expected: &'static str,
) -> ShapeError {
    ShapeError::Value { kind, parameter: parameter.into(), found, expected }
}

/// A number that is finite.
pub(super) fn finite(kind: &'static str, parameter: &str, found: f64) -> Result<f64, ShapeError> {
    if found.is_finite() { Ok(found) } else { Err(refused(kind, parameter, found, FINITE)) }
}

/// A radius whose curvature is a number too.
pub(super) fn radius(kind: &'static str, parameter: &str, found: f64) -> Result<f64, ShapeError> {
    let usable = found.is_normal() && found.recip().is_normal();
    if usable { Ok(found) } else { Err(refused(kind, parameter, found, RADIUS)) }
}

/// Fails unless there are as many values as parameters.
pub(super) fn count(kind: &'static str, values: &[f64], expected: usize) -> Result<(), ShapeError> {
    let found = values.len();
    if found == expected { Ok(()) } else { Err(ShapeError::Count { kind, found, expected }) }
}

/// A parameter from its parts.
pub(super) fn parameter(name: &str, unit: &str, value: f64) -> ShapeParameter {
    ShapeParameter { name: name.to_owned(), unit: unit.to_owned(), value }
}

/// The coefficient of the power `order` of a length: `A4` in mm^-3.
pub(super) fn coefficient(order: u8, value: f64) -> ShapeParameter {
    let unit = match order {
        0 => "mm".to_owned(),
        1 => "1".to_owned(),
        _ => format!("mm^-{}", order - 1),
    };
    ShapeParameter { name: format!("A{order}"), unit, value }
}
