//! Landmarks: a maximal set of points that are at least so many hops apart.

use std::cmp::Ordering;

use asphera_geometry::PointMm;
use rayon::prelude::*;

use super::links::Links;
use crate::neighbours::by_coordinates;

/// In which order points become landmarks. Each is a function of the place alone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LandmarkOrder {
    /// By z, then x, then y: landmarks lie close together.
    #[default]
    Sweep,
    /// By a fixed hash of the coordinates: a further point changes landmarks near it only, but they lie 15 to 30 % less close.
    Priority,
}

/// The landmarks, and how far every point is from the nearest of them.
pub(super) struct Landmarks {
    /// Points in the order in which they were chosen.
    pub(super) points: Vec<u32>,
    /// Hops from each point to the nearest landmark, below the distance between landmarks.
    pub(super) hops: Vec<u8>,
}

/// Chooses landmarks greedily (section 3.1): a point fewer than `apart` hops from an earlier one is passed over.
///
/// A search from a landmark stops where an earlier one is as near. So the hops found are those to the nearest landmark of all,
/// and every point is met few times.
pub(super) fn landmarks(
    links: &Links,
    points_mm: &[PointMm],
    apart: u8,
    order: LandmarkOrder,
) -> Landmarks {
    let mut hops = vec![FAR; links.len()];
    let mut chosen = Vec::new();
    let (mut ring, mut next) = (Vec::new(), Vec::new());
    for point in sorted(points_mm, order) {
        if hops[point as usize] != FAR {
            continue;
        }
        chosen.push(point);
        hops[point as usize] = 0;
        ring.clear();
        ring.push(point);
        for distance in 1..apart {
            next.clear();
            for &inner in &ring {
                for &outer in links.at(inner) {
                    let found = &mut hops[outer as usize];
                    if *found > distance {
                        *found = distance;
                        next.push(outer);
                    }
                }
            }
            std::mem::swap(&mut ring, &mut next);
        }
    }
    Landmarks { points: chosen, hops }
}

/// The points in the order in which they may become landmarks.
fn sorted(points_mm: &[PointMm], order: LandmarkOrder) -> Vec<u32> {
    let mut keyed: Vec<(u64, u32)> = points_mm
        .par_iter()
        .zip(0..points_mm.len() as u32)
        .map(|(&place, point)| match order {
            LandmarkOrder::Sweep => (ascending_bits(place[2]), point),
            LandmarkOrder::Priority => (hash(place), point),
        })
        .collect();
    let place = |point: u32| points_mm[point as usize];
    let compare = |a: &(u64, u32), b: &(u64, u32)| -> Ordering {
        a.0.cmp(&b.0).then_with(|| by_coordinates(place(a.1), place(b.1)))
    };
    keyed.par_sort_unstable_by(compare);
    keyed.into_iter().map(|(_, point)| point).collect()
}

/// Whole numbers that ascend as finite values do.
pub(super) fn ascending_bits(value: f64) -> u64 {
    let bits = value.to_bits();
    if bits >> 63 == 1 { !bits } else { bits | 1 << 63 }
}

/// A number for a place that any power of two as scale leaves as it is: from mantissas, signs and ratios of powers.
pub(super) fn hash(place: PointMm) -> u64 {
    let first = place.iter().find(|&&value| value != 0.0).map_or(0, |&value| power(value));
    place.iter().fold(0x9e37_79b9_7f4a_7c15, |sum, &value| {
        let ratio = if value == 0.0 { u64::MAX } else { power(value).wrapping_sub(first) };
        let mantissa = value.to_bits() & !(POWER_MASK << 52);
        mixed(mixed(sum ^ mantissa) ^ ratio)
    })
}

fn power(value: f64) -> u64 {
    value.to_bits() >> 52 & POWER_MASK
}

/// The mixer of splitmix64 (G. L. Steele, D. Lea, C. H. Flood, Fast splittable pseudorandom number generators, 2014).
fn mixed(sum: u64) -> u64 {
    let sum = (sum ^ sum >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let sum = (sum ^ sum >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    sum ^ sum >> 31
}

const POWER_MASK: u64 = 0x7ff;
/// No landmark found yet.
pub(super) const FAR: u8 = u8::MAX;
