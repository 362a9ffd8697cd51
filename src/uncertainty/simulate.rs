//! Figures of simulated measurements: the residuals with further errors of the budget laid over them.
//!
//! A propagation of distributions as in JCGM 101:2008. The residuals hold the errors of the measurement once
//! already, so draws hold them twice: their spread is the uncertainty of the figure, and what they have more
//! than the measurement on the average tells how much the measurement has more than the part (Efron &
//! Tibshirani, An Introduction to the Bootstrap, 10.2). That holds for figures that errors move smoothly; ranges and
//! extremes have limits of their own: see [`super::extremes`].

use rayon::prelude::*;

use super::Uncertainty;
use super::budget::{UncertaintyError, check};
use super::distribution::normal_exceeded;
use super::extremes::{Datum, Errors, Extremes};
use super::linear::dot;
use super::square::MeanSquare;
use asphera_form::NM_PER_MM;
use asphera_geometry::Numbers;

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
    /// Its standard uncertainty: the standard deviation of the draws. Where squares add up, that of the figure less `bias`,
    /// which is the one the interval is of: how far its interval of one standard deviation reaches. Of a range or an extreme
    /// that of the places that may be the extreme, whichever of them is.
    pub u: f64,
    /// What noise adds to the figure, as far as the draws tell: their mean less the figure. Of a mean height or
    /// RMS, in which squares add up, the figure less the root of what the draws' mean square leaves of its square. Of a range
    /// or an extreme, the figure less what the form has with a probability of one half or more.
    pub bias: f64,
    /// Draws in all.
    pub draws: u32,
    /// Draws in which the figure is unknown; they do not count.
    pub unknown: u32,
    /// Points a draw looked at; of a range or an extreme, how many points and windows over them may be the extreme.
    pub candidates: usize,
    sorted: Vec<f64>,
    kind: Kind,
}

/// How errors go into a figure.
#[derive(Clone, Debug, PartialEq)]
enum Kind {
    /// Much alike wherever the figure is: draws are mirrored at it.
    Smooth,
    /// They add to its square.
    Squares(MeanSquare),
    /// To its square nearly: the squares of the draws are mirrored at it.
    Sizes,
    /// `sorted` are lower limits, each of which a share of draws keeps; the upper limit is the largest of some values with
    /// standard deviations.
    Extremes(Vec<(f64, f64)>),
}

impl Simulated {
    /// An interval that holds the figure of the part with probability `confidence`, above 0 and below 1; never below 0.
    ///
    /// The quantiles of the draws mirrored at the figure (the basic interval: Davison & Hinkley, Bootstrap Methods
    /// and their Application, 5.2), or where squares add up the figures from which what was measured is as far away as that
    /// probability allows (`square`). Of a range or an extreme the interval holds the truth at least so often, whatever
    /// the form; it reaches down to what the form has for sure, and up to what a single place may have.
    pub fn interval(&self, confidence: f64) -> [f64; 2] {
        let tail = 0.5 * (1.0 - confidence);
        match &self.kind {
            Kind::Smooth => [1.0 - tail, tail]
                .map(|share| (2.0 * self.measured - self.quantile(share)).max(0.0)),
            Kind::Squares(square) => square.interval(normal_exceeded(tail)),
            Kind::Sizes => {
                let mean = mean_square(&self.sorted);
                let left = (2.0 * self.measured * self.measured - mean).max(0.0);
                [1.0 - tail, tail].map(|share| {
                    let drawn = self.quantile(share);
                    (left + mean - drawn * drawn).max(0.0).sqrt()
                })
            }
            Kind::Extremes(above) => {
                // Of so many draws and the measurement, a share of no more than `tail` is below this one.
                let rank = (tail * (self.sorted.len() + 1) as f64) as usize;
                [self.sorted[rank.saturating_sub(1)], farthest(above, normal_exceeded(tail))]
            }
        }
    }

    /// Value that such a share of the draws does not exceed.
    fn quantile(&self, share: f64) -> f64 {
        let last = self.sorted.len() - 1;
        self.sorted[((share * last as f64).round() as usize).min(last)]
    }

    /// `None` unless two draws at least have the figure.
    pub(super) fn new(
        measured: f64,
        found: &[Option<f64>],
        candidates: usize,
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
            candidates,
            sorted,
            kind: Kind::Smooth,
        })
    }

    /// As [`Simulated::new`], for a figure to the square of which errors add. `whole` is how much more the draws' mean square
    /// would be with all noise in them, where they have less.
    ///
    /// What was measured holds the noise once and the draws twice, so their squares have the variance 2·λ·N + 4·λ·m² with the
    /// letters of [`super::square`], N that of the draws: it tells λ. Errors that are larger in some directions are taken for as
    /// large in all.
    pub(super) fn of_squares(
        measured: f64,
        found: &[Option<f64>],
        candidates: usize,
        whole: f64,
    ) -> Option<Simulated> {
        let plain = Simulated::new(measured, found, candidates)?;
        let (square, mean) = (measured * measured, mean_square(&plain.sorted));
        let squares = plain.sorted.iter().map(|drawn| (drawn * drawn - mean).powi(2));
        let variance = squares.sum::<f64>() / (plain.sorted.len() - 1) as f64;
        let noise = mean - square;
        let divisor = 2.0 * (noise - whole).max(0.0) + 4.0 * square;
        let rate = if variance > 0.0 { variance / divisor } else { 0.0 };
        let left = MeanSquare { left: square - noise, noise: noise.max(0.0), rate, apart: 0.0 };
        Some(Simulated {
            u: left.u(),
            bias: measured - left.root(),
            kind: Kind::Squares(left),
            ..plain
        })
    }

    /// As [`Simulated::of_squares`], for a mean size, to the square of which errors add nearly. Its draws' scatter counts whole, as
    /// what noise adds is told less well.
    pub(super) fn of_sizes(
        measured: f64,
        found: &[Option<f64>],
        candidates: usize,
    ) -> Option<Simulated> {
        let plain = Simulated::new(measured, found, candidates)?;
        let mean = mean_square(&plain.sorted);
        let left = (2.0 * measured * measured - mean).max(0.0);
        let left_of = |drawn: &f64| (left + mean - drawn * drawn).max(0.0).sqrt();
        let count = plain.sorted.len() as f64;
        let middle = plain.sorted.iter().map(left_of).sum::<f64>() / count;
        let squares =
            plain.sorted.iter().map(|drawn| (left_of(drawn) - middle).powi(2)).sum::<f64>();
        let u = (squares / (count - 1.0)).sqrt();
        Some(Simulated { u, bias: measured - left.sqrt(), kind: Kind::Sizes, ..plain })
    }

    /// The mean square behind the noise; `None` where squares do not add up.
    pub(crate) fn mean_square(&self) -> Option<MeanSquare> {
        match self.kind {
            Kind::Squares(square) => Some(square),
            Kind::Smooth | Kind::Sizes | Kind::Extremes(_) => None,
        }
    }

    /// A range or an extreme: a lower limit of each draw, and values with standard deviations, of which one at least is the
    /// truth but for an error of that size.
    pub(super) fn of_extremes(
        measured: f64,
        mut limits: Vec<f64>,
        above: Vec<(f64, f64)>,
        candidates: usize,
    ) -> Simulated {
        limits.sort_by(f64::total_cmp);
        let mut found = Simulated {
            measured,
            u: farthest(&above, 1.0) - measured,
            bias: 0.0,
            draws: limits.len() as u32,
            unknown: 0,
            candidates,
            sorted: limits,
            kind: Kind::Extremes(above),
        };
        found.bias = (measured - found.quantile(0.5)).max(0.0);
        found
    }
}

/// The largest value with `k` standard deviations more.
fn farthest(values: &[(f64, f64)], k: f64) -> f64 {
    values.iter().fold(f64::NEG_INFINITY, |most, (value, sigma)| most.max(value + k * sigma))
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

impl Uncertainty {
    /// Any figure of the deviations by simulated measurements; `None` if the measurement or nearly all draws do
    /// not have it.
    ///
    /// `figure` is given deviations in mm, in the order of [`Uncertainty::indices`].
    pub fn simulate(
        &self,
        draws: &Draws,
        figure: impl Fn(&[f64]) -> Option<f64> + Sync,
    ) -> Result<Option<Simulated>, UncertaintyError> {
        draws.validate()?;
        let n = self.linear.len();
        let Some(measured) = figure(&self.linear.distances_mm) else { return Ok(None) };
        let of_draw = |draw: u32| figure(&self.residuals_mm(draws.seed, draw));
        let found: Vec<Option<f64>> = (0..draws.count).into_par_iter().map(of_draw).collect();
        Ok(Simulated::new(measured, &found, n))
    }

    /// As [`Uncertainty::simulate`], of a figure to the square of which errors add, as to that of an RMS slope: what noise
    /// adds is told by the squares.
    pub fn simulate_of_squares(
        &self,
        draws: &Draws,
        figure: impl Fn(&[f64]) -> Option<f64> + Sync,
    ) -> Result<Option<Simulated>, UncertaintyError> {
        draws.validate()?;
        let Some(measured) = figure(&self.linear.distances_mm) else { return Ok(None) };
        let of_draw = |draw: u32| figure(&self.residuals_mm(draws.seed, draw));
        let found: Vec<Option<f64>> = (0..draws.count).into_par_iter().map(of_draw).collect();
        Ok(Simulated::of_squares(measured, &found, self.linear.len(), 0.0))
    }

    /// All residuals of one draw, in mm.
    fn residuals_mm(&self, seed: u64, draw: u32) -> Vec<f64> {
        let Uncertainty { linear, modes, budget, noise_mm2, .. } = self;
        let noise = Numbers::new(seed, draw, POINTS);
        let factors: Vec<f64> = factors(seed, draw, modes.functions());
        let mut moved = self.moved_by(&factors);
        let waves = modes.waves(budget, &factors);
        let mut errors_mm: Vec<f64> = Vec::with_capacity(linear.len());
        for (place, variance_mm2) in noise_mm2.iter().enumerate() {
            let own_mm = variance_mm2.sqrt() * noise.normal(place);
            moved.iter_mut().zip(linear.gain(place)).for_each(|(sum, gain)| *sum += gain * own_mm);
            errors_mm.push(own_mm + waves.at(place, linear));
        }
        for (place, error_mm) in errors_mm.iter_mut().enumerate() {
            *error_mm += linear.distances_mm[place] - dot(linear.row(place), &moved);
        }
        errors_mm
    }

    /// The peak to valley deviation in nm, at the measured places, by simulated measurements. Its interval holds the truth
    /// whether the form stands out of the noise or not.
    pub fn peak_to_valley_nm(&self, draws: &Draws) -> Result<Simulated, UncertaintyError> {
        draws.validate()?;
        let [low, high] = extremes(&self.linear.distances_mm);
        let errors = OfDistances::new(self, &self.linear.distances_mm);
        let extremes = Extremes::new(&errors.errors(self), Datum::Fixed);
        Ok(extremes.range((high - low) * NM_PER_MM, draws))
    }

    /// Share of the correlated errors that the parameters take up.
    pub(super) fn moved_by(&self, factors: &[f64]) -> Vec<f64> {
        let mut moved = vec![0.0; self.linear.parameters.len()];
        for (of_function, factor) in self.modes.moved.iter().zip(factors) {
            moved.iter_mut().zip(of_function).for_each(|(sum, part)| *sum += part * factor);
        }
        moved
    }
}

/// Distances from a nominal with what is known of their errors, in nm.
pub(super) struct OfDistances {
    distances_nm: Vec<f64>,
    noise_nm2: Vec<f64>,
    /// At each node.
    functions_nm: Vec<Vec<f64>>,
}

impl OfDistances {
    pub(super) fn new(of: &Uncertainty, distances_mm: &[f64]) -> OfDistances {
        let nm = |values: &[f64], unit: f64| values.iter().map(|value| value * unit).collect();
        let functions = of.modes.residual_mm.iter();
        OfDistances {
            distances_nm: nm(distances_mm, NM_PER_MM),
            noise_nm2: nm(&of.noise_mm2, NM_PER_MM * NM_PER_MM),
            functions_nm: functions.map(|values| nm(values, NM_PER_MM)).collect(),
        }
    }

    pub(super) fn errors<'a>(&'a self, of: &'a Uncertainty) -> Errors<'a> {
        Errors {
            places_mm: &of.linear.places_mm,
            heights: &self.distances_nm,
            noise: &self.noise_nm2,
            independent: &self.noise_nm2,
            functions: &self.functions_nm,
            node_of: of.modes.nodes_of(),
        }
    }
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

/// Streams of random numbers: one for the points, one for the functions.
pub(super) const POINTS: u32 = 0;
const FACTORS: u32 = 1;
/// Fewer draws have no tails.
const LEAST_DRAWS: u32 = 20;

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(measured: f64) -> Simulated {
        let found = [2.0, 2.1, 2.2, 2.3, 2.4].map(|square: f64| Some(square.sqrt()));
        Simulated::of_squares(measured, &found, 5, 0.0).unwrap()
    }

    #[test]
    fn noise_adds_to_squares() {
        // Noise adds 0.2 to a square of 2.
        let simulated = drawn(2.0_f64.sqrt());
        let left = simulated.measured - simulated.bias;
        assert!((left * left - 1.8).abs() < 1e-12);
        let [low, high] = simulated.interval(0.95).map(|end| end * end);
        assert!(low < 1.8 && 1.8 < high && simulated.u > 0.0);
    }

    /// 4,000 measurements of noise alone, of a form as large as the noise and of one ten times as large: their own scatter is
    /// told by draws over each of them, which hold the noise twice.
    #[test]
    fn intervals_of_squares_hold_the_truth_and_u_is_the_scatter() {
        const VALUES: usize = 200;
        const MEASUREMENTS: u32 = 1000;
        let rms = |values: &[f64]| mean_square(values).sqrt();
        for form in [0.0, 1.0, 10.0] {
            let level = |i: usize| if i.is_multiple_of(2) { form } else { -form };
            let of = |seed: u32| {
                let noise = Numbers::new(5, seed, 0);
                let measured: Vec<f64> = (0..VALUES).map(|i| level(i) + noise.normal(i)).collect();
                let draw = |draw: u32| {
                    let more = Numbers::new(6 + u64::from(seed), draw, 1);
                    let drawn = measured.iter().enumerate().map(|(i, r)| r + more.normal(i));
                    Some(rms(&drawn.collect::<Vec<f64>>()))
                };
                let draws: Vec<Option<f64>> = (0..200).map(draw).collect();
                Simulated::of_squares(rms(&measured), &draws, VALUES, 0.0).unwrap()
            };
            let all: Vec<Simulated> = (0..MEASUREMENTS).into_par_iter().map(of).collect();
            let is_inside = |one: &&Simulated| {
                let [low, high] = one.interval(0.95);
                (low..=high).contains(&form)
            };
            let share = all.iter().filter(is_inside).count() as f64 / f64::from(MEASUREMENTS);
            // Nothing is at the end of what an interval can hold: there but one side can miss.
            let most = if form == 0.0 { 0.99 } else { 0.97 };
            assert!((0.93..=most).contains(&share), "{form}: {share}");
            let left: Vec<f64> = all.iter().map(|one| one.measured - one.bias).collect();
            let mean = left.iter().sum::<f64>() / left.len() as f64;
            let square = left.iter().map(|left| (left - mean).powi(2)).sum::<f64>();
            let scatter = (square / (left.len() - 1) as f64).sqrt();
            let u = all.iter().map(|one| one.u).sum::<f64>() / all.len() as f64;
            let ratio = u / scatter;
            // About nothing half of the roots are 0: what is left scatters by 0.48 of the fourth root of the variance, and u is
            // 0.71 of it.
            let largest = if form == 0.0 { 1.5 } else { 1.25 };
            assert!((0.85..largest).contains(&ratio), "{form}: u {u}, scatter {scatter}");
        }
    }

    #[test]
    fn where_noise_explains_more_than_there_is_the_draws_tell_what_may_be() {
        let simulated = drawn(1.0);
        assert_eq!(simulated.bias, 1.0);
        let [low, high] = simulated.interval(0.95);
        assert!(low == 0.0 && high > 0.1, "{high}");
    }
}
