//! Sides of closed lines by their height.

use super::ring_sides;
use crate::predicates::Place;

/// Sides in horizontal strips of equal height; one that passes through several stands in each.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Strips {
    low_mm: f64,
    height_mm: f64,
    /// Where the sides of a strip begin; one more than there are strips.
    starts: Vec<u32>,
    sides: Vec<[Place; 2]>,
}

impl Strips {
    pub(super) fn of(rings: &[Vec<Place>]) -> Strips {
        let sides: Vec<[Place; 2]> =
            rings.iter().flat_map(|ring| ring_sides(ring)).map(|(p, q)| [p, q]).collect();
        let heights = || sides.iter().flatten().map(|place| place[1]);
        let low_mm = heights().fold(f64::INFINITY, f64::min);
        let extent_mm = heights().fold(f64::NEG_INFINITY, f64::max) - low_mm;
        // As many strips as leave a side in three of them on the average.
        let travelled_mm: f64 = sides.iter().map(|[p, q]| (q[1] - p[1]).abs()).sum();
        let count = (2.0 * sides.len() as f64 * extent_mm / travelled_mm).floor().max(1.0);
        let count = if count.is_finite() { count as usize } else { 1 };
        let mut strips = Strips {
            low_mm,
            height_mm: extent_mm / count as f64,
            starts: vec![0; count + 1],
            sides: Vec::new(),
        };
        let ranges: Vec<[usize; 2]> = sides.iter().map(|side| strips.range(side)).collect();
        for &[first, last] in &ranges {
            strips.starts[first + 1..=last + 1].iter_mut().for_each(|start| *start += 1);
        }
        for strip in 0..count {
            strips.starts[strip + 1] += strips.starts[strip];
        }
        let mut next = strips.starts.clone();
        let mut sorted = vec![[[0.0; 2]; 2]; strips.starts[count] as usize];
        for (&side, &[first, last]) in sides.iter().zip(&ranges) {
            for at in &mut next[first..=last] {
                sorted[*at as usize] = side;
                *at += 1;
            }
        }
        strips.sides = sorted;
        strips
    }

    /// All sides that come within `reach_mm` of a height, some of them more than once unless `reach_mm` is 0.
    pub(super) fn sides(&self, y_mm: f64, reach_mm: f64) -> std::slice::Iter<'_, [Place; 2]> {
        let [first, last] = [self.strip(y_mm - reach_mm), self.strip(y_mm + reach_mm)];
        self.sides[self.starts[first] as usize..self.starts[last + 1] as usize].iter()
    }

    fn range(&self, [p, q]: &[Place; 2]) -> [usize; 2] {
        [self.strip(p[1].min(q[1])), self.strip(p[1].max(q[1]))]
    }

    /// The strip of a height, the outermost beyond all. Rounding errs for sides and places alike: it grows with the height.
    fn strip(&self, y_mm: f64) -> usize {
        let share = ((y_mm - self.low_mm) / self.height_mm).max(0.0);
        // Numbers beyond the range of an integer, and none, become its ends.
        (share as usize).min(self.starts.len() - 2)
    }
}
