//! Weighted least squares of a profile, with the uncertainty that noise of the vertices causes.
//!
//! Samples are weighted by the length of arc they stand for, so that the fit is that of the line
//! and not of the edges it happens to cross. They are interpolated between vertices, so that
//! neighbours have vertices in common: taking their errors for independent would tell uncertainties
//! too small. With the design X, the weights D, and the interpolation y = W·z from heights z whose
//! errors are independent and have one variance σ², the estimate is β = N⁻¹XᵀDy with N = XᵀDX, and
//!
//! - cov β = σ² N⁻¹ G Gᵀ N⁻¹ with G = XᵀDW, one column a vertex;
//! - the expected sum of squares rᵀDr of what is left is σ² (tr WᵀDW - tr N⁻¹GGᵀ), since
//!   (I-P)ᵀD(I-P) = D(I-P) for the projection P = X N⁻¹ XᵀD.
//!
//! The second tells σ² from what is left, whatever the weights.

use std::collections::BTreeMap;

use asphera_geometry::VertexId;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::pieces::Source;
use super::profile::{Profile, ProfileError};

/// The sums of a fit.
pub(super) struct NormalEquations {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    /// G, by vertex.
    gain: BTreeMap<VertexId, DVector<f64>>,
    /// tr WᵀDW.
    spread: f64,
    squares: f64,
}

/// What the sums tell.
pub(super) struct Solution {
    pub(super) parameters: DVector<f64>,
    /// N⁻¹GGᵀN⁻¹ / (tr WᵀDW - tr N⁻¹GGᵀ); times the sum of squares left it is the covariance.
    /// None if the fit can leave nothing, as of a profile inside one triangle.
    covariance_of_unit: Option<DMatrix<f64>>,
}

impl NormalEquations {
    pub(super) fn new(parameters: usize) -> NormalEquations {
        NormalEquations {
            normal: DMatrix::zeros(parameters, parameters),
            right: DVector::zeros(parameters),
            gain: BTreeMap::new(),
            spread: 0.0,
            squares: 0.0,
        }
    }

    /// Adds a sample: its weight, its row of X, its value, and how much the value changes with the
    /// height it is interpolated from.
    pub(super) fn add(
        &mut self,
        weight: f64,
        row: &DVector<f64>,
        value: f64,
        source: &Source,
        per_height: f64,
    ) {
        self.normal.ger(weight, row, row, 1.0);
        self.right.axpy(weight * value, row, 1.0);
        self.squares += weight * value * value;
        for (vertex, share) in source.weights() {
            let share = share * per_height;
            self.spread += weight * share * share;
            let gain = self.gain.entry(vertex).or_insert_with(|| DVector::zeros(row.len()));
            gain.axpy(weight * share, row, 1.0);
        }
    }

    /// The weighted sum of the squared values.
    pub(super) fn squares(&self) -> f64 {
        self.squares
    }

    /// The parameters that leave the least sum of squares.
    pub(super) fn solve(&self) -> Result<Solution, ProfileError> {
        let indeterminate = ProfileError::Indeterminate { parameters: self.right.len() };
        let cholesky = self.factor().ok_or(indeterminate)?;
        let parameters = cholesky.solve(&self.right);
        let mut gains = DMatrix::zeros(self.right.len(), self.right.len());
        for gain in self.gain.values() {
            gains.ger(1.0, gain, gain, 1.0);
        }
        let solved = cholesky.solve(&gains);
        let freedom = self.spread - solved.trace();
        let covariance_of_unit = (freedom > LEAST_FREEDOM * self.spread)
            .then(|| cholesky.solve(&solved.transpose()) / freedom);
        Ok(Solution { parameters, covariance_of_unit })
    }

    /// N in Cholesky's factors, unless its columns depend on each other but for rounding.
    fn factor(&self) -> Option<Cholesky<f64, Dyn>> {
        let cholesky = self.normal.clone().cholesky()?;
        let factor = cholesky.l_dirty();
        let told = |i: usize| factor[(i, i)].powi(2) > LEAST_PIVOT * self.normal[(i, i)];
        (0..self.right.len()).all(told).then_some(cholesky)
    }
}

impl Solution {
    /// The standard uncertainty of the parameter `index`, if what is left has this sum of squares.
    pub(super) fn uncertainty(&self, index: usize, squares: f64) -> Option<f64> {
        let covariance_of_unit = self.covariance_of_unit.as_ref()?;
        Some((covariance_of_unit[(index, index)] * squares).max(0.0).sqrt())
    }
}

/// How many different vertices a profile comes from must be above the parameters.
pub(super) fn ensure_enough(profile: &Profile, parameters: usize) -> Result<f64, ProfileError> {
    let length_mm = profile.length_mm().ok_or(ProfileError::NoLength)?;
    let sources = profile.sources().iter().flat_map(Source::weights);
    let vertices: std::collections::BTreeSet<VertexId> =
        sources.filter(|&(_, weight)| weight > 0.0).map(|(vertex, _)| vertex).collect();
    if vertices.len() > parameters {
        Ok(length_mm)
    } else {
        Err(ProfileError::TooShort { vertices: vertices.len(), parameters })
    }
}

/// A pivot that lost so many digits tells nothing.
const LEAST_PIVOT: f64 = 1e-12;
/// Where less than this share of the errors is left, the rest is rounding.
const LEAST_FREEDOM: f64 = 1e-9;
