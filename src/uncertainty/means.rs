//! Figures that average over the area, of simulated measurements of few points that stand for many.
//!
//! Of n points N are taken, spread evenly over them. Their correlated errors are what they are. Independent noise averages
//! out as over all points if each has √(N/n) of it; what the noise of all does to the parameters is then n/N times as
//! much as that of these. A mean square also grows by the whole noise of a point, which draws with all of
//! it tell beside: the mean of their squares less that of the others is added.

use rayon::prelude::*;

use super::Uncertainty;
use super::budget::UncertaintyError;
use super::linear::dot;
use super::simulate::{Draws, POINTS, Simulated, factors};
use asphera_geometry::Numbers;

/// How noise adds to an average.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Average {
    /// By its mean over the area: a fitted coefficient.
    OfHeights,
    /// By its square: an RMS.
    OfSquares,
}

impl Uncertainty {
    /// A figure that averages over the area by simulated measurements, of few points where there are many; `None` if
    /// the measurement or nearly all draws do not have it.
    ///
    /// `figure` is given some of the points, by their places in the order of [`Uncertainty::indices`], and deviations there in
    /// mm. A draw costs the same however many points there are.
    pub fn simulate_average(
        &self,
        draws: &Draws,
        kind: Average,
        figure: impl Fn(&[usize], &[f64]) -> Option<f64> + Sync,
    ) -> Result<Option<Simulated>, UncertaintyError> {
        draws.validate()?;
        let linear = &self.linear;
        let all: Vec<usize> = (0..linear.len()).collect();
        let Some(measured) = figure(&all, &linear.distances_mm) else {
            return Ok(None);
        };
        let some: Vec<usize> =
            (0..linear.len()).step_by(linear.len().div_ceil(MOST_AVERAGED)).collect();
        let distances_mm: Vec<f64> = some.iter().map(|&place| linear.distances_mm[place]).collect();
        let Some(of_some) = figure(&some, &distances_mm) else { return Ok(None) };
        let of_draw = |draw: u32| {
            let [averaged_mm, whole_mm] = self.residuals_of(&some, draws.seed, draw);
            let averaged = figure(&some, &averaged_mm)?;
            let is_whole = kind == Average::OfHeights || some.len() == linear.len();
            let whole = if is_whole { averaged } else { figure(&some, &whole_mm)? };
            Some([averaged, whole])
        };
        let drawn: Vec<Option<[f64; 2]>> = (0..draws.count).into_par_iter().map(of_draw).collect();
        if kind == Average::OfHeights {
            let shifted = drawn.iter().map(|drawn| Some(measured + (*drawn)?[0] - of_some));
            let found: Vec<Option<f64>> = shifted.collect();
            return Ok(Simulated::new(measured, &found, some.len()));
        }
        let known = drawn.iter().flatten();
        let more = known.clone().map(|[averaged, whole]| whole * whole - averaged * averaged);
        let more = more.sum::<f64>() / known.count().max(1) as f64;
        let shifted = drawn.iter().map(|drawn| {
            let [averaged, _] = (*drawn)?;
            let square = measured * measured + averaged * averaged - of_some * of_some + more;
            Some(square.max(0.0).sqrt())
        });
        let found: Vec<Option<f64>> = shifted.collect();
        Ok(Simulated::of_squares(measured, &found, some.len(), more))
    }

    /// Residuals of one draw at some places in mm: with noise as it averages out, and with all of it.
    fn residuals_of(&self, some: &[usize], seed: u64, draw: u32) -> [Vec<f64>; 2] {
        let Uncertainty { linear, modes, budget, noise_mm2, .. } = self;
        let noise = Numbers::new(seed, draw, POINTS);
        let factors = factors(seed, draw, modes.functions());
        let share = (some.len() as f64 / linear.len() as f64).sqrt();
        let mut moved = self.moved_by(&factors);
        let waves = modes.waves(budget, &factors);
        let mut own_mm = Vec::with_capacity(some.len());
        for &place in some {
            let own = noise_mm2[place].sqrt() * noise.normal(place);
            moved
                .iter_mut()
                .zip(linear.gain(place))
                .for_each(|(sum, gain)| *sum += gain * own / share);
            own_mm.push(own);
        }
        let without_mm = some.iter().map(|&place| {
            linear.distances_mm[place] + waves.at(place, linear) - dot(linear.row(place), &moved)
        });
        let without_mm: Vec<f64> = without_mm.collect();
        [share, 1.0].map(|share| {
            without_mm.iter().zip(&own_mm).map(|(value, own)| value + share * own).collect()
        })
    }
}

/// Points that stand for all where these are more.
const MOST_AVERAGED: usize = 16_384;
