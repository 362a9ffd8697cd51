//! How blocks go together, and what those that were measured say of the others.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use asphera_geometry::Numbers;

use crate::Kernel;

/// What one correlation says of the blocks that were not measured: Student's distribution.
#[derive(Clone, Debug)]
pub(super) struct Posterior {
    /// Their numbers.
    rest: Vec<usize>,
    /// Their means, nm.
    mean_nm: DVector<f64>,
    /// A root of their covariance for σ = 1 nm.
    root: DMatrix<f64>,
    /// Sum of squares of generalised least squares in nm², and its degrees of freedom.
    square_nm2: f64,
    freedom: f64,
}

impl Posterior {
    /// One draw: numbers of blocks and their means in nm.
    pub(super) fn draw(&self, numbers: &Numbers) -> Vec<(usize, f64)> {
        let count = self.rest.len();
        let sigma_nm = (self.square_nm2 / chi_square(self.freedom, numbers.normal(count))).sqrt();
        let normal = DVector::from_fn(count, |i, _| numbers.normal(i));
        let values = &self.mean_nm + &self.root * normal * sigma_nm;
        self.rest.iter().copied().zip(values.iter().copied()).collect()
    }
}

/// A number of the χ² distribution from a normal one (Wilson & Hilferty, PNAS 17 (1931) 684).
fn chi_square(freedom: f64, normal: f64) -> f64 {
    let part = 2.0 / (9.0 * freedom);
    freedom * (1.0 - part + normal * part.sqrt()).max(0.05).powi(3)
}

/// The correlations that count with their probabilities, by the blocks `seen`. `trend` has a column for each that the fit
/// takes off. `None` where none can be judged.
pub(super) fn posteriors(
    places_mm: &[[f64; 2]],
    means_nm: &[f64],
    trend: &DMatrix<f64>,
    seen: &[usize],
) -> Option<Vec<(f64, Posterior)>> {
    let rest: Vec<usize> =
        (0..places_mm.len()).filter(|at| seen.binary_search(at).is_err()).collect();
    let apart = |from: &[usize], to: &[usize]| {
        DMatrix::from_fn(from.len(), to.len(), |i, j| {
            let (a, b) = (places_mm[from[i]], places_mm[to[j]]);
            (a[0] - b[0]).hypot(a[1] - b[1])
        })
    };
    let problem = Problem {
        between: apart(seen, &rest),
        of_rest: apart(&rest, &rest),
        of_seen: apart(seen, seen),
        values: DVector::from_iterator(seen.len(), seen.iter().map(|&at| means_nm[at])),
        trend: trend.select_rows(seen),
        trend_of_rest: trend.select_rows(&rest),
        rest,
    };
    let candidates = problem.candidates();
    let judged: Vec<(f64, Candidate)> = candidates
        .par_iter()
        .filter_map(|&candidate| Some((problem.whitened(candidate)?.likelihood(), candidate)))
        .filter(|(likelihood, _)| likelihood.is_finite())
        .collect();
    let most = judged.iter().map(|(likelihood, _)| *likelihood).fold(f64::NEG_INFINITY, f64::max);
    let chance = |likelihood: f64| (likelihood - most).exp();
    let all: f64 = judged.iter().map(|(likelihood, _)| chance(*likelihood)).sum();
    let counting: Vec<(f64, Candidate)> = judged
        .into_iter()
        .map(|(likelihood, candidate)| (chance(likelihood) / all, candidate))
        .filter(|(chance, _)| *chance > NEGLIGIBLE)
        .collect();
    let posteriors = counting
        .par_iter()
        .map(|&(chance, candidate)| Some((chance, problem.posterior(candidate)?)))
        .collect::<Option<Vec<(f64, Posterior)>>>()?;
    (!posteriors.is_empty()).then_some(posteriors)
}

/// Kernel, length in mm, and variance that is independent from block to block over that of the wave.
type Candidate = (Kernel, f64, f64);

struct Problem {
    rest: Vec<usize>,
    /// Distances in mm.
    of_seen: DMatrix<f64>,
    between: DMatrix<f64>,
    of_rest: DMatrix<f64>,
    values: DVector<f64>,
    trend: DMatrix<f64>,
    trend_of_rest: DMatrix<f64>,
}

/// Values and trend made independent: L⁻¹·z and L⁻¹·X = Q·R for V = L·Lᵀ.
struct Whitened {
    root: DMatrix<f64>,
    q: DMatrix<f64>,
    r: DMatrix<f64>,
    /// Of the values along the trend, and beyond it.
    along: DVector<f64>,
    left: DVector<f64>,
}

impl Whitened {
    fn freedom(&self) -> f64 {
        (self.q.nrows() - self.q.ncols()) as f64
    }

    fn square(&self) -> f64 {
        self.left.norm_squared().max(f64::MIN_POSITIVE)
    }

    /// Logarithm of the restricted likelihood, σ² integrated out.
    fn likelihood(&self) -> f64 {
        let log_size: f64 = self.root.diagonal().map(f64::ln).sum();
        let of_trend: f64 = self.r.diagonal().map(|entry| entry.abs().ln()).sum();
        -log_size - of_trend - 0.5 * self.freedom() * self.square().ln()
    }
}

impl Problem {
    /// Lengths from that of a block to twice the part.
    fn candidates(&self) -> Vec<Candidate> {
        let largest = self.of_seen.max().max(self.between.max());
        let least = self.of_seen.iter().copied().filter(|&apart| apart > 0.0);
        let least = least.fold(largest, f64::min);
        let ratio = (2.0 * largest / least).ln() / (LENGTHS - 1) as f64;
        let lengths = (0..LENGTHS).map(|index| least * (ratio * index as f64).exp());
        let of_length = |length: f64| {
            KERNELS.into_iter().flat_map(move |kernel| RESTS.map(|rest| (kernel, length, rest)))
        };
        lengths.flat_map(of_length).collect()
    }

    fn whitened(&self, (kernel, length_mm, rest): Candidate) -> Option<Whitened> {
        let mut covariance = self.of_seen.map(|apart| kernel.correlation(apart / length_mm));
        covariance.fill_diagonal(1.0 + rest);
        let root = covariance.cholesky()?.unpack();
        let white = root.solve_lower_triangular(&self.values)?;
        let (q, r) = root.solve_lower_triangular(&self.trend)?.qr().unpack();
        let along = q.tr_mul(&white);
        let left = &white - &q * &along;
        Some(Whitened { root, q, r, along, left })
    }

    fn posterior(&self, candidate: Candidate) -> Option<Posterior> {
        let (kernel, length_mm, rest) = candidate;
        let white = self.whitened(candidate)?;
        let between = self.between.map(|apart| kernel.correlation(apart / length_mm));
        let known = white.root.solve_lower_triangular(&between)?;
        // What the trend adds at the rest beyond what the values tell: X_u − K·V⁻¹·X, in units of R.
        let beyond = &self.trend_of_rest.transpose() - white.r.tr_mul(&white.q.tr_mul(&known));
        let beyond = white.r.transpose().solve_lower_triangular(&beyond)?;
        let mean_nm = known.tr_mul(&white.left)
            + known.tr_mul(&(&white.q * &white.along))
            + beyond.tr_mul(&white.along);
        let mut covariance = self.of_rest.map(|apart| kernel.correlation(apart / length_mm));
        covariance.fill_diagonal(1.0 + rest);
        covariance += beyond.tr_mul(&beyond) - known.tr_mul(&known);
        let root = if self.rest.is_empty() { covariance } else { covariance.cholesky()?.unpack() };
        Some(Posterior {
            rest: self.rest.clone(),
            mean_nm,
            root,
            square_nm2: white.square(),
            freedom: white.freedom(),
        })
    }
}

/// Kernels that are no smoother than polished form: smoother ones would be too sure of what lies beyond.
const KERNELS: [Kernel; 2] = [Kernel::Matern, Kernel::Exponential];
const LENGTHS: usize = 6;
/// Variance of a block by itself over that of the wave.
const RESTS: [f64; 4] = [1e-3, 0.03, 1.0, 30.0];
/// A correlation that is less likely than this is left out.
const NEGLIGIBLE: f64 = 5e-3;
