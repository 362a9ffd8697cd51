//! Figures of simulated measurements: the residuals with further errors of the budget laid over them.
//!
//! A propagation of distributions as in JCGM 101:2008. The residuals hold the errors of the measurement once
//! already, so draws hold them twice: their spread is the uncertainty of the figure, and what they have more
//! than the measurement on the average tells how much the measurement has more than the part (Efron &
//! Tibshirani, An Introduction to the Bootstrap, 10.2). Where form stands out of the noise that is the whole
//! bias; where noise makes the figure, about two fifths of it.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::budget::{Budget, UncertaintyError, check};
use super::distribution::student_quantile;
use super::linear::{Linear, dot};
use super::modes::Modes;
use super::philox::Numbers;
use crate::deviation::NM_PER_MM;

/// How many measurements are simulated, and which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Draws {
    /// Number of draws, at least 20. A standard uncertainty is then known to 1/√(2·count): 1000 tell it to 2 %.
    pub count: u32,
    /// Seed. The same seed gives the same bits, whatever the number of threads.
    pub seed: u64,
}

/// A figure of simulated measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct Simulated {
    /// The figure of the measurement.
    pub measured: f64,
    /// Its standard uncertainty: the standard deviation of the draws.
    pub u: f64,
    /// What noise adds to the figure on the average, as far as the draws tell: their mean less the figure. Of a mean height or
    /// RMS, in which squares add up, the figure less the root of what the draws' mean square leaves of its square.
    pub bias: f64,
    /// Draws in all.
    pub draws: u32,
    /// Draws in which the figure is unknown; they do not count.
    pub unknown: u32,
    /// Points a draw looked at. Others are too far from the extremes to become one, or beyond the number
    /// allowed: see [`Simulated::capped`].
    pub candidates: usize,
    /// Whether there were more candidates than a draw looks at. The uncertainty is then slightly too small.
    pub capped: bool,
    sorted: Vec<f64>,
    /// Whether errors add to the square of the figure.
    squares: bool,
}

impl Simulated {
    /// An interval that holds the figure of the part with probability `confidence`, never below 0: the
    /// quantiles of the draws mirrored at the figure (the basic interval: Davison & Hinkley, Bootstrap Methods
    /// and their Application, 5.2), or of the squares mirrored at its square where squares add up. Where noise
    /// explains more than there is, what noise leaves of a square is taken as 0, not as less: the draws still tell how
    /// far above that the part may be.
    pub fn interval(&self, confidence: f64) -> [f64; 2] {
        let tail = 0.5 * (1.0 - confidence);
        let drawn = [1.0 - tail, tail].map(|share| self.quantile(share));
        if !self.squares {
            return drawn.map(|drawn| (2.0 * self.measured - drawn).max(0.0));
        }
        let mean = mean_square(&self.sorted);
        let left = (2.0 * self.measured * self.measured - mean).max(0.0);
        drawn.map(|drawn| (left + mean - drawn * drawn).max(0.0).sqrt())
    }

    /// What that share of the draws does not exceed.
    pub fn quantile(&self, share: f64) -> f64 {
        let last = self.sorted.len() - 1;
        self.sorted[((share * last as f64).round() as usize).min(last)]
    }

    /// `None` unless two draws at least have the figure.
    pub(super) fn new(
        measured: f64,
        found: &[Option<f64>],
        candidates: (usize, bool),
    ) -> Option<Simulated> {
        let mut sorted: Vec<f64> = found.iter().flatten().copied().collect();
        sorted.sort_by(f64::total_cmp);
        if sorted.len() < 2 {
            return None;
        }
        let count = sorted.len() as f64;
        let mean = sorted.iter().sum::<f64>() / count;
        let square: f64 = sorted.iter().map(|value| (value - mean) * (value - mean)).sum();
        Some(Simulated {
            measured,
            u: (square / (count - 1.0)).sqrt(),
            bias: mean - measured,
            draws: found.len() as u32,
            unknown: (found.len() - sorted.len()) as u32,
            candidates: candidates.0,
            capped: candidates.1,
            sorted,
            squares: false,
        })
    }

    /// As [`Simulated::new`], for a figure to the square of which errors add.
    pub(super) fn of_squares(
        measured: f64,
        found: &[Option<f64>],
        candidates: (usize, bool),
    ) -> Option<Simulated> {
        let plain = Simulated::new(measured, found, candidates)?;
        let left = 2.0 * measured * measured - mean_square(&plain.sorted);
        let bias = measured - left.max(0.0).sqrt();
        Some(Simulated { bias, squares: true, ..plain })
    }
}

fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64
}

impl Draws {
    pub(super) fn validate(&self) -> Result<(), UncertaintyError> {
        let count = f64::from(self.count);
        check("number of draws", count, self.count >= LEAST_DRAWS, "20 or more")
    }
}

/// All a draw needs.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) linear: &'a Linear,
    pub(super) modes: &'a Modes,
    pub(super) budget: &'a Budget,
    /// Independent variance of each point.
    pub(super) noise_mm2: &'a [f64],
    /// Covariance of the parameters by it.
    pub(super) covariance: &'a DMatrix<f64>,
}

impl Source<'_> {
    /// Any figure of the residuals in mm; `None` if too few draws have it. `O(n·(p + m))` a draw.
    pub(super) fn figure(
        &self,
        draws: &Draws,
        figure: impl Fn(&[f64]) -> Option<f64> + Sync,
    ) -> Result<Option<Simulated>, UncertaintyError> {
        draws.validate()?;
        let n = self.linear.len();
        let Some(measured) = figure(&self.linear.distances_mm) else { return Ok(None) };
        let of_draw = |draw: u32| figure(&self.residuals_mm(draws.seed, draw));
        let found: Vec<Option<f64>> = (0..draws.count).into_par_iter().map(of_draw).collect();
        Ok(Simulated::new(measured, &found, (n, false)))
    }

    /// All residuals of one draw, in mm.
    fn residuals_mm(&self, seed: u64, draw: u32) -> Vec<f64> {
        let Source { linear, modes, budget, noise_mm2, .. } = self;
        let noise = Numbers::new(seed, draw, POINTS);
        let factors: Vec<f64> = factors(seed, draw, modes.functions());
        let mut moved = self.moved_by(&factors);
        let waves = modes.waves(budget, &factors);
        let mut errors_mm: Vec<f64> = Vec::with_capacity(linear.len());
        for place in 0..linear.len() {
            let own_mm = noise_mm2[place].sqrt() * noise.normal(place);
            moved.iter_mut().zip(linear.gain(place)).for_each(|(sum, gain)| *sum += gain * own_mm);
            errors_mm.push(own_mm + waves.at(place, linear));
        }
        for (place, error_mm) in errors_mm.iter_mut().enumerate() {
            *error_mm += linear.distances_mm[place] - dot(linear.row(place), &moved);
        }
        errors_mm
    }

    /// Peak to valley in nm, from the points that can become an extreme. `O(n + c·(p + m))` a draw for c
    /// candidates, the first term once.
    pub(super) fn peak_to_valley_nm(&self, draws: &Draws) -> Result<Simulated, UncertaintyError> {
        draws.validate()?;
        let Source { linear, modes, noise_mm2, .. } = self;
        let (candidates, capped) = self.candidates();
        let values: Vec<(f64, f64, Vec<f64>)> = candidates
            .iter()
            .map(|&place| {
                let functions = modes.at(place, linear, self.budget);
                (linear.distances_mm[place], noise_mm2[place].sqrt(), functions)
            })
            .collect();
        // What the noise of all other points does to the parameters is one draw from its covariance.
        let mut others = self.covariance.clone();
        for &place in &candidates {
            let gain = linear.gain(place);
            for i in 0..gain.len() {
                for j in 0..gain.len() {
                    others[(i, j)] -= noise_mm2[place] * gain[i] * gain[j];
                }
            }
        }
        let root = lower_root(&others, self.covariance);
        let of_draw = |draw: u32| {
            let noise = Numbers::new(draws.seed, draw, POINTS);
            let rest = Numbers::new(draws.seed, draw, REST);
            let factors = factors(draws.seed, draw, modes.functions());
            let free: Vec<f64> = (0..root.ncols()).map(|index| rest.normal(index)).collect();
            let mut moved: Vec<f64> =
                (0..root.nrows()).map(|i| (0..=i).map(|j| root[(i, j)] * free[j]).sum()).collect();
            let mut own_mm = Vec::with_capacity(candidates.len());
            for (&place, (_, sigma_mm, _)) in candidates.iter().zip(&values) {
                let own = sigma_mm * noise.normal(place);
                moved.iter_mut().zip(linear.gain(place)).for_each(|(sum, gain)| *sum += gain * own);
                own_mm.push(own);
            }
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for ((&place, (distance_mm, _, functions)), own_mm) in
                candidates.iter().zip(&values).zip(&own_mm)
            {
                let value = distance_mm + own_mm + dot(functions, &factors)
                    - dot(linear.row(place), &moved);
                (low, high) = (low.min(value), high.max(value));
            }
            Some((high - low) * NM_PER_MM)
        };
        let found: Vec<Option<f64>> = (0..draws.count).into_par_iter().map(of_draw).collect();
        let [low, high] = extremes(&linear.distances_mm);
        let measured_nm = (high - low) * NM_PER_MM;
        let known = Simulated::new(measured_nm, &found, (candidates.len(), capped));
        Ok(known.expect("every draw has an extreme, for a fit has points"))
    }

    /// What the correlated errors take off the parameters.
    pub(super) fn moved_by(&self, factors: &[f64]) -> Vec<f64> {
        let mut moved = vec![0.0; self.linear.parameters.len()];
        for (of_function, factor) in self.modes.moved.iter().zip(factors) {
            moved.iter_mut().zip(of_function).for_each(|(sum, part)| *sum += part * factor);
        }
        moved
    }

    /// Points whose residual is so near an extreme that the errors can lift them over it.
    fn candidates(&self) -> (Vec<usize>, bool) {
        near_ends(&self.linear.distances_mm, self.reach_mm(), MOST_CANDIDATES)
    }

    /// The errors of two points differ by more than this with a probability of 1e-4 over all points.
    pub(super) fn reach_mm(&self) -> f64 {
        let Source { linear, modes, noise_mm2, .. } = self;
        let noise_mm2 = noise_mm2.iter().copied().fold(0.0, f64::max);
        let waves_mm2 = modes.residual_mm.iter().map(|values| dot(values, values));
        let u_mm = (noise_mm2 + waves_mm2.fold(0.0, f64::max)).sqrt();
        let share = MISSED / linear.len() as f64;
        std::f64::consts::SQRT_2 * u_mm * student_quantile(1.0 - share, f64::INFINITY)
    }
}

/// Indices of the values within `reach` of the largest or of the smallest, ascending; of more than `most` at one end the
/// outermost, and whether that was so. NaN is none.
pub(super) fn near_ends(values: &[f64], reach: f64, most: usize) -> (Vec<usize>, bool) {
    let [low, high] = extremes(values);
    let nearest = |mut near: Vec<usize>, sign: f64| {
        near.sort_by(|&a, &b| (sign * values[b]).total_cmp(&(sign * values[a])).then(a.cmp(&b)));
        let capped = near.len() > most;
        near.truncate(most);
        (near, capped)
    };
    let all = 0..values.len();
    let (above, many) =
        nearest(all.clone().filter(|&place| values[place] >= high - reach).collect(), 1.0);
    let (below, more) = nearest(all.filter(|&place| values[place] <= low + reach).collect(), -1.0);
    let mut found: Vec<usize> = above.into_iter().chain(below).collect();
    found.sort_unstable();
    found.dedup();
    (found, many || more)
}

/// Factors of the functions of the correlated errors in one draw.
pub(super) fn factors(seed: u64, draw: u32, count: usize) -> Vec<f64> {
    let numbers = Numbers::new(seed, draw, FACTORS);
    (0..count).map(|index| numbers.normal(index)).collect()
}

/// Smallest and largest.
pub(super) fn extremes(values: &[f64]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| {
        [low.min(value), high.max(value)]
    })
}

/// L with L·Lᵀ = `matrix`, which is semidefinite but for rounding of the size of `whole`.
fn lower_root(matrix: &DMatrix<f64>, whole: &DMatrix<f64>) -> DMatrix<f64> {
    let p = matrix.nrows();
    let mut root = DMatrix::zeros(p, p);
    for j in 0..p {
        let left = matrix[(j, j)] - (0..j).map(|k| root[(j, k)] * root[(j, k)]).sum::<f64>();
        if left <= ROUNDING * whole[(j, j)] {
            continue;
        }
        root[(j, j)] = left.sqrt();
        for i in j + 1..p {
            let known: f64 = (0..j).map(|k| root[(i, k)] * root[(j, k)]).sum();
            root[(i, j)] = (matrix[(i, j)] - known) / root[(j, j)];
        }
    }
    root
}

/// Streams of random numbers: one for the points, one for the functions, one for the points left out.
pub(super) const POINTS: u32 = 0;
const FACTORS: u32 = 1;
const REST: u32 = 2;
/// Fewer draws have no tails.
const LEAST_DRAWS: u32 = 20;
/// Points a draw looks at, at either end.
const MOST_CANDIDATES: usize = 2048;
/// Probability that a point which is no candidate would have been an extreme.
pub(super) const MISSED: f64 = 1e-4;
/// Share of a variance that rounding leaves of it.
const ROUNDING: f64 = 1e-12;

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(measured: f64) -> Simulated {
        let found = [2.0, 2.1, 2.2, 2.3, 2.4].map(|square: f64| Some(square.sqrt()));
        Simulated::of_squares(measured, &found, (5, false)).unwrap()
    }

    fn agree(found: [f64; 2], squares: [f64; 2]) {
        for (found, square) in found.into_iter().zip(squares) {
            assert!((found * found - square).abs() < 1e-12, "{found} {square}");
        }
    }

    #[test]
    fn squares_are_mirrored_at_what_was_measured() {
        let simulated = drawn(2.0_f64.sqrt());
        // Noise adds 0.2 to a square of 2.
        agree([simulated.measured - simulated.bias, 0.0], [1.8, 0.0]);
        agree(simulated.interval(0.95), [1.6, 2.0]);
    }

    #[test]
    fn where_noise_explains_more_than_there_is_the_draws_tell_what_may_be() {
        let simulated = drawn(1.0);
        assert_eq!(simulated.bias, 1.0);
        agree(simulated.interval(0.95), [0.0, 0.2]);
    }
}
