//! Figures of standards that need more than deviations: a file each, with a line in [`FIGURES`]. And their limits.

mod indication;
mod limits;
mod spectrum;
mod texture;
mod zone;

use asphera_figures::{Definition, Unit};
use asphera_form::Fit;
use asphera_geometry::{PointMm, VertexId};
use asphera_report::{FormFigure, SimulatedFigures, UncertaintyFigures, error_chain};
use asphera_uncertainty::{Simulated, UncertaintyError};
pub(super) use indication::found;
pub(super) use limits::{hold, limits};
pub(super) use spectrum::q_spectrum;

use super::details::FormDetails;
use super::deviation_map::DeviationMap;
use super::errors;
use super::systematic::Contributions;
use super::uncertainties::{Assessed, COVERAGE};
use crate::Part;

/// Each adds its figures to the details, where the nominal file asks for them. Reasons and checks have this order.
const FIGURES: [fn(&Measured<'_>, &mut FormDetails); 3] =
    [zone::add, spectrum::add_psd, texture::add];

/// Adds all figures that the nominal file asks for, with their uncertainties where a budget gives some.
pub(super) fn add(measured: &Measured<'_>, details: &mut FormDetails) {
    FIGURES.iter().for_each(|add| add(measured, details));
}

/// Ingredients of the figures, in the frame the fit was made in.
#[derive(Clone, Copy)]
pub(super) struct Measured<'a> {
    pub(super) part: &'a Part,
    pub(super) fit: &'a Fit,
    pub(super) points: &'a [PointMm],
    /// Deviation of every point, NaN for none.
    pub(super) deviations_mm: &'a [f64],
    pub(super) triangles: &'a [[VertexId; 3]],
    /// Whether each triangle is sampled densely enough.
    pub(super) covered: &'a [bool],
    /// The area each point stands for.
    pub(super) areas_mm2: &'a [f64],
    pub(super) map: Option<&'a DeviationMap>,
    /// Noise of a point, where it is known.
    pub(super) noise_nm: Option<f64>,
    /// Uncertainties, where there is a budget.
    pub(super) assessed: Option<&'a Assessed>,
    /// What systematic errors add to these.
    pub(super) systematic: &'a Contributions,
}

/// A figure that a limit may be held against.
pub(super) struct Limited {
    definition: Definition,
    value: f64,
    u: Option<f64>,
    /// Amount by which it may be too large.
    bias: f64,
    /// Scope of its standard uncertainty.
    covers: Option<String>,
}

impl Measured<'_> {
    /// The figure with what simulated measurements tell of it.
    fn with_uncertainty(
        &self,
        definition: Definition,
        figure: FormFigure,
        simulated: Option<&Simulated>,
    ) -> FormFigure {
        let Some((simulated, assessed)) = simulated.zip(self.assessed) else { return figure };
        let [low, high] = simulated.interval(COVERAGE);
        let model = errors::model(self.part);
        let mut told = SimulatedFigures {
            model: model.to_owned(),
            low,
            high,
            p: COVERAGE,
            covers: UncertaintyFigures::covers_places(model),
            without_noise: simulated.measured - simulated.bias,
            bias: simulated.bias,
            draws: simulated.draws,
            seed: assessed.draws.seed,
        };
        let mut u = simulated.u;
        if definition.unit() == Unit::Nanometres {
            let at_most_nm = self.systematic.at_most_nm(definition);
            u = self.systematic.count_simulated((figure.value, u), &mut told, at_most_nm);
        }
        FormFigure { u: Some(u), simulated: Some(told), ..figure }
    }
}

impl FormDetails {
    /// A figure that is known, or the reason why it is not.
    fn known<T>(&mut self, name: &str, found: Result<T, String>) -> Option<T> {
        found.map_err(|why| self.unknown.push(format!("{name}: {why}"))).ok()
    }

    /// Results of simulated measurements, where there is a budget.
    fn simulated<T>(
        &mut self,
        measured: &Measured<'_>,
        name: &str,
        simulate: impl FnOnce(&Assessed) -> Result<T, UncertaintyError>,
    ) -> Option<T> {
        let found = simulate(measured.assessed?).map_err(|why| error_chain(&why));
        self.known(&format!("uncertainty of the {name}"), found)
    }

    /// Adds a figure that a limit may be held against. `least` is the least it may be, where it may still be too large for that reason.
    fn add_limited(&mut self, definition: Definition, figure: &FormFigure, least: Option<f64>) {
        let by_noise = figure.simulated.as_ref().map_or(0.0, |simulated| simulated.bias.max(0.0));
        self.limited.push(Limited {
            definition,
            value: figure.value,
            u: figure.u,
            bias: least.map_or(0.0, |least| figure.value - least) + by_noise,
            covers: figure.simulated.as_ref().map(|simulated| simulated.covers.clone()),
        });
    }
}

#[cfg(test)]
mod spectra_tests;
#[cfg(test)]
mod tests;
