//! Samples along a curve, as far apart as a condition lets them be.

use asphera_geometry::side;

use super::SampledLine;
use super::fine::FineLine;
use crate::triangulation::distance_mm;

/// How far apart samples may be; every bound that is given holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spacing {
    /// Every place of the curve has a sample nearer than this times its local feature size.
    pub epsilon: Option<f64>,
    /// Every place has a sample nearer than this times the least local feature size between the two samples beside it.
    pub rho: Option<f64>,
    /// No place is farther than this from the side between the two samples beside it, mm.
    pub chord_mm: Option<f64>,
}

impl Spacing {
    /// About the least distance of samples where the local feature size is so many mm.
    pub(super) fn finest_mm(&self, lfs_mm: f64) -> f64 {
        let by_feature = self.epsilon.or(self.rho).map(|bound| bound * lfs_mm);
        // A chord of a circle as wide as the feature: sagitta s spans 2·√(2·r·s).
        let by_chord = self.chord_mm.map(|chord_mm| 2.0 * (2.0 * lfs_mm * chord_mm).sqrt());
        by_feature.unwrap_or(f64::INFINITY).min(by_chord.unwrap_or(f64::INFINITY))
    }

    /// Whether all places between two of a line meet the bounds with samples at these two.
    fn holds(&self, line: &FineLine, from: usize, to: usize) -> bool {
        let count = line.places.len();
        let place = |index: usize| line.places[index % count];
        let lfs_mm = |index: usize| line.lfs_mm[index % count];
        let ends = [place(from), place(to)];
        let reach_mm = (from..=to).map(lfs_mm).fold(f64::INFINITY, f64::min);
        (from + 1..to).all(|index| {
            let at = place(index);
            let near_mm = distance_mm(at, ends[0]).min(distance_mm(at, ends[1]));
            self.epsilon.is_none_or(|epsilon| near_mm < epsilon * lfs_mm(index))
                && self.rho.is_none_or(|rho| near_mm < rho * reach_mm)
                && self.chord_mm.is_none_or(|chord| side::distance_mm(ends, at) <= chord)
        })
    }
}

/// The samples of a line: corners and ends, and between them each as far from the one before as the bounds let it be.
pub(super) fn samples_of(line: &FineLine, spacing: &Spacing) -> SampledLine {
    let count = line.places.len();
    let mut fixed: Vec<usize> = (0..count).filter(|&index| line.is_corner[index]).collect();
    match line.closed {
        true if fixed.is_empty() => fixed.push(0),
        true => {}
        false => {
            fixed.extend([0, count - 1]);
            fixed.sort_unstable();
            fixed.dedup();
        }
    }
    let mut chosen = Vec::new();
    for (number, &start) in fixed.iter().enumerate() {
        let end = match fixed.get(number + 1) {
            Some(&next) => next,
            None if line.closed => fixed[0] + count,
            None => {
                chosen.push(start);
                break;
            }
        };
        let mut from = start;
        while from < end {
            chosen.push(from % count);
            let mut to = from + 1;
            while to < end && spacing.holds(line, from, to + 1) {
                to += 1;
            }
            from = to;
        }
    }
    let pick = |index: &usize| (line.places[*index], line.normals[*index], line.lfs_mm[*index]);
    let mut sampled = SampledLine { closed: line.closed, ..SampledLine::default() };
    for (place, normal, lfs_mm) in chosen.iter().map(pick) {
        sampled.places_mm.push(place);
        sampled.normals.push(normal);
        sampled.lfs_mm.push(lfs_mm);
    }
    sampled
}
