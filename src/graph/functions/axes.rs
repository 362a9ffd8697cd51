//! Principal axes of a cloud.

use super::FunctionError;
use super::distance::dot;
use super::jacobi::eigen;
use crate::cloud::{CHUNK, Cloud};

/// The directions along which the places of a cloud spread, the widest first.
#[derive(Clone, Debug, PartialEq)]
pub struct PrincipalAxes<const D: usize> {
    /// The mean of the places in mm.
    pub centre_mm: [f64; D],
    /// Unit vectors, one a row.
    pub axes: [[f64; D]; D],
    /// Standard deviation of the places along each axis in mm.
    pub spread_mm: [f64; D],
    /// The variance along the axis differs from that along another one by less than a thousandth of the largest.
    pub is_multiple: [bool; D],
}

/// Principal axes: eigenvectors of the covariance of the places. Linear time.
///
/// An axis points to where the third moment of the heights along it is above 0. Where that is 0 but for rounding, it points to the
/// farther end; where both ends are equally far, its first coordinate that is not 0 is above 0.
///
/// # Errors
///
/// A cloud without points.
pub fn principal_axes<const D: usize>(cloud: &Cloud<D>) -> Result<PrincipalAxes<D>, FunctionError> {
    let centre_mm = cloud.centre_mm().ok_or(FunctionError::NoPoints)?;
    // Scaled, so that products neither vanish nor overflow.
    let scale = if cloud.diagonal_mm() > 0.0 { cloud.diagonal_mm() } else { 1.0 };
    let from_centre = |place: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|axis| (place[axis] - centre_mm[axis]) / scale)
    };
    let mut covariance = [[0.0; D]; D];
    for chunk in cloud.places().chunks(CHUNK) {
        let mut sums = [[0.0; D]; D];
        for place in chunk {
            let from = from_centre(place);
            for row in 0..D {
                (0..D).for_each(|column| sums[row][column] += from[row] * from[column]);
            }
        }
        for row in 0..D {
            (0..D).for_each(|column| covariance[row][column] += sums[row][column]);
        }
    }
    let count = cloud.len() as f64;
    let (variances, mut axes) = eigen(covariance.map(|row| row.map(|sum| sum / count)));
    for axis in &mut axes {
        let heights = cloud.places().iter().map(|place| dot(&from_centre(place), axis));
        if points_back(heights, axis) {
            *axis = axis.map(|value| -value);
        }
    }
    let near = |a: f64, b: f64| (a - b).abs() < GAP * variances[0];
    let is_multiple = std::array::from_fn(|at| {
        (0..D).any(|other| other != at && near(variances[at], variances[other]))
    });
    let spread_mm = variances.map(|variance| scale * variance.max(0.0).sqrt());
    Ok(PrincipalAxes { centre_mm, axes, spread_mm, is_multiple })
}

/// Whether an axis is to be turned round.
fn points_back<const D: usize>(heights: impl Iterator<Item = f64>, axis: &[f64; D]) -> bool {
    let (mut cubes, mut sizes) = (0.0, 0.0);
    let mut ends: [f64; 2] = [0.0, 0.0];
    for height in heights {
        let cube = height * height * height;
        cubes += cube;
        sizes += cube.abs();
        ends = [ends[0].min(height), ends[1].max(height)];
    }
    if cubes.abs() > SAME * sizes {
        return cubes < 0.0;
    }
    let farther = ends[0] + ends[1];
    if farther.abs() > SAME * (ends[1] - ends[0]) {
        return farther < 0.0;
    }
    axis.iter().find(|value| value.abs() > SAME).is_some_and(|&value| value < 0.0)
}

/// Variances that differ by less than this share of the largest are one multiple eigenvalue.
const GAP: f64 = 1e-3;

/// Rounding leaves less than this share.
const SAME: f64 = 1e-9;
