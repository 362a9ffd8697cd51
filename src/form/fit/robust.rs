//! Losses that let single points deviate: M-estimates by iteratively reweighted least squares.
//!
//! A point whose distance is e (over its uncertainty, if points have any) gets the weight ψ(e)/e of its loss
//! at the scale s, 1.4826·MAD of all e unless it is given, and the weighted problem is solved anew until it no longer moves
//! (Holland & Welsch, Commun. Statist. A 6 (1977) 813; Huber & Ronchetti, Robust Statistics, 2nd ed., 7.8).
//! The scale is found with Huber's loss, whose solution is unique where the problem is linear. Tukey's loss
//! has many; it starts from Huber's and keeps the scale found there.
//!
//! Uncertainties follow Huber & Ronchetti, eq. 7.87: `K²·Σψ²/(n−p) / mean(ψ′)²·(JᵀJ)⁻¹` with
//! `K = 1 + p/n·var(ψ′)/mean(ψ′)²`, J the Jacobian without the weights of the loss.

use rayon::prelude::*;

use crate::fit::model::Model;
use crate::fit::refine::{LeastSquares, Limits, Refined, refine};
use crate::fit::selection::Selection;
use crate::fit::triangle::CHUNK;
use crate::{FitError, Nominal, Parameter, Pose, Termination};

/// How much a deviation counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Loss {
    /// By its square: least squares.
    #[default]
    Squares,
    /// By its square up to k scales, and linearly beyond. Takes single outliers; a quarter of gross ones on
    /// one side moves the fit by about a scale.
    Huber {
        /// The bend in scales, above 0. 1.345 keeps 95 % of the efficiency for normal deviations.
        k: f64,
    },
    /// Not at all beyond k scales (Tukey's biweight). Takes gross outliers up to about a third of the points.
    Tukey {
        /// The end in scales, above 0. 4.685 keeps 95 % of the efficiency for normal deviations.
        k: f64,
    },
}

impl Loss {
    /// Huber's loss with k = 1.345.
    pub const HUBER: Loss = Loss::Huber { k: 1.345 };
    /// Tukey's loss with k = 4.685.
    pub const TUKEY: Loss = Loss::Tukey { k: 4.685 };

    pub(crate) fn validate(&self) -> Result<(), FitError> {
        match *self {
            Loss::Huber { k } | Loss::Tukey { k } if !(k.is_finite() && k > 0.0) => {
                Err(FitError::Loss { found: k })
            }
            _ => Ok(()),
        }
    }

    /// ψ(e)/e at e scales: the weight.
    pub fn weight(&self, e: f64) -> f64 {
        match *self {
            Loss::Squares => 1.0,
            Loss::Huber { k } => {
                if e.abs() <= k {
                    1.0
                } else {
                    k / e.abs()
                }
            }
            Loss::Tukey { k } => {
                let left = (1.0 - (e / k) * (e / k)).max(0.0);
                left * left
            }
        }
    }

    /// By how much the variance of the parameters by normal noise of one scale exceeds that with the weights as
    /// they are: E ψ²/(E ψ′)² (Huber & Ronchetti, Robust Statistics, 2nd ed., eq. 4.27) over E w²/(E w)².
    pub fn noise_factor(&self) -> f64 {
        let psi = self.under_noise(|e| (self.weight(e) * e).powi(2));
        psi / self.under_noise(|e| self.weight(e).powi(2)) * self.pull_factor()
    }

    /// By how much the square of what an outlier moves the parameters by, under normal noise of one scale of the
    /// others, exceeds that with the weights as they are: (E w/E ψ′)². An outlier of e scales pulls with ψ(e), and
    /// what resists is ψ′ of the others, not their weight (the sandwich of Huber & Ronchetti, 7.6).
    pub fn pull_factor(&self) -> f64 {
        (self.under_noise(|e| self.weight(e)) / self.under_noise(|e| self.slope(e))).powi(2)
    }

    /// The mean of a function of deviations in scales under normal noise of one scale.
    fn under_noise(&self, value: impl Fn(f64) -> f64) -> f64 {
        let at = |index: u32| (f64::from(index) + 0.5) * NOISE_STEP - NOISE_REACH;
        let count = (2.0 * NOISE_REACH / NOISE_STEP) as u32;
        let density = |e: f64| (-0.5 * e * e).exp() / std::f64::consts::TAU.sqrt();
        (0..count).map(|index| value(at(index)) * density(at(index))).sum::<f64>() * NOISE_STEP
    }

    /// The integral of ψ from 0 to e scales, in squares of the scale.
    pub(crate) fn cost(&self, e: f64) -> f64 {
        match *self {
            Loss::Squares => e * e / 2.0,
            Loss::Huber { k } => {
                if e.abs() <= k {
                    e * e / 2.0
                } else {
                    k * (e.abs() - k / 2.0)
                }
            }
            Loss::Tukey { k } => {
                let left = (1.0 - (e / k) * (e / k)).max(0.0);
                k * k / 6.0 * (1.0 - left * left * left)
            }
        }
    }

    /// The losses a fit by this one goes through: each begins where the one before has ended, and the first finds the
    /// scale.
    pub(crate) fn stages(self) -> Vec<Loss> {
        match self {
            Loss::Tukey { .. } => vec![Loss::HUBER, self],
            _ => vec![self],
        }
    }

    /// ψ′(e) at e scales.
    pub(crate) fn slope(&self, e: f64) -> f64 {
        match *self {
            Loss::Squares => 1.0,
            Loss::Huber { k } => f64::from(e.abs() <= k),
            Loss::Tukey { k } => {
                let u = (e / k) * (e / k);
                if u < 1.0 { (1.0 - u) * (1.0 - 5.0 * u) } else { 0.0 }
            }
        }
    }
}

/// Effect of a robust loss.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robust {
    /// The loss.
    pub loss: Loss,
    /// The scale s in mm: the standard deviation of the distances if most of them are normal. With
    /// uncertainties that of a point of mean weight.
    pub scale_mm: f64,
    /// Whether the scale was given; otherwise it was found from the distances.
    pub scale_given: bool,
    /// Points the loss gives a weight below one half, the next included.
    pub below_half: usize,
    /// Points it leaves out altogether.
    pub zero: usize,
    /// Times the weights were worked out.
    pub rounds: usize,
}

/// A robust refinement.
pub(crate) struct RobustlyRefined {
    /// Its `system` and `last` are those without the weights of the loss.
    pub(crate) refined: Refined,
    pub(crate) robust: Robust,
    /// The standard deviation that goes with (JᵀJ)⁻¹; `None` where the loss leaves too few points.
    pub(crate) sigma_mm: Option<f64>,
    /// (Σw)²/Σw².
    pub(crate) effective_points: f64,
}

/// A robust loss and the scale it is given in mm; without one the scale is found from the distances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScaledLoss {
    pub(crate) loss: Loss,
    pub(crate) given_mm: Option<f64>,
}

/// As [`refine`] with another loss than squares. `None` if the numbers overflow.
pub(crate) fn refine_robustly(
    selection: &Selection,
    pose: Pose,
    nominal: Nominal,
    free: &[Parameter],
    limits: Limits,
    ScaledLoss { loss, given_mm }: ScaledLoss,
) -> Option<RobustlyRefined> {
    let base = selection.roots.as_deref();
    let squares = LeastSquares { points: &selection.points, roots: base, free };
    let mut refined = refine(squares, pose, nominal, limits, None)?;
    let stages = loss.stages();
    let (mut rounds, mut scale_mm) = (0, given_mm.unwrap_or(0.0));
    let mut limit_reached = false;
    for (stage, &loss) in stages.iter().enumerate() {
        limit_reached = true;
        for _ in 0..MAX_ROUNDS {
            rounds += 1;
            let e_mm = residuals(selection, &refined, base);
            let last_scale_mm = scale_mm;
            if stage == 0 && given_mm.is_none() {
                scale_mm = scale(&e_mm).max(limits.tolerance_mm).max(f64::MIN_POSITIVE);
            }
            let roots = weighted_roots(&e_mm, base, loss, scale_mm);
            let tolerance_mm = limits.tolerance_mm.max(SETTLED * scale_mm);
            let step = Limits {
                tolerance_mm,
                iterations: STEPS_A_ROUND,
                polish: false,
                damping: 0.0,
                ..limits
            };
            let weighted = LeastSquares { roots: Some(&roots), ..squares };
            let next = refine(weighted, refined.pose, refined.nominal, step, None)?;
            let settled = next.iterations == 0
                && next.termination.is_converged()
                && (scale_mm - last_scale_mm).abs() <= SETTLED_SCALE * scale_mm;
            refined = Refined {
                iterations: refined.iterations + next.iterations,
                evaluations: refined.evaluations + next.evaluations + 1,
                ..next
            };
            if settled {
                limit_reached = false;
                break;
            }
        }
    }
    if limit_reached {
        let motion_mm = refined.last.motion_mm;
        refined.termination = Termination::MaxIterations { limit: rounds, motion_mm };
    }
    let e_mm = residuals(selection, &refined, base);
    let weights: Vec<f64> = e_mm.iter().map(|e| loss.weight(e / scale_mm)).collect();
    let base_weight = |index: usize| base.map_or(1.0, |roots| roots[index] * roots[index]);
    let (sum, square) = weights.iter().enumerate().fold((0.0, 0.0), |(sum, square), (i, w)| {
        let weight = w * base_weight(i);
        (sum + weight, square + weight * weight)
    });
    let robust = Robust {
        loss,
        scale_mm,
        scale_given: given_mm.is_some(),
        below_half: weights.iter().filter(|&&weight| weight < 0.5).count(),
        zero: weights.iter().filter(|&&weight| weight == 0.0).count(),
        rounds,
    };
    let sigma_mm = sigma_mm(&e_mm, loss, scale_mm, refined.freedoms.count());
    let (system, spread) = squares.linearise(&refined.pose, &refined.nominal)?;
    refined.last = system.solve_along(&refined.freedoms, 0.0);
    (refined.system, refined.spread) = (system, spread);
    let effective_points = if square > 0.0 { sum * sum / square } else { 0.0 };
    Some(RobustlyRefined { refined, robust, sigma_mm, effective_points })
}

/// Distances in mm, each times the root of its weight.
fn residuals(selection: &Selection, refined: &Refined, base: Option<&[f64]>) -> Vec<f64> {
    let model = Model::new(&refined.nominal, &refined.pose, &[]);
    let distance = |(index, &point)| {
        // A refinement ends only where every point has a foot.
        let distance_mm = model.distance_mm(point).unwrap_or(f64::NAN);
        base.map_or(distance_mm, |roots: &[f64]| roots[index] * distance_mm)
    };
    selection.points.par_iter().enumerate().with_min_len(CHUNK).map(distance).collect()
}

/// 1.4826 times the median of the absolute deviations from the median: the standard deviation of normal
/// deviations.
pub(crate) fn scale(e_mm: &[f64]) -> f64 {
    let mut values = e_mm.to_vec();
    let Some(middle) = median(&mut values) else { return 0.0 };
    values.iter_mut().for_each(|value| *value = (*value - middle).abs());
    median(&mut values).map_or(0.0, |mad| NORMAL * mad)
}

/// The middle value, of an even number the upper of the two; `None` without any.
fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

fn weighted_roots(e_mm: &[f64], base: Option<&[f64]>, loss: Loss, scale_mm: f64) -> Vec<f64> {
    let root = |(index, e): (usize, &f64)| {
        loss.weight(e / scale_mm).sqrt() * base.map_or(1.0, |roots| roots[index])
    };
    e_mm.iter().enumerate().map(root).collect()
}

fn sigma_mm(e_mm: &[f64], loss: Loss, scale_mm: f64, parameters: usize) -> Option<f64> {
    let mut moments = Moments { count: e_mm.len() as f64, ..Moments::default() };
    for e in e_mm {
        let e = e / scale_mm;
        let (psi, slope) = (loss.weight(e) * e, loss.slope(e));
        moments.psi_square += psi * psi;
        moments.slope += slope;
        moments.slope_square += slope * slope;
    }
    moments.sigma(parameters).map(|(correction, root, mean)| correction * scale_mm * root / mean)
}

/// Sums over points of ψ² and ψ′ at their distances in scales.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    pub(crate) count: f64,
    pub(crate) psi_square: f64,
    pub(crate) slope: f64,
    pub(crate) slope_square: f64,
}

impl Moments {
    /// The factors K, the root of Σψ²/(n−p), and mean(ψ′) of eq. 7.87; `None` where the loss leaves too few points.
    fn sigma(&self, parameters: usize) -> Option<(f64, f64, f64)> {
        let n = self.count;
        let mean = self.slope / n;
        let variance = self.slope_square / n - mean * mean;
        let dof = n - parameters as f64;
        if dof <= 0.0 || mean <= 0.0 {
            return None;
        }
        let correction = 1.0 + parameters as f64 / n * variance / (mean * mean);
        Some((correction, (self.psi_square / dof).sqrt(), mean))
    }

    /// The standard deviation in scales that goes with (JᵀJ)⁻¹; `None` where the loss leaves too few points.
    pub(crate) fn sigma_in_scales(&self, parameters: usize) -> Option<f64> {
        self.sigma(parameters).map(|(correction, root, mean)| correction * root / mean)
    }
}

/// Steps and reach, in scales, of the integrals over the normal density: to eight digits.
const NOISE_STEP: f64 = 1e-3;
const NOISE_REACH: f64 = 8.0;
/// The standard deviation of a normal distribution in its median absolute deviations.
pub(crate) const NORMAL: f64 = 1.482_602_218_505_602;
/// Rounds of one loss. Each shrinks the way left by about the share of the points that lie out.
const MAX_ROUNDS: usize = 100;
/// Steps for one set of weights: more would be lost when the weights change.
const STEPS_A_ROUND: usize = 2;
/// Share of the scale by which the surface may still move: far below any uncertainty.
pub(crate) const SETTLED: f64 = 1e-7;
/// Relative change of the scale that counts as none.
const SETTLED_SCALE: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_and_slopes_of_the_losses() {
        let (huber, tukey) = (Loss::Huber { k: 1.5 }, Loss::Tukey { k: 4.0 });
        assert_eq!((huber.weight(1.5), huber.weight(-3.0), huber.slope(1.6)), (1.0, 0.5, 0.0));
        assert_eq!((tukey.weight(0.0), tukey.weight(2.0), tukey.weight(4.0)), (1.0, 0.5625, 0.0));
        assert_eq!(tukey.weight(9.0), 0.0);
        for loss in [huber, tukey, Loss::Squares] {
            for e in [-3.3, -0.7, 0.1, 1.2, 2.5, 5.0] {
                let psi = |e: f64| e * loss.weight(e);
                let numerical = (psi(e + 1e-6) - psi(e - 1e-6)) / 2e-6;
                assert!((numerical - loss.slope(e)).abs() < 1e-8, "{loss:?} at {e}");
            }
        }
    }

    #[test]
    fn scale_is_that_of_the_middle_half() {
        assert_eq!(scale(&[]), 0.0);
        let values: Vec<f64> = (-50..=50).map(f64::from).chain([1e9; 30]).collect();
        // The 66th of 131 values is 15, and 65 values lie nearer to it than 33.
        assert!((scale(&values) - NORMAL * 33.0).abs() < 1e-12, "{}", scale(&values) / NORMAL);
    }
}
