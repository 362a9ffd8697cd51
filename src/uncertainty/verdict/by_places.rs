//! What the places that were taken do to a limited figure that averages over the area.

use crate::{Uncertainty, Worth};
use asphera_figures::{Approximation, Definition, Sample, sagitta_gains};
use asphera_form::NM_PER_MM;

/// A figure over the area.
#[derive(Clone, Copy, Debug)]
pub(super) struct OfArea {
    pub(super) value: f64,
    /// Variance by how its places scatter, beside noise, of A in nm², of the square of an RMS in nm⁴. 0 of what does not average.
    pub(super) variance: f64,
    /// How much more noise goes into it than into the figure by the areas of points, as a ratio of variances.
    pub(super) crowding: f64,
}

/// `sample` has the deviations in the zone, less the terms, by their shares of the area; `value` is the figure over it, and
/// `areas_mm2` what the figure counts points given by, all alike without.
pub(super) fn of_area(
    definition: Definition,
    uncertainty: &Uncertainty,
    approximation: Approximation,
    sample: &Sample,
    (value, areas_mm2): (f64, Option<&[f64]>),
) -> OfArea {
    let shares = uncertainty.shares().unwrap_or_default();
    let inside = || sample.indices().iter();
    let by_area = crowding(inside().map(|&at| shares[at]));
    let by_points = crowding(
        inside().map(|&at| areas_mm2.map_or(1.0, |areas| areas[uncertainty.indices()[at]])),
    );
    let ratio = by_area / by_points;
    OfArea {
        value,
        variance: by_places(definition, uncertainty, approximation, sample, shares),
        crowding: if ratio.is_finite() { ratio } else { 1.0 },
    }
}

/// Variance of a mean by such weights, of values of variance 1.
fn crowding(weights: impl Iterator<Item = f64>) -> f64 {
    let [sum, square] =
        weights.fold([0.0, 0.0], |[sum, square], weight| [sum + weight, square + weight * weight]);
    square / (sum * sum)
}

/// [`OfArea::variance`].
fn by_places(
    definition: Definition,
    uncertainty: &Uncertainty,
    approximation: Approximation,
    sample: &Sample,
    shares: &[f64],
) -> f64 {
    let Some(values_nm) = definition.averaged_nm(sample, approximation) else { return 0.0 };
    let gains = match definition {
        Definition::Sagitta => match sagitta_gains(sample, approximation) {
            Some(gains) => Some(gains),
            None => return 0.0,
        },
        _ => None,
    };
    let all: f64 = shares.iter().sum();
    let inside: f64 = sample.indices().iter().map(|&at| shares[at]).sum();
    let per_share = all / inside;
    let mut worth = vec![Worth::default(); uncertainty.indices().len()];
    for (place, (&at, nm)) in sample.indices().iter().zip(&values_nm).enumerate() {
        worth[at] = match &gains {
            Some(gains) => {
                let gain = gains[place] * per_share;
                Worth { factors: [gain, *nm], by_noise: [(gain * NM_PER_MM).powi(2), 0.0] }
            }
            None => {
                let per_mm = (NM_PER_MM * per_share).powi(2);
                let by_noise = [4.0 * nm * nm * per_mm, -2.0 * per_mm * NM_PER_MM * NM_PER_MM];
                Worth { factors: [nm * per_share.sqrt(); 2], by_noise }
            }
        };
    }
    uncertainty.scatter_of_mean(&worth)
}
