//! The RMS of the form behind the noise: estimate, uncertainty, interval.
//!
//! With residuals r = e + z, e the form and z the errors after the refit, of covariance A = P·U·Pᵀ with
//! P = I − J·G, the mean square grows by the noise: E|r|² = |e|² + tr A and
//! var|r|² = 4·eᵀ·A·e + 2·tr A² (Searle & Gruber, Linear Models, 2nd ed., 2.4). A is never formed: its large
//! eigenvalues are those of the functions of the correlated errors after the refit, the others the variance of
//! the independent noise.
//!
//! Limits come from the inversion of a test. For every size of the form the most likely form of that size is
//! e = (I + λ·A)⁻¹·r; it takes more off r where the errors are large. The limit is the size at which the sum of
//! squares measured would be exceeded, or not be reached, by the wanted share. Its distribution is taken for
//! that of a scaled χ² with the same mean and variance (Patnaik, Biometrika 36 (1949) 202).

use nalgebra::{DMatrix, DVector};

use super::NoiseFound;
use super::distribution::{bisect, chi_square_cdf};
use super::linear::{Linear, dot};
use super::modes::Modes;
use super::places::Places;
use asphera_form::NM_PER_MM;

/// The RMS about the nominal with the part of the noise in it.
///
/// The figure without noise is one of its own: reports must not call it the RMS.
#[derive(Clone, Debug, PartialEq)]
pub struct RmsUncertainty {
    /// RMS of the residuals as measured, in nm.
    pub measured_nm: f64,
    /// RMS that the errors of the points alone would leave after the fit, in nm.
    pub noise_nm: f64,
    /// RMS of the form without noise in nm: the root of the difference of the squares, 0 if that is negative.
    pub form_nm: f64,
    /// Standard uncertainty of `form_nm` in nm: half the width of its 68.27 % interval.
    pub u_nm: f64,
    spread: Spread,
}

/// What the distribution of the sum of squares is made of, in mm² and mm⁴.
#[derive(Clone, Debug, PartialEq)]
struct Spread {
    points: f64,
    /// |r|².
    square: f64,
    /// tr A.
    noise: f64,
    /// Variance of the estimate |r|² − tr A where there is no form.
    variance: f64,
    /// Directions in which the errors have a variance of their own.
    directions: Vec<Direction>,
    /// Largest of their variances.
    largest: f64,
    /// Variance of the independent noise of a point after the fit.
    own: f64,
}

/// A direction in the space of the residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Direction {
    /// Square of the residuals along it; of the last one, which holds all without correlation, less the noise.
    square: f64,
    /// Variance of the errors along it.
    variance: f64,
}

impl RmsUncertainty {
    /// An interval in nm that holds the RMS of the form with probability `confidence`, the same share
    /// missing at either end.
    pub fn interval_nm(&self, confidence: f64) -> [f64; 2] {
        let tail = 0.5 * (1.0 - confidence);
        [1.0 - tail, tail]
            .map(|share| (self.spread.limit(share) / self.spread.points).sqrt() * NM_PER_MM)
    }

    /// `noise_mm2` is the independent variance of each point, which `shared_by` neighbours have in common; `covariance` that of the
    /// parameters by it; `found` how well it is known.
    ///
    /// Shared noise has a larger variance along smooth form, Σ C of a row, and Σ C² for Σ C(0)²: a half of the points as C is Gaussian. `O(n·p² + N·m² + m³)` for N nodes
    /// and m functions.
    pub(super) fn new(
        linear: &Linear,
        modes: &Modes,
        (noise_mm2, shared_by): (&[f64], f64),
        covariance: &DMatrix<f64>,
        found: &NoiseFound,
    ) -> RmsUncertainty {
        let p = linear.parameters.len();
        // The diagonal of P·D·Pᵀ: D − 2·D·(J·G) + J·C·Jᵀ.
        let of_point = |place: usize| {
            let row = linear.row(place);
            let moved: f64 = (0..p)
                .map(|i| (0..p).map(|j| row[i] * covariance[(i, j)] * row[j]).sum::<f64>())
                .sum();
            noise_mm2[place] * (1.0 - 2.0 * dot(row, linear.gain(place))) + moved
        };
        let independent = (0..linear.len()).map(of_point).sum::<f64>().max(0.0);
        let freedom = (linear.len() - p) as f64;
        let all: f64 = noise_mm2.iter().sum();
        let fourth: f64 = noise_mm2.iter().map(|variance| variance * variance).sum();
        let trace_square = if all > 0.0 { fourth * (independent / all).powi(2) } else { 0.0 };
        // Before the fit takes p degrees of freedom, n of them.
        let trace_square = trace_square * linear.len() as f64 / freedom;
        let own = independent / freedom;

        let square: f64 = linear.distances_mm.iter().map(|distance| distance * distance).sum();
        let mut directions = correlated(modes);
        let (mut trace, mut variance) =
            (independent, 2.0 * trace_square * (0.5 * shared_by).max(1.0));
        let mut rest = square - (freedom - directions.len() as f64).max(0.0) * own;
        for direction in &mut directions {
            let eigenvalue = direction.variance;
            trace += eigenvalue;
            variance += 2.0 * eigenvalue * (eigenvalue + 2.0 * own);
            rest -= direction.square;
            // A long wave that stands for shared noise has its spectral density at long wavelengths, and less at shorter ones.
            direction.variance = (eigenvalue + own).max(own * shared_by);
        }
        directions.push(Direction { square: rest.max(0.0), variance: own * shared_by });
        variance += by_measuring(independent, freedom, found.measured.then_some(found.dof));
        // Half of what may be form is taken for it.
        let by_form = 0.5 * linear.len() as f64 * found.by_form_mm2;
        variance += by_form * by_form;
        trace -= by_form.min(independent);
        let spread = Spread {
            points: linear.len() as f64,
            square,
            noise: trace,
            variance: variance.max(0.0),
            largest: directions.iter().fold(0.0, |most, direction| direction.variance.max(most)),
            directions,
            own,
        };
        let nm = |square: f64| (square.max(0.0) / spread.points).sqrt() * NM_PER_MM;
        RmsUncertainty {
            measured_nm: nm(square),
            noise_nm: nm(trace),
            form_nm: 0.0,
            u_nm: 0.0,
            spread,
        }
        .told()
    }

    /// The form and its uncertainty, by the spread.
    fn told(mut self) -> RmsUncertainty {
        let Spread { points, square, noise, .. } = self.spread;
        self.form_nm = ((square - noise).max(0.0) / points).sqrt() * NM_PER_MM;
        let [low, high] = self.interval_nm(ONE_SIGMA);
        self.u_nm = 0.5 * (high - low);
        self
    }

    /// The same with the form over the area, of points that stand for `shares` of it. Where shares differ, the noise counts
    /// by them, and correlated errors as they do of points that count alike.
    pub(super) fn over(
        mut self,
        places: &Places,
        shares: &[f64],
        noise_mm2: &[f64],
    ) -> RmsUncertainty {
        let spread = &mut self.spread;
        let points = spread.points;
        let mean_mm2 = noise_mm2.iter().sum::<f64>() / points;
        let own = spread.own;
        if mean_mm2 > 0.0 {
            let by_share = noise_mm2.iter().zip(shares).map(|(variance, share)| variance * share);
            // What the fit takes of the noise it takes of either mean.
            spread.noise += points * own * (by_share.sum::<f64>() / mean_mm2 - 1.0);
        }
        let noise_nm = mean_mm2.sqrt() * NM_PER_MM;
        let square = points * places.mean_square_nm2(noise_nm) / (NM_PER_MM * NM_PER_MM);
        spread.variance = spread.variance * places.crowding
            + points * points * places.variance_nm4(noise_nm) / NM_PER_MM.powi(4);
        if let Some(all) = spread.directions.last_mut() {
            all.square = (all.square + square - spread.square).max(0.0);
            all.variance *= places.crowding;
            spread.largest = spread.largest.max(all.variance);
        }
        spread.square = square;
        self.told()
    }
}

impl Spread {
    /// The sum of squares of the form for which the one measured is not exceeded with probability `share`;
    /// 0 if none is.
    fn limit(&self, share: f64) -> f64 {
        if self.largest == 0.0 && self.variance == 0.0 {
            return (self.square - self.noise).max(0.0);
        }
        if self.below(0.0, 0.0) <= share {
            return 0.0;
        }
        // ln(1 + λ·largest): forms from nothing to beyond the residuals themselves.
        let form = |logarithm: f64| self.form((-logarithm).exp());
        let is_more = |logarithm: f64| {
            let (size, along) = form(logarithm);
            self.below(size, along) > share
        };
        if !is_more(WIDEST) {
            return form(bisect(-WIDEST, WIDEST, is_more)).0;
        }
        // The residuals have nothing in the direction of the largest errors; a larger form must.
        let (size, along) = form(WIDEST);
        let beyond = |more: f64| self.below(size + more, along + more * self.largest) > share;
        let mut high = self.square.max(self.noise);
        while beyond(high) {
            high *= 2.0;
        }
        size + bisect(0.0, high, beyond)
    }

    /// |e|² and eᵀ·A·e of e = (I + λ·A)⁻¹·r, for 1 + λ·largest.
    fn form(&self, shrunk: f64) -> (f64, f64) {
        self.directions.iter().fold((0.0, 0.0), |(size, along), direction| {
            // A share of 0 belongs to noise of variance 0, if there is any other.
            let share = if self.largest > 0.0 { direction.variance / self.largest } else { 1.0 };
            let left = 1.0 + (shrunk - 1.0) * share;
            let square = direction.square / (left * left);
            (size + square, along + square * direction.variance)
        })
    }

    /// P(|r|² ≤ that measured) for a form of that size, with eᵀ·A·e.
    fn below(&self, size: f64, along: f64) -> f64 {
        let (mean, variance) = (size + self.noise, 4.0 * along + self.variance);
        let scale = 0.5 * variance / mean;
        if scale > 0.0 && scale.is_finite() {
            chi_square_cdf(self.square / scale, mean / scale)
        } else {
            f64::from(mean <= self.square)
        }
    }
}

/// The directions of the correlated errors: eigenvalues of Σ ṽ·ṽᵀ, and the residuals along them.
fn correlated(modes: &Modes) -> Vec<Direction> {
    let m = modes.functions();
    if m == 0 {
        return Vec::new();
    }
    let mut functions = DMatrix::zeros(modes.nodes.len(), m);
    let mut distances = DVector::zeros(modes.nodes.len());
    for (index, (node, values)) in modes.nodes.iter().zip(&modes.residual_mm).enumerate() {
        // Rows by the root of their weight: then the products are sums over all points.
        let root = node.count.sqrt();
        values.iter().enumerate().for_each(|(k, value)| functions[(index, k)] = root * value);
        distances[index] = root * node.distance_mm;
    }
    let along = functions.tr_mul(&distances);
    let eigen = functions.tr_mul(&functions).symmetric_eigen();
    let largest = eigen.eigenvalues.max();
    let pairs = eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter());
    pairs
        .filter(|&(&value, _)| value > NEGLIGIBLE * largest && value > 0.0)
        .map(|(&value, vector)| Direction {
            square: vector.dot(&along).powi(2) / value,
            variance: value,
        })
        .collect()
}

/// What it adds to the variance that the noise was measured from the same points: for an estimate with ν
/// degrees of freedom of a trace t whose best estimate would have ν₀, 2·t²·(1/ν − 2/ν₀), since the error of the
/// best estimate is uncorrelated with what another lacks (Hausman, Econometrica 46 (1978) 1251).
fn by_measuring(trace: f64, best_dof: f64, dof: Option<f64>) -> f64 {
    dof.map_or(0.0, |dof| 2.0 * trace * trace * (1.0 / dof - 2.0 / best_dof))
}

/// Probability within one standard deviation of a normal distribution.
pub(super) const ONE_SIGMA: f64 = 0.682_689_492_137_086;
/// Eigenvalues below this share of the largest are rounding.
const NEGLIGIBLE: f64 = 1e-12;
/// ln of the widest range of sizes: 1e-9 to 1e9 times the residuals along the largest errors.
const WIDEST: f64 = 20.0;
