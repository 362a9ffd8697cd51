//! What may hide where nothing was measured.

use super::budget::{UncertaintyError, check};

/// What the unmeasured part of the aperture may add to a peak to valley deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hidden {
    /// At most this at either end, in nm: an extreme between the points.
    AtMost {
        /// What may be added to the highest and taken from the lowest deviation, in nm.
        each_end_nm: f64,
    },
    /// Anything: the figure is the least it can be.
    Unbounded,
}

/// How much may hide between points whose largest empty circle has radius `gap_radius_mm`, if the deviation
/// bends by no more than `bend_per_mm` (its largest second derivative in any direction, mm/mm²) anywhere.
///
/// Between the corners of a triangle with an empty circumcircle of radius R, a function lies within ½·bend·R² of
/// the plane through them (Waldron, SIAM J. Numer. Anal. 35 (1998) 1191), and a plane has its extremes at the
/// corners. Beyond the outermost points there is no such bound; neither is there without a gap or a bend: the
/// answer is then [`Hidden::Unbounded`].
pub fn unmeasured(
    gap_radius_mm: Option<f64>,
    bend_per_mm: Option<f64>,
) -> Result<Hidden, UncertaintyError> {
    let length = |name, value: Option<f64>| match value {
        Some(v) => check(name, v, v.is_finite() && v >= 0.0, "a finite number not below 0"),
        None => Ok(()),
    };
    length("radius of the largest gap in mm", gap_radius_mm)?;
    length("largest second derivative in 1/mm", bend_per_mm)?;
    Ok(match (gap_radius_mm, bend_per_mm) {
        (Some(radius_mm), Some(bend)) => {
            Hidden::AtMost { each_end_nm: 0.5 * bend * radius_mm * radius_mm * 1e6 }
        }
        _ => Hidden::Unbounded,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paraboloid −½·κ·r² about the circumcentre reaches the bound exactly, for an equilateral triangle.
    #[test]
    fn a_dome_between_three_points_is_just_hidden() {
        let (bend, radius_mm) = (3e-5, 0.4);
        let at_corners_nm = -0.5 * bend * radius_mm * radius_mm * 1e6;
        let Ok(Hidden::AtMost { each_end_nm }) = unmeasured(Some(radius_mm), Some(bend)) else {
            panic!("a bound");
        };
        assert!((each_end_nm + at_corners_nm).abs() < 1e-12);
    }

    #[test]
    fn without_gap_or_bend_there_is_no_bound() {
        assert_eq!(unmeasured(None, Some(1.0)), Ok(Hidden::Unbounded));
        assert_eq!(unmeasured(Some(1.0), None), Ok(Hidden::Unbounded));
        assert!(unmeasured(Some(f64::NAN), None).is_err() && unmeasured(None, Some(-1.0)).is_err());
    }
}
