//! The points that an edge carries, and what that costs.

use super::ends::Ends;
use crate::{PlaceMm, SampleId};

/// The points of an edge.
#[derive(Clone, Debug, Default)]
pub(super) struct Load {
    pub(super) samples: Vec<SampleId>,
    /// Whether they go onto the edge; else each goes to the nearer end.
    pub(super) is_along: bool,
    pub(super) cost_mm2: f64,
    /// The part of the cost across the edge, if they go onto it.
    pub(super) across_mm2: f64,
}

impl Load {
    pub(super) fn new(ends: &Ends, samples: Vec<SampleId>, places: &[PlaceMm]) -> Load {
        let at = |sample: SampleId| places[sample as usize];
        let cost = Cost::of(ends, samples.iter().map(|&sample| at(sample)), &mut Vec::new());
        Load {
            is_along: cost.is_along(),
            cost_mm2: cost.least_mm2(),
            across_mm2: cost.across_mm2,
            samples,
        }
    }
}

/// What it costs to carry points onto an edge, and to its ends.
pub(super) struct Cost {
    across_mm2: f64,
    along_mm2: f64,
    to_ends_mm2: f64,
}

impl Cost {
    /// `feet` is memory to work in.
    pub(super) fn of(
        ends: &Ends,
        places: impl ExactSizeIterator<Item = PlaceMm>,
        feet: &mut Vec<f64>,
    ) -> Cost {
        let count = places.len();
        let mut cost = Cost { across_mm2: 0.0, along_mm2: 0.0, to_ends_mm2: 0.0 };
        feet.clear();
        for place in places {
            let across_mm = ends.across_mm(place);
            cost.across_mm2 += across_mm * across_mm;
            cost.to_ends_mm2 += ends.end_distance_mm2(place);
            feet.push(ends.along_mm(place));
        }
        if cost.across_mm2 >= cost.to_ends_mm2 {
            // Going along can only add to that.
            cost.along_mm2 = f64::INFINITY;
            return cost;
        }
        feet.sort_unstable_by(f64::total_cmp);
        let stretch_mm = ends.length_mm / count as f64;
        cost.along_mm2 = count as f64 * stretch_mm * stretch_mm / 12.0;
        for (index, foot_mm) in feet.iter().enumerate() {
            let off_mm = foot_mm - (index as f64 + 0.5) * stretch_mm;
            cost.along_mm2 += off_mm * off_mm;
        }
        cost
    }

    fn is_along(&self) -> bool {
        self.across_mm2 + self.along_mm2 < self.to_ends_mm2
    }

    pub(super) fn least_mm2(&self) -> f64 {
        (self.across_mm2 + self.along_mm2).min(self.to_ends_mm2)
    }
}
