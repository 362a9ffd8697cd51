//! The least-squares circle with its uncertainty, and the roundness about it.

use std::f64::consts::TAU;

use super::range::noise_range;
use crate::PlaceMm;

/// The circle of least squares of the distances of points to it (ISO 12181-1, LSCI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    /// Its centre, mm.
    pub centre_mm: PlaceMm,
    /// Standard uncertainty of its coordinates by the scatter of the points, mm.
    pub u_centre_mm: [f64; 2],
    /// Its diameter, mm.
    pub diameter_mm: f64,
    /// Standard uncertainty of the diameter by the scatter of the points, mm.
    pub u_diameter_mm: f64,
    /// Standard deviation of the points about it, form and noise together, mm.
    pub deviation_rms_mm: f64,
    /// Largest less least distance of the points from the centre, unfiltered (roundness deviation), mm.
    pub roundness_mm: f64,
    /// Standard uncertainty of the roundness, mm: noise makes it too large, by 2·u at most in 95 of 100 cases.
    pub u_roundness_mm: f64,
    /// Noise of the points, from how much each differs from its neighbours along the circle, mm.
    pub noise_sigma_mm: f64,
    /// Angle that the points span, degrees: 360 less the widest gap.
    pub span_deg: f64,
}

impl Circle {
    /// The circle of points; none of fewer than four, of points on a line, or where the search does not end.
    ///
    /// Gauss and Newton's iteration from the algebraic fit of I. Kåsa (IEEE Transactions on Instrumentation and Measurement 25 (1976) 8-14).
    /// The covariance is s²·(JᵀJ)⁻¹, s² the sum of squares over n - 3: points count as independent and equally uncertain. n·log n time.
    pub fn fit(points_mm: &[PlaceMm]) -> Option<Circle> {
        Fitted::circle(points_mm).map(|fitted| Circle::about(&fitted))
    }
}

/// The circle of [`Circle::fit`] with (JᵀJ)⁻¹ of its centre and radius.
pub(super) struct Fitted {
    /// The points from their mean, which is the next.
    local: Vec<PlaceMm>,
    mean: PlaceMm,
    /// The centre from there.
    centre: PlaceMm,
    pub(super) radius_mm: f64,
    pub(super) unit: [[f64; 3]; 3],
}

impl Fitted {
    pub(super) fn circle(points_mm: &[PlaceMm]) -> Option<Fitted> {
        if points_mm.len() < 4 {
            return None;
        }
        let count = points_mm.len() as f64;
        let mean =
            [0, 1].map(|axis| points_mm.iter().map(|place| place[axis]).sum::<f64>() / count);
        let local: Vec<PlaceMm> =
            points_mm.iter().map(|[x, y]| [x - mean[0], y - mean[1]]).collect();
        let ([mut a, mut b], mut radius) = algebraic(&local)?;
        for _ in 0..MOST_STEPS {
            let (normal, right) = equations(&local, [a, b], radius);
            let [da, db, dr] = solved(normal, right)?;
            (a, b, radius) = (a + da, b + db, radius + dr);
            if da.abs().max(db.abs()).max(dr.abs()) <= 1e-14 * radius.abs() {
                break;
            }
        }
        let extent = local.iter().flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
        if !radius.is_finite() || radius <= 0.0 || radius > 1e4 * extent {
            return None;
        }
        let (normal, _) = equations(&local, [a, b], radius);
        let column = |index: usize| {
            let mut right = [0.0; 3];
            right[index] = 1.0;
            solved(normal, right)
        };
        let unit = [column(0)?, column(1)?, column(2)?];
        Some(Fitted { local, mean, centre: [a, b], radius_mm: radius, unit })
    }

    pub(super) fn centre_mm(&self) -> PlaceMm {
        [self.mean[0] + self.centre[0], self.mean[1] + self.centre[1]]
    }
}

impl Circle {
    fn about(fitted: &Fitted) -> Circle {
        let Fitted { local, centre: [a, b], radius_mm: radius, unit, .. } = fitted;
        let count = local.len() as f64;
        // Angle and deviation of every point, in the order of the angles.
        let mut polar: Vec<(f64, f64)> = local
            .iter()
            .map(|[x, y]| ((y - b).atan2(x - a), (x - a).hypot(y - b) - radius))
            .collect();
        polar.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.total_cmp(&q.1)));
        let squares: f64 = polar.iter().map(|(_, deviation)| deviation * deviation).sum();
        let variance = squares / (count - 3.0);
        let u_mm = |index: usize| (variance * unit[index][index]).sqrt();
        let (low, high) =
            polar.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| {
                (low.min(it.1), high.max(it.1))
            });
        let noise_sigma_mm = noise(&polar);
        let next = polar.iter().cycle().skip(1).zip(&polar);
        let gap = next.map(|(next, at)| (next.0 - at.0).rem_euclid(TAU)).fold(0.0, f64::max);
        Circle {
            centre_mm: fitted.centre_mm(),
            u_centre_mm: [u_mm(0), u_mm(1)],
            diameter_mm: 2.0 * radius,
            u_diameter_mm: 2.0 * u_mm(2),
            deviation_rms_mm: (squares / count).sqrt(),
            roundness_mm: high - low,
            u_roundness_mm: 0.5 * noise_sigma_mm * noise_range(local.len(), 0.95),
            noise_sigma_mm,
            span_deg: (TAU - gap).to_degrees(),
        }
    }
}

/// Centre and radius of the circle of least squares of x² + y² - 2ax - 2by - c.
fn algebraic(local: &[PlaceMm]) -> Option<(PlaceMm, f64)> {
    let (mut normal, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for [x, y] in local {
        add(&mut normal, &mut right, [2.0 * x, 2.0 * y, 1.0], x * x + y * y);
    }
    let [a, b, c] = solved(normal, right)?;
    let squared = c + a * a + b * b;
    (squared > 0.0).then(|| ([a, b], squared.sqrt()))
}

/// The normal equations of a step of Gauss and Newton's iteration.
fn equations(local: &[PlaceMm], [a, b]: PlaceMm, radius: f64) -> ([[f64; 3]; 3], [f64; 3]) {
    let (mut normal, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for [x, y] in local {
        let distance = (x - a).hypot(y - b);
        if distance > 0.0 {
            let row = [(x - a) / distance, (y - b) / distance, 1.0];
            add(&mut normal, &mut right, row, distance - radius);
        }
    }
    (normal, right)
}

fn add(normal: &mut [[f64; 3]; 3], right: &mut [f64; 3], row: [f64; 3], value: f64) {
    for i in 0..3 {
        for j in 0..3 {
            normal[i][j] += row[i] * row[j];
        }
        right[i] += row[i] * value;
    }
}

/// The solution of three equations of a positive definite matrix (Cholesky); none where it is none.
pub(super) fn solved(m: [[f64; 3]; 3], right: [f64; 3]) -> Option<[f64; 3]> {
    let mut l = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = m[i][j] - sum;
            if i == j {
                // Points on a line leave nothing but rounding.
                if rest.is_nan() || rest <= 1e-13 * m[i][i].abs() {
                    return None;
                }
                l[i][i] = rest.sqrt();
            } else {
                l[i][j] = rest / l[j][j];
            }
        }
    }
    let mut z = [0.0; 3];
    for i in 0..3 {
        let sum: f64 = (0..i).map(|k| l[i][k] * z[k]).sum();
        z[i] = (right[i] - sum) / l[i][i];
    }
    let mut x = [0.0; 3];
    for i in (0..3).rev() {
        let sum: f64 = (i + 1..3).map(|k| l[k][i] * x[k]).sum();
        x[i] = (z[i] - sum) / l[i][i];
    }
    Some(x)
}

/// The standard deviation of noise from second differences of deviations in the order of their angles.
fn noise(polar: &[(f64, f64)]) -> f64 {
    let squares: f64 =
        polar.windows(3).map(|three| (three[0].1 - 2.0 * three[1].1 + three[2].1).powi(2)).sum();
    // The variance of a second difference of equal noise is 1 + 4 + 1 times its own.
    (squares / (6.0 * (polar.len() - 2) as f64)).sqrt()
}

/// Most steps of the iteration; it takes three to six.
const MOST_STEPS: usize = 50;
