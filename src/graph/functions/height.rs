//! Heights: along a direction, or along a principal axis.

use super::distance::{dot, unit};
use super::{Field, FunctionError, principal_axes};
use crate::cloud::Cloud;

/// The height along a direction of any length, in mm from the origin. Linear time.
///
/// # Errors
///
/// A direction that is not finite, or 0.
pub fn height<const D: usize>(
    cloud: &Cloud<D>,
    direction: [f64; D],
) -> Result<Field, FunctionError> {
    let unit = unit(direction)?;
    Ok(Field::length(cloud.places().iter().map(|place| dot(place, &unit)).collect()))
}

/// The height along principal axis `number`, from 1 for the longest, in mm from the centre. Linear time.
///
/// Where the variance along that axis is nearly that along another one, `is_multiple` is set: the axis then depends on where the
/// points happen to lie.
///
/// # Errors
///
/// An axis that the cloud does not have; a cloud without points.
pub fn principal_height<const D: usize>(
    cloud: &Cloud<D>,
    number: usize,
) -> Result<Field, FunctionError> {
    if !(1..=D).contains(&number) {
        return Err(FunctionError::Axis { found: number, dimensions: D });
    }
    let axes = principal_axes(cloud)?;
    let axis = axes.axes[number - 1];
    let along =
        |place: &[f64; D]| dot(&std::array::from_fn(|at| place[at] - axes.centre_mm[at]), &axis);
    let values = cloud.places().iter().map(along).collect();
    Ok(Field { values, is_length: true, is_multiple: axes.is_multiple[number - 1] })
}
