//! Weights of points, drawn from their coordinates.

use asphera_geometry::PointMm;

use crate::draw::bits;

/// The weight of a point in a round, as a share of the square of the distance of its nearest neighbour: less than 0.45².
///
/// In the second half of the rounds mirrored points part.
pub(super) fn share(place: PointMm, round: usize) -> f64 {
    let drawn = bits(place, round, round <= SYMMETRIC_ROUNDS);
    WIDEST * WIDEST * (drawn >> 11) as f64 * 2_f64.powi(-53)
}

/// Weights below half the distance of neighbours keep every point in its own cell.
pub(super) const WIDEST: f64 = 0.45;
const SYMMETRIC_ROUNDS: usize = 20;
