//! The samples about another, nearest first, found along the edges of the triangulation.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use asphera_geometry::predicates::{certain_distances, compare_distances, squared_distance};

use super::Triangulation;
use crate::samples::{PlaceMm, SampleId};

/// Samples in the order of their distance.
///
/// The Delaunay edges among the samples of any disc connect them. So the next nearest sample is always a neighbour of one
/// that was found before, and a heap of the neighbours met suffices.
pub(super) struct Nearby<'a> {
    triangulation: &'a Triangulation,
    from_mm: PlaceMm,
    met: Met,
    heap: BinaryHeap<Candidate>,
}

/// A sample that was met; the nearest is the greatest.
struct Candidate {
    squared_mm2: f64,
    from_mm: PlaceMm,
    at_mm: PlaceMm,
    sample: SampleId,
}

impl<'a> Nearby<'a> {
    pub(super) fn new(triangulation: &'a Triangulation, sample: SampleId) -> Nearby<'a> {
        let from_mm = triangulation.place(sample);
        let mut met = Met::new();
        met.insert(sample);
        let mut nearby = Nearby { triangulation, from_mm, met, heap: BinaryHeap::new() };
        nearby.meet(sample);
        nearby
    }

    /// Puts the neighbours of a sample among the candidates.
    fn meet(&mut self, sample: SampleId) {
        for spoke in self.triangulation.spokes(sample) {
            if self.met.insert(spoke.to) {
                let (from_mm, at_mm) = (self.from_mm, self.triangulation.place(spoke.to));
                let squared_mm2 = squared_distance(from_mm, at_mm);
                self.heap.push(Candidate { squared_mm2, from_mm, at_mm, sample: spoke.to });
            }
        }
    }
}

/// The nearest other sample that is wanted, of equally near ones that of the smallest number; none where no neighbour is wanted.
///
/// As [`Nearby`], without its order: what is farther than the best one so far is not asked about.
pub(super) fn nearest_of(
    triangulation: &Triangulation,
    sample: SampleId,
    is_wanted: impl Fn(SampleId) -> bool,
) -> Option<SampleId> {
    let from_mm = triangulation.place(sample);
    let candidate = |sample: SampleId| {
        let at_mm = triangulation.place(sample);
        Candidate { squared_mm2: squared_distance(from_mm, at_mm), from_mm, at_mm, sample }
    };
    let neighbours = triangulation.spokes(sample).iter().map(|spoke| spoke.to);
    let mut best = neighbours.filter(|&other| is_wanted(other)).map(candidate).max()?;
    let mut met = Met::new();
    met.insert(sample);
    let mut open = vec![sample];
    while let Some(at) = open.pop() {
        for spoke in triangulation.spokes(at) {
            let other = candidate(spoke.to);
            if other > best && met.insert(spoke.to) {
                if is_wanted(spoke.to) {
                    best = other;
                }
                open.push(spoke.to);
            }
        }
    }
    Some(best.sample)
}

/// The samples that were met: few as a rule, so they lie in a small table, each in the first free place from that of its number on.
struct Met {
    /// A power of two of places, at most half of them taken.
    places: Vec<SampleId>,
    taken: usize,
}

impl Met {
    fn new() -> Met {
        Met { places: vec![FREE; LEAST_PLACES], taken: 0 }
    }

    /// Takes note of a sample; false if it was met before.
    fn insert(&mut self, sample: SampleId) -> bool {
        if 2 * self.taken >= self.places.len() {
            let wider = vec![FREE; 4 * self.places.len()];
            let places = std::mem::replace(&mut self.places, wider);
            self.taken = 0;
            places.into_iter().filter(|&it| it != FREE).for_each(|it| {
                self.insert(it);
            });
        }
        let mask = self.places.len() - 1;
        // Fibonacci hashing (D. E. Knuth, The Art of Computer Programming 3, section 6.4): neighbours have numbers close together.
        let mut at = (sample.wrapping_mul(0x9E37_79B9) >> 16) as usize & mask;
        while self.places[at] != FREE {
            if self.places[at] == sample {
                return false;
            }
            at = (at + 1) & mask;
        }
        self.places[at] = sample;
        self.taken += 1;
        true
    }
}

/// No sample has this number: there are fewer.
const FREE: SampleId = SampleId::MAX;
const LEAST_PLACES: usize = 64;

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
        certain_distances(other.squared_mm2, self.squared_mm2)
            .unwrap_or_else(|| {
                compare_distances(self.from_mm, other.at_mm, self.from_mm, self.at_mm)
            })
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
