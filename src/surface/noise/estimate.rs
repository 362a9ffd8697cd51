//! The noise of the heights from what neighbourhoods leave of their own polynomials.
//!
//! 1. Vertices are chosen evenly along their numbers, by the multiples of the golden ratio modulo 1,
//!    a sequence of low discrepancy (H. Niederreiter, Random Number Generation and Quasi-Monte Carlo
//!    Methods, 1992, chapter 3). About each a cubic is fitted to two rings (see `residuals.rs`).
//! 2. *Rough scale.* Wrong readings must not decide what counts as one. So a third of the degrees
//!    of freedom of every neighbourhood is given away to its worst samples, one after the other; the
//!    rest has a standard deviation of about 0.46 σ, and the median over the neighbourhoods is safe
//!    while half of them have no more wrong readings than that.
//! 3. Again from the start, samples are left out while the worst studentized residual is above 4.5
//!    times the rough scale of the neighbourhood, or of all neighbourhoods if that is larger.
//! 4. The studentized residuals of what is left have the standard deviation σ, whatever leverage
//!    and degrees of freedom; of a normal distribution σ is 1.4826 times the median of their sizes
//!    (P. J. Rousseeuw, C. Croux, J. Am. Stat. Assoc. 88 (1993) 1273-1283,
//!    doi:10.1080/01621459.1993.10476408).
//!
//! **What it sees.** Only the part of the deviations that differs from sample to sample. Noise that
//! was filtered, or drifts, is smooth over a neighbourhood and not seen. Form finer than two rings is
//! taken for noise: the figure is then an upper bound.

use asphera_geometry::{PointMm, VertexId};
use rayon::prelude::*;
use thiserror::Error;

use super::residuals::Residuals;
use super::steps::step_sigma_mm;
use super::{Along, Noise};
use crate::curvature::{Adjacency, Rings};

/// How many neighbourhoods are looked at, and which noise is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoiseSettings {
    neighbourhoods: usize,
    along: Along,
}

/// A number of neighbourhoods that is too small.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{neighbourhoods} neighbourhoods are not at least {min}", min = NoiseSettings::NEIGHBOURHOODS_MIN)]
pub struct NoiseSettingsError {
    /// Value given.
    pub neighbourhoods: usize,
}

impl NoiseSettings {
    /// Default number of neighbourhoods: some 37,000 degrees of freedom, which give the noise to
    /// 0.6 %.
    pub const NEIGHBOURHOODS: usize = 4096;
    /// Fewer tell nothing.
    pub const NEIGHBOURHOODS_MIN: usize = 20;

    /// At most that many neighbourhoods, at least [`NoiseSettings::NEIGHBOURHOODS_MIN`].
    pub fn new(neighbourhoods: usize, along: Along) -> Result<NoiseSettings, NoiseSettingsError> {
        if neighbourhoods < NoiseSettings::NEIGHBOURHOODS_MIN {
            Err(NoiseSettingsError { neighbourhoods })
        } else {
            Ok(NoiseSettings { neighbourhoods, along })
        }
    }

    pub(super) fn neighbourhoods(&self) -> usize {
        self.neighbourhoods
    }
}

impl Default for NoiseSettings {
    /// [`NoiseSettings::NEIGHBOURHOODS`] and noise along z.
    fn default() -> NoiseSettings {
        NoiseSettings { neighbourhoods: NoiseSettings::NEIGHBOURHOODS, along: Along::Z }
    }
}

/// Noise found in the points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseEstimate {
    /// The noise.
    pub noise: Noise,
    /// Standard uncertainty of its standard deviation in mm, from the number of residuals.
    pub uncertainty_mm: f64,
    /// How many neighbourhoods were used.
    pub neighbourhoods: u64,
    /// How many neighbourhoods were looked at but had too few samples, or so many wrong readings that
    /// nothing was left.
    pub unusable: u64,
    /// How many residuals the figure is the median of.
    pub residuals: u64,
    /// Share of the samples that stood off by more than 4.5 standard deviations and were left out.
    pub outlier_share: f64,
    /// Step in which the heights come, mm, where the noise found is no more than that of rounding.
    pub step_mm: Option<f64>,
    /// How regions differ, where they do: `noise` is then no more than a middle.
    pub uneven: Option<UnevenNoise>,
}

/// Noise that differs from region to region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnevenNoise {
    /// Standard deviation in the quietest region, mm.
    pub least_mm: f64,
    /// Standard deviation in the loudest region, mm.
    pub most_mm: f64,
    /// Root mean square over all regions, mm: what it adds to the mean square of the deviations.
    pub rms_mm: f64,
    /// Standard uncertainty of that, mm.
    pub u_rms_mm: f64,
}

impl NoiseEstimate {
    /// The estimate for heights that come in such a step: no noise below that of rounding.
    #[must_use]
    pub fn with_step(self, step_mm: f64) -> NoiseEstimate {
        let rounding = Noise::new(step_sigma_mm(step_mm), self.noise.along()).ok();
        match rounding.filter(|rounding| rounding.sigma_mm() > self.noise.sigma_mm()) {
            Some(noise) => NoiseEstimate { noise, step_mm: Some(step_mm), uneven: None, ..self },
            None => self,
        }
    }

    /// Standard uncertainty in mm of what the noise adds to the root mean square: where regions differ, of their own.
    pub fn u_mm(&self) -> f64 {
        self.uneven.map_or(self.uncertainty_mm, |uneven| uneven.u_rms_mm)
    }

    /// The estimate with how regions of about the same size differ. Less than twice, or no more than chance explains, is no
    /// difference; nor is noise below [`NoiseEstimate::NEGLIGIBLE_MM`].
    #[must_use]
    pub fn over(self, regions: &[NoiseEstimate]) -> NoiseEstimate {
        let by_noise = |a: &&NoiseEstimate, b: &&NoiseEstimate| {
            a.noise.sigma_mm().total_cmp(&b.noise.sigma_mm())
        };
        let ends = regions.iter().min_by(by_noise).zip(regions.iter().max_by(by_noise));
        let Some((least, most)) = ends else { return self };
        let [least_mm, most_mm] = [least, most].map(|region| region.noise.sigma_mm());
        let by_chance_mm = SURE * least.uncertainty_mm.hypot(most.uncertainty_mm);
        let differs = most_mm >= TWICE * least_mm && most_mm - least_mm > by_chance_mm;
        if !differs || most_mm < NoiseEstimate::NEGLIGIBLE_MM {
            return self;
        }
        let share = |region: &NoiseEstimate| region.neighbourhoods as f64;
        let all: f64 = regions.iter().map(share).sum();
        let square = |region: &NoiseEstimate| share(region) * region.noise.sigma_mm().powi(2);
        let rms_mm = (regions.iter().map(square).sum::<f64>() / all).sqrt();
        // Of the square of a region it is 2·σ·u(σ).
        let of_square = |region: &NoiseEstimate| {
            share(region) * 2.0 * region.noise.sigma_mm() * region.uncertainty_mm
        };
        let u_square = regions.iter().map(|region| of_square(region).powi(2)).sum::<f64>().sqrt();
        let u_rms_mm = u_square / all / (2.0 * rms_mm);
        let uneven = UnevenNoise { least_mm, most_mm, rms_mm, u_rms_mm };
        NoiseEstimate { uneven: Some(uneven), ..self }
    }

    /// Noise that no instrument has: what polynomials leave of smooth form is larger.
    pub const NEGLIGIBLE_MM: f64 = 1e-7;
}

/// Why the noise is not known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Error)]
pub enum NoiseUnknown {
    /// Too few vertices have neighbourhoods that tell something.
    #[error("the points have {usable} neighbourhoods to estimate it from, {needed} are needed", needed = NoiseSettings::NEIGHBOURHOODS_MIN)]
    TooFewNeighbourhoods {
        /// How many there are.
        usable: u64,
    },
}

/// Regions whose noise differs by less have the same.
const TWICE: f64 = 2.0;
/// Standard uncertainties by which the ends of some twenty regions differ by chance, at most.
const SURE: f64 = 5.0;

/// Estimates the noise of the heights of a surface. `adjacency` is that of these points.
///
/// Takes some 8 µs for each of the neighbourhoods looked at, however many points there are, and
/// depends on nothing but the arguments. Neighbourhoods are shared out to rayon's threads.
///
/// # Panics
///
/// When the adjacency is that of more points than these.
pub fn estimate_noise(
    points: &[PointMm],
    adjacency: &Adjacency,
    settings: &NoiseSettings,
) -> Result<NoiseEstimate, NoiseUnknown> {
    let chosen = chosen(adjacency.len(), settings.neighbourhoods);
    estimate_noise_about(points, adjacency, &chosen, settings)
}

/// The noise by the neighbourhoods of these vertices, as [`estimate_noise`].
///
/// # Errors
///
/// Too few of them.
///
/// # Panics
///
/// As [`estimate_noise`], and where there is no such vertex.
pub fn estimate_noise_about(
    points: &[PointMm],
    adjacency: &Adjacency,
    vertices: &[VertexId],
    settings: &NoiseSettings,
) -> Result<NoiseEstimate, NoiseUnknown> {
    let neighbourhoods = |vertex: VertexId| (points, adjacency, vertex, settings.along);
    let rough_mm: Vec<Option<f64>> = vertices
        .par_iter()
        .map_init(Work::default, |work, &vertex| work.rough_mm(neighbourhoods(vertex)))
        .collect();
    let mut known: Vec<f64> = rough_mm.iter().copied().flatten().collect();
    let too_few = |usable: usize| NoiseUnknown::TooFewNeighbourhoods { usable: usable as u64 };
    if known.len() < NoiseSettings::NEIGHBOURHOODS_MIN {
        return Err(too_few(known.len()));
    }
    let typical_mm = median(&mut known);
    let cleaned: Vec<Option<Cleaned>> = vertices
        .par_iter()
        .zip(&rough_mm)
        .map_init(Work::default, |work, (&vertex, rough_mm)| {
            let scale_mm = rough_mm.as_ref()?.clamp(typical_mm, LOUDEST * typical_mm);
            work.cleaned(neighbourhoods(vertex), OUTLIER * scale_mm)
        })
        .collect();
    let cleaned: Vec<Cleaned> = cleaned.into_iter().flatten().collect();
    if cleaned.len() < NoiseSettings::NEIGHBOURHOODS_MIN {
        return Err(too_few(cleaned.len()));
    }
    let mut sizes_mm: Vec<f64> = cleaned.iter().flat_map(|c| c.sizes_mm.iter().copied()).collect();
    let residuals = sizes_mm.len();
    let sigma_mm = NORMAL * median(&mut sizes_mm);
    let samples: usize = cleaned.iter().map(|cleaned| cleaned.samples.len()).sum();
    let out: usize = cleaned.iter().map(|cleaned| cleaned.left_out).sum();
    let freedom: usize = cleaned.iter().map(|cleaned| cleaned.freedom).sum();
    let mut distinct: Vec<VertexId> =
        cleaned.iter().flat_map(|c| c.samples.iter().copied()).collect();
    distinct.sort_unstable();
    distinct.dedup();
    // Neighbourhoods that overlap tell the same twice.
    let independent = freedom as f64 * distinct.len() as f64 / samples as f64;
    let noise = Noise::new(sigma_mm, settings.along)
        .expect("residuals of finite points within range are finite");
    Ok(NoiseEstimate {
        noise,
        uncertainty_mm: MEDIAN_DEVIATION * sigma_mm / independent.sqrt(),
        neighbourhoods: cleaned.len() as u64,
        unusable: (vertices.len() - cleaned.len()) as u64,
        residuals: residuals as u64,
        outlier_share: out as f64 / samples as f64,
        step_mm: None,
        uneven: None,
    })
}

/// Up to `count` of the numbers below `all`, evenly spread, in order.
pub(super) fn chosen(all: usize, count: usize) -> Vec<VertexId> {
    if count >= all {
        return (0..all as VertexId).collect();
    }
    let mut chosen: Vec<VertexId> = (0..count as u64)
        .map(|index| {
            // The fraction in 64 bits: its product with the count keeps them all.
            let fraction = u128::from(index.wrapping_mul(GOLDEN_RATIO));
            ((fraction * all as u128) >> 64) as VertexId
        })
        .collect();
    chosen.sort_unstable();
    chosen.dedup();
    chosen
}

/// Remainder of a neighbourhood without its wrong readings.
struct Cleaned {
    sizes_mm: Vec<f64>,
    samples: Vec<VertexId>,
    left_out: usize,
    freedom: usize,
}

type Neighbourhood<'a> = (&'a [PointMm], &'a Adjacency, VertexId, Along);

/// Memory that one neighbourhood leaves to the next.
#[derive(Default)]
struct Work {
    rings: Rings,
    residuals: Residuals,
}

impl Work {
    /// Fits a neighbourhood; the size along the direction of the noise of a residual of 1 along z.
    fn fit(&mut self, (points, adjacency, vertex, along): Neighbourhood<'_>) -> Option<f64> {
        self.rings.gather(adjacency, vertex, RINGS);
        let slope = self.residuals.fit(points, self.rings.samples())?;
        Some(match along {
            Along::Z => 1.0,
            Along::Normal => 1.0 / slope.secant,
        })
    }

    /// Rough standard deviation of the noise, with a third of the freedom given to the worst.
    fn rough_mm(&mut self, neighbourhood: Neighbourhood<'_>) -> Option<f64> {
        let scale = self.fit(neighbourhood)?;
        for _ in 0..self.residuals.freedom() / 3 {
            self.residuals.leave_out_worst(0.0);
        }
        Some(scale * self.residuals.deviation() / TRIMMED)
    }

    fn cleaned(&mut self, neighbourhood: Neighbourhood<'_>, limit_mm: f64) -> Option<Cleaned> {
        let scale = self.fit(neighbourhood)?;
        let limit = limit_mm / scale;
        while self.residuals.leave_out_worst(limit) {}
        (self.residuals.worst() <= limit).then(|| Cleaned {
            sizes_mm: self.residuals.studentized().map(|size| scale * size).collect(),
            samples: self.rings.samples().to_vec(),
            left_out: self.residuals.left_out(),
            freedom: self.residuals.freedom(),
        })
    }
}

/// The median of values of which there is one at least; the lower of two.
fn median(values: &mut [f64]) -> f64 {
    let middle = (values.len() - 1) / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Rings of a neighbourhood: a cubic leaves about half of the samples' freedom.
const RINGS: usize = 2;
/// 2⁶⁴ over the golden ratio.
const GOLDEN_RATIO: u64 = 0x9E37_79B9_7F4A_7C15;
/// Standard deviation of normal residuals over the true one when a third of nine degrees of freedom
/// went to the worst. It decides only where wrong readings begin.
const TRIMMED: f64 = 0.46;
/// A residual above this many standard deviations is a wrong reading: normal noise has 7 in a
/// million beyond.
const OUTLIER: f64 = 4.5;
/// How much larger than typical the noise of one neighbourhood can be before it must be due to wrong
/// readings.
const LOUDEST: f64 = 3.0;
/// Standard deviation of a normal distribution over the median of its sizes.
const NORMAL: f64 = 1.482_602_218_505_602;
/// Standard deviation of that estimate over σ, times the root of the number of values: its
/// efficiency is 37 %.
const MEDIAN_DEVIATION: f64 = 1.166;
