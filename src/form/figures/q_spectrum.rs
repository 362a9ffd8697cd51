//! The slope spectrum of the rotational part: its coefficients in Forbes' Q-bfs polynomials.
//!
//! G. W. Forbes, Opt. Express 15 (2007) 5218 (the polynomials and their slope orthogonality) and 18 (2010)
//! 19700, appendix A (the recurrences used here). The sum is u²·(1 − u²)·Σ a_m·Q_m(u²) with u = r/radius.
//! It vanishes at the vertex and at the rim, so a piston and a power are fitted beside it.

use std::num::NonZeroU8;

use super::least_squares::least_squares;
use super::{Sample, Unknown};

/// The rotational part of a deviation in slope-orthogonal polynomials.
#[derive(Clone, Debug, PartialEq)]
pub struct QSpectrum {
    /// Radius in mm at which u = 1.
    pub radius_mm: f64,
    /// Coefficient of u² in nm: the rise from the vertex to the rim.
    pub power_nm: f64,
    /// a_m in nm, m = 0 first.
    pub coefficients_nm: Vec<f64>,
    /// Root of Σ a_m², over the radius, in µrad: the RMS meridional slope of the series with the weight
    /// 1/√(1 − u²) over u, which stresses the rim.
    pub slope_rms_urad: f64,
}

/// Fits `terms` Q-bfs polynomials with piston, tilt and power, together, by area-weighted least squares at
/// the measured places. `O(n·p²)` for p terms.
///
/// With gaps, parts of the deviation that vary with the azimuth other than the tilt may enter.
pub fn q_spectrum(sample: &Sample, terms: NonZeroU8) -> Result<QSpectrum, Unknown> {
    let (used, columns) = (sample.weighted(), usize::from(terms.get()) + BESIDE);
    if sample.is_empty() {
        return Err(Unknown::NoPoints);
    }
    if used < columns {
        return Err(Unknown::TooFewPoints { used, needed: columns });
    }
    let radius_mm = sample.radius_mm();
    if radius_mm == 0.0 {
        return Err(Unknown::OnePlace);
    }
    let recurrence = Recurrence::new(columns - BESIDE);
    let solution = least_squares(sample, columns, |[x, y], row| {
        let (u, v) = (x / radius_mm, y / radius_mm);
        let square = u * u + v * v;
        let (beside, series) = row.split_at_mut(BESIDE);
        beside.copy_from_slice(&[1.0, u, v, square]);
        recurrence.values(square, series);
    });
    if !solution.is_complete() {
        let determined = solution.coefficients.iter().flatten().count();
        return Err(Unknown::IndeterminateSeries { determined, wanted: columns });
    }
    let coefficients_nm: Vec<f64> = (BESIDE..columns).map(|i| solution.or_zero(i)).collect();
    let square: f64 = coefficients_nm.iter().map(|a| a * a).sum();
    Ok(QSpectrum {
        radius_mm,
        power_nm: solution.or_zero(BESIDE - 1),
        coefficients_nm,
        slope_rms_urad: square.sqrt() / radius_mm,
    })
}

/// Numbers f_m, g_m and h_m of Forbes 2010, eqs. A.14 to A.16.
struct Recurrence {
    f: Vec<f64>,
    g: Vec<f64>,
    h: Vec<f64>,
}

impl Recurrence {
    fn new(terms: usize) -> Recurrence {
        let (mut f, mut g, mut h) = (vec![2.0, 0.5 * 19.0_f64.sqrt()], vec![-0.5], Vec::new());
        for m in 2..terms {
            let order = m as f64;
            h.push(-order * (order - 1.0) / (2.0 * f[m - 2]));
            let g_before = -(1.0 + g[m - 2] * h[m - 2]) / f[m - 1];
            g.push(g_before);
            let square = order * (order + 1.0) + 3.0 - g_before * g_before - h[m - 2] * h[m - 2];
            f.push(square.sqrt());
        }
        Recurrence { f, g, h }
    }

    /// u²·(1 − u²)·Q_m(u²) for m = 0 on.
    fn values(&self, square: f64, values: &mut [f64]) {
        let (mut p_before, mut p) = (2.0, 6.0 - 8.0 * square);
        for m in 0..values.len() {
            values[m] = match m {
                0 => 1.0,
                1 => (13.0 - 16.0 * square) / 19.0_f64.sqrt(),
                _ => {
                    (p_before, p) = (p, (2.0 - 4.0 * square) * p - p_before);
                    (p - self.g[m - 1] * values[m - 1] - self.h[m - 2] * values[m - 2]) / self.f[m]
                }
            };
        }
        let envelope = square * (1.0 - square);
        values.iter_mut().for_each(|value| *value *= envelope);
    }
}

/// Columns beside the series: piston, tilt, power.
const BESIDE: usize = 4;

#[cfg(test)]
mod tests {
    use super::*;

    /// prysm 0.21.1, `prysm.polynomials.Qbfs(n, x)` for n = 0, 1, 2, 5, 12 at x = 0.3 and 0.9.
    #[test]
    fn values_are_those_of_prysm() {
        let expected = [
            (0, [0.0819, 0.15389999999999995]),
            (1, [0.21720255786222853, 0.0014122832577071476]),
            (2, [0.24498137961735916, -0.04770615164142416]),
            (5, [0.14826485462270605, 0.025103456135587933]),
            (12, [0.05089772532051877, -0.00690394328677838]),
        ];
        let mut values = [0.0; 13];
        for (u, column) in [(0.3_f64, 0), (0.9, 1)] {
            Recurrence::new(13).values(u * u, &mut values);
            for (n, row) in expected {
                assert!((values[n] - row[column]).abs() < 1e-13, "{n} {u}: {}", values[n]);
            }
        }
    }

    /// Mean of the product of two slopes with the weight (2/π)/√(1 − u²): u = cos θ with θ evenly spread
    /// gives it exactly for polynomials.
    #[test]
    fn slopes_are_orthonormal() {
        let (terms, nodes) = (10, 64);
        let recurrence = Recurrence::new(terms);
        let mut gram = vec![0.0; terms * terms];
        for k in 0..nodes {
            let u = ((k as f64 + 0.5) * std::f64::consts::PI / nodes as f64).cos();
            let at = |u: f64| {
                let mut values = vec![0.0; terms];
                recurrence.values(u * u, &mut values);
                values
            };
            // Richardson's extrapolation of central differences.
            let h = 1e-3;
            let central = |h: f64| -> Vec<f64> {
                let pairs = at(u + h).into_iter().zip(at(u - h));
                pairs.map(|(above, below)| (above - below) / (2.0 * h)).collect()
            };
            let (fine, coarse) = (central(0.5 * h), central(h));
            let slope: Vec<f64> =
                fine.iter().zip(coarse).map(|(fine, coarse)| (4.0 * fine - coarse) / 3.0).collect();
            for i in 0..terms {
                for j in 0..terms {
                    gram[i * terms + j] += slope[i] * slope[j] / nodes as f64;
                }
            }
        }
        for i in 0..terms {
            for j in 0..terms {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((gram[i * terms + j] - expected).abs() < 1e-5, "{i} {j}");
            }
        }
    }
}
