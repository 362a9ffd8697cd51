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

/// Points that follow one another, and the axis along which they do, if they are more than one.
pub(super) struct Run {
    pub(super) points: Range<usize>,
    pub(super) axis: Option<Axis>,
}

/// Cuts a batch into runs, each as long as its steps lead along one axis.
pub(super) fn runs(places: impl ExactSizeIterator<Item = Place>, into: &mut Vec<Run>) {
    into.clear();
    let mut last: Option<Place> = None;
    for (index, place) in places.enumerate() {
        let step = last.map(|last| [place[0] - last[0], place[1] - last[1]]);
        last = Some(place);
        match (into.last_mut(), step) {
            (Some(Run { points, axis: Some(axis) }), Some(step)) if axis.leads(step) => {
                points.end = index + 1;
            }
            (Some(Run { points, axis: axis @ None }), Some(step)) if step != [0.0; 2] => {
                points.end = index + 1;
                *axis = Some(Axis::of(step));
            }
            _ => into.push(Run { points: index..index + 1, axis: None }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(places: &[Place]) -> Vec<(Range<usize>, Option<Axis>)> {
        let mut found = Vec::new();
        runs(places.iter().copied(), &mut found);
        found.into_iter().map(|run| (run.points, run.axis)).collect()
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
