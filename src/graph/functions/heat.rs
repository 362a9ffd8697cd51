//! The heat kernel signature: how much heat is left at a place some time after it was put there.

use super::pieces::by_piece;
use super::{Field, FunctionError, eigenfunctions};
use crate::cloud::Cloud;
use crate::nearest::Nearest;

/// Σ exp(−λᵢt)·φᵢ² over the first [`HEAT_EIGENFUNCTIONS`] eigenfunctions and the constant one (J. Sun, M. Ovsjanikov, L. Guibas,
/// Computer Graphics Forum 28 (2009) 1383-1392). Time is counted in units of 1/λ₁, so that the size of the cloud does not matter:
/// 1 tells large shapes apart, 0.05 small ones. Fewer eigenfunctions where a quarter of the places are fewer. Each piece of a
/// cloud has its own heat; one of fewer than four places has the value 0.
///
/// # Errors
///
/// A time that is not above 0; a cloud of fewer than four places.
pub fn heat_kernel<const D: usize>(
    cloud: &Cloud<D>,
    nearest: &Nearest,
    time: f64,
) -> Result<Field, FunctionError> {
    if !(time.is_finite() && time > 0.0) {
        return Err(FunctionError::Time { found: time });
    }
    by_piece(cloud, nearest, |cloud, nearest| of_piece(cloud, nearest, time))
}

fn of_piece<const D: usize>(
    cloud: &Cloud<D>,
    nearest: &Nearest,
    time: f64,
) -> Result<Field, FunctionError> {
    let count = HEAT_EIGENFUNCTIONS.min(cloud.len() / 4).max(1);
    let found = eigenfunctions(cloud, nearest, count)?;
    let mut values = vec![1.0; cloud.len()];
    for (eigenvalue, field) in found.eigenvalues.iter().zip(&found.fields) {
        let left = (-time * eigenvalue / found.eigenvalues[0]).exp();
        values.iter_mut().zip(&field.values).for_each(|(sum, value)| *sum += left * value * value);
    }
    // Squares of a whole eigenspace do not hang on its basis; only the last one may have lost its twin.
    let is_multiple = found.fields.last().is_some_and(|last| last.is_multiple)
        && (-time * found.eigenvalues[count - 1] / found.eigenvalues[0]).exp() > CUT_OFF;
    Ok(Field { values, is_length: false, is_multiple })
}

/// Eigenfunctions that the sum runs over.
pub const HEAT_EIGENFUNCTIONS: usize = 30;
/// Bound on what a cut eigenspace matters.
const CUT_OFF: f64 = 1e-3;
