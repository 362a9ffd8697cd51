//! Patches of a part: as many neighbouring points each, with their means.

use crate::distribution::fisher_cdf;
use crate::halve::halve;
use crate::linear::Linear;

/// Neighbouring points, or a single one.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Mean place, part frame, mm.
    pub(super) place_mm: [f64; 2],
    /// Means of the derivatives and of the deviations in mm, each point by its weight.
    pub(super) row: Vec<f64>,
    pub(super) deviation_mm: f64,
    /// What an error of 1 mm of the whole patch takes off the parameters.
    pub(super) gain: Vec<f64>,
}

/// Sums over the deviations of a patch, each point by its weight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    pub(super) points: f64,
    pub(super) weight: f64,
    pub(super) first_mm: f64,
    pub(super) second_mm2: f64,
    /// Of the places, each point alike.
    pub(super) places_mm: [f64; 2],
}

impl Sums {
    pub(super) fn push(&mut self, weight: f64, deviation_mm: f64, place_mm: [f64; 2]) {
        if weight > 0.0 {
            self.points += 1.0;
            self.weight += weight;
            self.first_mm += weight * deviation_mm;
            self.second_mm2 += weight * deviation_mm * deviation_mm;
            (0..2).for_each(|axis| self.places_mm[axis] += place_mm[axis]);
        }
    }

    pub(super) fn mean_place_mm(&self) -> [f64; 2] {
        self.places_mm.map(|sum| sum / self.points)
    }

    pub(super) fn add(&mut self, other: &Sums) {
        self.points += other.points;
        self.weight += other.weight;
        self.first_mm += other.first_mm;
        self.second_mm2 += other.second_mm2;
        (0..2).for_each(|axis| self.places_mm[axis] += other.places_mm[axis]);
    }
}

/// How far the means of patches are from those of independent deviations (analysis of variance in one way: Fisher,
/// Statistical Methods for Research Workers, ch. 7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Independence {
    /// The variance of the means over what the deviations within the patches would leave of it: about 1 where
    /// deviations are independent from point to point.
    pub ratio: f64,
    /// The probability of so large a ratio, or a larger one, if they are.
    pub p: f64,
}

impl Independence {
    /// `None` where there are no points beyond one a patch, no patches beyond the parameters, or no deviations.
    pub(super) fn new(patches: &[Sums], parameters: usize) -> Option<Independence> {
        let points: f64 = patches.iter().map(|sums| sums.points).sum();
        let count = patches.len() as f64;
        let (between_dof, within_dof) = (count - parameters as f64, points - count);
        let between_mm2: f64 = patches.iter().map(|sums| sums.first_mm.powi(2) / sums.weight).sum();
        let all_mm2: f64 = patches.iter().map(|sums| sums.second_mm2).sum();
        let within_mm2 = all_mm2 - between_mm2;
        if between_dof < 1.0 || within_dof < 1.0 || within_mm2 <= ROUNDING * all_mm2 {
            return None;
        }
        let ratio = (between_mm2 / between_dof) / (within_mm2 / within_dof);
        Some(Independence { ratio, p: 1.0 - fisher_cdf(ratio, between_dof, within_dof) })
    }
}

/// Places of [`Linear`] in groups: halves those of some weight at the median of the longer extent, until they are
/// `most` groups, a power of two, or one point each. `O(n·log n)`.
pub(super) fn groups(linear: &Linear, most: usize) -> Vec<Vec<usize>> {
    let mut order: Vec<usize> =
        (0..linear.len()).filter(|&place| linear.weights[place] > 0.0).collect();
    let mut groups = Vec::new();
    split(&mut order, &linear.places_mm, most, &mut groups);
    groups
}

fn split(order: &mut [usize], places_mm: &[[f64; 2]], most: usize, groups: &mut Vec<Vec<usize>>) {
    if most == 1 || order.len() < 2 {
        if !order.is_empty() {
            // The order in which a selection leaves a group must not show in the bits of its means.
            let mut group = order.to_vec();
            group.sort_unstable();
            groups.push(group);
        }
        return;
    }
    let (low, high) = halve(order, places_mm);
    split(low, places_mm, most / 2, groups);
    split(high, places_mm, most / 2, groups);
}

/// The patch of a group, with the sums over its deviations. `O(n·p)`.
pub(super) fn patch(group: &[usize], linear: &Linear) -> (Patch, Sums) {
    let p = linear.parameters.len();
    let mut patch =
        Patch { place_mm: [0.0; 2], row: vec![0.0; p], deviation_mm: 0.0, gain: vec![0.0; p] };
    let mut sums = Sums::default();
    for &place in group {
        let weight = linear.weights[place];
        sums.push(weight, linear.distances_mm[place], linear.places_mm[place]);
        patch.row.iter_mut().zip(linear.row(place)).for_each(|(sum, entry)| *sum += weight * entry);
        patch.gain.iter_mut().zip(linear.gain(place)).for_each(|(sum, entry)| *sum += entry);
    }
    patch.place_mm = sums.mean_place_mm();
    patch.deviation_mm = sums.first_mm / sums.weight;
    patch.row.iter_mut().for_each(|sum| *sum /= sums.weight);
    (patch, sums)
}

/// Patches of one part, a power of two: so many that waves down to a sixteenth of a round part are seen, so
/// few that their covariance matrix is factorised in some milliseconds.
pub(super) const MOST: usize = 256;
/// Share of a sum of squares that is rounding.
const ROUNDING: f64 = 1e-12;
