//! What curvature alone says of the local feature size: a ceiling, and its share of a floor.
//!
//! A medial ball cannot bend less than the surface it touches from inside, so its radius is at most that of the
//! larger principal curvature κ, and lfs ≤ 1/κ. **That is a bound from above.** Curvature cannot bound
//! lfs from below: two flat sheets have none, and their lfs is half their distance.
//!
//! The least lfs of a surface is its *reach*, and that is the smaller of the least radius of curvature
//! and half the width of the narrowest bottleneck (E. Aamari, J. Kim, F. Chazal, B. Michel, A. Rinaldo,
//! L. Wasserman, Electronic Journal of Statistics 13 (2019) 1359-1399, doi:10.1214/19-EJS1551, theorem
//! 3.4; the notion is H. Federer's, Transactions of the AMS 93 (1959) 418-491). So curvature gives
//! a floor with a second figure only: the half width of the narrowest bottleneck, from the nominal or
//! from medial balls ([`MedialAxis::half_bottleneck_mm`](crate::MedialAxis::half_bottleneck_mm)).

use super::error::{LfsError, not_negative};

/// The larger principal curvature at a place, by size, with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curvature {
    per_mm: f64,
    uncertainty_per_mm: f64,
}

impl Curvature {
    /// The larger of the two principal curvatures by size, and how wrong it may be, in 1/mm.
    ///
    /// # Errors
    ///
    /// When the curvature is not finite, or the uncertainty not finite or negative.
    pub fn new(per_mm: f64, uncertainty_per_mm: f64) -> Result<Curvature, LfsError> {
        let per_mm = not_negative("curvature in 1/mm, by size,", per_mm.abs())?;
        let uncertainty_per_mm = not_negative("uncertainty_per_mm", uncertainty_per_mm)?;
        Ok(Curvature { per_mm, uncertainty_per_mm })
    }

    /// What the local feature size there cannot exceed, in mm: 1/(κ - u). `None` where the curvature
    /// is within its uncertainty of zero: it then bounds nothing.
    pub fn ceiling_mm(&self) -> Option<f64> {
        let sure_per_mm = self.per_mm - self.uncertainty_per_mm;
        (sure_per_mm > 0.0).then(|| 1.0 / sure_per_mm)
    }

    /// What the radius of curvature there is at least, in mm: 1/(κ + u). Infinite on a plane that is
    /// known to be one. **No bound of the local feature size**; see [`reach_floor_mm`].
    pub fn radius_floor_mm(&self) -> f64 {
        1.0 / (self.per_mm + self.uncertainty_per_mm)
    }
}

/// What the local feature size is nowhere below, in mm, given the curvatures of a surface everywhere and
/// half the width of its narrowest bottleneck (infinite if it has none).
///
/// It holds as far as the curvatures do: between the places where they are known the surface must not
/// bend more than within their uncertainties. `None` without a curvature.
///
/// # Errors
///
/// When the half width is not above zero.
pub fn reach_floor_mm(
    curvatures: impl IntoIterator<Item = Curvature>,
    half_bottleneck_mm: f64,
) -> Result<Option<f64>, LfsError> {
    if half_bottleneck_mm.is_nan() || half_bottleneck_mm <= 0.0 {
        return Err(LfsError::Argument {
            name: "half_bottleneck_mm",
            found: half_bottleneck_mm,
            allowed: "above zero, or infinite",
        });
    }
    let least =
        curvatures.into_iter().map(|curvature| curvature.radius_floor_mm()).reduce(f64::min);
    Ok(least.map(|least_mm| least_mm.min(half_bottleneck_mm)))
}
