//! Polynomials along a profile: level, tilt, and what bends more.

use nalgebra::DVector;

use super::normal_equations::{NormalEquations, ensure_enough};
use super::profile::{Profile, ProfileError};

/// The highest degree of a polynomial that is fitted.
pub const MAX_DEGREE: usize = 12;

/// A polynomial in the arc position, fitted to a profile by least squares over the arc position.
#[derive(Clone, Debug, PartialEq)]
pub struct PolynomialFit {
    /// The middle of the profile, and half its extent, in mm.
    middle_mm: f64,
    half_mm: f64,
    /// The coefficients of Legendre's polynomials over the extent, from degree 0 on, in mm.
    coefficients_mm: Vec<f64>,
    /// The value in the middle of the extent in mm.
    pub level_mm: f64,
    /// The slope in the middle of the extent, mm a mm; of a constant 0.
    pub slope: f64,
    /// Standard uncertainty of a straight line's slope: noise of the vertices that is independent
    /// and of one size, as large as what the fit leaves tells. None for other degrees, and where a fit can leave
    /// nothing, as of a profile inside one triangle.
    pub u_slope: Option<f64>,
    /// Root of the mean square over the arc position of what is left in mm, samples weighted by
    /// length.
    pub rms_mm: f64,
}

impl Profile {
    /// The straight line that fits best: level and tilt.
    ///
    /// # Errors
    ///
    /// As [`Profile::polynomial`].
    pub fn line(&self) -> Result<PolynomialFit, ProfileError> {
        self.polynomial(1)
    }

    /// The polynomial of a degree that fits best, from 0 for the mean level to [`MAX_DEGREE`].
    /// Distances count along the value. Takes time in proportion to the samples and the square of
    /// the degree, with the logarithm for the vertices.
    ///
    /// # Errors
    ///
    /// If the degree is too high, if the profile comes from no more vertices than there are
    /// coefficients, or lies so that they cannot be told from each other.
    pub fn polynomial(&self, degree: usize) -> Result<PolynomialFit, ProfileError> {
        if degree > MAX_DEGREE {
            return Err(ProfileError::Degree { degree });
        }
        let length_mm = ensure_enough(self, degree + 1)?;
        let [low, high] = self.extent_mm();
        let (middle_mm, half_mm) = (low / 2.0 + high / 2.0, (high - low) / 2.0);
        let offset_mm = self.samples()[0].value_mm;
        let mut sums = NormalEquations::new(degree + 1);
        for (sample, source) in self.samples().iter().zip(self.sources()) {
            let row = legendre(degree, (sample.s_mm - middle_mm) / half_mm);
            // What all have in common is not squared.
            sums.add(sample.length_mm, &row, sample.value_mm - offset_mm, source, 1.0);
        }
        let solution = sums.solve()?;
        let mut coefficients_mm: Vec<f64> = solution.parameters.iter().copied().collect();
        coefficients_mm[0] += offset_mm;
        let mut fit = PolynomialFit {
            middle_mm,
            half_mm,
            coefficients_mm,
            level_mm: 0.0,
            slope: 0.0,
            u_slope: None,
            rms_mm: 0.0,
        };
        let left = |sample: &super::Sample| sample.value_mm - fit.value_mm(sample.s_mm);
        let squares: f64 =
            self.samples().iter().map(|sample| sample.length_mm * left(sample).powi(2)).sum();
        fit.rms_mm = (squares / length_mm).sqrt();
        fit.level_mm = fit.value_mm(middle_mm);
        fit.slope = fit.slope_in_the_middle();
        fit.u_slope =
            (degree == 1).then(|| solution.uncertainty(1, squares)).flatten().map(|u| u / half_mm);
        Ok(fit)
    }

    /// The smallest arc position and the largest.
    pub(super) fn extent_mm(&self) -> [f64; 2] {
        let places = self.samples().iter().map(|sample| sample.s_mm);
        places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], s_mm| {
            [low.min(s_mm), high.max(s_mm)]
        })
    }
}

impl PolynomialFit {
    /// Its value in mm at an arc position in mm.
    pub fn value_mm(&self, s_mm: f64) -> f64 {
        let row = legendre(self.degree(), (s_mm - self.middle_mm) / self.half_mm);
        row.iter().zip(&self.coefficients_mm).map(|(term, coefficient)| term * coefficient).sum()
    }

    /// Its degree.
    pub fn degree(&self) -> usize {
        self.coefficients_mm.len() - 1
    }

    /// What it leaves of a profile.
    pub fn residual(&self, profile: &Profile) -> Profile {
        profile.map(|sample| sample.value_mm - self.value_mm(sample.s_mm))
    }

    /// From P'ₙ(0) = n·Pₙ₋₁(0).
    fn slope_in_the_middle(&self) -> f64 {
        let at_zero = legendre(self.degree(), 0.0);
        let terms = (1..self.coefficients_mm.len())
            .map(|n| self.coefficients_mm[n] * n as f64 * at_zero[n - 1]);
        terms.sum::<f64>() / self.half_mm
    }
}

/// Legendre's polynomials up to a degree by their recurrence, (n+1)·Pₙ₊₁ = (2n+1)·t·Pₙ - n·Pₙ₋₁.
fn legendre(degree: usize, t: f64) -> DVector<f64> {
    let mut row = DVector::from_element(degree + 1, 1.0);
    if degree > 0 {
        row[1] = t;
    }
    for n in 1..degree {
        let order = n as f64;
        row[n + 1] = ((2.0 * order + 1.0) * t * row[n] - order * row[n - 1]) / (order + 1.0);
    }
    row
}
