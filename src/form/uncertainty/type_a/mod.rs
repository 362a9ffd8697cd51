//! How well a fit is known, judged from nothing but its own deviations.
//!
//! A form deviation is no noise: it goes on in the same sense over millimetres, so that n points tell far less
//! than n independent ones would, and the covariance of [`crate::Fit`] is too small. What follows from a
//! covariance C of the deviations is G·C·Gᵀ (see [`super::uncertainty()`]); here C comes from the deviations.
//!
//! They are taken for one sample of a random function of stationary covariance `σ²·(ρ(h/ℓ) + w·[h = 0])`: a wave
//! with the correlation ρ of a [`Kernel`] over the length ℓ, and a rest that is independent from patch to patch
//! (noise, and waves shorter than a patch). A fit absorbs a part of long waves, so deviations are correlated
//! less than what made them, and an empirical autocovariance would be too small where it matters most. The
//! restricted likelihood has no such bias, because it only looks at combinations of the deviations that no
//! change of parameters alters (Patterson & Thompson, Biometrika 58 (1971) 545). With V = ρ + w, X the
//! derivatives of the m + p patch means by the p parameters, and q the sum of squares of generalised least
//! squares, its logarithm is `−½·(ln|V| + ln|XᵀV⁻¹X| + m·ln q)` once σ² is integrated out.
//!
//! Little is known of ρ, ℓ and w from a single part, above all of waves as long as itself. So none is chosen:
//! all three kernels, lengths from the distance of the patches up to the largest extent of the part, and eight
//! ratios w, each a priori as likely as the next, count by their likelihood. Under one of them the error of a
//! parameter over its standard deviation has Student's distribution with m degrees of freedom; over all it has
//! the mixture of these (Berger, De Oliveira & Sansó, J. Am. Stat. Assoc. 96 (2001) 1361, on marginalised rather
//! than plugged-in correlation). Waves longer than the part look as curvature, tilt or shift of it; they belong
//! to the parameters, and no number made from the deviations can tell of them. For the same reason height and tilts
//! are overrated where deviations are mere noise: a weak wave of the size of the part cannot be ruled out.

mod glance;
mod patches;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::Expanded;
use super::budget::{Kernel, UncertaintyError};
use super::distribution::{bisect, student_cdf};
use super::linear::Linear;
use crate::{Aperture, Covariance, Fit, Parameter, PointMm};
use patches::{MOST, Patch, Sums, groups, patch};

pub use glance::glance;
pub use patches::Independence;

/// What the deviations of a fit tell of its parameters (a type A evaluation: JCGM 100:2008, 4.2).
#[derive(Clone, Debug, PartialEq)]
pub struct TypeA {
    /// One entry an estimate of the fit, in its order.
    pub parameters: Vec<TypeAParameter>,
    /// Covariances of the estimates, in their order.
    pub covariance: Covariance,
    /// The most likely correlation.
    pub correlation: Correlation,
    /// How likely each kernel is, whatever its length; they add up to 1.
    pub kernels: [(Kernel, f64); 3],
    /// Patches the correlation was judged by: at most 256.
    pub patches: usize,
    /// Whether the deviations could be independent; `None` where patches are single points, or nothing deviates.
    pub independence: Option<Independence>,
}

/// The correlation of deviations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correlation {
    /// How it falls with the distance.
    pub kernel: Kernel,
    /// Correlation length ℓ in mm.
    pub length_mm: f64,
    /// Standard deviation of the correlated part in mm.
    pub sigma_mm: f64,
    /// Standard deviation of the mean of a patch in mm by what is independent from patch to patch.
    pub rest_mm: f64,
}

/// The uncertainty of a parameter by the deviations.
#[derive(Clone, Debug, PartialEq)]
pub struct TypeAParameter {
    /// Which.
    pub parameter: Parameter,
    /// Its value in [`Parameter::unit`].
    pub value: f64,
    /// Its standard uncertainty in the same unit.
    pub u: f64,
    /// Degrees of freedom of each Student's distribution in the mixture: patches less parameters.
    pub dof: f64,
    /// Probability and scale, in the unit of the parameter, of each of them.
    mixture: Vec<(f64, f64)>,
}

impl TypeAParameter {
    /// The half width of the interval about the value that holds the truth with probability `p`, above 0 and
    /// below 1.
    pub fn expanded(&self, p: f64) -> Expanded {
        let outside = |half: f64| outside(&self.mixture, half, self.dof);
        let mut high = self.u;
        while high.is_normal() && outside(high) > 1.0 - p {
            high *= 2.0;
        }
        let expanded = bisect(0.0, high, |half| outside(half) > 1.0 - p);
        let k = if self.u > 0.0 { expanded / self.u } else { 0.0 };
        Expanded { expanded, k, p, dof: self.dof }
    }
}

/// The uncertainties of the parameters of `fit` over the `points` it was made from, by their deviations alone.
///
/// The measurand is what fits to parts of this make would give on the average: what remains after the fit is
/// taken for a sample of what every such part has. Errors of the machine that no deviation shows are not in it;
/// [`super::uncertainty()`] takes them from a budget. `aperture` is that of the settings of the fit and
/// `uncertainties_mm` those of [`crate::fit_weighted`], if it had any. `O(n·p² + n·log n)`, and some tenths of
/// a second for the patches.
pub fn type_a(
    points: &[PointMm],
    fit: &Fit,
    aperture: &Aperture,
    uncertainties_mm: Option<&[f64]>,
) -> Result<TypeA, UncertaintyError> {
    let linear = Linear::new(points, fit, aperture, uncertainties_mm)?;
    let (patches, sums): (Vec<Patch>, Vec<Sums>) =
        groups(&linear, MOST).iter().map(|group| patch(group, &linear)).unzip();
    let p = linear.parameters.len();
    if patches.len() < p + LEAST_FREEDOM {
        return Err(UncertaintyError::TooFewPoints {
            used: patches.len(),
            needed: p + LEAST_FREEDOM,
        });
    }
    Ok(found(fit, &patches, Independence::new(&sums, p)))
}

/// What some patches tell of the parameters of a fit; they are more than these.
fn found(fit: &Fit, patches: &[Patch], independence: Option<Independence>) -> TypeA {
    let p = fit.estimates.len();
    let deviations = DMatrix::from_fn(patches.len(), 1, |i, _| patches[i].deviation_mm);
    let judged = Judge::new(patches).judge(&deviations);
    let chances = chances(&judged, 0);
    let freedom = (patches.len() - p) as f64;
    // The variance of Student's distribution over the square of its scale.
    let wider = freedom / (freedom - 2.0);
    let mut covariance = DMatrix::zeros(p, p);
    for (of, chance) in judged.iter().zip(&chances) {
        covariance += &of.covariance * (wider * chance * of.squares[0] / freedom);
    }
    let parameters = fit.estimates.iter().enumerate().map(|(index, estimate)| TypeAParameter {
        parameter: estimate.parameter,
        value: estimate.value,
        u: covariance[(index, index)].sqrt(),
        dof: freedom,
        mixture: mixture(&judged, &chances, index, freedom, 0),
    });
    let mut kernels = KERNELS.map(|kernel| (kernel, 0.0));
    for (of, chance) in judged.iter().zip(&chances) {
        let own = kernels.iter_mut().find(|(kernel, _)| *kernel == of.kernel);
        own.into_iter().for_each(|(_, sum)| *sum += chance);
    }
    let first = (0, f64::NEG_INFINITY);
    let (best, _) = chances
        .iter()
        .enumerate()
        .fold(first, |best, (index, &chance)| if chance > best.1 { (index, chance) } else { best });
    let sigma_mm = (judged[best].squares[0] / freedom).sqrt();
    TypeA {
        parameters: parameters.collect(),
        covariance: Covariance::new(p, covariance.as_slice(), 1.0),
        correlation: Correlation {
            kernel: judged[best].kernel,
            length_mm: judged[best].length_mm,
            sigma_mm,
            rest_mm: sigma_mm * judged[best].rest.sqrt(),
        },
        kernels,
        patches: patches.len(),
        independence,
    }
}

/// Probability of a value farther than `half` from 0 under a mixture of Student's distributions.
fn outside(mixture: &[(f64, f64)], half: f64, dof: f64) -> f64 {
    let beyond = |&(chance, scale): &(f64, f64)| {
        let t = if scale > 0.0 { half / scale } else { f64::INFINITY };
        2.0 * chance * (1.0 - student_cdf(t, dof))
    };
    mixture.iter().map(beyond).sum()
}

/// Probability and scale of one parameter under every correlation.
fn mixture(
    judged: &[Judged],
    chances: &[f64],
    parameter: usize,
    freedom: f64,
    sample: usize,
) -> Vec<(f64, f64)> {
    let scale = |of: &Judged| {
        (of.covariance[(parameter, parameter)] * of.squares[sample] / freedom).max(0.0).sqrt()
    };
    judged.iter().zip(chances).map(|(of, &chance)| (chance, scale(of))).collect()
}

/// The patches, made ready for many correlations.
struct Judge {
    /// Distances of the patches in mm.
    apart_mm: DMatrix<f64>,
    /// An orthonormal basis of the derivatives.
    basis: DMatrix<f64>,
    gains: DMatrix<f64>,
    /// The correlations that may be: kernel, length, share of the rest.
    candidates: Vec<(Kernel, f64, f64)>,
}

/// What one correlation makes of some samples of deviations.
struct Judged {
    kernel: Kernel,
    length_mm: f64,
    /// Variance that is independent from patch to patch over that of the wave.
    rest: f64,
    /// Covariance of the parameters for σ = 1 mm.
    covariance: DMatrix<f64>,
    /// For each sample the sum of squares of generalised least squares in mm².
    squares: Vec<f64>,
    /// For each sample the logarithm of the restricted likelihood.
    likelihoods: Vec<f64>,
}

impl Judge {
    fn new(patches: &[Patch]) -> Judge {
        let (n, p) = (patches.len(), patches.first().map_or(0, |patch| patch.row.len()));
        let apart_mm = DMatrix::from_fn(n, n, |i, j| {
            let (a, b) = (patches[i].place_mm, patches[j].place_mm);
            (a[0] - b[0]).hypot(a[1] - b[1])
        });
        let mut rows = DMatrix::from_fn(n, p, |i, j| patches[i].row[j]);
        for mut column in rows.column_iter_mut() {
            let length = column.norm();
            if length > 0.0 {
                column /= length;
            }
        }
        let candidates = lengths_mm(&apart_mm).into_iter().flat_map(|length_mm| {
            let kernels = KERNELS.into_iter();
            kernels.flat_map(move |kernel| RESTS.map(|rest| (kernel, length_mm, rest)))
        });
        Judge {
            candidates: candidates.collect(),
            basis: if p == 0 { rows } else { rows.qr().q() },
            gains: DMatrix::from_fn(n, p, |i, j| patches[i].gain[j]),
            apart_mm,
        }
    }

    /// One sample of deviations a column. `O(N³)` a correlation for N patches.
    fn judge(&self, deviations_mm: &DMatrix<f64>) -> Vec<Judged> {
        let under = |&candidate: &(Kernel, f64, f64)| self.under(candidate, deviations_mm);
        self.candidates.par_iter().filter_map(under).collect()
    }

    /// `None` where the correlation is too near to singular.
    fn under(
        &self,
        (kernel, length_mm, rest): (Kernel, f64, f64),
        deviations_mm: &DMatrix<f64>,
    ) -> Option<Judged> {
        let mut correlation = self.apart_mm.map(|apart| kernel.correlation(apart / length_mm));
        correlation.fill_diagonal(1.0 + rest);
        let covariance = self.gains.tr_mul(&(&correlation * &self.gains));
        let root = correlation.cholesky()?.unpack();
        let white = root.solve_lower_triangular(deviations_mm)?;
        let mut log_size = root.diagonal().map(f64::ln).sum();
        let left = if self.basis.ncols() == 0 {
            white
        } else {
            let (basis, r) = root.solve_lower_triangular(&self.basis)?.qr().unpack();
            log_size += r.diagonal().map(|entry| entry.abs().ln()).sum();
            &white - &basis * basis.tr_mul(&white)
        };
        let freedom = (self.basis.nrows() - self.basis.ncols()) as f64;
        let squares: Vec<f64> =
            left.column_iter().map(|column| column.norm_squared().max(f64::MIN_POSITIVE)).collect();
        let likelihoods = squares.iter().map(|square| -log_size - 0.5 * freedom * square.ln());
        let likelihoods: Vec<f64> = likelihoods.collect();
        let finite = likelihoods.iter().all(|likelihood| likelihood.is_finite());
        finite.then_some(Judged { kernel, length_mm, rest, covariance, squares, likelihoods })
    }
}

/// Probability of each correlation by one sample.
fn chances(judged: &[Judged], sample: usize) -> Vec<f64> {
    let most = judged.iter().map(|of| of.likelihoods[sample]).fold(f64::NEG_INFINITY, f64::max);
    let shares: Vec<f64> = judged.iter().map(|of| (of.likelihoods[sample] - most).exp()).collect();
    let all: f64 = shares.iter().sum();
    shares.iter().map(|share| share / all).collect()
}

/// Lengths in equal ratios from the middle distance of neighbouring patches to the largest of all.
fn lengths_mm(apart_mm: &DMatrix<f64>) -> Vec<f64> {
    let largest = apart_mm.max();
    if !(largest > 0.0 && largest.is_finite()) {
        return vec![1.0];
    }
    let nearest = |column: nalgebra::DVectorView<'_, f64>| {
        let others = column.iter().copied().filter(|&apart| apart > 0.0);
        others.fold(f64::INFINITY, f64::min)
    };
    let mut nearest: DVector<f64> =
        DVector::from_iterator(apart_mm.ncols(), apart_mm.column_iter().map(nearest));
    nearest.as_mut_slice().sort_unstable_by(f64::total_cmp);
    let least = nearest[nearest.len() / 2].min(largest);
    let ratio = (largest / least).ln() / (LENGTHS - 1) as f64;
    (0..LENGTHS).map(|index| least * (ratio * index as f64).exp()).collect()
}

/// All kernels there are.
const KERNELS: [Kernel; 3] = [Kernel::Gaussian, Kernel::Matern, Kernel::Exponential];
/// How many lengths.
const LENGTHS: usize = 9;
/// Variance of the rest over that of the wave: from hardly any, which keeps Gaussian kernels regular, to so much
/// that the wave is less than the mean of all patches is known to.
const RESTS: [f64; 8] = [1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0, 1e2, 1e3];
/// Fewer deviations than these beyond the parameters have no correlation to see.
const LEAST_FREEDOM: usize = 8;
