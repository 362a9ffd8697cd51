//! A front that passes over the places in the order of their distances.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::super::ring::Rings;
use crate::cloud::{Cloud, PlaceId};
use crate::tree::squared_distance;

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
    let mut behind: Vec<Corner<D>> = Vec::new();
    while let Some(Reverse((bits, place))) = open.pop() {
        let at = place as usize;
        if is_passed[at] || distances[at].to_bits() != bits {
            continue;
        }
        is_passed[at] = true;
        let own = distances[at];
        behind.clear();
        for (other, length) in
            rings.neighbours(place).filter(|(other, _)| is_passed[*other as usize])
        {
            let distance = distances[other as usize];
            if let Some(source) = placed([own, distance], length) {
                behind.push(Corner { position: places[other as usize], length, distance, source });
            }
        }
        for (other, length) in
            rings.neighbours(place).filter(|(other, _)| !is_passed[*other as usize])
        {
            let mut least = distances[other as usize].min(own + length);
            let position = &places[other as usize];
            for corner in &behind {
                // No way round the corner is shorter than this.
                if corner.distance >= least {
                    continue;
                }
                let across = squared_distance(position, &corner.position).sqrt();
                if let Some(distance) = unfolded(corner.source, [corner.length, length, across]) {
                    least = least.min(distance);
                }
            }
            if least < distances[other as usize] {
                // A front does not go back, whatever rounding says.
                distances[other as usize] = least.max(own);
                open.push(Reverse((least.max(own).to_bits(), other)));
            }
        }
    }
    distances
}

/// A neighbour that the front has passed.
struct Corner<const D: usize> {
    position: [f64; D],
    /// From the place that is passed now, mm.
    length: f64,
    /// From the source, mm.
    distance: f64,
    /// The source in the plane of the triangle, mm.
    source: [f64; 2],
}

/// The source beyond the side qr of a triangle pqr, with its distances from q and r and the length |qr|, all in mm. q lies in the
/// origin, r on the x axis; the second coordinate counts downwards. `None` where no place has such distances.
fn placed([of_q, of_r]: [f64; 2], qr: f64) -> Option<[f64; 2]> {
    let x = foot(qr, [of_q, of_r]);
    let square = of_q * of_q - x * x;
    (square >= 0.0).then(|| [x, square.sqrt()])
}

/// Distance of p from a source, with p unfolded into its plane above the x axis; `None` where the straight way does not cross the side
/// qr. Given are the source as of [`placed`] and the lengths |qr|, |pq|, |pr|, all in mm.
fn unfolded([s_x, s_y]: [f64; 2], [qr, pq, pr]: [f64; 3]) -> Option<f64> {
    let p_x = foot(qr, [pq, pr]);
    let p_square = pq * pq - p_x * p_x;
    if p_square.is_nan() || p_square <= 0.0 {
        return None;
    }
    let p_y = p_square.sqrt();
    let crossing = (p_x * s_y + s_x * p_y) / (p_y + s_y);
    (0.0..=qr).contains(&crossing).then(|| (p_x - s_x).hypot(p_y + s_y))
}

/// Where a place lies along the side qr, by its distances from q and r, mm.
fn foot(qr: f64, [to_q, to_r]: [f64; 2]) -> f64 {
    (qr * qr + (to_q - to_r) * (to_q + to_r)) / (2.0 * qr)
}
