//! Uncertainties of the final figures, and the limits held against them.

use asphera_figures::{Subject, Treatment};
use asphera_form::Covariance;
use asphera_geometry::PointMm;
use asphera_report::{FitDetails, UncertaintyFigures};
use asphera_surface::Plane;
use asphera_surface::noise::step_sigma_mm;
use asphera_uncertainty::verdict::{Limit, LimitError, Over, finding};
use asphera_uncertainty::{
    Budget, Draws, Effect, Noise, Places, Simulated, Uncertainty, UncertaintyError, places,
    uncertainty as uncertainty_of,
};

use super::errors;
use super::fitting::Fitted;
use super::judged::{AllJudged, Judged};
use crate::Part;
use asphera_report::error_chain;

/// The uncertainties of a part.
pub(super) struct Assessed {
    pub(super) uncertainty: Uncertainty,
    /// Against the design, where the shape was free and limits refer to it; else why it is not known.
    design: Option<Result<Uncertainty, String>>,
    pub(super) pv: Simulated,
    pub(super) draws: Draws,
    /// Whether averages and parameters count the places that were taken.
    places: [bool; 2],
}

impl Assessed {
    /// Covariance of the parameters by the whole budget.
    pub(super) fn covariance(&self) -> &Covariance {
        &self.uncertainty.covariance
    }

    /// The uncertainty that a limit is judged by, and whether it is against the design.
    fn uncertainty_for(&self, limit: &Limit, part: &Part) -> Result<(&Uncertainty, bool), String> {
        match (&self.design, limit.definition.subject().treatment(&part.free)) {
            (Some(design), Treatment::FromDesign) => {
                design.as_ref().map(|found| (found, true)).map_err(Clone::clone)
            }
            _ => Ok((&self.uncertainty, false)),
        }
    }

    /// The part of it that long waves and the machine make.
    pub(super) fn correlated(&self) -> &Covariance {
        &self.uncertainty.correlated
    }
}

/// Effect of the places of the points. `areas_mm2` is what each stands for in the mesh.
pub(super) fn taken(
    part: &Part,
    points: &[PointMm],
    deviations_mm: &[f64],
    fitted: &Fitted,
    areas_mm2: &[f64],
) -> Option<Places> {
    let Fitted { fit, reference, uncertainties_mm, .. } = fitted;
    let alike = reference.is_none() && fit.robust.is_none() && uncertainties_mm.is_none();
    let areas_mm2 = Some(areas_mm2).filter(|areas_mm2| areas_mm2.iter().any(|area| *area > 0.0));
    places(points, deviations_mm, fit, &part.aperture, areas_mm2, alike)
}

/// Works them out, if the nominal file asks for them. `plane` is that of projection, in whose frame points and fit are;
/// `places` what their places do, `step_nm` the step of the heights where noise does not blur it.
pub(super) fn assess(
    part: &Part,
    points: &[PointMm],
    fitted: &Fitted,
    plane: &Plane,
    places: Option<&Places>,
    step_nm: Option<f64>,
) -> Option<Result<Assessed, UncertaintyError>> {
    let (budget, draws) = part.judging.uncertainty.as_ref()?;
    let effects = budget.effects.iter().map(|effect| in_plane(effect, plane)).collect();
    let weights = fitted.uncertainties_mm.as_deref();
    let noise = match (&budget.noise, weights) {
        // What the points say of themselves, where nothing else is stated.
        (Noise::Measured, Some(u_mm)) => Noise::EachPoint(u_mm.to_vec()),
        // Neighbours that share a step say nothing of their errors.
        (Noise::Measured, None) if let Some(step_nm) = step_nm => {
            Noise::Uniform { sigma_mm: step_sigma_mm(1e-6 * step_nm), dof: f64::INFINITY }
        }
        (stated, _) => stated.clone(),
    };
    let budget = Budget { effects, noise, ..budget.clone() };
    let assessed = || {
        let over = |uncertainty: Uncertainty| match places {
            Some(places) => uncertainty.over(places),
            None => uncertainty,
        };
        let uncertainty = uncertainty_of(points, &fitted.fit, &part.aperture, weights, &budget)?;
        let uncertainty = over(uncertainty);
        let pv = uncertainty.peak_to_valley_nm(draws)?;
        let refers = |limit: &Limit| {
            limit.definition.subject().treatment(&part.free) == Treatment::FromDesign
        };
        let is_needed = part.judging.limits.iter().any(refers);
        let design = fitted.design.as_ref().filter(|_| is_needed).map(|_| {
            let fit = fitted.fit_for(Subject::Indication, part)?;
            uncertainty_of(points, fit, &part.aperture, weights, &budget)
                .map(over)
                .map_err(|error| error_chain(&error))
        });
        let of_parameters = places.is_some_and(Places::is_of_fit);
        let places = [places.is_some(), of_parameters];
        Ok(Assessed { uncertainty, design, pv, draws: *draws, places })
    };
    Some(assessed())
}

/// An effect of the machine, in the frame of the plane.
pub(super) fn in_plane(effect: &Effect, plane: &Plane) -> Effect {
    let (axes, whole) = (plane.axes(), effect.displacement);
    let along = |to: [f64; 3], from: [f64; 3]| -> f64 {
        (0..3).map(|i| (0..3).map(|j| to[i] * whole[i][j] * from[j]).sum::<f64>()).sum()
    };
    Effect {
        displacement: axes.map(|to| axes.map(|from| along(to, from))),
        about_mm: plane.to_plane(effect.about_mm),
        ..effect.clone()
    }
}

/// Uncertainties of PV and RMS by the budget, as reports write them.
pub(super) fn of_heights(assessed: &Assessed, part: &Part) -> UncertaintyFigures {
    let Assessed { uncertainty, pv, draws, places: [of_averages, _], .. } = assessed;
    let (model, rms) = (errors::model(part), &uncertainty.rms);
    UncertaintyFigures {
        model: model.to_owned(),
        pv_at_most: false,
        u_pv_nm: pv.u,
        pv_bias_nm: pv.bias,
        pv_95_nm: pv.interval(COVERAGE),
        pv_covers: UncertaintyFigures::covers_places(model),
        u_rms_nm: rms.u_nm,
        rms_without_noise_nm: rms.form_nm,
        rms_95_nm: rms.interval_nm(COVERAGE),
        rms_covers: UncertaintyFigures::covers_area(model, *of_averages),
        noise_nm: uncertainty.noise.sigma_mm * 1e6,
        noise_measured: uncertainty.noise.measured,
        draws: Some(draws.count),
        seed: Some(draws.seed),
    }
}

/// Scope of the expanded uncertainties of the parameters by the budget, in words; `None` without parameters.
pub(super) fn covers_parameters(assessed: &Assessed, part: &Part) -> Option<String> {
    let [_, of_parameters] = assessed.places;
    let some = !assessed.uncertainty.parameters.is_empty();
    some.then(|| FitDetails::covers_part(errors::model(part), of_parameters))
}

/// What was found of the limits, with uncertainties by the budget.
pub(super) fn judged<'a>(
    part: &'a Part,
    assessed: &Assessed,
    areas_mm2: Option<&[f64]>,
) -> AllJudged<'a> {
    let over = Over { aperture: &part.aperture, areas_mm2 };
    let one = |limit: &'a Limit| {
        let unknown = |why| Judged { limit, found: Err(why), from_design: false, covers: None };
        let (uncertainty, from_design) = match assessed.uncertainty_for(limit, part) {
            Ok(found) => found,
            Err(why) => return Ok(unknown(why)),
        };
        let found = finding(limit, uncertainty, &part.nominal, over, &assessed.draws);
        match found.map_err(|error| without(&error))? {
            Ok(found) => {
                let covers =
                    errors::covers(errors::model(part), limit.definition, assessed.places[0]);
                Ok(Judged { limit, found: Ok(found), from_design, covers: Some(covers) })
            }
            Err(why) => Ok(unknown(why.to_string())),
        }
    };
    part.limits().iter().map(one).collect()
}

/// Why no limit can be judged where uncertainties cannot be worked out.
pub(super) fn unknown(error: &UncertaintyError) -> String {
    without(&LimitError::Uncertainty(error.clone()))
}

fn without(error: &LimitError) -> String {
    format!("the limits cannot be judged: {}", error_chain(error))
}

/// Probability of coverage of the intervals told.
pub(super) const COVERAGE: f64 = 0.95;

#[cfg(test)]
mod tests;
