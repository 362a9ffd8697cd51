//! How a batch is cut into runs of points that follow one another along a line.

use std::ops::Range;

use asphera_geometry::predicates::Place;

/// An axis of the plane with a sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    index: usize,
    sign: f64,
}

impl Axis {
    /// How far along the axis a place lies; no rounding, so places can be compared exactly.
    #[inline(always)]
    pub(super) fn along(self, place: Place) -> f64 {
        self.sign * place[self.index]
    }

    /// How far off the axis a place lies, to one side or the other; no rounding.
    #[inline(always)]
    pub(super) fn across(self, place: Place) -> f64 {
        place[1 - self.index]
    }

    /// Whether three places follow one another along the axis, strictly.
    #[inline(always)]
    pub(super) fn is_between(self, first: Place, middle: Place, last: Place) -> bool {
        self.along(first) < self.along(middle) && self.along(middle) < self.along(last)
    }

    pub(super) fn reversed(self) -> Axis {
        Axis { index: self.index, sign: -self.sign }
    }

    /// Whether two lead along the same line.
    pub(super) fn is_parallel(self, other: Axis) -> bool {
        self.index == other.index
    }

    /// The axis along which a step leads most.
    pub(super) fn of(step: Place) -> Axis {
        let index = usize::from(step[1].abs() > step[0].abs());
        Axis { index, sign: if step[index] < 0.0 { -1.0 } else { 1.0 } }
    }

    /// Whether a step leads along the axis, by at most some 70° off it.
    fn leads(self, step: Place) -> bool {
        let along = self.sign * step[self.index];
        along > 0.0 && along >= 0.36 * step[1 - self.index].abs()
    }
}

/// Numbers of points that follow one another: every `stride`th from the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Track {
    pub(super) first: usize,
    pub(super) count: usize,
    pub(super) stride: usize,
}

impl Track {
    #[inline(always)]
    pub(super) fn at(self, index: usize) -> usize {
        self.first + index * self.stride
    }

    pub(super) fn part(self, indices: Range<usize>) -> Track {
        Track { first: self.at(indices.start), count: indices.len(), ..self }
    }

    /// The same points where numbers begin at another one.
    pub(super) fn from(self, first: usize) -> Track {
        Track { first: self.first + first, ..self }
    }

    pub(super) fn numbers(self) -> impl ExactSizeIterator<Item = usize> + Clone {
        (0..self.count).map(move |index| self.at(index))
    }
}

/// Points that follow one another, and the axis along which they do, if they are more than one.
pub(super) struct Run {
    pub(super) points: Track,
    pub(super) axis: Option<Axis>,
}

/// Cuts a batch into runs, each as long as its steps lead along one axis.
pub(super) fn runs(places: impl ExactSizeIterator<Item = Place>, into: &mut Vec<Run>) {
    into.clear();
    add_runs(Track { first: 0, count: places.len(), stride: 1 }, places, into);
}

/// Cuts a batch in which several lines arrive by turns, a point of each at a time: the runs of each line, one line after
/// the other. As many lines as make the fewest runs; false if that is one, or none does.
pub(super) fn runs_by_turns(
    count: usize,
    place: impl Fn(usize) -> Place,
    into: &mut Vec<Run>,
) -> bool {
    if count < FEWEST {
        return false;
    }
    let cut = |count: usize, lines: usize, into: &mut Vec<Run>| {
        into.clear();
        for first in 0..lines {
            let track = Track { first, count: (count - first).div_ceil(lines), stride: lines };
            add_runs(track, track.numbers().map(&place), into);
        }
        into.len()
    };
    // Of points in no order a few tell that they are.
    let few = count.min(FEW);
    let best = (2..=MOST_LINES).map(|lines| (cut(few, lines, into), lines)).min();
    match best {
        Some((runs, lines)) if runs <= few / 4 => cut(count, lines, into) <= count / SCATTERED,
        _ => false,
    }
}

/// Batches of which more than one point in so many starts a run follow no line.
pub(super) const SCATTERED: usize = 8;

/// Lines by turns that are told from points in no order.
const MOST_LINES: usize = 8;

/// Batches of fewer points are as well inserted point by point.
const FEWEST: usize = 2 * MOST_LINES;

/// So many points tell. In no order every second or third starts a run.
const FEW: usize = 64;

/// Adds the runs of the points of a track.
fn add_runs(track: Track, places: impl Iterator<Item = Place>, into: &mut Vec<Run>) {
    let mut last: Option<Place> = None;
    let start = into.len();
    for (index, place) in places.enumerate() {
        let step = last.map(|last| [place[0] - last[0], place[1] - last[1]]);
        last = Some(place);
        match (into[start..].last_mut(), step) {
            (Some(Run { points, axis: Some(axis) }), Some(step)) if axis.leads(step) => {
                points.count += 1;
            }
            (Some(Run { points, axis: axis @ None }), Some(step)) if step != [0.0; 2] => {
                points.count += 1;
                *axis = Some(Axis::of(step));
            }
            _ => into.push(Run { points: track.part(index..index + 1), axis: None }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(track: Track) -> Range<usize> {
        assert_eq!(track.stride, 1);
        track.first..track.first + track.count
    }

    fn cut(places: &[Place]) -> Vec<(Range<usize>, Option<Axis>)> {
        let mut found = Vec::new();
        runs(places.iter().copied(), &mut found);
        found.into_iter().map(|run| (range(run.points), run.axis)).collect()
    }

    #[test]
    fn a_serpentine_is_cut_where_it_turns() {
        let places = [[0.0, 0.0], [1.0, 0.1], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [0.0, 1.0]];
        let (right, up) = (Axis { index: 0, sign: 1.0 }, Axis { index: 1, sign: 1.0 });
        assert_eq!(cut(&places), [(0..3, Some(right)), (3..6, Some(right.reversed()))]);
        assert_eq!(cut(&[[0.0, 0.0], [0.1, 1.0], [0.0, 5.0]]), [(0..3, Some(up))]);
    }

    #[test]
    fn points_that_stand_still_or_are_alone_have_no_axis() {
        assert_eq!(cut(&[]), []);
        assert_eq!(cut(&[[1.0, 2.0]]), [(0..1, None)]);
        assert_eq!(cut(&[[1.0, 2.0], [1.0, 2.0]]), [(0..1, None), (1..2, None)]);
    }

    /// The tracks of runs and how many runs each has, of so many lines by turns, each `at` a line and a step.
    fn by_turns(
        lines: usize,
        count: usize,
        at: impl Fn(usize, usize) -> Place,
    ) -> Option<Vec<Run>> {
        let mut found = Vec::new();
        runs_by_turns(count, |index| at(index % lines, index / lines), &mut found).then_some(found)
    }

    #[test]
    fn lines_by_turns_are_runs_one_line_after_the_other() {
        for lines in 2..=8 {
            let far = |line: usize, step: usize| [step as f64, 50.0 * line as f64];
            let found = by_turns(lines, 100, far).expect("each line is one run");
            let points: Vec<Track> = found.iter().map(|run| run.points).collect();
            let track =
                |first| Track { first, count: (100 - first).div_ceil(lines), stride: lines };
            assert_eq!(points, (0..lines).map(track).collect::<Vec<_>>());
        }
    }

    #[test]
    fn runs_by_turns_hold_every_point_once() {
        let zigzag = |line: usize, step: usize| {
            let step = step % 40;
            [if step < 20 { step } else { 40 - step } as f64, 9.0 * line as f64 + step as f64 / 8.0]
        };
        let found = by_turns(3, 601, zigzag).expect("each line turns at every 20th step");
        let mut numbers: Vec<usize> = found.iter().flat_map(|run| run.points.numbers()).collect();
        numbers.sort_unstable();
        assert!(numbers.into_iter().eq(0..601));
    }

    #[test]
    fn points_in_no_order_are_no_lines_by_turns() {
        let scattered = |index: usize| [0.618, 0.755].map(|share| (index as f64 * share).fract());
        for count in [0, 1, 8, 64, 1000] {
            assert!(by_turns(1, count, |_, index| scattered(index * index)).is_none(), "{count}");
        }
    }

    #[test]
    fn the_runs_hold_every_point_once() {
        let places: Vec<Place> = (0..500)
            .map(|i| {
                let t = f64::from(i) * 0.37;
                [t * t.cos(), t * t.sin()]
            })
            .collect();
        let mut next = 0;
        for (points, _) in cut(&places) {
            assert_eq!(points.start, next);
            next = points.end;
        }
        assert_eq!(next, 500);
    }
}
