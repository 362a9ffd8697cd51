//! Where a large batch of scan lines is cut in two: at a line near its middle.

use std::ops::Range;

use asphera_geometry::predicates::Place;

use super::runs::{Axis, Run, SCATTERED, runs};

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
    // Of scattered points a few tell that they are.
    let few = window.start..window.start + window.len() / 16;
    runs(few.clone().map(&place), &mut found);
    if 2 * found.len() > few.len() {
        return None;
    }
    runs(window.clone().map(&place), &mut found);
    if found.len() > window.len() / SCATTERED {
        return None;
    }
    // The window may have cut the first and the last.
    let whole = found.get(1..found.len().saturating_sub(1))?;
    let longest = whole.iter().map(|run| run.points.count).max()?;
    // Both blocks have the seam: they are alike if its middle is that of the batch. Of one that leads around
    // it is the start, lest most of a ring be left unfinished beside it.
    let from_middle = |index: usize| {
        let (run, next) = (&whole[index], &whole[index + 1..]);
        let Range { start, end } = range(run);
        if leads_around(run, next) { 2 * start } else { start + end }.abs_diff(window.len())
    };
    let mut order: Vec<usize> = (0..whole.len()).collect();
    order.sort_by_cached_key(|&index| from_middle(index));
    let place = |index: usize| place(window.start + index);
    let seam = order.into_iter().find_map(|index| {
        let (run, next) = whole[index..].split_first()?;
        if leads_around(run, next) {
            let last = closes(run.points.first, next[2].points.first..window.len(), place)?;
            return Some(Seam { points: run.points.first..last + 1, closed: true });
        }
        let is_line = 4 * run.points.count >= 3 * longest && run.points.count >= LEAST_POINTS;
        is_line.then(|| Seam { points: range(run), closed: false })
    })?;
    let [start, end] = [seam.points.start, seam.points.end].map(|index| window.start + index);
    Some(Seam { points: start..end, ..seam })
}

/// The points of a run of which each follows the one before it.
fn range(run: &Run) -> Range<usize> {
    run.points.first..run.points.first + run.points.count
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

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn seam_of(places: &[Place]) -> Option<Seam> {
        seam(places.len(), |index| places[index])
    }

    /// Lines of 50 points, every other one backwards if they turn.
    fn lines(count: usize, turning: bool) -> Vec<Place> {
        let at = |index: usize| {
            let (line, step) = (index / 50, index % 50);
            let step = if turning && line % 2 == 1 { 49 - step } else { step };
            [step as f64, line as f64]
        };
        (0..count).map(at).collect()
    }

    #[test]
    fn lines_are_cut_at_a_whole_one_next_to_the_middle() {
        for turning in [false, true] {
            let found = seam_of(&lines(2_000, turning));
            assert_eq!(found, Some(Seam { points: 950..1_000, closed: false }), "{turning}");
            // The batch begins within a line.
            let found = seam_of(&lines(2_000, turning)[20..]);
            assert_eq!(found, Some(Seam { points: 980..1_030, closed: false }), "{turning}");
        }
    }

    #[test]
    fn a_spiral_is_cut_at_a_turn() {
        let spiral: Vec<Place> = (0..4_000)
            .map(|index| {
                let angle = (2.0 * TAU * f64::from(index)).sqrt();
                [angle / TAU * angle.cos(), angle / TAU * angle.sin()]
            })
            .collect();
        let Some(Seam { points, closed: true }) = seam_of(&spiral) else { panic!("it turns") };
        let angle = |index: usize| (2.0 * TAU * index as f64).sqrt();
        let turned = angle(points.end - 1) - angle(points.start);
        assert!((turned - TAU).abs() < 0.03, "{points:?}: {turned}");
        assert!(points.start.abs_diff(2_000) < 100, "{points:?}");
    }

    #[test]
    fn rings_are_cut_at_one_of_as_many_points() {
        // Far from the centre the next ring is nearer than the next point.
        let rings: Vec<Place> = (0..8_000)
            .map(|index| {
                let (radius, angle) = (1e3 + f64::from(index / 200), f64::from(index % 200));
                let angle = angle / 200.0 * TAU;
                [radius * angle.cos(), radius * angle.sin()]
            })
            .collect();
        let Some(Seam { points, closed: true }) = seam_of(&rings) else { panic!("they turn") };
        assert!((199..=201).contains(&points.len()), "{points:?}");
    }

    #[test]
    fn there_is_none_in_what_is_no_scan_of_many_lines() {
        assert_eq!(seam_of(&[]), None);
        assert_eq!(seam_of(&[[1.0, 1.0]; 100]), None);
        let line: Vec<Place> = (0..1_000).map(|index| [f64::from(index), 0.0]).collect();
        assert_eq!(seam_of(&line), None);
        let scattered: Vec<Place> = (0..1_000)
            .map(|index| [(f64::from(index) * 0.618).fract(), (f64::from(index) * 0.414).fract()])
            .collect();
        assert_eq!(seam_of(&scattered), None);
        // Lines as long as the window.
        assert_eq!(seam_of(&lines(150, true)), None);
    }
}
