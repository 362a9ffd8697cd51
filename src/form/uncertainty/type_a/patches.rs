//! Patches of a part: as many neighbouring points each, with their means.

use crate::uncertainty::halve::halve;
use crate::uncertainty::linear::Linear;

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

/// Halves the points of some weight at the median of the longer extent, until they are [`MOST`] patches or
/// one point each. `O(n·log n + n·p)`.
pub(super) fn patches(linear: &Linear) -> Vec<Patch> {
    let mut order: Vec<usize> =
        (0..linear.len()).filter(|&place| linear.weights[place] > 0.0).collect();
    let mut groups = Vec::new();
    split(&mut order, &linear.places_mm, MOST, &mut groups);
    groups.iter().map(|group| patch(group, linear)).collect()
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

fn patch(group: &[usize], linear: &Linear) -> Patch {
    let p = linear.parameters.len();
    let mut patch =
        Patch { place_mm: [0.0; 2], row: vec![0.0; p], deviation_mm: 0.0, gain: vec![0.0; p] };
    let mut weights = 0.0;
    for &place in group {
        let weight = linear.weights[place];
        weights += weight;
        patch.deviation_mm += weight * linear.distances_mm[place];
        patch.row.iter_mut().zip(linear.row(place)).for_each(|(sum, entry)| *sum += weight * entry);
        patch.gain.iter_mut().zip(linear.gain(place)).for_each(|(sum, entry)| *sum += entry);
        for axis in 0..2 {
            patch.place_mm[axis] += linear.places_mm[place][axis];
        }
    }
    patch.place_mm = patch.place_mm.map(|sum| sum / group.len() as f64);
    patch.deviation_mm /= weights;
    patch.row.iter_mut().for_each(|sum| *sum /= weights);
    patch
}

/// Patches of one part, a power of two: so many that waves down to a sixteenth of a round part are seen, so
/// few that their covariance matrix is factorised in some milliseconds.
const MOST: usize = 256;
