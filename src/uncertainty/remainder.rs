//! The range of what least squares leave of the deviations over a zone, of simulated measurements.
//!
//! What is taken off by least squares is linear in the deviations, so errors are left as heights are. Correlated errors are
//! taken off once, function by function, at the nodes of [`Modes`]. Independent noise stays as it is: a share of columns over
//! points of its variance goes with what is taken off, and that is not counted. The rest is that of any range: see [`Extremes`].

use rayon::prelude::*;

use super::Uncertainty;
use super::budget::UncertaintyError;
use super::extremes::{Datum, Errors, Extremes};
use super::modes::Modes;
use super::simulate::{Draws, Simulated};
use asphera_figures::Sample;
use asphera_form::NM_PER_MM;

/// The points of a node that are in the zone.
struct Patch {
    node: usize,
    /// Their numbers in the sample.
    members: Vec<usize>,
    /// The one that stands for their place, as a number in the sample.
    middle: usize,
}

impl Uncertainty {
    /// The range in nm of what least squares leave of the deviations, by simulated measurements; `None` if nothing is left. Its
    /// interval holds the truth as that of [`Uncertainty::peak_to_valley_nm`] does; what noise does to what is taken off is
    /// neglected.
    ///
    /// `left` must be linear. It is given places in mm, part frame, deviations there in mm, and how much each counts;
    /// `whole` is what it leaves of the deviations. `O(n log n)` once, and a draw costs the same for any number of points.
    pub(crate) fn simulate_range(
        &self,
        draws: &Draws,
        whole: &Sample,
        left: impl Fn(&[[f64; 2]], &[f64], &[f64]) -> Option<Sample> + Sync,
    ) -> Result<Option<Simulated>, UncertaintyError> {
        draws.validate()?;
        let Some([low_nm, high_nm]) = Sample::range(whole.values_nm()) else { return Ok(None) };
        let patches = self.patches(whole);
        let functions_nm = self.functions_left(whole, &patches, left);
        let mut patch_of = vec![0; whole.len()];
        for (index, patch) in patches.iter().enumerate() {
            patch.members.iter().for_each(|&member| patch_of[member] = index);
        }
        let noise_nm2 = |&place: &usize| self.noise_mm2[place] * NM_PER_MM * NM_PER_MM;
        let noise: Vec<f64> = whole.indices().iter().map(noise_nm2).collect();
        let errors = Errors {
            places_mm: whole.places_mm(),
            heights: whole.values_nm(),
            noise: &noise,
            independent: &noise,
            functions: &functions_nm,
            node_of: &patch_of,
        };
        Ok(Some(Extremes::new(&errors, Datum::Fixed).range(high_nm - low_nm, draws)))
    }

    /// The points of a sample by their nodes.
    fn patches(&self, whole: &Sample) -> Vec<Patch> {
        let Modes { nodes, .. } = &self.modes;
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

    /// Remainder of each function of the correlated errors at each patch, in nm; all of it where patches are too few for
    /// anything to be taken off.
    fn functions_left(
        &self,
        whole: &Sample,
        patches: &[Patch],
        left: impl Fn(&[[f64; 2]], &[f64], &[f64]) -> Option<Sample> + Sync,
    ) -> Vec<Vec<f64>> {
        let places_mm: Vec<[f64; 2]> =
            patches.iter().map(|patch| whole.places_mm()[patch.middle]).collect();
        let counts: Vec<f64> = patches.iter().map(|patch| patch.members.len() as f64).collect();
        let of_function = |function: usize| {
            let residual_mm = &self.modes.residual_mm;
            let values_mm: Vec<f64> =
                patches.iter().map(|patch| residual_mm[patch.node][function]).collect();
            let sample = left(&places_mm, &values_mm, &counts);
            match sample.filter(|sample| sample.len() == patches.len()) {
                Some(sample) => sample.values_nm().to_vec(),
                None => values_mm.iter().map(|value| value * NM_PER_MM).collect(),
            }
        };
        let functions: Vec<Vec<f64>> =
            (0..self.modes.functions()).into_par_iter().map(of_function).collect();
        let of_patch = |patch: usize| functions.iter().map(|values| values[patch]).collect();
        (0..patches.len()).map(of_patch).collect()
    }
}

#[cfg(test)]
mod tests;
