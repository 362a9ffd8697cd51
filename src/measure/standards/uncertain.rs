//! Uncertainties of figures that are made of more than deviations.

use asphera_figures::texture::Definition;
use asphera_form::ZoneFit;
use asphera_report::{FormFigure, SimulatedFigures, UncertaintyFigures, error_chain};
use asphera_uncertainty::{Simulated, UncertaintyError};

use super::texture::Found;
use super::zone;
use crate::errors;
use crate::uncertainties::{Assessed, COVERAGE};
use crate::{Part, TextureSettings};

/// Results of simulated measurements.
#[derive(Default)]
pub(super) struct Uncertain {
    pub(super) zone: Option<Sure>,
    pub(super) texture: Vec<(Definition, Sure)>,
    /// Why the others are not known.
    pub(super) unknown: Option<String>,
}

/// The uncertainty of one figure.
pub(super) struct Sure {
    u: f64,
    simulated: SimulatedFigures,
}

impl Uncertain {
    /// By the budget, of the figures that were found.
    pub(super) fn of(
        zone: Option<&ZoneFit>,
        texture: Option<&(&TextureSettings, Found)>,
        assessed: &Assessed,
        part: &Part,
    ) -> Uncertain {
        let mut found = Uncertain::default();
        if let Err(why) = found.simulate(zone, texture, assessed, part) {
            let why = error_chain(&why);
            found.unknown = Some(format!("uncertainties of zone and texture: {why}"));
        }
        found
    }

    fn simulate(
        &mut self,
        zone: Option<&ZoneFit>,
        texture: Option<&(&TextureSettings, Found)>,
        assessed: &Assessed,
        part: &Part,
    ) -> Result<(), UncertaintyError> {
        let Assessed { uncertainty, draws, .. } = assessed;
        if let Some(zone) = zone {
            let simulated = zone::simulated(zone, assessed)?;
            self.zone = simulated.map(|simulated| Sure::new(&simulated, assessed, part));
        }
        if let Some((settings, found)) = texture {
            let TextureSettings { scale, f_operation } = settings;
            let all = uncertainty.texture(&found.surface, scale, *f_operation, draws)?;
            let sure = |(definition, simulated): &(Definition, Simulated)| {
                (*definition, Sure::new(simulated, assessed, part))
            };
            self.texture = all.iter().map(sure).collect();
        }
        Ok(())
    }
}

impl Sure {
    fn new(simulated: &Simulated, assessed: &Assessed, part: &Part) -> Sure {
        let [low, high] = simulated.interval(COVERAGE);
        let model = errors::model(part);
        let simulated_figures = SimulatedFigures {
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
        Sure { u: simulated.u, simulated: simulated_figures }
    }
}

/// The figure with its uncertainty, where that is known.
pub(super) fn with(figure: FormFigure, sure: Option<&Sure>) -> FormFigure {
    match sure {
        Some(Sure { u, simulated }) => {
            FormFigure { u: Some(*u), simulated: Some(simulated.clone()), ..figure }
        }
        None => figure,
    }
}
