//! Circle, or line, through the samples about one.

use crate::samples::PlaceMm;

/// A circle or a line in coordinates from a sample, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::curves) enum Fit {
    Circle { centre: PlaceMm, radius: f64 },
    Line { middle: PlaceMm, along: PlaceMm },
}

impl Fit {
    /// The hyper fit of a circle; a line where the circle is so wide that they cannot be told apart.
    ///
    /// A. Al-Sharadqah, N. Chernov, Electronic Journal of Statistics 3 (2009) 886-911, doi:10.1214/09-EJS419: the algebraic fit
    /// without essential bias, its eigenvalue by Newton's method from 0.
    pub(in crate::curves) fn new(places: &[PlaceMm]) -> Fit {
        let count = places.len() as f64;
        let mean = |of: &dyn Fn(PlaceMm) -> f64| -> f64 {
            places.iter().map(|&place| of(place)).sum::<f64>() / count
        };
        let middle = [mean(&|place| place[0]), mean(&|place| place[1])];
        let x = |place: PlaceMm| place[0] - middle[0];
        let y = |place: PlaceMm| place[1] - middle[1];
        let z = |place: PlaceMm| x(place) * x(place) + y(place) * y(place);
        let [xx, yy, xy] = [mean(&|p| x(p) * x(p)), mean(&|p| y(p) * y(p)), mean(&|p| x(p) * y(p))];
        let [xz, yz, zz] = [mean(&|p| x(p) * z(p)), mean(&|p| y(p) * z(p)), mean(&|p| z(p) * z(p))];
        let size = xx + yy;
        let covariance = xx * yy - xy * xy;
        let spread = zz - size * size;
        let a2 = 4.0 * covariance - 3.0 * size * size - zz;
        let a1 = spread * size + 4.0 * covariance * size - xz * xz - yz * yz;
        let a0 = xz * (xz * yy - yz * xy) + yz * (yz * xx - xz * xy) - spread * covariance;
        let (mut eta, mut value) = (0.0, a0);
        for _ in 0..MOST_STEPS {
            let slope = a1 + eta * (2.0 * a2 + 16.0 * eta * eta);
            let next = eta - value / slope;
            if next == eta || !next.is_finite() {
                break;
            }
            let at_next = a0 + next * (a1 + next * (a2 + 4.0 * next * next));
            if at_next.abs() >= value.abs() {
                break;
            }
            (eta, value) = (next, at_next);
        }
        let determinant = eta * eta - eta * size + covariance;
        let offset = [
            0.5 * (xz * (yy - eta) - yz * xy) / determinant,
            0.5 * (yz * (xx - eta) - xz * xy) / determinant,
        ];
        let radius = (offset[0] * offset[0] + offset[1] * offset[1] + size - 2.0 * eta).sqrt();
        if radius < WIDEST * size.sqrt() {
            let centre = [middle[0] + offset[0], middle[1] + offset[1]];
            return Fit::Circle { centre, radius };
        }
        let angle = 0.5 * (2.0 * xy).atan2(xx - yy);
        Fit::Line { middle, along: [angle.cos(), angle.sin()] }
    }

    /// Signed way along the fit from the foot of one place to that of another, mm.
    pub(super) fn way(&self, from: PlaceMm, to: PlaceMm) -> f64 {
        match *self {
            Fit::Circle { centre, radius } => {
                let [ux, uy] = [from[0] - centre[0], from[1] - centre[1]];
                let [vx, vy] = [to[0] - centre[0], to[1] - centre[1]];
                radius * (ux * vy - uy * vx).atan2(ux * vx + uy * vy)
            }
            Fit::Line { along, .. } => (to[0] - from[0]) * along[0] + (to[1] - from[1]) * along[1],
        }
    }

    /// The place on the fit nearest to another.
    pub(in crate::curves) fn foot(&self, place: PlaceMm) -> PlaceMm {
        match *self {
            Fit::Circle { centre, radius } => {
                let [x, y] = [place[0] - centre[0], place[1] - centre[1]];
                let share = radius / (x * x + y * y).sqrt();
                // At the centre every place is as near.
                if share.is_finite() {
                    [centre[0] + share * x, centre[1] + share * y]
                } else {
                    place
                }
            }
            Fit::Line { middle, along } => {
                let way = (place[0] - middle[0]) * along[0] + (place[1] - middle[1]) * along[1];
                [middle[0] + way * along[0], middle[1] + way * along[1]]
            }
        }
    }

    /// Unit normal of the fit at a place.
    pub(super) fn normal(&self, place: PlaceMm) -> PlaceMm {
        match *self {
            Fit::Circle { centre, .. } => {
                let [x, y] = [place[0] - centre[0], place[1] - centre[1]];
                let length = (x * x + y * y).sqrt();
                if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] }
            }
            Fit::Line { along, .. } => [-along[1], along[0]],
        }
    }

    /// Way from a place along a unit direction to where that line meets the fit next to it; none if it does not.
    pub(super) fn meeting(&self, place: PlaceMm, direction: PlaceMm) -> Option<f64> {
        match *self {
            Fit::Circle { centre, radius } => {
                let [x, y] = [place[0] - centre[0], place[1] - centre[1]];
                let along = x * direction[0] + y * direction[1];
                let off = x * direction[1] - y * direction[0];
                let half = radius * radius - off * off;
                if half < 0.0 {
                    return None;
                }
                let [near, far] = [-along - half.sqrt(), -along + half.sqrt()];
                Some(if near.abs() < far.abs() { near } else { far })
            }
            Fit::Line { middle, along } => {
                let normal = [-along[1], along[0]];
                let rise = direction[0] * normal[0] + direction[1] * normal[1];
                let away = (middle[0] - place[0]) * normal[0] + (middle[1] - place[1]) * normal[1];
                let way = away / rise;
                way.is_finite().then_some(way)
            }
        }
    }
}

/// Newton's method converges in few steps or not at all.
const MOST_STEPS: usize = 50;
/// Radius over the spread of the samples from which on a circle is a line.
const WIDEST: f64 = 1e6;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn circles_are_found_exactly() {
        for (centre, radius) in [([3.0, -1.0], 2.0), ([0.0, 50.0], 50.25), ([1e-3, 0.0], 1e-3)] {
            let places: Vec<PlaceMm> = (0..7)
                .map(|index| {
                    let (sin, cos) = (1.0 + 0.15 * f64::from(index)).sin_cos();
                    [centre[0] + radius * cos, centre[1] + radius * sin]
                })
                .collect();
            let Fit::Circle { centre: found, radius: of } = Fit::new(&places) else {
                panic!("a line")
            };
            assert!((of - radius).abs() < 1e-7 * radius, "{of} for {radius}");
            let off = (found[0] - centre[0]).hypot(found[1] - centre[1]);
            assert!(off < 1e-7 * radius, "{found:?} for {centre:?}");
        }
    }

    /// The hyper fit has no essential bias: of short noisy arcs the mean radius is right to second order.
    #[test]
    fn noisy_arcs_have_no_bias_of_second_order() {
        let numbers = asphera_geometry::Numbers::new(5, 0, 0);
        let (draws, count, sigma) = (4000, 20, 0.02);
        let mut sum = 0.0;
        for draw in 0..draws {
            let places: Vec<PlaceMm> = (0..count)
                .map(|index| {
                    let (sin, cos) = (1.5 * index as f64 / count as f64).sin_cos();
                    let at = 2 * (draw * count + index);
                    [cos + sigma * numbers.normal(at), sin + sigma * numbers.normal(at + 1)]
                })
                .collect();
            if let Fit::Circle { radius, .. } = Fit::new(&places) {
                sum += radius / draws as f64;
            }
        }
        // The simple algebraic fit (Kåsa) is 1.7 % short here; the error of the mean is 0.0007.
        assert!((sum - 1.0).abs() < 0.004, "{sum}");
    }

    #[test]
    fn points_on_a_line_give_a_line() {
        let places: Vec<PlaceMm> = (0..5).map(|x| [f64::from(x), 2.0 * f64::from(x)]).collect();
        let fit = Fit::new(&places);
        assert!(matches!(fit, Fit::Line { .. }), "{fit:?}");
        assert!((fit.way(places[1], places[3]).abs() - 2.0 * 5.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!(fit.meeting([0.0, 5.0], [1.0, 0.0]).map(|way| (way * 1e6).round()), Some(2.5e6));
    }
}
