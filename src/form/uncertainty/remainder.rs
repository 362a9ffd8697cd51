//! The range of what least squares leave of the deviations over a zone, of simulated measurements.
//!
//! What is taken off by least squares is linear in the deviations, so errors are left as heights are. Correlated errors are
//! taken off once, function by function, at the nodes of [`Modes`]. Independent noise stays as it is: of its variance a
//! share of columns over points is taken off, here below a five-hundredth, and that is not counted. So the highest of the points
//! of a node, with noise, has the distribution ln P(h) = Σ ln Φ((h − d)/σ) over the points with remainders d, from
//! which a draw takes it, and to which it adds the correlated errors there. That is exact for any
//! number of points near the extremes, be they few on a peak or all of them where noise makes the range, and a draw costs the same
//! however many points there are.

use std::f64::consts::SQRT_2;

use rayon::prelude::*;

use super::budget::UncertaintyError;
use super::distribution::{normal_cdf, student_quantile};
use super::linear::dot;
use super::modes::Modes;
use super::philox::Numbers;
use super::simulate::{Draws, MISSED, Simulated, Source, factors};
use crate::deviation::NM_PER_MM;
use crate::figures::Sample;

/// The points of a node that are in the zone.
struct Patch {
    node: usize,
    /// Their numbers in the sample.
    members: Vec<usize>,
    /// The one that stands for their place, as a number in the sample.
    middle: usize,
}

/// One end of a patch that may hold an extreme.
struct End {
    /// Number of the patch.
    patch: usize,
    highest: Highest,
}

impl Source<'_> {
    /// The range in nm of `whole`, which is what `left` leaves of the residuals; `None` if it is empty or nearly all draws are.
    ///
    /// `left` is given places in mm, deviations there in mm and how much each counts, every one alike where that is not said.
    /// Up to 16,384 points are drawn one by one. `O(n)` once, `O(m·p²)` for m functions of correlated errors,
    /// and a draw costs the same for any more points.
    pub(super) fn range_nm(
        &self,
        draws: &Draws,
        whole: &Sample,
        left: impl Fn(&[[f64; 2]], &[f64], Option<&[f64]>) -> Option<Sample> + Sync,
    ) -> Result<Option<Simulated>, UncertaintyError> {
        draws.validate()?;
        let linear = self.linear;
        let Some([low_nm, high_nm]) = Sample::range(whole.values_nm()) else { return Ok(None) };
        let patches = self.patches(whole);
        let waves = if whole.len() > MOST_DRAWN {
            self.left_of_waves(whole, &patches, &left)
        } else {
            // So few are as quickly drawn one by one.
            None
        };
        let Some(waves_nm) = waves else {
            return self.figure(draws, |deviations_mm| {
                let drawn = left(&linear.places_mm, deviations_mm, None)?;
                Sample::range(drawn.values_nm()).map(|[low, high]| high - low)
            });
        };
        let sigma_nm = |member: usize| self.noise_mm2[whole.indices()[member]].sqrt() * NM_PER_MM;
        let most_nm2 = waves_nm.iter().map(|values| dot(values, values)).fold(0.0, f64::max);
        let noise_nm = (0..whole.len()).map(sigma_nm).fold(0.0, f64::max);
        let share = MISSED / whole.len() as f64;
        let reach_nm =
            SQRT_2 * noise_nm.hypot(most_nm2.sqrt()) * student_quantile(1.0 - share, f64::INFINITY);
        let table = Unlikely::new();
        // The lowest are the highest of what is mirrored.
        let ends = |sign: f64, extreme_nm: f64| -> Vec<End> {
            let of_patch = |(patch, own): (usize, &Patch)| {
                let points = || {
                    let height =
                        |&member: &usize| (sign * whole.values_nm()[member], sigma_nm(member));
                    own.members.iter().map(height)
                };
                let top_nm = points().map(|(height, _)| height).fold(f64::NEG_INFINITY, f64::max);
                (top_nm >= sign * extreme_nm - reach_nm)
                    .then(|| End { patch, highest: Highest::new(points, top_nm, &table) })
            };
            patches.par_iter().enumerate().filter_map(of_patch).collect()
        };
        let (above, below) = (ends(1.0, high_nm), ends(-1.0, low_nm));
        let of_draw = |draw: u32| {
            let factors = factors(draws.seed, draw, self.modes.functions());
            let end = |ends: &[End], sign: f64, stream: u32| {
                let numbers = Numbers::new(draws.seed, draw, stream);
                ends.iter().fold(f64::NEG_INFINITY, |most_nm, end| {
                    let wave_nm = sign * dot(&waves_nm[end.patch], &factors);
                    let chance = numbers.uniform(patches[end.patch].node);
                    most_nm.max(wave_nm + end.highest.drawn_nm(chance, most_nm - wave_nm))
                })
            };
            Some(end(&above, 1.0, HIGHEST) + end(&below, -1.0, LOWEST))
        };
        let found: Vec<Option<f64>> = (0..draws.count).into_par_iter().map(of_draw).collect();
        let looked_at = [&above, &below]
            .map(|ends| ends.iter().map(|end| patches[end.patch].members.len()).sum::<usize>());
        let looked_at = looked_at.iter().sum::<usize>().min(whole.len());
        Ok(Simulated::new(high_nm - low_nm, &found, (looked_at, false)))
    }

    /// The points of a sample by their nodes.
    fn patches(&self, whole: &Sample) -> Vec<Patch> {
        let Modes { nodes, .. } = self.modes;
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); nodes.len()];
        for (member, &place) in whole.indices().iter().enumerate() {
            members[self.modes.node_of(place)].push(member);
        }
        let of_node = |(node, members): (usize, Vec<usize>)| {
            let [x, y] = nodes[node].place_mm;
            let apart = |member: &usize| {
                let place = whole.places_mm()[*member];
                (place[0] - x).hypot(place[1] - y)
            };
            let middle = members.iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
            Some(Patch { node, members, middle })
        };
        members.into_iter().enumerate().filter_map(of_node).collect()
    }

    /// What is left of each function of the correlated errors at each patch, in nm; `None` where that cannot be told from the
    /// nodes.
    fn left_of_waves(
        &self,
        whole: &Sample,
        patches: &[Patch],
        left: &(impl Fn(&[[f64; 2]], &[f64], Option<&[f64]>) -> Option<Sample> + Sync),
    ) -> Option<Vec<Vec<f64>>> {
        let places_mm: Vec<[f64; 2]> =
            patches.iter().map(|patch| whole.places_mm()[patch.middle]).collect();
        let counts: Vec<f64> = patches.iter().map(|patch| patch.members.len() as f64).collect();
        let of_function = |function: usize| {
            let residual_mm = &self.modes.residual_mm;
            let values_mm: Vec<f64> =
                patches.iter().map(|patch| residual_mm[patch.node][function]).collect();
            let sample = left(&places_mm, &values_mm, Some(&counts))?;
            (sample.len() == patches.len()).then(|| sample.values_nm().to_vec())
        };
        let functions: Option<Vec<Vec<f64>>> =
            (0..self.modes.functions()).into_par_iter().map(of_function).collect();
        let functions = functions?;
        let of_patch = |patch: usize| functions.iter().map(|values| values[patch]).collect();
        Some((0..patches.len()).map(of_patch).collect())
    }
}

/// The highest of some points with noise: −ln P(highest ≤ h) for heights at even steps.
struct Highest {
    start_nm: f64,
    step_nm: f64,
    /// Logarithms, falling.
    unlikely_ln: Vec<f64>,
}

impl Highest {
    /// Of points given as height and standard deviation in nm, of which the highest is `top_nm`.
    fn new<I: Iterator<Item = (f64, f64)>>(
        points: impl Fn() -> I,
        top_nm: f64,
        table: &Unlikely,
    ) -> Highest {
        let sigma_nm = points().map(|(_, sigma)| sigma).fold(0.0, f64::max);
        let (start_nm, step_nm) = (top_nm - BELOW * sigma_nm, STEP * sigma_nm);
        let mut unlikely = vec![0.0; ((BELOW + ABOVE) / STEP) as usize + 1];
        for (height_nm, sigma_nm) in points() {
            for (step, sum) in unlikely.iter_mut().enumerate() {
                let above_nm = start_nm + step as f64 * step_nm - height_nm;
                let x = above_nm / sigma_nm.max(f64::MIN_POSITIVE);
                if x >= TABLE_END {
                    break;
                }
                *sum += table.at(x);
            }
        }
        let least = f64::MIN_POSITIVE;
        let unlikely_ln = unlikely.iter().map(|sum| sum.max(least).ln()).collect();
        Highest { start_nm, step_nm, unlikely_ln }
    }

    /// The height that is not exceeded with a probability of `chance`, where that is above `least_nm`; else anything below.
    fn drawn_nm(&self, chance: f64, least_nm: f64) -> f64 {
        let wanted_ln = (-chance.ln()).ln();
        let last = self.unlikely_ln.len() - 1;
        let known = ((least_nm - self.start_nm) / self.step_nm).floor();
        if known >= 0.0 && self.unlikely_ln[(known as usize).min(last)] <= wanted_ln {
            return f64::NEG_INFINITY;
        }
        let above = self.unlikely_ln.partition_point(|&ln| ln > wanted_ln);
        let steps = match above {
            0 => 0.0,
            above if above > last => last as f64,
            above => {
                let [low, high] = [above - 1, above].map(|at| self.unlikely_ln[at]);
                (above - 1) as f64 + (low - wanted_ln) / (low - high)
            }
        };
        self.start_nm + steps * self.step_nm
    }
}

/// −ln Φ(x), from a table.
struct Unlikely(Vec<f64>);

impl Unlikely {
    fn new() -> Unlikely {
        let value = |entry: usize| {
            let x = entry as f64 / TABLE_STEPS - TABLE_END;
            if x > 0.0 { -(-normal_cdf(-x)).ln_1p() } else { -normal_cdf(x).ln() }
        };
        Unlikely((0..=(2.0 * TABLE_END * TABLE_STEPS) as usize + 1).map(value).collect())
    }

    /// For x below 8, those below −8 taken for −8.
    fn at(&self, x: f64) -> f64 {
        let entry = ((x + TABLE_END) * TABLE_STEPS).max(0.0);
        let (index, share) = (entry as usize, entry.fract());
        self.0[index] + share * (self.0[index + 1] - self.0[index])
    }
}

/// Points that are drawn one by one.
const MOST_DRAWN: usize = 16_384;
/// How far below and above its highest point the highest of a patch is looked for, in standard deviations, and the step.
const BELOW: f64 = 4.0;
const ABOVE: f64 = 8.0;
const STEP: f64 = 0.25;
/// The end of the table on either side, and its steps to a standard deviation.
const TABLE_END: f64 = 8.0;
const TABLE_STEPS: f64 = 64.0;
/// Streams of random numbers, beside those of the measurements and of texture.
const HIGHEST: u32 = 8;
const LOWEST: u32 = 9;

#[cfg(test)]
mod tests;
