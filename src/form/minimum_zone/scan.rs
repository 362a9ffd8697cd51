//! All points at one place: which of every block stick out most.

use rayon::prelude::*;

use super::residuals::Residuals;

/// What stands out of one block of points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extremes {
    /// Index and distance in mm of the highest point; of equal ones the first.
    pub(super) high: Option<(usize, f64)>,
    /// The same of the lowest.
    pub(super) low: Option<(usize, f64)>,
    /// The first point without a distance.
    pub(super) lost: Option<usize>,
}

/// Highest and lowest distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) high_mm: f64,
    pub(super) low_mm: f64,
}

impl Span {
    pub(super) fn of(distances: impl Iterator<Item = f64>) -> Span {
        let none = Span { high_mm: f64::NEG_INFINITY, low_mm: f64::INFINITY };
        distances
            .fold(none, |span, d| Span { high_mm: span.high_mm.max(d), low_mm: span.low_mm.min(d) })
    }

    /// Middle of the zone: that of the span if the zone floats, else the surface.
    pub(super) fn centre_mm(self, floating: bool) -> f64 {
        if floating { 0.5 * (self.high_mm + self.low_mm) } else { 0.0 }
    }

    /// Half the width of the zone.
    pub(super) fn half_mm(self, floating: bool) -> f64 {
        if floating {
            0.5 * (self.high_mm - self.low_mm)
        } else {
            self.high_mm.abs().max(self.low_mm.abs())
        }
    }
}

/// Extremes of every block of consecutive points. `O(n)`.
pub(super) fn scan<R: Residuals>(problem: &R, at: &R::Place) -> Vec<Extremes> {
    (0..problem.len().div_ceil(BLOCK))
        .into_par_iter()
        .with_min_len(TASK)
        .map(|block| {
            let range = block * BLOCK..((block + 1) * BLOCK).min(problem.len());
            let mut distances = Vec::with_capacity(range.len());
            problem.distances(at, range.clone(), &mut distances);
            extremes(range.start, &distances)
        })
        .collect()
}

/// The span of all blocks; `None` if a point has no distance.
pub(super) fn span(blocks: &[Extremes]) -> Option<Span> {
    let found = |block: &Extremes| {
        block.lost.is_none().then_some([block.high, block.low]).into_iter().flatten().flatten()
    };
    let whole = blocks.iter().all(|block| block.lost.is_none());
    whole.then(|| Span::of(blocks.iter().flat_map(found).map(|(_, distance_mm)| distance_mm)))
}

fn extremes(start: usize, distances: &[f64]) -> Extremes {
    let mut extremes = Extremes { high: None, low: None, lost: None };
    for (index, &d) in (start..).zip(distances) {
        if d.is_nan() {
            extremes.lost = extremes.lost.or(Some(index));
            continue;
        }
        if extremes.high.is_none_or(|(_, high)| d > high) {
            extremes.high = Some((index, d));
        }
        if extremes.low.is_none_or(|(_, low)| d < low) {
            extremes.low = Some((index, d));
        }
    }
    extremes
}

/// Points of a block: few enough that a ring or line of a scan has several blocks.
pub(super) const BLOCK: usize = 512;
/// Blocks a parallel task takes at least.
const TASK: usize = 8;
