//! Random bits of a point, drawn from its coordinates.

use asphera_geometry::PointMm;

/// Bits that depend on the coordinates of a point and a round alone.
///
/// Powers of two as scale change nothing. Neither do quarter turns about axes through the origin where `is_symmetric`; then mirrored
/// points have the same bits.
pub(crate) fn bits(place: PointMm, round: usize, is_symmetric: bool) -> u64 {
    let mut sides = place;
    if is_symmetric {
        sides = sides.map(f64::abs);
        sides.sort_unstable_by(f64::total_cmp);
    }
    let mixed = sides.iter().fold(round as u64, |mixed, value| {
        // Without the exponent.
        let bits = value.to_bits() & !(0x7ff << 52);
        let next = (mixed ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (next ^ next >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9)
    });
    mixed ^ mixed >> 32
}
