//! Lines and circles fitted to pieces, with the covariance of what was fitted, and where two of them meet.

use super::circle::Fitted;
use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// A line or a circle without ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    /// A place on the line, and the angle of the way of the curve.
    Line { through_mm: PlaceMm, angle: f64 },
    /// `turn` is 1 where the curve goes round it counter-clockwise, else -1.
    Circle { centre_mm: PlaceMm, radius_mm: f64, turn: f64 },
}

/// A shape fitted to points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Element {
    pub(super) shape: Shape,
    /// (JᵀJ)⁻¹ of the three numbers of [`Shape::varied`].
    unit: [[f64; 3]; 3],
    /// Points it is fitted to.
    pub(super) points: usize,
    /// Sum of their squared distances, mm².
    pub(super) squares_mm2: f64,
    /// Standard deviation by which its points count, mm; set when all are fitted.
    pub(super) sigma_mm: f64,
}

impl Shape {
    /// The same with its three numbers changed: of a line its angle, the offset to its left, and nothing; of a circle x and y of its centre
    /// and its radius.
    fn varied(&self, by: [f64; 3]) -> Shape {
        match *self {
            Shape::Line { through_mm: [x, y], angle } => Shape::Line {
                through_mm: [x - by[1] * angle.sin(), y + by[1] * angle.cos()],
                angle: angle + by[0],
            },
            Shape::Circle { centre_mm: [x, y], radius_mm, turn } => Shape::Circle {
                centre_mm: [x + by[0], y + by[1]],
                radius_mm: radius_mm + by[2],
                turn,
            },
        }
    }

    /// The nearest place on it.
    pub(super) fn foot_mm(&self, place: PlaceMm) -> PlaceMm {
        match *self {
            Shape::Line { through_mm: [x, y], angle } => {
                let (sin, cos) = angle.sin_cos();
                let along = (place[0] - x) * cos + (place[1] - y) * sin;
                [x + along * cos, y + along * sin]
            }
            Shape::Circle { centre_mm, radius_mm, .. } => {
                let distance = distance_mm(place, centre_mm);
                let share = if distance > 0.0 { radius_mm / distance } else { 0.0 };
                [0, 1].map(|axis| centre_mm[axis] + share * (place[axis] - centre_mm[axis]))
            }
        }
    }

    /// The distance of a place from it, mm.
    pub(super) fn distance_mm(&self, place: PlaceMm) -> f64 {
        distance_mm(place, self.foot_mm(place))
    }

    /// Largest less least signed distance of places from it, mm.
    pub(super) fn range_mm(&self, places_mm: &[PlaceMm]) -> f64 {
        let signed = |place: PlaceMm| match *self {
            Shape::Line { through_mm: [x, y], angle } => {
                (place[1] - y) * angle.cos() - (place[0] - x) * angle.sin()
            }
            Shape::Circle { centre_mm, .. } => distance_mm(place, centre_mm),
        };
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = places_mm
            .iter()
            .fold(ends, |(low, high), &place| (low.min(signed(place)), high.max(signed(place))));
        high - low
    }

    /// The angle of the way of the curve at a place on it.
    pub(super) fn angle_at(&self, place: PlaceMm) -> f64 {
        match *self {
            Shape::Line { angle, .. } => angle,
            Shape::Circle { centre_mm: [x, y], turn, .. } => {
                (turn * (place[0] - x)).atan2(-turn * (place[1] - y))
            }
        }
    }

    /// Where two shapes meet, nearest to a place; none where they do not.
    pub(super) fn meeting_mm(&self, other: &Shape, near: PlaceMm) -> Option<PlaceMm> {
        match (*self, *other) {
            (Shape::Line { through_mm: p, angle: a }, Shape::Line { through_mm: q, angle: b }) => {
                let sine = (b - a).sin();
                let along = ((q[0] - p[0]) * b.sin() - (q[1] - p[1]) * b.cos()) / sine;
                let place = [p[0] + along * a.cos(), p[1] + along * a.sin()];
                place.iter().all(|value| value.is_finite()).then_some(place)
            }
            (Shape::Line { .. }, Shape::Circle { centre_mm, radius_mm, .. }) => {
                let foot = self.foot_mm(centre_mm);
                let half = (radius_mm.powi(2) - distance_mm(foot, centre_mm).powi(2)).sqrt();
                let (sin, cos) = self.angle_at(foot).sin_cos();
                nearer([half, -half].map(|it| [foot[0] + it * cos, foot[1] + it * sin]), near)
            }
            (Shape::Circle { .. }, Shape::Line { .. }) => other.meeting_mm(self, near),
            (
                Shape::Circle { centre_mm: p, radius_mm: r, .. },
                Shape::Circle { centre_mm: q, radius_mm: s, .. },
            ) => {
                let apart = distance_mm(p, q);
                let along = 0.5 * (apart + (r * r - s * s) / apart);
                let half = (r * r - along * along).sqrt();
                let [cos, sin] = [(q[0] - p[0]) / apart, (q[1] - p[1]) / apart];
                let place =
                    |half: f64| [p[0] + along * cos - half * sin, p[1] + along * sin + half * cos];
                nearer([half, -half].map(place), near)
            }
        }
    }
}

impl Element {
    /// The line of least squares through points in the order of the curve.
    pub(super) fn line(points_mm: &[PlaceMm]) -> Option<Element> {
        let [first, .., last] = points_mm else { return None };
        let count = points_mm.len() as f64;
        let through_mm = [0, 1].map(|axis| {
            let from = first[axis];
            from + points_mm.iter().map(|place| place[axis] - from).sum::<f64>() / count
        });
        let [mut xx, mut xy, mut yy] = [0.0; 3];
        for place in points_mm {
            let [x, y] = [place[0] - through_mm[0], place[1] - through_mm[1]];
            xx += x * x;
            xy += x * y;
            yy += y * y;
        }
        let axis = 0.5 * (2.0 * xy).atan2(xx - yy);
        let (sin, cos) = axis.sin_cos();
        let goes_back = (last[0] - first[0]) * cos + (last[1] - first[1]) * sin < 0.0;
        let angle = if goes_back { axis + std::f64::consts::PI } else { axis };
        let spread = xx * cos * cos + 2.0 * xy * sin * cos + yy * sin * sin;
        let mut unit = [[0.0; 3]; 3];
        unit[0][0] = 1.0 / spread;
        unit[1][1] = 1.0 / count;
        let shape = Shape::Line { through_mm, angle };
        (spread > 0.0).then(|| Element::new(shape, unit, points_mm))
    }

    /// The circle of least squares of points in the order of the curve.
    pub(super) fn circle(points_mm: &[PlaceMm]) -> Option<Element> {
        let fitted = Fitted::circle(points_mm)?;
        let centre_mm = fitted.centre_mm();
        let crossed = points_mm.windows(2).map(|pair| {
            let [p, q] = [pair[0], pair[1]].map(|it| [it[0] - centre_mm[0], it[1] - centre_mm[1]]);
            p[0] * q[1] - p[1] * q[0]
        });
        let turn = if crossed.sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
        let shape = Shape::Circle { centre_mm, radius_mm: fitted.radius_mm, turn };
        Some(Element::new(shape, fitted.unit, points_mm))
    }

    fn new(shape: Shape, unit: [[f64; 3]; 3], points_mm: &[PlaceMm]) -> Element {
        let squares_mm2 = points_mm.iter().map(|&place| shape.distance_mm(place).powi(2)).sum();
        Element { shape, unit, points: points_mm.len(), squares_mm2, sigma_mm: 0.0 }
    }

    /// Points beyond those that its numbers take.
    pub(super) fn spare(&self) -> usize {
        let numbers = if matches!(self.shape, Shape::Line { .. }) { 2 } else { 3 };
        self.points.saturating_sub(numbers)
    }
}

/// A figure of elements and its standard uncertainty; none where a change within the uncertainty leaves none.
///
/// Elements have points of their own, so they are independent: u² = Σ gᵀCg, g by differences over 0.3 standard uncertainties.
pub(super) fn figure<const N: usize>(
    elements: &[Element],
    of: impl Fn(&[Shape]) -> Option<[f64; N]>,
) -> Option<([f64; N], [f64; N])> {
    let mut shapes: Vec<Shape> = elements.iter().map(|element| element.shape).collect();
    let value = of(&shapes)?;
    let mut variance = [0.0; N];
    for (index, element) in elements.iter().enumerate() {
        let covariance = element.unit.map(|row| row.map(|it| it * element.sigma_mm.powi(2)));
        let mut slopes = [[0.0; N]; 3];
        for number in 0..3 {
            let step = 0.3 * covariance[number][number].sqrt();
            if step == 0.0 {
                continue;
            }
            let mut side = |step: f64| {
                let mut by = [0.0; 3];
                by[number] = step;
                shapes[index] = element.shape.varied(by);
                of(&shapes)
            };
            let (high, low) = (side(step)?, side(-step)?);
            slopes[number] = std::array::from_fn(|it| (high[it] - low[it]) / (2.0 * step));
        }
        shapes[index] = element.shape;
        for i in 0..3 {
            for j in 0..3 {
                for it in 0..N {
                    variance[it] += slopes[i][it] * covariance[i][j] * slopes[j][it];
                }
            }
        }
    }
    Some((value, variance.map(|it| it.max(0.0).sqrt())))
}

/// The nearer of two places to a third; none if they are no numbers.
fn nearer([p, q]: [PlaceMm; 2], near: PlaceMm) -> Option<PlaceMm> {
    let place = if distance_mm(q, near) < distance_mm(p, near) { q } else { p };
    place.iter().all(|value| value.is_finite()).then_some(place)
}
