//! A front that passes over the places in the order of their distances.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use asphera_geometry::greater;

use super::super::ring::Rings;
use crate::cloud::{Cloud, PlaceId};

/// Distances from the nearest source in mm; infinite in parts of the graph without one.
pub(super) fn sweep<const D: usize>(
    cloud: &Cloud<D>,
    rings: &Rings,
    sources: &[PlaceId],
) -> Vec<f64> {
    let places = cloud.places();
    let mut distances = vec![f64::INFINITY; places.len()];
    let mut is_passed = vec![false; places.len()];
    // Distances are not negative, so their bits are in their order.
    let mut open: BinaryHeap<Reverse<(u64, PlaceId)>> = BinaryHeap::new();
    for &source in sources {
        distances[source as usize] = 0.0;
        open.push(Reverse((0, source)));
    }
    let (mut behind, mut ahead) = (Vec::new(), Vec::new());
    while let Some(Reverse((bits, place))) = open.pop() {
        let at = place as usize;
        if is_passed[at] || distances[at].to_bits() != bits {
            continue;
        }
        is_passed[at] = true;
        let own = distances[at];
        behind.clear();
        ahead.clear();
        for (other, length) in rings.neighbours(place) {
            let way: [f64; D] = way(&places[at], &places[other as usize]);
            if !is_passed[other as usize] {
                ahead.push((other, length, way));
            } else if let Some(source) = placed([own, distances[other as usize]], length) {
                behind.push(Corner { direction: way.map(|mm| mm / length), length, source });
            }
        }
        for (other, length, way) in &ahead {
            let known = distances[*other as usize];
            let mut least = known.min(own + length);
            let square = unfolded(&behind, own, *length, way);
            if square < least * least {
                least = square.sqrt();
            }
            // A front does not go back, whatever rounding says.
            least = least.max(own);
            if least < known {
                distances[*other as usize] = least;
                open.push(Reverse((least.to_bits(), *other)));
            }
        }
    }
    distances
}

fn way<const D: usize>(from: &[f64; D], to: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|axis| to[axis] - from[axis])
}

/// A neighbour r, which the front has passed, of the place q that it passes now.
struct Corner<const D: usize> {
    /// From q, of length 1.
    direction: [f64; D],
    /// The length |qr| in mm.
    length: f64,
    /// The source in the plane of a triangle pqr, mm.
    source: [f64; 2],
}

/// The source beyond the side qr of a triangle pqr, with its distances from q and r and the length |qr|, all in mm. q lies in the
/// origin, r on the x axis; the second coordinate counts downwards. `None` where no place has such distances.
fn placed([of_q, of_r]: [f64; 2], qr: f64) -> Option<[f64; 2]> {
    let x = (qr * qr + (of_q - of_r) * (of_q + of_r)) / (2.0 * qr);
    let square = of_q * of_q - x * x;
    (square >= 0.0).then(|| [x, square.sqrt()])
}

/// Square of the least distance of p from the source in mm², with p unfolded into the plane of q, a corner r and the source; infinite where
/// the straight way crosses no side qr. Given are the distance of q and the way from q to p with its length, in mm.
fn unfolded<const D: usize>(corners: &[Corner<D>], of_q: f64, pq: f64, way: &[f64; D]) -> f64 {
    let mut least = f64::INFINITY;
    for Corner { direction, length, source: [s_x, s_y] } in corners {
        // The triangle with q in the origin, r on the x axis and p above it.
        let p_x: f64 = (0..D).map(|axis| way[axis] * direction[axis]).sum();
        let square = pq * pq - p_x * p_x;
        let p_y = greater(square, 0.0).sqrt();
        let crossing = p_x * s_y + s_x * p_y;
        let is_crossed = (square > 0.0) & (crossing >= 0.0) & (crossing <= length * (p_y + s_y));
        // By the theorem of cosines.
        let found = of_q * of_q + pq * pq - 2.0 * (p_x * s_x - p_y * s_y);
        // All is computed and chosen from, which spares branches that nobody can foresee.
        let found = if is_crossed { found } else { f64::INFINITY };
        least = if found < least { found } else { least };
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unfolded_way_is_the_straight_one_of_the_plane() {
        // Steps by irrational numbers spread the places; the plane lies askew in space.
        let (u, v) = ([2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0], [-2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0]);
        let in_space = |[x, y]: [f64; 2]| -> [f64; 3] {
            std::array::from_fn(|axis| 5.0 + x * u[axis] + y * v[axis])
        };
        let apart = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
        let mut crossed = 0;
        for at in 0..5000_u32 {
            let spread = |step: f64| (f64::from(at) * step).fract();
            let (q, r) = ([0.0, 0.0], [0.1 + spread(0.618_034), 0.0]);
            let p = [3.0 * spread(0.414_214) - 1.0, 0.01 + spread(0.732_051)];
            // As far as a thousand triangles.
            let far = 1000.0_f64.powf(spread(0.236_068));
            let source = [far * (spread(0.645_751) - 0.5), -far * spread(0.316_625)];
            let [place_q, place_r, place_p] = [q, r, p].map(in_space);
            let of_q = apart(source, q);
            let Some(placed) = placed([of_q, apart(source, r)], r[0]) else { continue };
            let direction = way(&place_q, &place_r).map(|mm| mm / r[0]);
            let corner = Corner { direction, length: r[0], source: placed };
            let found = unfolded(&[corner], of_q, apart(q, p), &way(&place_q, &place_p)).sqrt();
            let crossing = (p[0] * -source[1] + source[0] * p[1]) / (p[1] - source[1]);
            if (1e-6..r[0] - 1e-6).contains(&crossing) {
                let truth = apart(source, p);
                assert!((found - truth).abs() < 1e-9 * truth, "{found} {truth}");
                crossed += 1;
            } else if crossing < -1e-6 || crossing > r[0] + 1e-6 {
                assert_eq!(found, f64::INFINITY);
            }
        }
        assert!(crossed > 500, "{crossed}");
    }
}
