//! Expansion: the coefficients of values at scattered places in a basis, by least squares.
//!
//! Two passes over the points. The first sums the normal equations; the second sums the residuals of their
//! solution, which gives the residual figures without cancellation and one step of refinement. Points are
//! taken in blocks within fixed chunks, and chunks are joined as a fixed binary tree: the result depends on
//! the order of the points in the last bits, but never on the number of threads.
//!
//! Functions of the disc are summed by their [`moments`](super::moments), where these are as good; all else by the
//! products of the [`terms`](super::terms).

use nalgebra::DMatrix;
use rayon::prelude::*;
use thiserror::Error;

use super::moments::Moments;
use super::normal::Normal;
use super::passes::{CHUNK, Kernel, Points};
use super::terms::Terms;
use super::{Basis, Scale};

/// Coefficients of values in a basis.
#[derive(Clone, Debug, PartialEq)]
pub struct Expansion {
    /// The coefficient of every term, in the unit of the values; `None` where the places do not determine it
    /// (the value of every coefficient then is that of a fit without these terms).
    pub coefficients: Vec<Option<f64>>,
    /// Names of the terms without a coefficient.
    pub indeterminate: Vec<String>,
    /// Largest over smallest singular value of the matrix of the other terms at the places, its columns
    /// scaled to unit length: 1 if they are orthogonal over the places. Coefficients lose about its
    /// logarithm in digits, and noise is amplified by up to it.
    pub condition: f64,
    /// Points the expansion is over.
    pub used: usize,
    /// Points left out because place, value or weight was not finite.
    pub not_finite: usize,
    /// Points left out because the basis is not defined there.
    pub outside: usize,
    /// Root of the (weighted) mean square of what the terms leave, in the unit of the values.
    pub residual_rms: f64,
    /// The largest residual in size.
    pub largest_residual: LargestResidual,
    covariance: Option<DMatrix<f64>>,
    kept: Vec<usize>,
}

/// The largest residual and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestResidual {
    /// Value minus expansion, in the unit of the values.
    pub residual: f64,
    /// Index of the point; of equal ones the first.
    pub index: usize,
}

/// Why there is no expansion.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ExpandError {
    /// Lists of different lengths.
    #[error("{places} places with {values} values and {weights} weights, expected as many of each")]
    Lengths {
        /// Places given.
        places: usize,
        /// Values given.
        values: usize,
        /// Weights given; as many as places if there are none.
        weights: usize,
    },
    /// A weight below zero.
    #[error("weight {index} is {weight}, expected zero or a positive number")]
    Weight {
        /// Index of the point.
        index: usize,
        /// Its weight.
        weight: f64,
    },
    /// Every place lies where the basis is not defined.
    #[error(
        "none of {outside} points lies where the {kind} is defined, half width {half_x_mm} mm by {half_y_mm} mm. The points are {nearest_mm} to {farthest_mm} mm from the axis: centre them, or normalise by {farthest_mm} mm or more"
    )]
    Outside {
        /// The basis.
        kind: &'static str,
        /// Finite points, all of them outside.
        outside: usize,
        /// Half width or radius along x, in mm.
        half_x_mm: f64,
        /// Half width or radius along y, in mm.
        half_y_mm: f64,
        /// Distance of the nearest of them from the axis, in mm.
        nearest_mm: f64,
        /// Distance of the farthest of them from the axis, in mm.
        farthest_mm: f64,
    },
    /// Fewer points than terms.
    #[error(
        "{used} usable points for {terms} terms of the {kind} ({outside} more lie outside its domain, \
         {not_finite} are not finite): give more points or fewer terms"
    )]
    TooFew {
        /// The basis.
        kind: &'static str,
        /// Points that could be used.
        used: usize,
        /// Terms asked for.
        terms: usize,
        /// Points outside the domain.
        outside: usize,
        /// Points that are not finite.
        not_finite: usize,
    },
    /// Sums that overflowed.
    #[error("the values are too large: the sum of their squares is not finite")]
    Overflow,
}

impl Expansion {
    /// Covariance of two coefficients in the square of the unit of the values, from σ²·(AᵀWA)⁻¹ with σ² the
    /// weighted square of the residuals over the degrees of freedom. `None` for an indeterminate term and
    /// without degrees of freedom.
    ///
    /// It takes the residuals for noise without correlation and the weights for reciprocal variances; what
    /// other terms would still explain, and weights that are areas, make it an estimate.
    pub fn covariance(&self, term: usize, other: usize) -> Option<f64> {
        let row = self.kept.binary_search(&term).ok()?;
        let column = self.kept.binary_search(&other).ok()?;
        Some(self.covariance.as_ref()?[(row, column)])
    }

    /// Standard uncertainty (k = 1) of a coefficient: the root of its variance.
    pub fn u(&self, term: usize) -> Option<f64> {
        self.covariance(term, term).map(f64::sqrt)
    }

    /// The coefficients with 0 for the indeterminate ones: what [`residuals`] takes.
    pub fn filled(&self) -> Vec<f64> {
        self.coefficients.iter().map(|coefficient| coefficient.unwrap_or(0.0)).collect()
    }
}

/// Coefficients of `values` at `places_mm` (x, y in mm), so that the sum of the squares of the residuals,
/// each times its weight if there are weights, is least. `O(n·terms²)`.
///
/// A term that the terms before it already give at these places, to 1e-6 of its size, is indeterminate.
/// Points that are not finite and points outside the domain are left out and counted; a weight of 0 takes
/// part in nothing but the count.
pub fn expand(
    basis: &dyn Basis,
    scale: &Scale,
    places_mm: &[[f64; 2]],
    values: &[f64],
    weights: Option<&[f64]>,
) -> Result<Expansion, ExpandError> {
    let count = places_mm.len();
    let weighed = weights.map_or(count, <[f64]>::len);
    if values.len() != count || weighed != count {
        return Err(ExpandError::Lengths { places: count, values: values.len(), weights: weighed });
    }
    if let Some(index) = weights.and_then(|weights| weights.iter().position(|&w| w < 0.0)) {
        let weight = weights.map_or(f64::NAN, |weights| weights[index]);
        return Err(ExpandError::Weight { index, weight });
    }
    let points = Points { basis, scale, places_mm, values, weights };
    if let Some(moments) = basis.on_disc().and_then(Moments::new)
        && let Some(found) = solved(&points, &moments)?
    {
        return Ok(found);
    }
    let found = solved(&points, &Terms { basis, weighted: weights.is_some() })?;
    Ok(found.expect("the products of the terms are always sure"))
}

/// The expansion after a kernel; `None` if that is not sure of it.
fn solved<K: Kernel>(points: &Points<'_>, kernel: &K) -> Result<Option<Expansion>, ExpandError> {
    let terms = points.basis.terms();
    let sums = points.sums(kernel);
    let tally = sums.tally;
    tally.check(points)?;
    let equations = kernel.equations(&sums.sums);
    let normal = Normal::new(&equations.gram);
    if !kernel.is_sure(&sums.sums, &equations, &normal) {
        return Ok(None);
    }
    if !equations.along.iter().chain([&equations.square]).all(|entry| entry.is_finite()) {
        return Err(ExpandError::Overflow);
    }
    let kept = normal.kept().to_vec();
    let mut coefficients = vec![0.0; terms];
    for (&term, value) in kept.iter().zip(normal.solve(&equations.along)) {
        coefficients[term] = value;
    }
    let rest = points.rest(kernel, &coefficients);
    let along = kernel.along(&rest.sums);
    // The refined solution leaves less by what the correction explains.
    let mut square = rest.square;
    for (&term, correction) in kept.iter().zip(normal.solve(&along)) {
        coefficients[term] += correction;
        square -= correction * along[term];
    }
    let square = square.max(0.0);
    let freedom = tally.used - kept.len();
    let covariance = (freedom > 0).then(|| normal.inverse() * (square / freedom as f64));
    let is_kept = |term: &usize| kept.binary_search(term).is_ok();
    Ok(Some(Expansion {
        coefficients: (0..terms).map(|term| is_kept(&term).then(|| coefficients[term])).collect(),
        indeterminate: (0..terms)
            .filter(|term| !is_kept(term))
            .map(|term| points.basis.name(term))
            .collect(),
        condition: normal.condition(),
        used: tally.used,
        not_finite: tally.not_finite,
        outside: tally.outside,
        residual_rms: if rest.weight > 0.0 { (square / rest.weight).sqrt() } else { 0.0 },
        largest_residual: rest.largest,
        covariance,
        kept,
    }))
}

/// Value minus expansion at every place, in the unit of the values; NaN where the place or value is not
/// finite or the basis is not defined. Lists beyond the shortest are not looked at. `O(n·terms)`.
pub fn residuals(
    basis: &dyn Basis,
    scale: &Scale,
    coefficients: &[f64],
    places_mm: &[[f64; 2]],
    values: &[f64],
) -> Vec<f64> {
    let count = places_mm.len().min(values.len());
    let points = Points { basis, scale, places_mm, values, weights: None };
    let mut all = vec![f64::NAN; count];
    let kernel = Terms { basis, weighted: false };
    all.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
        let start = chunk * CHUNK;
        let mut room = kernel.room();
        points.blocks(start..start + out.len(), |block| {
            let residuals = kernel.residuals(block, &mut room, coefficients);
            for (index, residual) in block.indices.iter().zip(residuals).take(block.count) {
                out[index - start] = residual;
            }
        });
    });
    all
}
