//! Running sums of points, and from them how far a line or a circle of least squares is from them.

use crate::PlaceMm;

/// Sums of the powers of coordinates, counted from a place near the points.
#[derive(Clone, Copy, Default)]
pub(super) struct Moments {
    count: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
    xz: f64,
    yz: f64,
    zz: f64,
}

impl Moments {
    /// Adds a point by its way from the place that is counted from.
    pub(super) fn add(&mut self, [x, y]: PlaceMm) {
        let z = x * x + y * y;
        self.count += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
        self.xz += x * z;
        self.yz += y * z;
        self.zz += z * z;
    }

    /// The sum of squared distances to the line of least squares, mm².
    pub(super) fn line_squares_mm2(&self) -> f64 {
        let [_, _, xx, xy, yy] = self.spread();
        let half = 0.5 * (xx - yy);
        self.count * (0.5 * (xx + yy) - half.hypot(xy)).max(0.0)
    }

    /// The sum of squared distances to a circle, mm²: nearly the least. n·η of G. Taubin's fit (IEEE Transactions on Pattern Analysis and
    /// Machine Intelligence 13 (1991) 1115-1138), η by Newton's iteration from 0 as N. Chernov gives it (Circular and linear
    /// regression, 2010, section 5.10). A line counts as a circle without end.
    pub(super) fn circle_squares_mm2(&self) -> f64 {
        let [mx, my, xx, xy, yy] = self.spread();
        let n = self.count;
        let mz = (self.xx + self.yy) / n;
        let [cxz, cyz] = [self.xz / n - mx * mz, self.yz / n - my * mz];
        let czz = self.zz / n - mz * mz;
        // z counted from the mean of the points.
        let xz = cxz - 2.0 * mx * xx - 2.0 * my * xy;
        let yz = cyz - 2.0 * mx * xy - 2.0 * my * yy;
        let variance =
            czz + 4.0 * (mx * mx * xx + my * my * yy - mx * cxz - my * cyz) + 8.0 * mx * my * xy;
        let z = xx + yy;
        let area = xx * yy - xy * xy;
        let a3 = 4.0 * z;
        let a2 = -3.0 * z * z - (variance + z * z);
        let a1 = variance * z + 4.0 * area * z - xz * xz - yz * yz;
        let a0 = xz * (xz * yy - yz * xy) + yz * (yz * xx - xz * xy) - variance * area;
        let value = |eta: f64| a0 + eta * (a1 + eta * (a2 + eta * a3));
        let mut eta = 0.0_f64;
        for _ in 0..MOST_STEPS {
            let slope = a1 + eta * (2.0 * a2 + 3.0 * eta * a3);
            let next = eta - value(eta) / slope;
            if !next.is_finite() || next <= eta || next - eta <= 1e-12 * next {
                break;
            }
            eta = next;
        }
        (n * eta).clamp(0.0, self.line_squares_mm2())
    }

    /// Mean place, and mean products of the coordinates from it.
    fn spread(&self) -> [f64; 5] {
        let n = self.count;
        let [mx, my] = [self.x / n, self.y / n];
        [mx, my, self.xx / n - mx * mx, self.xy / n - mx * my, self.yy / n - my * my]
    }
}

/// Most steps of the iteration; it takes three to six.
const MOST_STEPS: usize = 30;

#[cfg(test)]
mod tests {
    use super::*;

    fn of(points: &[PlaceMm]) -> Moments {
        let mut moments = Moments::default();
        points.iter().for_each(|&point| moments.add(point));
        moments
    }

    #[test]
    fn lines_and_circles_have_no_squares() {
        let line: Vec<PlaceMm> =
            (0..30).map(|x| [f64::from(x), 2.0 * f64::from(x) + 1.0]).collect();
        assert!(of(&line).line_squares_mm2() < 1e-9 && of(&line).circle_squares_mm2() < 1e-9);
        let arc: Vec<PlaceMm> = (0..30)
            .map(|index| (f64::from(index) * 0.05).sin_cos())
            .map(|(sin, cos)| [5.0 * cos - 4.0, 5.0 * sin])
            .collect();
        assert!(of(&arc).circle_squares_mm2() < 1e-9 && of(&arc).line_squares_mm2() > 1.0);
    }

    #[test]
    fn squares_are_those_of_alternating_deviations() {
        // Deviations of alternating sign are orthogonal to line and circle but for parts of 1/n.
        let line: Vec<PlaceMm> =
            (0..400).map(|x| [0.1 * f64::from(x), if x % 2 == 0 { 1e-3 } else { -1e-3 }]).collect();
        assert!((of(&line).line_squares_mm2() / 4e-4 - 1.0).abs() < 0.01);
        let ring: Vec<PlaceMm> = (0..400)
            .map(|index| {
                let (sin, cos) = (f64::from(index) * std::f64::consts::TAU / 400.0).sin_cos();
                let radius = 3.0 + if index % 2 == 0 { 1e-3 } else { -1e-3 };
                [radius * cos - 3.0, radius * sin]
            })
            .collect();
        assert!((of(&ring).circle_squares_mm2() / 4e-4 - 1.0).abs() < 0.01);
    }
}
