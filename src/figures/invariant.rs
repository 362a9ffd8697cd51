//! The rotationally invariant part of a sample.

use std::num::NonZeroU16;

use super::Sample;

/// Azimuthal mean as a function of the radius: a broken line through knots.
///
/// It is the least-squares one, so that it and what it leaves are orthogonal over the sample, and gaps
/// only widen the distance of knots instead of leaving holes. Knots lie at even distances, but an interval
/// with fewer than two distinct radii is joined to its inner neighbour (the innermost to its outer one).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Invariant {
    knots_mm: Vec<f64>,
    heights_nm: Vec<f64>,
}

impl Invariant {
    /// The invariant part with up to `rings` intervals. The sample must not be empty. `O(n)`.
    pub(crate) fn new(sample: &Sample, rings: NonZeroU16) -> Invariant {
        let radii: Vec<f64> =
            sample.places_mm().iter().map(|place| place[0].hypot(place[1])).collect();
        let knots_mm = knots(sample, &radii, rings);
        if knots_mm.len() == 1 {
            let values = sample.values_nm();
            return Invariant { knots_mm, heights_nm: vec![sample.mean(|i| values[i])] };
        }
        // Normal equations of hat functions: a symmetric tridiagonal matrix.
        let count = knots_mm.len();
        let (mut diagonal, mut beside, mut right) =
            (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        let points = radii.iter().zip(sample.values_nm()).zip(sample.areas());
        for ((&radius_mm, value), area) in points {
            let (left, outer) = hat(&knots_mm, radius_mm);
            let inner = 1.0 - outer;
            diagonal[left] += area * inner * inner;
            beside[left] += area * inner * outer;
            diagonal[left + 1] += area * outer * outer;
            right[left] += area * inner * value;
            right[left + 1] += area * outer * value;
        }
        for i in 1..count {
            let factor = beside[i - 1] / diagonal[i - 1];
            diagonal[i] -= factor * beside[i - 1];
            right[i] -= factor * right[i - 1];
        }
        let mut heights_nm = vec![0.0; count];
        for i in (0..count).rev() {
            let outer = heights_nm.get(i + 1).map_or(0.0, |height| beside[i] * height);
            heights_nm[i] = (right[i] - outer) / diagonal[i];
        }
        Invariant { knots_mm, heights_nm }
    }

    /// Its height in nm at a distance from the axis; within the sampled radii.
    pub(crate) fn at(&self, radius_mm: f64) -> f64 {
        if self.knots_mm.len() == 1 {
            return self.heights_nm[0];
        }
        let (left, outer) = hat(&self.knots_mm, radius_mm);
        self.heights_nm[left] + outer * (self.heights_nm[left + 1] - self.heights_nm[left])
    }
}

/// Rings that leave some sixteen evenly spread points in the innermost one.
pub(crate) fn usual_rings(sample: &Sample) -> NonZeroU16 {
    let rings = (sample.weighted() as f64).sqrt() / 4.0;
    NonZeroU16::new(rings.min(MOST_USUAL_RINGS) as u16).unwrap_or(NonZeroU16::MIN)
}

/// Ends of the intervals, ascending. One knot alone if all radii are the same.
fn knots(sample: &Sample, radii: &[f64], rings: NonZeroU16) -> Vec<f64> {
    let weighted = radii.iter().zip(sample.areas()).filter(|&(_, &area)| area > 0.0);
    let weighted: Vec<f64> = weighted.map(|(&radius, _)| radius).collect();
    let low = weighted.iter().copied().fold(f64::INFINITY, f64::min);
    let high = weighted.iter().copied().fold(0.0, f64::max);
    let same = SAME_RADIUS * high;
    if high - low <= same {
        return vec![low];
    }
    let intervals = usize::from(rings.get());
    let width = (high - low) / intervals as f64;
    let mut ranges = vec![[f64::INFINITY, f64::NEG_INFINITY]; intervals];
    for radius in weighted {
        let interval = (((radius - low) / width) as usize).min(intervals - 1);
        let [least, most] = &mut ranges[interval];
        *least = least.min(radius);
        *most = most.max(radius);
    }
    // With two distinct radii in every interval each hat function has a radius of its own under it
    // (Schoenberg & Whitney, Trans. Am. Math. Soc. 74 (1953) 246), so the matrix is regular.
    let distinct = |[least, most]: [f64; 2]| most - least > same.max(DISTINCT * width);
    let mut knots = vec![low];
    let mut open = [f64::INFINITY, f64::NEG_INFINITY];
    for (interval, [least, most]) in ranges.into_iter().enumerate() {
        open = [open[0].min(least), open[1].max(most)];
        if distinct(open) {
            knots.push(low + width * (interval + 1) as f64);
            open = [f64::INFINITY, f64::NEG_INFINITY];
        }
    }
    // What is left at the outer end joins the interval before it.
    if knots.len() == 1 {
        knots.push(high);
    }
    *knots.last_mut().expect("there are two knots") = high;
    knots
}

/// The interval of a radius and how far it lies towards its outer knot, 0 to 1. Two knots at least.
fn hat(knots_mm: &[f64], radius_mm: f64) -> (usize, f64) {
    let last = knots_mm.len() - 2;
    let left = knots_mm.partition_point(|&knot| knot <= radius_mm).saturating_sub(1).min(last);
    let along = (radius_mm - knots_mm[left]) / (knots_mm[left + 1] - knots_mm[left]);
    (left, along.clamp(0.0, 1.0))
}

/// More rings resolve no form any more.
const MOST_USUAL_RINGS: f64 = 256.0;
/// Relative difference below which two radii are the same.
pub(crate) const SAME_RADIUS: f64 = 1e-9;
/// Radii of an interval that lie closer than this share of its width do not hold both its ends.
const DISTINCT: f64 = 0.1;
