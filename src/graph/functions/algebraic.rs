//! Functions of the coordinates alone, in the frame of the file.

use super::Field;
use crate::cloud::Cloud;
use crate::tree::squared_distance;

/// The logarithm of the distance from the origin.
///
/// ```text
/// f(p) = log(‖p‖ + 1)
/// ```
///
/// ‖p‖ in mm. Linear time.
pub fn logarithm<const D: usize>(cloud: &Cloud<D>) -> Field {
    let norm = |place| squared_distance(place, &[0.0; D]).sqrt();
    Field::number(cloud.places().iter().map(|place| norm(place).ln_1p()).collect())
}

/// The square ‖p‖² of the distance from the origin, in mm². Linear time.
pub fn squared_norm<const D: usize>(cloud: &Cloud<D>) -> Field {
    let square = |place| squared_distance(place, &[0.0; D]);
    Field::number(cloud.places().iter().map(square).collect())
}

/// The saddle x² − y², in mm². Linear time.
pub fn saddle<const D: usize>(cloud: &Cloud<D>) -> Field {
    // Of the product no digits are lost where x and y are near each other.
    let value = |place: &[f64; D]| (place[0] - place[1]) * (place[0] + place[1]);
    Field::number(cloud.places().iter().map(value).collect())
}
