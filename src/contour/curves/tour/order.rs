//! A tour as a list of samples that can be reversed in part.

use crate::{Graph, SampleId};

/// A closed tour.
pub(super) struct Order {
    samples: Vec<SampleId>,
    /// The place of every sample in the list.
    places: Vec<usize>,
}

impl Order {
    pub(super) fn new(samples: Vec<SampleId>) -> Order {
        let mut places = vec![0; samples.len()];
        for (place, &sample) in samples.iter().enumerate() {
            places[sample as usize] = place;
        }
        Order { samples, places }
    }

    pub(super) fn len(&self) -> usize {
        self.samples.len()
    }

    /// The sample after (`true`) or before another.
    pub(super) fn beside(&self, sample: SampleId, is_after: bool) -> SampleId {
        let (place, count) = (self.places[sample as usize], self.len());
        let next = if is_after { place + 1 } else { place + count - 1 };
        self.samples[next % count]
    }

    /// Replaces the edges a-b and c-d by a-c and b-d. b must lie on the side of a on which d lies of c.
    pub(super) fn exchange(&mut self, [a, b]: [SampleId; 2], [c, d]: [SampleId; 2]) {
        match self.beside(a, true) == b && self.beside(c, true) == d {
            true => self.reverse(b, c),
            false => self.reverse(a, d),
        }
    }

    /// Reverses the way from one sample on to another, or all but that: as a tour it is the same.
    fn reverse(&mut self, from: SampleId, to: SampleId) {
        let count = self.len();
        let [mut low, mut high] = [from, to].map(|sample| self.places[sample as usize]);
        let mut length = (high + count - low) % count + 1;
        if 2 * length > count {
            (low, high) = ((high + 1) % count, (low + count - 1) % count);
            length = count - length;
        }
        for _ in 0..length / 2 {
            self.samples.swap(low, high);
            for place in [low, high] {
                self.places[self.samples[place] as usize] = place;
            }
            (low, high) = ((low + 1) % count, (high + count - 1) % count);
        }
    }

    pub(super) fn graph(&self) -> Graph {
        let next = self.samples.iter().cycle().skip(1);
        Graph::new(self.samples.iter().zip(next).map(|(&from, &to)| [from, to]))
    }
}
