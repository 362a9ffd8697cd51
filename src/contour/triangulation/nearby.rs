//! The samples about another, nearest first, found along the edges of the triangulation.

use std::cmp::Ordering;
use std::collections::{BTreeSet, BinaryHeap};

use asphera_geometry::predicates::compare_distances;

use super::Triangulation;
use crate::samples::{PlaceMm, SampleId};

/// Samples in the order of their distance.
///
/// The Delaunay edges among the samples of any disc connect them. So the next nearest sample is always a neighbour of one
/// that was found before, and a heap of the neighbours met suffices.
pub(super) struct Nearby<'a> {
    triangulation: &'a Triangulation,
    from_mm: PlaceMm,
    met: BTreeSet<SampleId>,
    heap: BinaryHeap<Candidate>,
}

/// A sample that was met; the nearest is the greatest.
struct Candidate {
    from_mm: PlaceMm,
    at_mm: PlaceMm,
    sample: SampleId,
}

impl<'a> Nearby<'a> {
    pub(super) fn new(triangulation: &'a Triangulation, sample: SampleId) -> Nearby<'a> {
        let from_mm = triangulation.place(sample);
        let mut nearby = Nearby {
            triangulation,
            from_mm,
            met: BTreeSet::from([sample]),
            heap: BinaryHeap::new(),
        };
        nearby.meet(sample);
        nearby
    }

    /// Puts the neighbours of a sample among the candidates.
    fn meet(&mut self, sample: SampleId) {
        for spoke in self.triangulation.spokes(sample) {
            if self.met.insert(spoke.to) {
                self.heap.push(Candidate {
                    from_mm: self.from_mm,
                    at_mm: self.triangulation.place(spoke.to),
                    sample: spoke.to,
                });
            }
        }
    }
}

impl Iterator for Nearby<'_> {
    type Item = SampleId;

    fn next(&mut self) -> Option<SampleId> {
        let Candidate { sample, .. } = self.heap.pop()?;
        self.meet(sample);
        Some(sample)
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Candidate) -> Ordering {
        compare_distances(self.from_mm, other.at_mm, self.from_mm, self.at_mm)
            .then(other.sample.cmp(&self.sample))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Candidate) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Candidate) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Candidate {}
