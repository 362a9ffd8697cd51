//! Where two elements of a curve join, and the area and length that joined elements enclose.

use std::f64::consts::{PI, TAU};

use super::course::area_mm2;
use super::element::Shape;
use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// How one element goes over into the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Joint {
    /// They cross at a corner near a place.
    Corner(PlaceMm),
    /// They touch.
    Touch(PlaceMm),
    /// Neither is known: half way between the feet of a place.
    Near(PlaceMm),
}

impl Joint {
    /// The joint of two shapes whose points change hands near a place; `reach_mm` is how far from there they may meet. Shapes that may touch
    /// make a corner from [`CORNER_DEG`] on, others from [`SMOOTH_DEG`] on.
    pub(super) fn new(shapes: [&Shape; 2], near: PlaceMm, reach_mm: f64, may_touch: bool) -> Joint {
        let least_deg = if may_touch { CORNER_DEG } else { SMOOTH_DEG };
        let is_near = |place: PlaceMm| distance_mm(place, near) <= reach_mm;
        let meeting = shapes[0].meeting_mm(shapes[1], near).filter(|&place| is_near(place));
        let is_corner =
            meeting.is_some_and(|place| turn(shapes, place).abs() >= least_deg.to_radians());
        match touch_mm(shapes, near) {
            _ if is_corner => Joint::Corner(near),
            Some(place) if is_near(place) => Joint::Touch(near),
            _ => Joint::Near(near),
        }
    }

    /// Its place; none where shapes do not meet any more.
    pub(super) fn place_mm(&self, shapes: [&Shape; 2]) -> Option<PlaceMm> {
        match *self {
            Joint::Corner(near) => shapes[0].meeting_mm(shapes[1], near),
            Joint::Touch(near) => touch_mm(shapes, near),
            Joint::Near(near) => Some(middle_of_feet(shapes, near)),
        }
    }
}

/// The turn of the curve at a place from one shape to the next, -π to π.
pub(super) fn turn(shapes: [&Shape; 2], place: PlaceMm) -> f64 {
    let turn = shapes[1].angle_at(place) - shapes[0].angle_at(place);
    turn - TAU * (turn / TAU).round()
}

/// How far two shapes reach beyond touching each other, in mm: above 0 where they miss each other; none of two lines.
pub(super) fn overlap_mm(shapes: [&Shape; 2]) -> Option<f64> {
    match (shapes[0], shapes[1]) {
        (Shape::Line { .. }, Shape::Line { .. }) => None,
        (line @ Shape::Line { .. }, Shape::Circle { centre_mm, radius_mm, .. })
        | (Shape::Circle { centre_mm, radius_mm, .. }, line @ Shape::Line { .. }) => {
            Some(line.distance_mm(*centre_mm) - radius_mm)
        }
        (
            Shape::Circle { centre_mm: p, radius_mm: r, turn },
            Shape::Circle { centre_mm: q, radius_mm: s, turn: other },
        ) => {
            // Circles that go round the same way touch from within.
            let touching = if turn == other { (r - s).abs() } else { r + s };
            Some(distance_mm(*p, *q) - touching)
        }
    }
}

/// Where two shapes are nearest to each other; none of two lines and of circles about one centre.
fn touch_mm(shapes: [&Shape; 2], near: PlaceMm) -> Option<PlaceMm> {
    let on_way = match (shapes[0], shapes[1]) {
        (Shape::Line { .. }, Shape::Line { .. }) => return None,
        (line @ Shape::Line { .. }, Shape::Circle { centre_mm, .. })
        | (Shape::Circle { centre_mm, .. }, line @ Shape::Line { .. }) => line.foot_mm(*centre_mm),
        (Shape::Circle { centre_mm: p, .. }, Shape::Circle { centre_mm: q, .. }) => {
            // The side of the line through both centres that the place is on.
            let [x, y] = [q[0] - p[0], q[1] - p[1]];
            let from = if distance_mm(near, *p) < distance_mm(near, *q) { p } else { q };
            let side = (near[0] - from[0]) * x + (near[1] - from[1]) * y;
            let length = x.hypot(y);
            let far = 1e3 * side.signum() * distance_mm(near, *from) / length;
            (length > 0.0).then_some([from[0] + far * x, from[1] + far * y])?
        }
    };
    let place = middle_of_feet(shapes, on_way);
    place.iter().all(|value| value.is_finite()).then_some(place)
}

fn middle_of_feet(shapes: [&Shape; 2], place: PlaceMm) -> PlaceMm {
    let [p, q] = shapes.map(|shape| shape.foot_mm(place));
    [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]
}

/// The ends of every shape of a closed curve, by the joints, each with the next shape; none where one does not meet the next.
pub(super) fn ends_mm(shapes: &[Shape], joints: &[Joint]) -> Option<Vec<[PlaceMm; 2]>> {
    let count = shapes.len();
    if joints.len() != count {
        return None;
    }
    let place =
        |index: usize| joints[index].place_mm([&shapes[index], &shapes[(index + 1) % count]]);
    let places: Vec<PlaceMm> = (0..count).map(place).collect::<Option<_>>()?;
    Some((0..count).map(|index| [places[(index + count - 1) % count], places[index]]).collect())
}

/// Area in mm² and length in mm of a closed curve of shapes, by their ends.
pub(super) fn area_and_length(shapes: &[Shape], ends_mm: &[[PlaceMm; 2]]) -> [f64; 2] {
    let corners: Vec<PlaceMm> = ends_mm.iter().map(|ends| ends[1]).collect();
    let mut sums = [area_mm2(&corners), 0.0];
    for (shape, &[from, to]) in shapes.iter().zip(ends_mm) {
        match *shape {
            Shape::Line { .. } => sums[1] += distance_mm(from, to),
            Shape::Circle { radius_mm, turn, .. } => {
                let sweep = sweep(shape, [from, to]);
                sums[0] += 0.5 * turn * radius_mm * radius_mm * (sweep - sweep.sin());
                sums[1] += radius_mm * sweep;
            }
        }
    }
    sums
}

/// The angle that a circle goes round from one place to another, above 0 to 2π; 0 of a line.
pub(super) fn sweep(shape: &Shape, [from, to]: [PlaceMm; 2]) -> f64 {
    let Shape::Circle { turn, .. } = *shape else { return 0.0 };
    let angle = (turn * (shape.angle_at(to) - shape.angle_at(from))).rem_euclid(TAU);
    if angle > 0.0 { angle } else { TAU }
}

/// The angle between two directions as lines, 0 to π/2.
pub(super) fn between_lines(first: f64, second: f64) -> f64 {
    let angle = (second - first).rem_euclid(PI);
    angle.min(PI - angle)
}

/// Turn from which on two pieces make a corner although noise may hide that they touch, degrees.
const CORNER_DEG: f64 = 25.0;
/// Turn below which the curve goes on smoothly, degrees.
const SMOOTH_DEG: f64 = 5.0;
