//! Where a large batch of scan lines is cut in two: at a line near its middle.

use std::ops::Range;

use super::runs::{Axis, Run, runs};
use super::sheet::SCATTERED;
use crate::exact::Place;

/// Points of a batch, one after the other, that shall part what comes before them from what comes after.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Seam {
    pub(super) points: Range<usize>,
    /// Whether they lead around, so that the last is joined with the first; else they lead from one
    /// side of the hull to another.
    pub(super) closed: bool,
}

/// The line at which a batch of `count` points may be cut, if it is one of many.
///
/// It only looks promising: whether it parts the points is told when both blocks are meshed. Looks at
/// a quarter of the points.
pub(super) fn seam(count: usize, place: impl Fn(usize) -> Place) -> Option<Seam> {
    let window = count / 8 * 3..count / 8 * 5;
    let mut found = Vec::new();
    runs(window.clone().map(&place), &mut found);
    if found.len() > window.len() / SCATTERED {
        return None;
    }
    // The window may have cut the first and the last.
    let whole = found.get(1..found.len().saturating_sub(1))?;
    let longest = whole.iter().map(|run| run.points.len()).max()?;
    let from_middle = |run: &Run| run.points.start.abs_diff(window.len() / 2);
    let mut order: Vec<usize> = (0..whole.len()).collect();
    order.sort_by_key(|&index| from_middle(&whole[index]));
    let place = |index: usize| place(window.start + index);
    let seam = order.into_iter().find_map(|index| {
        let (run, next) = whole[index..].split_first()?;
        if leads_around(run, next) {
            let last = closes(run.points.start, next[2].points.start..window.len(), place)?;
            return Some(Seam { points: run.points.start..last + 1, closed: true });
        }
        let is_line = 4 * run.points.len() >= 3 * longest && run.points.len() >= LEAST_POINTS;
        is_line.then(|| Seam { points: run.points.clone(), closed: false })
    })?;
    let [start, end] = [seam.points.start, seam.points.end].map(|index| window.start + index);
    Some(Seam { points: start..end, ..seam })
}

/// Whether a run and the three after it each turn by a right angle to the same side.
fn leads_around(run: &Run, next: &[Run]) -> bool {
    let axes = |runs: &[Run]| -> Option<[Axis; 3]> {
        let [a, b, c, ..] = runs else { return None };
        Some([a.axis?, b.axis?, c.axis?])
    };
    match (run.axis, axes(next)) {
        (Some(first), Some([second, third, fourth])) => {
            third == first.reversed() && fourth == second.reversed() && !second.is_parallel(first)
        }
        _ => false,
    }
}

/// The last of the points that lead from `first` around and back to it: the next one would
/// lie past it, or no nearer.
fn closes(first: usize, within: Range<usize>, place: impl Fn(usize) -> Place) -> Option<usize> {
    let start = place(first);
    let off = |index: usize| {
        let [x, y] = place(index);
        [x - start[0], y - start[1]]
    };
    let dot = |a: Place, b: Place| a[0] * b[0] + a[1] * b[1];
    (within.start..within.end.saturating_sub(1)).find(|&index| {
        let (here, next) = (off(index), off(index + 1));
        dot(here, next) < 0.0 || dot(next, next) >= dot(here, here)
    })
}

/// A line of fewer points is none.
const LEAST_POINTS: usize = 3;
