//! What the places that were taken do to a limited figure that averages over the area.

use super::limit::Limit;
use crate::{Uncertainty, Worth};
use asphera_figures::{Approximation, Definition, Sample, sagitta_gains};
use asphera_form::NM_PER_MM;

/// Standard uncertainty in nm of a figure by how its places scatter, beside noise. `sample` has the deviations in the zone,
/// less the terms, by their shares of the area; `value_nm` is the figure over it. 0 for what does not average.
pub(super) fn by_places(
    limit: &Limit,
    uncertainty: &Uncertainty,
    approximation: Approximation,
    sample: &Sample,
    value_nm: f64,
) -> f64 {
    let Some(values_nm) = limit.definition.averaged_nm(sample, approximation) else { return 0.0 };
    let gains = match limit.definition {
        Definition::Sagitta => match sagitta_gains(sample, approximation) {
            Some(gains) => Some(gains),
            None => return 0.0,
        },
        _ => None,
    };
    let all: f64 = uncertainty.shares().map_or(0.0, |shares| shares.iter().sum());
    let inside: f64 = uncertainty
        .shares()
        .map_or(0.0, |shares| sample.indices().iter().map(|&at| shares[at]).sum());
    let per_share = all / inside;
    let mut worth = vec![Worth::default(); uncertainty.indices().len()];
    for (place, (&at, nm)) in sample.indices().iter().zip(&values_nm).enumerate() {
        worth[at] = match &gains {
            Some(gains) => {
                let gain = gains[place] * per_share;
                Worth { value: gain * nm, by_noise: [(gain * NM_PER_MM).powi(2), 0.0] }
            }
            None => {
                let per_mm = (NM_PER_MM * per_share).powi(2);
                let by_noise = [4.0 * nm * nm * per_mm, -2.0 * per_mm * NM_PER_MM * NM_PER_MM];
                Worth { value: (nm * nm - value_nm * value_nm) * per_share, by_noise }
            }
        };
    }
    let scatter = uncertainty.scatter_of_mean(&worth).sqrt();
    if gains.is_some() { scatter } else { value_nm.hypot(scatter.sqrt()) - value_nm }
}
