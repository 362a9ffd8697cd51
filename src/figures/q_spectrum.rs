//! The slope spectrum of the rotational part: its coefficients in Forbes' Q-bfs polynomials.
//!
//! G. W. Forbes, Opt. Express 15 (2007) 5218 (the polynomials and their slope orthogonality) and 18 (2010)
//! 19700, appendix A (the recurrences used here). The sum is u²·(1 − u²)·Σ a_m·Q_m(u²) with u = r/radius.
//! It vanishes at the vertex and at the rim, so a piston and a power are fitted beside it.

use std::num::NonZeroU8;

use nalgebra::DMatrix;

use super::least_squares::{RANK_TOLERANCE, factored, noise_gram};
use super::{Sample, Unknown};
use asphera_form::linear::{Step, System};

/// The rotational part of a deviation in slope-orthogonal polynomials.
///
/// Where the noise is known, the series has no more terms than stand out of it: those beyond are taken to be 0. All
/// uncertainties are by independent noise of the points, or by what the fit leaves, if that is more.
#[derive(Clone, Debug, PartialEq)]
pub struct QSpectrum {
    /// Radius in mm at which u = 1.
    pub radius_mm: f64,
    /// Coefficient of u² in nm: the rise from the vertex to the rim.
    pub power_nm: f64,
    /// a_m in nm, m = 0 first.
    pub coefficients_nm: Vec<f64>,
    /// Standard uncertainty of each a_m in nm.
    pub u_nm: Vec<f64>,
    /// RMS in nm that one standard uncertainty of each a_m makes at the measured places.
    pub u_height_nm: Vec<f64>,
    /// RMS in nm of the deviation less piston, tilt and power.
    pub rms_nm: f64,
    /// Terms asked for.
    pub asked: usize,
    /// The noise of a point in nm that was taken.
    pub noise_nm: f64,
    /// Whether that is the RMS of what the fit leaves, because no noise was known or this is more: form that is finer, or not
    /// rotational and of a higher order than what is fitted beside the series, errs like noise at places without order.
    pub noise_of_residuals: bool,
    /// Whether what it leaves has waves along the radius of a tenth of the series' height or more.
    pub waves_left: bool,
    /// The RMS slope.
    pub slope: SeriesSlope,
}

/// Root of Σ a_m² over the radius: the RMS meridional slope of a series with the weight 1/√(1 − u²) over u, which stresses
/// the rim. In µrad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeriesSlope {
    /// By the coefficients as fitted.
    pub fitted_urad: f64,
    /// Mean share of noise in that, in squares.
    pub noise_urad: f64,
    /// Without what noise adds; 0 where noise makes all of it.
    pub form_urad: f64,
    /// Standard deviation of the mean square, in µrad².
    spread_urad2: f64,
}

impl SeriesSlope {
    /// An interval that holds the slope without noise, `k` standard deviations of the mean square to either side.
    pub fn interval_urad(&self, k: f64) -> [f64; 2] {
        let square = self.fitted_urad * self.fitted_urad - self.noise_urad * self.noise_urad;
        [-k, k].map(|k| (square + k * self.spread_urad2).max(0.0).sqrt())
    }
}

impl QSpectrum {
    /// Whether a term is determined: its uncertainty makes no higher a form than all of the deviation is.
    pub fn is_determined(&self, term: usize) -> bool {
        self.u_height_nm.get(term).is_some_and(|height_nm| *height_nm <= self.rms_nm)
    }

    /// Whether the last quarter of the terms holds less than a tenth of the sum of the squares, noise taken off. If not,
    /// the deviation has more waves along the radius than they follow, and that bends all of them; so it does where such
    /// waves are left. Terms that do not stand out of the noise need no following.
    pub fn ends(&self) -> bool {
        let squares = self.coefficients_nm.iter().zip(&self.u_nm).map(|(a, u)| a * a - u * u);
        let squares: Vec<f64> = squares.collect();
        let tail = self.asked * 3 / 4;
        let tail: f64 = squares.iter().skip(tail).sum();
        !self.waves_left && tail <= LARGEST_TAIL * squares.iter().sum::<f64>().max(0.0)
    }
}

/// Fits up to `terms` Q-bfs polynomials with piston, tilt and power, together, by area-weighted least squares at
/// the measured places. `O(n·p²)` for p terms.
///
/// Coma, astigmatism of two orders and trefoil are fitted with them where the places tell all apart: they are form, not noise,
/// and are no part of the series.
///
/// `noise_nm` is the independent noise of a point. From the last term down, those are left out whose coefficient is
/// below four of its standard uncertainties, until one is not: near the rim and the vertex few points tell many terms
/// apart, and their noise would come back in the first ones a hundredfold. Where all terms leave more than the noise, that
/// counts as noise. Without a noise all terms stay. Terms that the places do not tell apart go in either case.
///
/// With gaps, parts of the deviation that vary with the azimuth other than the tilt may enter.
pub fn q_spectrum(
    sample: &Sample,
    terms: NonZeroU8,
    noise_nm: Option<f64>,
) -> Result<QSpectrum, Unknown> {
    let (used, asked) = (sample.weighted(), usize::from(terms.get()));
    if sample.is_empty() {
        return Err(Unknown::NoPoints);
    }
    if used < asked + BESIDE {
        return Err(Unknown::TooFewPoints { used, needed: asked + BESIDE });
    }
    let radius_mm = sample.radius_mm();
    if radius_mm == 0.0 {
        return Err(Unknown::OnePlace);
    }
    let recurrence = Recurrence::new(asked);
    let with = |beside: usize| {
        let columns = |place: [f64; 2], row: &mut [f64]| {
            recurrence.row(place.map(|part| part / radius_mm), row, beside);
        };
        let system = factored(sample, beside + asked, columns);
        let gram = noise_gram(sample, beside + asked, columns);
        Problem { system, gram, beside }
    };
    let whole = (used >= 2 * (asked + BESIDE + VARIANT)).then(|| with(BESIDE + VARIANT));
    let problem = whole.filter(|whole| Fitted::new(whole, asked).is_some());
    let problem = problem.unwrap_or_else(|| with(BESIDE));
    let Problem { system, beside, .. } = &problem;
    let beside = *beside;
    let columns = |place: [f64; 2], row: &mut [f64]| {
        recurrence.row(place.map(|part| part / radius_mm), row, beside);
    };
    let rms_after = |change: &[f64]| {
        let mut all = vec![0.0; asked + beside];
        all[..change.len()].copy_from_slice(change);
        (system.square_after(&all) / sample.total_area()).sqrt()
    };
    let mut fewer = (1..=asked).rev().filter_map(|terms| Fitted::new(&problem, terms));
    let Some(most) = fewer.next() else {
        let all: Vec<Vec<usize>> = (0..asked + beside).map(|column| vec![column]).collect();
        let determined = system.determinate(&all, RANK_TOLERANCE).len();
        return Err(Unknown::IndeterminateSeries { determined, wanted: asked + beside });
    };
    let freedom = (used - most.step.change.len()).max(1) as f64 / used as f64;
    let left_nm = rms_after(&most.step.change) / freedom.sqrt();
    // The noise itself is known to some percent.
    let noise_of_residuals = noise_nm.is_none_or(|noise_nm| left_nm > MORE_THAN_NOISE * noise_nm);
    let noise = noise_nm.filter(|_| !noise_of_residuals).unwrap_or(left_nm);
    let shorter = noise_nm.is_some().then_some(fewer).into_iter().flatten();
    let Fitted { step, covariance } = most.shortened(shorter, noise);
    let low: Vec<usize> = (0..BESIDE).collect();
    let rms_nm = rms_after(&system.solve(&low, 0.0).change);
    let series = step.change[beside..].to_vec();
    let waves = rotational_square(sample, &step.change, left_nm, columns);
    let covariance = covariance * (noise * noise);
    let u_nm: Vec<f64> = covariance.diagonal().iter().map(|square| square.sqrt()).collect();
    let height = |term: usize| system.length(beside + term) / sample.total_area().sqrt();
    Ok(QSpectrum {
        radius_mm,
        power_nm: step.change[BESIDE - 1],
        slope: slope(&series, &covariance, radius_mm),
        u_height_nm: u_nm.iter().enumerate().map(|(term, u)| u * height(term)).collect(),
        coefficients_nm: series,
        u_nm,
        rms_nm,
        asked,
        noise_nm: noise,
        noise_of_residuals,
        waves_left: waves > (LEAST_WAVE * rms_nm).powi(2),
    })
}

/// Mean square of what a fit leaves that is the same all around, by rings of equal area; 0 unless it is four times what
/// independent errors of `left_nm` make of the means of rings.
fn rotational_square(
    sample: &Sample,
    change: &[f64],
    left_nm: f64,
    columns: impl Fn([f64; 2], &mut [f64]),
) -> f64 {
    let rings = (RINGS_A_COLUMN * change.len()).min(sample.weighted() / LEAST_IN_RING).max(1);
    let radius_mm = sample.radius_mm();
    let mut row = vec![0.0; change.len()];
    let mut sums = vec![(0.0, 0.0); rings];
    let pairs = sample.places_mm().iter().zip(sample.values_nm()).zip(sample.areas());
    for ((&[x, y], value), area) in pairs {
        columns([x, y], &mut row);
        let fitted: f64 = row.iter().zip(change).map(|(column, by)| column * by).sum();
        let share = (x * x + y * y) / (radius_mm * radius_mm);
        let ring = &mut sums[((share * rings as f64) as usize).min(rings - 1)];
        ring.0 += area;
        ring.1 += area * (value - fitted);
    }
    let occupied = sums.iter().filter(|(area, _)| *area > 0.0).count() as f64;
    let square = sums.iter().filter(|(area, _)| *area > 0.0).map(|(area, sum)| sum * sum / area);
    let square = square.sum::<f64>() / sample.total_area();
    let by_noise = left_nm * left_nm * occupied / sample.weighted() as f64;
    if square > 4.0 * by_noise { square } else { 0.0 }
}

/// The least-squares problem of all terms.
struct Problem {
    system: System,
    /// Of [`noise_gram`].
    gram: DMatrix<f64>,
    /// Columns before those of the series.
    beside: usize,
}

/// A fit of some of the terms, with the covariance of their coefficients for a noise of 1 nm.
struct Fitted {
    step: Step,
    covariance: DMatrix<f64>,
}

impl Fitted {
    /// `None` where the places do not tell them apart.
    fn new(problem: &Problem, terms: usize) -> Option<Fitted> {
        let Problem { system, gram, beside } = problem;
        let count = beside + terms;
        let kept: Vec<usize> = (0..count).collect();
        let step = system.solve(&kept, 0.0);
        if step.condition * RANK_TOLERANCE >= 1.0 || step.condition.is_nan() {
            return None;
        }
        let inverse = DMatrix::from_vec(count, count, step.inverse_gram());
        let all = &inverse * gram.view((0, 0), (count, count)) * &inverse;
        let covariance = all.view((*beside, *beside), (terms, terms)).into_owned();
        Some(Fitted { step, covariance })
    }

    /// The first of this and of ever `shorter` ones whose last term stands out of the noise; the shortest if none does.
    fn shortened(self, shorter: impl Iterator<Item = Fitted>, noise_nm: f64) -> Fitted {
        let mut found = self;
        for fitted in shorter {
            if found.last_in_u(noise_nm) >= STANDS_OUT {
                break;
            }
            found = fitted;
        }
        found
    }

    /// Size of the last coefficient in units of its standard uncertainty.
    fn last_in_u(&self, noise_nm: f64) -> f64 {
        let last = self.covariance.nrows() - 1;
        let u_nm = noise_nm * self.covariance[(last, last)].sqrt();
        let size_nm = self.step.change.last().map_or(0.0, |last| last.abs());
        if u_nm > 0.0 { size_nm / u_nm } else { f64::INFINITY }
    }
}

/// With coefficients a + e, e of covariance C: E Σ(a+e)² = Σa² + tr C, and the variance of the sum is 4·aᵀCa + 2·tr C²
/// (Searle & Gruber, Linear Models, 2nd ed., 2.4).
fn slope(coefficients_nm: &[f64], covariance_nm2: &DMatrix<f64>, radius_mm: f64) -> SeriesSlope {
    let square: f64 = coefficients_nm.iter().map(|a| a * a).sum();
    let noise = covariance_nm2.trace();
    let form = (square - noise).max(0.0);
    let along: f64 = (0..coefficients_nm.len())
        .flat_map(|i| (0..coefficients_nm.len()).map(move |j| (i, j)))
        .map(|(i, j)| coefficients_nm[i] * covariance_nm2[(i, j)] * coefficients_nm[j])
        .sum();
    // The form without noise goes by its own size, along what was found.
    let along = if square > 0.0 { along * form / square } else { 0.0 };
    let spread = (4.0 * along.max(0.0) + 2.0 * covariance_nm2.norm_squared()).sqrt();
    SeriesSlope {
        fitted_urad: square.sqrt() / radius_mm,
        noise_urad: noise.sqrt() / radius_mm,
        form_urad: form.sqrt() / radius_mm,
        spread_urad2: spread / (radius_mm * radius_mm),
    }
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

    /// What is `beside` the series, and the series, at a place in units of the radius.
    fn row(&self, [u, v]: [f64; 2], row: &mut [f64], beside: usize) {
        let square = u * u + v * v;
        let (cosine, sine) = (u * u - v * v, 2.0 * u * v);
        let all: [f64; BESIDE + VARIANT] = [
            1.0,
            u,
            v,
            square,
            square * u,
            square * v,
            cosine,
            sine,
            square * cosine,
            square * sine,
            u * cosine - v * sine,
            u * sine + v * cosine,
        ];
        let (before, series) = row.split_at_mut(beside);
        before.copy_from_slice(&all[..beside]);
        self.values(square, series);
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
/// Further ones, in pairs: coma, astigmatism, its second order, trefoil.
const VARIANT: usize = 8;
/// A last term below so many standard uncertainties may be noise: of 24 that are, one in 700 is above.
const STANDS_OUT: f64 = 4.0;
/// What the series leaves counts as noise from here on, in units of the noise.
const MORE_THAN_NOISE: f64 = 1.1;
/// Least RMS of waves that are left, as a share of that of the deviation.
const LEAST_WAVE: f64 = 0.1;
/// Rings to look for waves in, for each column of the fit, and points in each.
const RINGS_A_COLUMN: usize = 4;
const LEAST_IN_RING: usize = 8;
/// Largest share of the squares that the last quarter of a series that ends may have.
const LARGEST_TAIL: f64 = 0.1;

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
