//! The area that a side of a polygon of points cuts off where the curve has a corner between two points.

use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// The area between the side in the middle of six points and the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CutCorner {
    /// The curve goes smoothly on, or its points do not tell.
    None,
    /// The points before and after lie on straight ways that meet: the triangle of these, mm², above 0 where it lies to the right. The second is its
    /// variance by the noise of the points.
    Sharp(f64, f64),
    /// The curve turns too fast for its points. The area lies between nothing and this, mm².
    Blurred(f64),
}

impl CutCorner {
    /// The corner cut off between the third and the fourth of six points in a row, whose noise across the curve is σ.
    ///
    /// A corner is sharp if the way turns at these two, and at the points beside them by a fifth of that at most. Its legs together are then no longer than
    /// [`LONGEST`] of the sides beside: the spacing shows nothing longer. Else the area is at most that of the triangle of the ways that meet, and of the
    /// triangle of equal legs of that length.
    pub(super) fn between(places_mm: [PlaceMm; 6], sigma_mm: f64) -> CutCorner {
        let [n, o, p, q, r, s] = places_mm;
        let [before, first, second, after] =
            [turn([n, o, p]), turn([o, p, q]), turn([p, q, r]), turn([q, r, s])];
        let total = first + second;
        let beside = [[n, o], [o, p], [q, r], [r, s]].map(|[p, q]| distance_mm(p, q));
        let least_mm = beside[1].min(beside[2]);
        let most_mm = LONGEST * beside.into_iter().fold(0.0, f64::max);
        let is_told = total.abs() > LEAST_TURN.max(TOLD * sigma_mm / least_mm);
        let is_straight = before.abs().max(after.abs()) <= STRAIGHT * total.abs();
        let triangle = triangle([o, p, q, r]);
        if let (true, Some((area_mm2, legs_mm))) = (is_told && is_straight, triangle)
            && legs_mm <= most_mm
        {
            return CutCorner::Sharp(area_mm2, variance([o, p, q, r], area_mm2, sigma_mm));
        }
        if first.abs().max(second.abs()) <= MOST_TURN {
            return CutCorner::None;
        }
        let side_mm = distance_mm(p, q);
        let height_mm = 0.5 * (most_mm.powi(2) - side_mm.powi(2)).max(0.0).sqrt();
        let by_legs_mm2 = 0.5 * side_mm * height_mm;
        let by_ways_mm2 = triangle.map_or(f64::INFINITY, |(area_mm2, _)| area_mm2.abs());
        CutCorner::Blurred(by_legs_mm2.min(by_ways_mm2).copysign(total))
    }
}

/// The triangle of a side and the ways before and after it: its area, and the length of its legs together; none where these do not meet ahead.
fn triangle([o, p, q, r]: [PlaceMm; 4]) -> Option<(f64, f64)> {
    let [ux, uy] = [p[0] - o[0], p[1] - o[1]];
    let [vx, vy] = [q[0] - r[0], q[1] - r[1]];
    let [x, y] = [q[0] - p[0], q[1] - p[1]];
    let crossed = ux * vy - uy * vx;
    // p + a·u = q + b·v.
    let [a, b] = [(x * vy - y * vx) / crossed, (x * uy - y * ux) / crossed];
    let legs_mm = a * ux.hypot(uy) + b * vx.hypot(vy);
    let area_mm2 = 0.5 * a * (ux * y - uy * x);
    // A corner at a point lies before or behind it by the noise.
    let is_ahead = a >= -AT_POINT && b >= -AT_POINT;
    (is_ahead && area_mm2.is_finite()).then_some((area_mm2, legs_mm))
}

/// The variance of a triangle where each of its points has noise across its way.
fn variance(places_mm: [PlaceMm; 4], area_mm2: f64, sigma_mm: f64) -> f64 {
    let way = |from: usize, to: usize| {
        let [p, q] = [places_mm[from], places_mm[to]];
        let length_mm = distance_mm(p, q);
        [(q[0] - p[0]) / length_mm, (q[1] - p[1]) / length_mm]
    };
    let ways = [way(0, 1), way(0, 1), way(2, 3), way(2, 3)];
    let moved = |index: usize| {
        let mut places_mm = places_mm;
        let [x, y] = ways[index];
        let [at_x, at_y] = places_mm[index];
        places_mm[index] = [at_x - sigma_mm * y, at_y + sigma_mm * x];
        triangle(places_mm).map_or(0.0, |(moved_mm2, _)| moved_mm2 - area_mm2)
    };
    (0..4).map(|index| moved(index).powi(2)).sum()
}

/// The turn at the second of three places, left above 0.
pub(super) fn turn([p, q, r]: [PlaceMm; 3]) -> f64 {
    let crossed = (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0]);
    let along = (q[0] - p[0]) * (r[0] - q[0]) + (q[1] - p[1]) * (r[1] - q[1]);
    crossed.atan2(along)
}

/// Largest turn from side to side that is not a corner, radians.
pub(super) const MOST_TURN: f64 = 0.5;
/// Least turn of a corner, radians,
const LEAST_TURN: f64 = 0.25;
/// and over σ per length of a side.
const TOLD: f64 = 15.0;
/// Largest turn beside a sharp corner over its own.
const STRAIGHT: f64 = 0.2;
/// Length of the legs of a corner over the longest side near it.
const LONGEST: f64 = 1.5;
/// Share of a side by which a corner may lie behind its point.
const AT_POINT: f64 = 0.1;
