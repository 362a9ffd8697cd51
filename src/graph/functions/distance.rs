//! Straight distances: from a point, the centre, an axis.

use super::{Field, FunctionError};
use crate::cloud::Cloud;
use crate::tree::squared_distance;

/// The distance from a point in mm. Linear time.
///
/// # Errors
///
/// A point that is not finite.
pub fn distance_from_point<const D: usize>(
    cloud: &Cloud<D>,
    point_mm: [f64; D],
) -> Result<Field, FunctionError> {
    if !point_mm.iter().all(|value| value.is_finite()) {
        return Err(FunctionError::Point { point_mm: point_mm.to_vec() });
    }
    let distance = |place| squared_distance(place, &point_mm).sqrt();
    Ok(Field::length(cloud.places().iter().map(distance).collect()))
}

/// The distance from the mean of the places in mm. Linear time.
///
/// # Errors
///
/// A cloud without points.
pub fn distance_from_centre<const D: usize>(cloud: &Cloud<D>) -> Result<Field, FunctionError> {
    distance_from_point(cloud, cloud.centre_mm().ok_or(FunctionError::NoPoints)?)
}

/// The distance from a straight line in mm. Linear time.
///
/// # Errors
///
/// A point or a direction that is not finite, or a direction of length 0.
pub fn distance_from_axis<const D: usize>(
    cloud: &Cloud<D>,
    point_mm: [f64; D],
    direction: [f64; D],
) -> Result<Field, FunctionError> {
    if !point_mm.iter().all(|value| value.is_finite()) {
        return Err(FunctionError::Point { point_mm: point_mm.to_vec() });
    }
    let unit = unit(direction)?;
    let distance = |place: &[f64; D]| {
        let from: [f64; D] = std::array::from_fn(|axis| place[axis] - point_mm[axis]);
        let along = dot(&from, &unit);
        let across = std::array::from_fn(|axis| from[axis] - along * unit[axis]);
        squared_distance(&across, &[0.0; D]).sqrt()
    };
    Ok(Field::length(cloud.places().iter().map(distance).collect()))
}

pub(super) fn dot<const D: usize>(p: &[f64; D], q: &[f64; D]) -> f64 {
    (0..D).map(|axis| p[axis] * q[axis]).sum()
}

/// A direction of length 1.
pub(super) fn unit<const D: usize>(direction: [f64; D]) -> Result<[f64; D], FunctionError> {
    let largest = direction.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    if !(largest > 0.0 && largest.is_finite() && direction.iter().all(|value| !value.is_nan())) {
        return Err(FunctionError::Direction { direction: direction.to_vec() });
    }
    // Scaled first, so that squares neither vanish nor overflow.
    let scaled = direction.map(|value| value / largest);
    let length = dot(&scaled, &scaled).sqrt();
    Ok(scaled.map(|value| value / length))
}
