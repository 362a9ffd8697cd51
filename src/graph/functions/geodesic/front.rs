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
            behind.push(Corner { position: places[other as usize], length, distance });
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
                if let Some(distance) =
                    unfolded([own, corner.distance], [corner.length, length, across])
                {
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
}

/// Distance of p from a source beyond the side qr of the triangle pqr, unfolded into its plane; `None` where the straight way does not
/// cross that side. Given are the distances of q and r from the source, and the lengths |qr|, |pq|, |pr|, all in mm.
///
/// q lies in the origin, r on the x axis, p above and the source s below it.
fn unfolded([of_q, of_r]: [f64; 2], [qr, pq, pr]: [f64; 3]) -> Option<f64> {
    let foot = |to_q: f64, to_r: f64| (qr * qr + (to_q - to_r) * (to_q + to_r)) / (2.0 * qr);
    let (p_x, s_x) = (foot(pq, pr), foot(of_q, of_r));
    let p_square = pq * pq - p_x * p_x;
    let s_square = of_q * of_q - s_x * s_x;
    if !(p_square > 0.0 && s_square >= 0.0) {
        return None;
    }
    let (p_y, s_y) = (p_square.sqrt(), s_square.sqrt());
    let crossing = (p_x * s_y + s_x * p_y) / (p_y + s_y);
    (0.0..=qr).contains(&crossing).then(|| (p_x - s_x).hypot(p_y + s_y))
}
