//! Uncertainties of the minimum zone and of the texture.

use asphera_report::{FormFigure, FormFigures, SimulatedFigures, UncertaintyFigures};
use asphera_uncertainty::{Simulated, UncertaintyError};

use super::Found;
use crate::Part;
use crate::errors;
use crate::uncertainties::{Assessed, COVERAGE};
use asphera_report::error_chain;

/// Writes them beside those of the figures that were found, or why they are not known.
pub(crate) fn tell(form: &mut FormFigures, found: &Found, assessed: &Assessed, part: &Part) {
    if let Err(why) = try_to_tell(form, found, assessed, part) {
        let why = error_chain(&why);
        form.unknown.push(format!("uncertainties of minimum zone and texture: {why}"));
    }
}

fn try_to_tell(
    form: &mut FormFigures,
    found: &Found,
    assessed: &Assessed,
    part: &Part,
) -> Result<(), UncertaintyError> {
    let Assessed { uncertainty, draws, .. } = assessed;
    if let (Some(zone), Some(figures)) = (&found.zone, &mut form.standards.minimum_zone)
        && let Some(simulated) = uncertainty.minimum_zone_nm(zone, draws)?
    {
        beside(&mut figures.width, &simulated, assessed, part);
    }
    if let (Some(surface), Some(figures), Some(settings)) =
        (&found.texture, &mut form.standards.texture, &part.figures.texture)
    {
        let all = uncertainty.texture(surface, &settings.scale, settings.f_operation, draws)?;
        for (definition, simulated) in &all {
            let id = definition.id();
            let figure = figures.figures.iter_mut().find(|figure| figure.id == id);
            figure.into_iter().for_each(|figure| beside(figure, simulated, assessed, part));
        }
    }
    Ok(())
}

/// Writes the uncertainty beside a figure.
pub(crate) fn beside(
    figure: &mut FormFigure,
    simulated: &Simulated,
    assessed: &Assessed,
    part: &Part,
) {
    let [low, high] = simulated.interval(COVERAGE);
    figure.u = Some(simulated.u);
    figure.simulated = Some(SimulatedFigures {
        model: errors::model(part).to_owned(),
        low,
        high,
        p: COVERAGE,
        covers: UncertaintyFigures::covers_places(errors::model(part)),
        without_noise: simulated.measured - simulated.bias,
        bias: simulated.bias,
        draws: simulated.draws,
        seed: assessed.draws.seed,
    });
}
