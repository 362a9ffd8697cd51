//! The deviation of a whole aperture as it may turn out, by what was measured of it.
//!
//! The aperture is cut into blocks. The means of those that were measured are taken for a sample of a random function
//! with the correlation σ²·(ρ(h/ℓ) + w·[h = 0]), as in [`crate::type_a()`]: which kernel, length and w is
//! judged by the restricted likelihood, which looks only at what neither a parameter of the fit nor a wave
//! longer than the part, a polynomial of the third degree, can take off. Those that were
//! not are then drawn given the others (universal kriging: Cressie, Statistics for Spatial Data, 1993, 3.4; conditional
//! simulation: 3.6), the parameters and the polynomial being unknown and σ² too, and the whole is fitted anew. So a
//! fit of a part that has swallowed long waves of it says by itself how little it tells of the rest. What varies
//! within a block that was not measured is as in one that was, taken at random.
//!
//! The assumption is that the function is the same kind everywhere. An isolated defect, or an edge that is turned
//! down, is not of that kind.

mod correlation;
mod field;
mod predicted;

use nalgebra::DMatrix;

use self::correlation::{Posterior, posteriors};
use self::field::{Block, blocks};
pub use self::predicted::Predicted;
use asphera_figures::{Definition, Terms, fringe_orders};
use asphera_form::basis::{Normalisation, zernike_value};
use asphera_form::linear::Model;
use asphera_form::{Aperture, Nominal, Parameter, Pose};
use asphera_geometry::Numbers;

/// Wholes as they may turn out, each as likely as the next.
#[derive(Clone, Debug)]
pub struct Forecast {
    aperture: Aperture,
    blocks: Vec<Block>,
    /// Orthonormal under the weights: what the fit takes off.
    fitted: Vec<Vec<f64>>,
    /// Blocks that were measured as they are, fitted anew.
    now_nm: Vec<f64>,
    draws: Vec<Drawn>,
}

/// One whole.
#[derive(Clone, Debug)]
struct Drawn {
    /// Means of the blocks, fitted anew, nm.
    mean_nm: Vec<f64>,
    /// Mean square about the mean, nm².
    scatter_nm2: Vec<f64>,
    /// For each block the one whose extremes it has: itself, if it was measured.
    like: Vec<usize>,
}

/// Deviations from a fit, and where they are.
#[derive(Clone, Copy, Debug)]
pub struct Deviations<'a> {
    /// Places in the part frame in mm, seen along its axis.
    pub places_mm: &'a [[f64; 2]],
    /// As many deviations in mm; NaN where a point does not count.
    pub deviations_mm: &'a [f64],
}

/// What is forecast of these deviations from a fit of the `free` parameters. `missing` is the share of the aperture that was not measured, 0 to 1, if
/// it is known; otherwise blocks with fewer points than most are taken for partly measured. `None` without an aperture, with fewer
/// than 16 blocks of a 144th of its box measured beyond the parameters, or where no correlation can be judged. `O(n)`
/// and some tens of milliseconds. The same arguments give the same bits.
pub fn forecast(
    Deviations { places_mm, deviations_mm }: Deviations<'_>,
    aperture: &Aperture,
    nominal: &Nominal,
    pose: &Pose,
    free: &[Parameter],
    missing: Option<f64>,
) -> Option<Forecast> {
    let blocks = blocks(places_mm, deviations_mm, aperture, missing)?;
    let weights: Vec<f64> = blocks.iter().map(|block| block.weight).collect();
    let fitted = orthonormal(columns(&blocks, nominal, pose, free)?, &weights);
    let seen: Vec<usize> = (0..blocks.len()).filter(|&at| blocks[at].seen.is_some()).collect();
    if seen.len() < fitted.len() + DRIFT + LEAST_BLOCKS {
        return None;
    }
    let drift = fitted.iter().cloned().chain(drift(&blocks, aperture)).collect();
    let drift = orthonormal(drift, &weights);
    let trend = DMatrix::from_fn(blocks.len(), drift.len(), |i, j| drift[j][i]);
    let places: Vec<[f64; 2]> = blocks.iter().map(|block| block.place_mm).collect();
    let means_nm: Vec<f64> =
        blocks.iter().map(|block| block.seen.map_or(0.0, |seen| seen.mean_nm)).collect();
    let posteriors = posteriors(&places, &means_nm, &trend, &seen)?;
    let mut forecast = Forecast {
        aperture: aperture.clone(),
        now_nm: means_nm,
        draws: Vec::new(),
        blocks,
        fitted,
    };
    forecast.draws = (0..DRAWS).map(|draw| forecast.draw(draw, &seen, &posteriors)).collect();
    Some(forecast)
}

impl Forecast {
    /// A figure over a zone, after removal of terms: PV, or else RMS. `now_nm` is its value of the points there are.
    ///
    /// What the blocks tell of the present figure is replaced by that value. `None` where the zone holds nothing
    /// measured. `places_mm` and `deviations_mm` are those the forecast is of.
    pub fn predict(
        &self,
        definition: Definition,
        zone: &Aperture,
        less: &Terms,
        now_nm: f64,
        (places_mm, deviations_mm): (&[[f64; 2]], &[f64]),
    ) -> Option<Predicted> {
        let zone = if *zone == Aperture::None { &self.aperture } else { zone };
        let extremes_nm = if *zone == self.aperture {
            let own = |block: &Block| block.seen.map(|seen| [seen.below_nm, seen.above_nm]);
            self.blocks.iter().map(own).collect()
        } else {
            field::extremes_nm(&self.blocks, &self.aperture, zone, places_mm, deviations_mm)
        };
        let inside = Inside {
            blocks: &self.blocks,
            shares: field::shares(&self.blocks, &self.aperture, zone),
            extremes_nm,
        };
        let columns = self.terms(less);
        let removed = orthonormal(columns.clone(), &self.weights(|_| true));
        // The present figure had the terms removed from what is measured.
        let measured = self.weights(|block| block.seen.is_some());
        let removed_now = orthonormal(columns, &measured);
        let mut present = Drawn {
            mean_nm: self.now_nm.clone(),
            scatter_nm2: self.blocks.iter().map(scatter_nm2).collect(),
            like: (0..self.blocks.len()).collect(),
        };
        take_off(&removed_now, &measured, &mut present.mean_nm);
        let weights = self.weights(|_| true);
        let of_range = definition == Definition::PeakToValley;
        let figure = |drawn: &Drawn| {
            if of_range { inside.range_nm(drawn) } else { inside.square_nm2(drawn) }
        };
        let now = figure(&present)?;
        let value_nm = |drawn: &Drawn| {
            let mut drawn = drawn.clone();
            take_off(&removed, &weights, &mut drawn.mean_nm);
            let more = figure(&drawn)? - now;
            Some(if of_range { now_nm + more } else { (now_nm * now_nm + more).max(0.0).sqrt() })
        };
        let values_nm: Option<Vec<f64>> = self.draws.iter().map(value_nm).collect();
        values_nm.map(Predicted::of_values)
    }

    /// One whole.
    fn draw(&self, draw: u32, seen: &[usize], posteriors: &[(f64, Posterior)]) -> Drawn {
        let (numbers, varied) = (Numbers::new(SEED, draw, 0), Numbers::new(SEED, draw, 1));
        let choice = (f64::from(draw) + 0.5) / f64::from(DRAWS);
        let mut so_far = 0.0;
        let chosen = posteriors.iter().find(|(chance, _)| {
            so_far += chance;
            so_far >= choice
        });
        let (_, posterior) = chosen.unwrap_or(&posteriors[posteriors.len() - 1]);
        let mut mean_nm = self.now_nm.clone();
        let mut scatters_nm2: Vec<f64> = self.blocks.iter().map(scatter_nm2).collect();
        let mut like: Vec<usize> = (0..self.blocks.len()).collect();
        for (at, nm) in posterior.draw(&numbers) {
            let block = &self.blocks[at];
            mean_nm[at] = nm;
            like[at] = block.beside.unwrap_or_else(|| seen[varied.one_of(at, seen.len())]);
            let other = &self.blocks[like[at]];
            // The variance of the mean square of so many normal numbers.
            let spread = (2.0 / block.weight + 2.0 / other.weight).sqrt();
            scatters_nm2[at] = scatter_nm2(other) * (1.0 + varied.normal(at) * spread).max(0.0);
        }
        take_off(&self.fitted, &self.weights(|_| true), &mut mean_nm);
        Drawn { mean_nm, scatter_nm2: scatters_nm2, like }
    }

    /// Of the blocks that count, 0 of others.
    fn weights(&self, counts: impl Fn(&Block) -> bool) -> Vec<f64> {
        self.blocks.iter().map(|block| if counts(block) { block.weight } else { 0.0 }).collect()
    }

    /// Terms over the blocks.
    fn terms(&self, less: &Terms) -> Vec<Vec<f64>> {
        let reach_mm = self.aperture.reach_mm().unwrap_or(f64::INFINITY);
        let terms = less.list();
        let numbers = terms.iter().flat_map(|term| term.fringe());
        let columns = numbers.filter_map(|&number| {
            let (n, m) = fringe_orders(number)?;
            let value = |block: &Block| {
                let [x, y] = block.place_mm.map(|mm| mm / reach_mm);
                zernike_value(n, m, Normalisation::UnitHeight, x, y).unwrap_or(0.0)
            };
            Some(self.blocks.iter().map(value).collect())
        });
        columns.collect()
    }
}

/// Part of the blocks that lies in a zone.
struct Inside<'a> {
    blocks: &'a [Block],
    /// Of each block.
    shares: Vec<f64>,
    /// How far its points there reach below and above its mean; `None` without one.
    extremes_nm: Vec<Option<[f64; 2]>>,
}

impl Inside<'_> {
    /// Blocks of which something is known: measured in the zone, or drawn.
    fn known<'a>(&'a self, drawn: &'a Drawn) -> impl Iterator<Item = usize> + 'a {
        (0..self.blocks.len()).filter(|&at| {
            self.shares[at] > 0.0 && (drawn.like[at] != at || self.extremes_nm[at].is_some())
        })
    }

    /// `None` where nothing is known.
    fn range_nm(&self, drawn: &Drawn) -> Option<f64> {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for at in self.known(drawn) {
            let like = drawn.like[at];
            let [below, above] = if like == at {
                self.extremes_nm[at]?
            } else {
                let other = self.blocks[like].seen?;
                [other.below_nm, other.above_nm]
            };
            low = low.min(drawn.mean_nm[at] - below);
            high = high.max(drawn.mean_nm[at] + above);
        }
        (high >= low).then_some(high - low)
    }

    fn square_nm2(&self, drawn: &Drawn) -> Option<f64> {
        let (mut sum, mut weights) = (0.0, 0.0);
        for at in self.known(drawn) {
            let weight = self.shares[at] * self.blocks[at].weight;
            sum += weight * (drawn.mean_nm[at].powi(2) + drawn.scatter_nm2[at]);
            weights += weight;
        }
        (weights > 0.0).then(|| sum / weights)
    }
}

fn scatter_nm2(block: &Block) -> f64 {
    block.seen.map_or(0.0, |seen| seen.scatter_nm2)
}

/// Derivatives of the distance by each parameter at the blocks.
fn columns(
    blocks: &[Block],
    nominal: &Nominal,
    pose: &Pose,
    free: &[Parameter],
) -> Option<Vec<Vec<f64>>> {
    let model = Model::new(nominal, pose, free);
    let mut columns = vec![Vec::with_capacity(blocks.len()); free.len()];
    let mut row = vec![0.0; free.len() + 1];
    for block in blocks {
        let [x, y] = block.place_mm;
        let point = pose.to_measured([x, y, nominal.height_mm(x, y)?]);
        model.row(point, &mut row)?;
        columns.iter_mut().zip(&row).for_each(|(column, &entry)| column.push(entry));
    }
    Some(columns)
}

/// Waves longer than the part, which no part of it tells the length of: all powers of the place to the third.
fn drift(blocks: &[Block], aperture: &Aperture) -> impl Iterator<Item = Vec<f64>> {
    let reach_mm = aperture.reach_mm().unwrap_or(f64::INFINITY);
    let powers = (0..=3).flat_map(|sum| (0..=sum).map(move |y| (sum - y, y)));
    powers.map(move |(i, j)| {
        let value = |block: &Block| {
            let [x, y] = block.place_mm.map(|mm| mm / reach_mm);
            x.powi(i) * y.powi(j)
        };
        blocks.iter().map(value).collect()
    })
}

/// Columns of unit length under the weights of the blocks, orthogonal to each other; those that others make up are left
/// out (Gram and Schmidt, twice).
fn orthonormal(columns: Vec<Vec<f64>>, weights: &[f64]) -> Vec<Vec<f64>> {
    let mut found: Vec<Vec<f64>> = Vec::new();
    for mut column in columns {
        let before = product(&column, &column, weights).sqrt();
        take_off(&found, weights, &mut column);
        take_off(&found, weights, &mut column);
        let length = product(&column, &column, weights).sqrt();
        if length > RANK_TOLERANCE * before {
            column.iter_mut().for_each(|entry| *entry /= length);
            found.push(column);
        }
    }
    found
}

/// Part of values that orthonormal columns take off.
fn take_off(columns: &[Vec<f64>], weights: &[f64], values: &mut [f64]) {
    for column in columns {
        let along = product(column, values, weights);
        values.iter_mut().zip(column).for_each(|(value, entry)| *value -= along * entry);
    }
}

fn product(a: &[f64], b: &[f64], weights: &[f64]) -> f64 {
    a.iter().zip(b).zip(weights).map(|((a, b), weight)| weight * a * b).sum()
}

/// How many wholes: a probability of 95 % to 1 %.
const DRAWS: u32 = 400;
const SEED: u64 = 0x5eed;
/// Powers of the place to the third.
const DRIFT: usize = 10;
/// Fewer blocks beyond the parameters tell no correlation.
const LEAST_BLOCKS: usize = 16;
/// Columns nearer to each other than this are one.
const RANK_TOLERANCE: f64 = 1e-7;

#[cfg(test)]
mod tests;
