//! The order of insertion: rounds that grow eightfold, each along a Hilbert curve (N. Amenta, S. Choi, G. Rote 2003, "BRIO").
//!
//! Rounds keep cavities small whatever the points; the curve keeps a point near the one before, so that finding its cell is cheap
//! and memory is in the cache.

use asphera_geometry::BoxMm;
use rayon::prelude::*;

use crate::surface::Numbered;

/// Arranges points for insertion.
pub(super) fn arrange(places: &mut [Numbered]) {
    let bounds = BoxMm::about(places.iter().map(|&(place, _)| place));
    let widest = bounds.size_mm().into_iter().fold(0.0, f64::max);
    // Without a width all places are one; any scale will do.
    let scale = if widest > 0.0 { f64::from(SIDE - 1) / widest } else { 0.0 };
    let last = places.len().max(1).ilog2().saturating_sub(FIRST_ROUND) / GROWTH;
    places.par_sort_by_cached_key(|&(place, _)| {
        let at = [0, 1, 2].map(|axis| ((place[axis] - bounds.low[axis]) * scale) as u32);
        (round(place, last), hilbert(at))
    });
}

/// The round of a place: seven eighths of all are in the last, seven eighths of the others in the one before.
fn round(place: [f64; 3], last: u32) -> u32 {
    let mixed = place.iter().fold(0_u64, |mixed, value| {
        let next = (mixed ^ value.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        next ^ next >> 29
    });
    let coin = mixed.wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 32 << 32;
    last.saturating_sub(coin.leading_zeros() / GROWTH)
}

/// Position along the Hilbert curve (J. Skilling, "Programming the Hilbert curve", AIP Conference Proceedings 707 (2004) 381).
fn hilbert(at: [u32; 3]) -> u64 {
    let mut x = at;
    let mut bit = SIDE >> 1;
    while bit > 1 {
        let below = bit - 1;
        for axis in 0..3 {
            if x[axis] & bit != 0 {
                x[0] ^= below;
            } else {
                let swapped = (x[0] ^ x[axis]) & below;
                x[0] ^= swapped;
                x[axis] ^= swapped;
            }
        }
        bit >>= 1;
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut turn = 0;
    let mut bit = SIDE >> 1;
    while bit > 1 {
        if x[2] & bit != 0 {
            turn ^= bit - 1;
        }
        bit >>= 1;
    }
    let x = x.map(|value| value ^ turn);
    (0..BITS)
        .rev()
        .fold(0, |key, bit| x.iter().fold(key, |key, value| key << 1 | u64::from(value >> bit & 1)))
}

/// Bits of the curve along an axis.
const BITS: u32 = 20;
/// Steps of the curve along an axis.
const SIDE: u32 = 1 << BITS;
/// The first round has at least about so many points, as a power of two.
const FIRST_ROUND: u32 = 7;
/// Each round has so many times the points of all before it, as a power of two. With rounds that double the triangulation of 300,000
/// points took 5 to 10 % longer.
const GROWTH: u32 = 3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_on_the_curve_are_neighbours_in_space() {
        let shift = BITS - 3;
        let mut cells: Vec<(u64, [u32; 3])> = (0..512)
            .map(|at| [at & 7, at >> 3 & 7, at >> 6])
            .map(|cell| (hilbert(cell.map(|value| value << shift)) >> (3 * shift), cell))
            .collect();
        cells.sort_unstable();
        for (expected, pair) in (0..).zip(cells.windows(2)) {
            assert_eq!(pair[0].0, expected);
            let steps: u32 = (0..3).map(|axis| pair[0].1[axis].abs_diff(pair[1].1[axis])).sum();
            assert_eq!(steps, 1, "{pair:?}");
        }
    }
}
