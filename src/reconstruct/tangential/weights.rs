//! Weights of points, drawn from their coordinates.

use asphera_geometry::PointMm;

/// The weight of a point in a round, as a share of the square of the distance of its nearest neighbour: less than 0.45².
///
/// Powers of two as scale and quarter turns about the axes through the origin change nothing in the first half of the rounds. Then
/// signs and order of the coordinates count too, so that mirrored points part.
pub(super) fn share(place: PointMm, round: usize) -> f64 {
    let mut sides = place;
    if round <= SYMMETRIC_ROUNDS {
        sides = sides.map(f64::abs);
        sides.sort_unstable_by(f64::total_cmp);
    }
    let mixed = sides.iter().fold(round as u64, |mixed, value| {
        // Without the exponent.
        let bits = value.to_bits() & !(0x7ff << 52);
        let next = (mixed ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (next ^ next >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9)
    });
    let uniform = ((mixed ^ mixed >> 32) >> 11) as f64 * 2_f64.powi(-53);
    WIDEST * WIDEST * uniform
}

/// Weights below half the distance of neighbours keep every point in its own cell.
pub(super) const WIDEST: f64 = 0.45;
const SYMMETRIC_ROUNDS: usize = 20;
