//! Height parameters of a texture in simulated measurements.
//!
//! Filters are linear, so errors pass them as heights do, and a draw adds what is left of its errors to the heights as
//! measured. What is correlated is filtered once, function by function, at the nodes of [`Modes`]. Independent noise is not
//! drawn point by point: what filters leave of its variance and of its square is known from the share of each frequency that
//! passes ([`NoiseLeft`]). Averages over the area, Sa and Sq, take that noise by its mean, and by a normal
//! deviate for its fluctuation: with y the noise at a place and f what is averaged, var f(h + y) = (E f′)²·var y + rest
//! (the first term of an expansion in Hermite polynomials); of the first as many places are independent as if nothing
//! had been filtered, of the rest as many as the squares of the noise tell. Extremes, Sp, Sv and Sz, have limits of their
//! own ([`super::extremes`]): of the noise of a single place filters leave a part, of that of a mean over places no more than
//! there was.
//!
//! The first order takes waves of the surface for whole of which an S-filter passes a part; u of Sa and Sq is then too large,
//! by up to a half or so. Noise adds to averages in squares, so that for these the share of the noise is taken off in squares.

use std::f64::consts::{PI, SQRT_2};

use rayon::prelude::*;

use super::Uncertainty;
use super::budget::UncertaintyError;
use super::distribution::{normal_cdf, student_quantile};
use super::extremes::{self, Errors, Extremes};
use super::linear::dot;
use super::modes::Modes;
use super::simulate::{Draws, Simulated, extremes, factors};
use asphera_figures::Definition;
use asphera_figures::texture::{Datum, Functions, Mesh, NoiseLeft, Parameter, Scale};
use asphera_form::NM_PER_MM;
use asphera_geometry::Numbers;

/// A place of the surface that counts.
struct Place {
    /// Its index among the points of the fit.
    index: usize,
    height_nm: f64,
    /// Share of the area.
    share: f64,
    node: usize,
    /// Variance of the noise that is left there in nm².
    left_nm2: f64,
}

/// The mean of a quantity over the places.
type Mean<'a> = dyn Fn(&dyn Fn(&Place) -> f64) -> f64 + 'a;

/// Part that all of them share.
struct Nodes {
    /// Remainder of each function at each node in nm.
    functions: Functions,
    /// Remainder of the noise at each.
    left: Vec<NoiseLeft>,
    /// Area in mm² of a point there.
    areas_mm2: Vec<f64>,
}

impl Uncertainty {
    /// Sa, Sq, Sp, Sv and Sz of a scale-limited surface of the deviations, in nm, by simulated measurements; empty where no
    /// point counts. Vertices of `surface` are the points given, in their order.
    ///
    /// `scale` and `f_operation` are what made the surface; robust filters count as linear ones. `O(n)` once, and a draw
    /// costs the same however many points there are. Where cut-offs are below a sixteenth of the part, long-wave errors
    /// count for what pieces of a forty-eighth of it tell.
    pub fn texture(
        &self,
        surface: &Mesh,
        scale: &Scale,
        f_operation: Datum,
        draws: &Draws,
    ) -> Result<Vec<(Definition, Simulated)>, UncertaintyError> {
        draws.validate()?;
        let linear = &self.linear;
        let needed = linear.indices.last().map_or(0, |last| last + 1);
        if surface.len() < needed {
            return Err(UncertaintyError::Lengths { points: needed, found: surface.len() });
        }
        let areas_mm2 = surface.areas_mm2();
        let area_mm2 = |index: usize| areas_mm2[linear.indices[index]];
        let place = |index: usize| {
            let height_nm = surface.height_nm(linear.indices[index])?;
            let node = self.modes.node_of(index);
            let left_nm2 = self.noise_mm2[index] * NM_PER_MM * NM_PER_MM;
            let share = Some(area_mm2(index)).filter(|area| *area > 0.0)?;
            Some(Place { index, height_nm, share, node, left_nm2 })
        };
        let mut places: Vec<Place> = (0..linear.len()).filter_map(place).collect();
        if places.is_empty() {
            return Ok(Vec::new());
        }
        let nodes = self.nodes(&places, scale, [f_operation, surface.datum()]);
        let all_mm2: f64 = places.iter().map(|place| place.share).sum();
        for place in &mut places {
            place.share /= all_mm2;
            place.left_nm2 *= nodes.left[place.node].variance;
        }
        let mut found = self.averages(&places, &nodes, draws);
        found.extend(self.ends(&places, &nodes, scale, draws));
        let of = |(parameter, simulated)| (Definition::Texture(parameter), simulated);
        Ok(found.into_iter().map(of).collect())
    }

    /// What filters leave at the nodes; shares of places are still areas in mm².
    fn nodes(&self, places: &[Place], scale: &Scale, datums: [Datum; 2]) -> Nodes {
        let Modes { nodes, residual_mm, .. } = &self.modes;
        let (mut areas_mm2, mut counts) = (vec![0.0; nodes.len()], vec![0.0_f64; nodes.len()]);
        for place in places {
            areas_mm2[place.node] += place.share;
            counts[place.node] += 1.0;
        }
        let places_mm: Vec<[f64; 2]> = nodes.iter().map(|node| node.place_mm).collect();
        let of_node =
            |values: &Vec<f64>| values.iter().map(|value| value * NM_PER_MM).collect::<Vec<f64>>();
        let functions: Functions = residual_mm.iter().map(of_node).collect();
        let functions = if self.modes.functions() == 0 {
            functions
        } else {
            scale.of_functions(&places_mm, &areas_mm2, functions, datums)
        };
        let areas_mm2: Vec<f64> =
            areas_mm2.iter().zip(&counts).map(|(area, count)| area / count.max(1.0)).collect();
        let left = areas_mm2.par_iter().map(|&area| scale.of_noise(area)).collect();
        Nodes { functions, left, areas_mm2 }
    }

    /// Sa and Sq.
    fn averages(
        &self,
        places: &[Place],
        nodes: &Nodes,
        draws: &Draws,
    ) -> Vec<(Parameter, Simulated)> {
        let step = places.len().div_ceil(MOST_AVERAGED);
        let some: Vec<&Place> = places.iter().step_by(step).collect();
        let weight: f64 = some.iter().map(|place| place.share).sum();
        let mean = |of: &dyn Fn(&Place) -> f64| -> f64 {
            some.iter().map(|place| place.share * of(place)).sum::<f64>() / weight
        };
        let whole = |of: &dyn Fn(f64) -> f64| -> f64 {
            places.iter().map(|place| place.share * of(place.height_nm)).sum()
        };
        let table = FoldedNormal::new();
        // Means of the size and of the square, as measured and of some places.
        let measured = [whole(&f64::abs), whole(&|h| h * h)];
        let of_some =
            [mean(&|place| place.height_nm.abs()), mean(&|place| place.height_nm.powi(2))];
        let spread = self.spread(places, &mean, nodes, &table);
        let with_waves = |draw: u32| {
            let factors = factors(draws.seed, draw, self.modes.functions());
            let waves_nm: Vec<f64> =
                nodes.functions.iter().map(|values| dot(values, &factors)).collect();
            [
                mean(&|place| {
                    table.mean(place.height_nm + waves_nm[place.node], place.left_nm2.sqrt())
                }),
                mean(&|place| (place.height_nm + waves_nm[place.node]).powi(2) + place.left_nm2),
            ]
        };
        let drawn: Vec<[f64; 2]> = if self.modes.functions() > 0 {
            (0..draws.count).into_par_iter().map(with_waves).collect()
        } else {
            vec![with_waves(0); draws.count as usize]
        };
        let parameters = [Parameter::Sa, Parameter::Sq];
        let figure = |(column, parameter): (usize, Parameter)| {
            let of_draw = |(draw, drawn): (u32, &[f64; 2])| {
                let noise = Numbers::new(draws.seed, draw, TEXTURE).normal(column);
                let mean = measured[column] + drawn[column] - of_some[column];
                let mean = (mean + spread[column].sqrt() * noise).max(0.0);
                Some(if parameter == Parameter::Sq { mean.sqrt() } else { mean })
            };
            let found: Vec<Option<f64>> = (0..).zip(&drawn).map(of_draw).collect();
            let measured = match parameter {
                Parameter::Sq => measured[column].sqrt(),
                _ => measured[column],
            };
            let simulated = match parameter {
                Parameter::Sq => Simulated::of_squares(measured, &found, some.len(), 0.0),
                _ => Simulated::of_sizes(measured, &found, some.len()),
            };
            Some((parameter, simulated?))
        };
        parameters.into_iter().enumerate().filter_map(figure).collect()
    }

    /// Variances by independent noise of the means of the size and of the square of the heights.
    fn spread(
        &self,
        places: &[Place],
        mean: &Mean<'_>,
        nodes: &Nodes,
        table: &FoldedNormal,
    ) -> [f64; 2] {
        // What one place of many counts.
        let single: f64 = places.iter().map(|place| place.share * place.share).sum();
        let of = |first: &dyn Fn(f64, f64) -> f64, all: &dyn Fn(f64, f64) -> f64| {
            let of_place = |place: &Place| {
                let (h, s2) = (place.height_nm, place.left_nm2);
                if s2 <= 0.0 {
                    return 0.0;
                }
                let NoiseLeft { variance, square } = nodes.left[place.node];
                let linear = first(h, s2);
                let rest = (all(h, s2) - linear).max(0.0);
                linear / variance + rest * square / (variance * variance)
            };
            single * mean(&of_place)
        };
        let of_size =
            of(&|h, s2| s2 * (2.0 * normal_cdf(h / s2.sqrt()) - 1.0).powi(2), &|h, s2| {
                h * h + s2 - table.mean(h, s2.sqrt()).powi(2)
            });
        let of_square = of(&|h, s2| 4.0 * h * h * s2, &|h, s2| 4.0 * h * h * s2 + 2.0 * s2 * s2);
        [of_size, of_square]
    }

    /// Sp, Sv and Sz.
    fn ends(
        &self,
        places: &[Place],
        nodes: &Nodes,
        scale: &Scale,
        draws: &Draws,
    ) -> Vec<(Parameter, Simulated)> {
        let of = |value: &dyn Fn(&Place) -> f64| places.iter().map(value).collect::<Vec<f64>>();
        let heights_nm = of(&|place| place.height_nm);
        let mut noise_nm2 = of(&|place| place.left_nm2);
        if scale.s_mm().is_some() {
            let near = self.near_ends(places, nodes);
            let left = self.left_at(places, &near, nodes, scale);
            near.into_iter().zip(left).for_each(|(place, left_nm2)| noise_nm2[place] = left_nm2);
        }
        let places_mm: Vec<[f64; 2]> =
            places.iter().map(|place| self.linear.places_mm[place.index]).collect();
        let node_of: Vec<usize> = places.iter().map(|place| place.node).collect();
        let found = Extremes::new(
            &Errors {
                places_mm: &places_mm,
                heights: &heights_nm,
                noise: &noise_nm2,
                independent: &of(&|place| self.noise_mm2[place.index] * NM_PER_MM * NM_PER_MM),
                functions: &nodes.functions,
                node_of: &node_of,
            },
            extremes::Datum::Fixed,
        );
        let [low, high] = extremes(&heights_nm);
        let [sp, sv, sz] = found.figures([high, -low], draws);
        vec![(Parameter::Sp, sp), (Parameter::Sv, sv), (Parameter::Sz, sz)]
    }

    /// Places that may be an extreme, the outermost if there are many.
    fn near_ends(&self, places: &[Place], nodes: &Nodes) -> Vec<usize> {
        let noise_nm2 = places.iter().map(|place| place.left_nm2).fold(0.0, f64::max);
        let waves_nm2 = nodes.functions.iter().map(|values| dot(values, values));
        let u_nm = (noise_nm2 + waves_nm2.fold(0.0, f64::max)).sqrt();
        let share = MISSED / places.len() as f64;
        let reach_nm = AT_BORDER * SQRT_2 * u_nm * student_quantile(1.0 - share, f64::INFINITY);
        let heights_nm = places.iter().map(|place| place.height_nm);
        let ranked = |sign: f64| {
            let mut ranked: Vec<(f64, usize)> =
                heights_nm.clone().map(|height| sign * height).zip(0..).collect();
            let most = ranked.iter().map(|(height, _)| *height).fold(f64::NEG_INFINITY, f64::max);
            ranked.retain(|(height, _)| *height >= most - reach_nm);
            ranked.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            ranked.truncate(MOST_NEAR);
            ranked.into_iter().map(|(_, index)| index)
        };
        let mut found: Vec<usize> = ranked(1.0).chain(ranked(-1.0)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Variance in nm² of the noise that is left at some places, the border regarded.
    fn left_at(&self, places: &[Place], some: &[usize], nodes: &Nodes, scale: &Scale) -> Vec<f64> {
        let places_mm: Vec<[f64; 2]> =
            places.iter().map(|place| self.linear.places_mm[place.index]).collect();
        let areas_mm2: Vec<f64> = places.iter().map(|place| nodes.areas_mm2[place.node]).collect();
        let of_place = |&i: &usize| places[i].left_nm2;
        match scale.of_noise_at(&places_mm, &areas_mm2, some) {
            None => some.iter().map(of_place).collect(),
            Some(left) => some
                .iter()
                .zip(left)
                .map(|(&i, left)| self.noise_mm2[places[i].index] * left * NM_PER_MM * NM_PER_MM)
                .collect(),
        }
    }
}

/// E|h + s·z| with z standard normal, from a table.
struct FoldedNormal {
    values: Vec<f64>,
}

impl FoldedNormal {
    fn new() -> FoldedNormal {
        let value = |step: usize| {
            let t = step as f64 * STEP;
            (2.0 / PI).sqrt() * (-0.5 * t * t).exp() + t * (2.0 * normal_cdf(t) - 1.0)
        };
        FoldedNormal { values: (0..=STEPS).map(value).collect() }
    }

    /// To 1e-4 of `sigma`.
    fn mean(&self, height: f64, sigma: f64) -> f64 {
        let size = height.abs();
        let at = size / (sigma * STEP);
        if sigma <= 0.0 || at >= STEPS as f64 {
            return size;
        }
        let (step, share) = (at as usize, at.fract());
        sigma * (self.values[step] + share * (self.values[step + 1] - self.values[step]))
    }
}

/// Places that averages are taken over, spread evenly over the points.
const MOST_AVERAGED: usize = 8192;
/// Places at either end whose noise is worked out with the border regarded.
const MOST_NEAR: usize = 2048;
/// Probability that a place which is not near would have been an extreme.
const MISSED: f64 = 1e-4;
/// By how much more the noise may be left at the border.
const AT_BORDER: f64 = 2.0;
/// A stream of random numbers, beside those of the measurements.
const TEXTURE: u32 = 3;
/// Of the table, in standard deviations.
const STEP: f64 = 1.0 / 64.0;
const STEPS: usize = 512;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_size_of_normal_numbers_about_a_height() {
        let table = FoldedNormal::new();
        // √(2/π); 1.16663 = 2·φ(1) + 2·Φ(1) − 1 with φ(1) = 0.241971, Φ(1) = 0.841345.
        for (height, sigma, truth) in
            [(0.0, 1.0, 0.797_885), (-1.0, 1.0, 1.166_632), (90.0, 3.0, 90.0), (2.0, 0.0, 2.0)]
        {
            assert!((table.mean(height, sigma) - truth).abs() < 1e-4 * (1.0 + sigma));
        }
    }
}
