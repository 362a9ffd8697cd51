//! Harmonic functions: the value of a place is the weighted mean of its neighbours, except where it is given.

use rayon::prelude::*;

use super::geodesic::{ends, geodesic_from_ends};
use super::laplacian::{Laplacian, dot};
use super::pieces::by_piece;
use super::{Field, FunctionError};
use crate::cloud::{Cloud, PlaceId};
use crate::nearest::Nearest;

/// The harmonic function with given values at some places. It has no maximum and no minimum elsewhere.
///
/// The weighted Laplacian of the other places is solved by conjugate gradients with the diagonal as preconditioner (Golub and Van
/// Loan, Matrix Computations, 4th edition, algorithm 11.5.1). Some √n rounds of k·n time.
///
/// # Errors
///
/// No given value, one that is not finite, a place that is none; a cloud in pieces.
pub fn harmonic<const D: usize>(
    cloud: &Cloud<D>,
    nearest: &Nearest,
    fixed: &[(PlaceId, f64)],
) -> Result<Field, FunctionError> {
    if fixed.is_empty() || fixed.len() > cloud.len() {
        return Err(FunctionError::Sources { found: fixed.len(), most: cloud.len() });
    }
    for &(place, value) in fixed {
        if place as usize >= cloud.len() {
            return Err(FunctionError::Source { found: place, places: cloud.len() });
        }
        if !value.is_finite() {
            return Err(FunctionError::Fixed { place, value });
        }
    }
    let laplacian = Laplacian::new(cloud, nearest)?;
    Ok(Field::number(solve(&laplacian, fixed)?))
}

/// The harmonic function that is 0 at one end of the cloud and 1 at the other, the ends being those of
/// [`geodesic_from_ends`]. Each piece of a cloud has its own ends.
///
/// # Errors
///
/// A cloud without points.
pub fn harmonic_between_ends<const D: usize>(
    cloud: &Cloud<D>,
    nearest: &Nearest,
) -> Result<Field, FunctionError> {
    by_piece(cloud, nearest, of_piece)
}

fn of_piece<const D: usize>(cloud: &Cloud<D>, nearest: &Nearest) -> Result<Field, FunctionError> {
    let laplacian = Laplacian::new(cloud, nearest)?;
    let distances = geodesic_from_ends(cloud, nearest)?;
    let [low, high] = ends(&distances);
    if low == high {
        return Ok(Field::number(vec![0.0; cloud.len()]));
    }
    let values = solve(&laplacian, &[(low, 0.0), (high, 1.0)])?;
    Ok(Field { values, is_length: false, is_multiple: distances.is_multiple })
}

fn solve(laplacian: &Laplacian, fixed: &[(PlaceId, f64)]) -> Result<Vec<f64>, FunctionError> {
    let count = laplacian.len();
    let mut is_fixed = vec![false; count];
    let given = fixed.iter().map(|&(_, value)| value);
    let (low, high) = given.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let mut values = vec![f64::midpoint(low, high); count];
    for &(place, value) in fixed {
        is_fixed[place as usize] = true;
        values[place as usize] = value;
    }
    // What flows out of each free place; 0 where the value is given.
    let flow = |values: &[f64]| -> Vec<f64> {
        let of = |place: usize| {
            if is_fixed[place] {
                return 0.0;
            }
            let differences =
                laplacian.neighbours(place).map(|(other, w)| w * (values[place] - values[other]));
            differences.sum::<f64>()
        };
        (0..count).into_par_iter().map(of).collect()
    };
    let mut residual: Vec<f64> = flow(&values).iter().map(|flow| -flow).collect();
    let eased = |residual: &[f64]| -> Vec<f64> {
        residual.iter().zip(laplacian.degrees()).map(|(flow, degree)| flow / degree).collect()
    };
    let mut step = eased(&residual);
    let mut size = dot(&residual, &step);
    let wanted = TOLERANCE * TOLERANCE * size;
    let most = ROUNDS + 20 * (count as f64).sqrt() as usize;
    for _ in 0..most {
        if size <= wanted {
            // The extremes are among the given values: what lies beyond is rounding.
            values.iter_mut().for_each(|value| *value = value.clamp(low, high));
            return Ok(values);
        }
        let along = flow(&step);
        let length = size / dot(&step, &along);
        for (at, value) in values.iter_mut().enumerate() {
            *value += length * step[at];
            residual[at] -= length * along[at];
        }
        let next = eased(&residual);
        let left = dot(&residual, &next);
        let share = left / size;
        step.iter_mut().zip(&next).for_each(|(step, next)| *step = next + share * *step);
        size = left;
    }
    let residual = (size / wanted).sqrt() * TOLERANCE;
    Err(FunctionError::Unsolved { tolerance: TOLERANCE, rounds: most, residual })
}

/// The residual left, as a share of the first.
const TOLERANCE: f64 = 1e-10;
/// Rounds at most, beside twenty times the root of the number of places.
const ROUNDS: usize = 1000;
