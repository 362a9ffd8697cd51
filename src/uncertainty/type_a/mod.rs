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
//! ratios w count by their likelihood, a priori alike but for the length: as likely for each step of 1/ℓ, the wave
//! number. That there is no wave at all is a priori as likely as that there is one. Under one of them the error of
//! a parameter over its standard deviation has Student's distribution with m degrees of freedom; over all it has
//! the mixture of these (Berger, De Oliveira & Sansó, J. Am. Stat. Assoc. 96 (2001) 1361, on marginalised rather
//! than plugged-in correlation). Its variance would be that of the few longest waves that are not ruled out, so a
//! standard uncertainty is taken from the interval that holds 68.27 %.
//!
//! *What is meant.* The value of another part of this make, or of this one under another error of so long waves: the
//! random function drawn anew, the points where they are. It is not how far the best fit to this very part depends on
//! which points were taken: [`asphera_form::Estimate::u`] tells that, and no correlation is in it, for the form stays. Over
//! random functions drawn anew u of parameters that bend the surface is right to a tenth or two whatever the function,
//! height and tilts where ℓ is below a third of the part. Beyond, heights and tilts may be 0.7 to 1.6 times as
//! uncertain, and of waves longer than the part no number made from the deviations can tell: they look as a change of
//! its parameters.

mod glance;
mod patches;
#[cfg(test)]
mod tests;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::Expanded;
use super::budget::{Kernel, UncertaintyError};
use super::distribution::student_cdf;
use super::linear::Linear;
use asphera_form::{Aperture, Covariance, Fit, Freedoms, Parameter, PointMm};
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
    /// The most likely correlation, if there is one.
    pub correlation: Correlation,
    /// How likely each kernel is, whatever its length, if there is one; they add up to 1.
    pub kernels: [(Kernel, f64); 3],
    /// How likely it is that there is none: that deviations are independent from patch to patch.
    pub independent: f64,
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
    /// Its standard uncertainty in the same unit: half the width of the interval that holds 68.27 %.
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
        let expanded = half_width(&self.mixture, self.dof, p);
        let k = if self.u > 0.0 { expanded / self.u } else { 0.0 };
        Expanded { expanded, k, p, dof: self.dof }
    }
}

/// The uncertainties of the parameters of `fit` over the `points` it was made from, by their deviations alone.
///
/// The measurand is what fits to parts of this make would give on the average: what remains after the fit is
/// taken for a sample of what every such part has. The best fit to this very part is known better: see
/// [`asphera_form::Estimate::u`]. Errors of the machine that no deviation shows are not in it;
/// [`super::uncertainty()`] takes them from a budget. `aperture` is that of the settings of the fit and
/// `uncertainties_mm` those of [`asphera_form::fit_weighted`], if it had any. `O(n·p² + n·log n)`, and some tenths of
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
    let judged = Judge::new(patches, &fit.freedoms).judge(&deviations);
    let chances = chances(&judged, 0);
    let freedom = (patches.len() - p) as f64;
    let parameters = fit.estimates.iter().enumerate().map(|(index, estimate)| {
        let mixture = mixture(&judged, &chances, index, freedom, 0);
        let u = half_width(&mixture, freedom, ONE_SIGMA);
        let (parameter, value) = (estimate.parameter, estimate.value);
        TypeAParameter { parameter, value, u, dof: freedom, mixture }
    });
    let parameters: Vec<TypeAParameter> = parameters.collect();
    TypeA {
        covariance: covariance(&judged, &chances, &parameters),
        parameters,
        patches: patches.len(),
        independence,
        ..waves(&judged, &chances, freedom)
    }
}

/// Correlated as the mixture is, with the variances of the parameters.
fn covariance(judged: &[Judged], chances: &[f64], parameters: &[TypeAParameter]) -> Covariance {
    let p = parameters.len();
    let mut mixed = DMatrix::zeros(p, p);
    for (of, chance) in judged.iter().zip(chances) {
        mixed += &of.covariance * (chance * of.squares[0]);
    }
    let scale = |index: usize| {
        let root: f64 = mixed[(index, index)].sqrt();
        if root > 0.0 { parameters[index].u / root } else { 0.0 }
    };
    let entries = DMatrix::from_fn(p, p, |i, j| mixed[(i, j)] * scale(i) * scale(j));
    Covariance::new(p, entries.as_slice(), 1.0)
}

/// Estimate of the waves, without parameters.
fn waves(judged: &[Judged], chances: &[f64], freedom: f64) -> TypeA {
    let of_waves = || {
        let each = judged.iter().zip(chances);
        each.filter_map(|(of, &chance)| Some((of.wave?, of, chance)))
    };
    let any: f64 = of_waves().map(|(.., chance)| chance).sum();
    let mut kernels = KERNELS.map(|kernel| (kernel, 1.0 / KERNELS.len() as f64));
    if any > 0.0 {
        for (kernel, share) in &mut kernels {
            let own = of_waves().filter(|(wave, ..)| wave.kernel == *kernel);
            *share = own.map(|(.., chance)| chance).sum::<f64>() / any;
        }
    }
    let best = of_waves().reduce(|best, one| if one.2 > best.2 { one } else { best });
    let (wave, of, _) = best.expect("an exponential wave with a rest is always regular");
    let sigma_mm = (of.squares[0] / freedom).sqrt();
    TypeA {
        parameters: Vec::new(),
        covariance: Covariance::new(0, &[], 1.0),
        correlation: Correlation {
            kernel: wave.kernel,
            length_mm: wave.length_mm,
            sigma_mm,
            rest_mm: sigma_mm * wave.rest.sqrt(),
        },
        kernels,
        independent: (1.0 - any).max(0.0),
        patches: 0,
        independence: None,
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

/// Half the width of the interval about 0 that holds the probability `p` of a mixture.
fn half_width(mixture: &[(f64, f64)], dof: f64, p: f64) -> f64 {
    let mut high = mixture.iter().map(|&(_, scale)| scale).fold(0.0, f64::max);
    while high.is_normal() && outside(mixture, high, dof) > 1.0 - p {
        high *= 2.0;
    }
    let mut low = 0.0;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if outside(mixture, middle, dof) > 1.0 - p { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Probability and scale of one parameter under every correlation of some likelihood.
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
    let likely = judged.iter().zip(chances).filter(|&(_, &chance)| chance > NEGLIGIBLE);
    likely.map(|(of, &chance)| (chance, scale(of))).collect()
}

/// The patches, made ready for many correlations.
struct Judge {
    /// Distances of the patches in mm.
    apart_mm: DMatrix<f64>,
    /// An orthonormal basis of the derivatives.
    basis: DMatrix<f64>,
    gains: DMatrix<f64>,
    /// The waves that may be, and that there is none.
    candidates: Vec<Candidate>,
}

/// A correlation that may be.
#[derive(Clone, Copy)]
struct Candidate {
    /// `None`: deviations are independent from patch to patch.
    wave: Option<Wave>,
    /// How likely it is before anything is seen, over what others are.
    before: f64,
}

/// A wave that may be.
#[derive(Clone, Copy)]
struct Wave {
    kernel: Kernel,
    length_mm: f64,
    /// Variance that is independent from patch to patch over that of the wave.
    rest: f64,
}

/// Samples of deviations under one correlation.
struct Judged {
    wave: Option<Wave>,
    before: f64,
    /// Covariance of the parameters for σ = 1 mm, or for so much of what is independent where there is no wave.
    covariance: DMatrix<f64>,
    /// For each sample the sum of squares of generalised least squares in mm².
    squares: Vec<f64>,
    /// For each sample the logarithm of the restricted likelihood.
    likelihoods: Vec<f64>,
}

impl Judge {
    fn new(patches: &[Patch], freedoms: &Freedoms) -> Judge {
        let (n, p) = (patches.len(), patches.first().map_or(0, |patch| patch.row.len()));
        let apart_mm = DMatrix::from_fn(n, n, |i, j| {
            let (a, b) = (patches[i].place_mm, patches[j].place_mm);
            (a[0] - b[0]).hypot(a[1] - b[1])
        });
        let mut rows = DMatrix::from_fn(n, p, |i, j| patches[i].row[j]);
        if let Some(directions) = freedoms.directions() {
            rows *= directions;
        }
        for mut column in rows.column_iter_mut() {
            let length = column.norm();
            if length > 0.0 {
                column /= length;
            }
        }
        Judge {
            candidates: candidates(&lengths_mm(&apart_mm)),
            basis: if rows.ncols() == 0 { rows } else { rows.qr().q() },
            gains: DMatrix::from_fn(n, p, |i, j| patches[i].gain[j]),
            apart_mm,
        }
    }

    /// One sample of deviations a column. `O(N³)` a correlation for N patches.
    fn judge(&self, deviations_mm: &DMatrix<f64>) -> Vec<Judged> {
        let under = |&candidate: &Candidate| self.under(candidate, deviations_mm);
        self.candidates.par_iter().filter_map(under).collect()
    }

    /// `None` where the correlation is too near to singular.
    fn under(
        &self,
        Candidate { wave, before }: Candidate,
        deviations_mm: &DMatrix<f64>,
    ) -> Option<Judged> {
        let correlation = match wave {
            None => DMatrix::identity(self.apart_mm.nrows(), self.apart_mm.ncols()),
            Some(Wave { kernel, length_mm, rest }) => {
                let mut correlation =
                    self.apart_mm.map(|apart| kernel.correlation(apart / length_mm));
                correlation.fill_diagonal(1.0 + rest);
                correlation
            }
        };
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
        finite.then_some(Judged { wave, before, covariance, squares, likelihoods })
    }
}

/// Probability of each correlation by one sample.
fn chances(judged: &[Judged], sample: usize) -> Vec<f64> {
    let most = judged.iter().map(|of| of.likelihoods[sample]).fold(f64::NEG_INFINITY, f64::max);
    let share = |of: &Judged| of.before * (of.likelihoods[sample] - most).exp();
    let shares: Vec<f64> = judged.iter().map(share).collect();
    let all: f64 = shares.iter().sum();
    shares.iter().map(|share| share / all).collect()
}

/// The waves that may be over some lengths, and last that there is none.
fn candidates(lengths_mm: &[f64]) -> Vec<Candidate> {
    let waves = lengths_mm.iter().flat_map(|&length_mm| {
        // Lengths in equal ratios stand for equal steps of 1/ℓ by 1/ℓ.
        let before = lengths_mm[0] / length_mm;
        KERNELS.into_iter().flat_map(move |kernel| {
            RESTS.map(|rest| Candidate { wave: Some(Wave { kernel, length_mm, rest }), before })
        })
    });
    let mut candidates: Vec<Candidate> = waves.collect();
    let before = candidates.iter().map(|candidate| candidate.before).sum();
    candidates.push(Candidate { wave: None, before });
    candidates
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
/// After which the half width of an interval is known to 1e-9 of the largest scale.
const HALVINGS: usize = 32;
/// The probability of ±1 standard deviation of a normal distribution.
const ONE_SIGMA: f64 = 0.682_689_492_137_085_9;
/// Probability of a correlation that does not show in an interval, nor do all such together.
const NEGLIGIBLE: f64 = 1e-8;
/// Fewer deviations than these beyond the parameters have no correlation to see.
const LEAST_FREEDOM: usize = 8;
