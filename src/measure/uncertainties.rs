//! Uncertainties of the final figures, and the limits held against them.

use asphera_figures::{Subject, Treatment, Unit};
use asphera_form::{Aperture, Covariance};
use asphera_geometry::PointMm;
use asphera_report::{FitDetails, FormFigure, FormFigures, Status, UncertaintyFigures, Verdict};
use asphera_surface::Plane;
use asphera_uncertainty::verdict::{Finding, Limit, LimitError, Over, finding};
use asphera_uncertainty::{
    Budget, Draws, Effect, Noise, Places, Simulated, Uncertainty, UncertaintyError, places,
    uncertainty as uncertainty_of,
};

use super::decision::{Held, hold};
use super::errors::{self, ErrorsOfFigures};
use super::fitting::Fitted;
use super::judgement::without_checks;
use super::naming;
use super::unmeasured::Unmeasured;
use crate::Part;
use asphera_report::error_chain;

/// The uncertainties of a part.
pub(super) struct Assessed {
    pub(super) uncertainty: Uncertainty,
    /// Against the design, where the shape was free and limits refer to it; else why it is not known.
    design: Option<Result<Uncertainty, String>>,
    pv: Simulated,
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
/// `places` what their places do.
pub(super) fn assess(
    part: &Part,
    points: &[PointMm],
    fitted: &Fitted,
    plane: &Plane,
    places: Option<&Places>,
) -> Option<Result<Assessed, UncertaintyError>> {
    let (budget, draws) = part.judging.uncertainty.as_ref()?;
    let effects = budget.effects.iter().map(|effect| in_plane(effect, plane)).collect();
    let weights = fitted.uncertainties_mm.as_deref();
    let noise = match (&budget.noise, weights) {
        // What the points say of themselves, where nothing else is stated.
        (Noise::Measured, Some(u_mm)) => Noise::EachPoint(u_mm.to_vec()),
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

/// Writes the uncertainties beside the figures.
pub(super) fn tell(form: &mut FormFigures, assessed: &Assessed, part: &Part) {
    let Assessed { uncertainty, pv, draws, places: [of_averages, of_parameters], .. } = assessed;
    let model = errors::model(part);
    if !uncertainty.parameters.is_empty() {
        let covers = FitDetails::covers_part(model, *of_parameters);
        form.fit.details.expanded_covers = Some(covers);
    }
    for of in &uncertainty.parameters {
        if let Some(figures) = form.fit.parameters.get_mut(&of.parameter.name(&part.nominal)) {
            figures.u = Some(of.u).filter(|u| u.is_finite());
            figures.expanded_95 = Some(of.expanded(COVERAGE).expanded).filter(|u| u.is_finite());
        }
    }
    let rms = &uncertainty.rms;
    for figure in form.figures.iter_mut().filter(|figure| figure.variant.starts_with("as fitted")) {
        figure.u = match &figure.name[..] {
            "PV" => Some(pv.u),
            "RMS over the points" => Some(rms.u_nm),
            _ => None,
        };
    }
    form.deviation.uncertainty = Some(UncertaintyFigures {
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
    });
}

/// As [`tell`], where only the noise is known: the uncertainties of PV and RMS.
pub(super) fn tell_noise(form: &mut FormFigures, known: &ErrorsOfFigures) {
    for figure in form.figures.iter_mut().filter(|figure| figure.variant.starts_with("as fitted")) {
        figure.u = match &figure.name[..] {
            "PV" => Some(known.u_pv_nm),
            "RMS over the points" => Some(known.u_rms_nm),
            _ => None,
        };
    }
    form.deviation.uncertainty = Some(known.figures(form.deviation.pv_nm, true));
}

/// The verdict by limits and guard band, what is not measured regarded: of the deviation the fit leaves, and of that from
/// the design.
/// Figures of zones are added to `figures`; others that have a limit get their uncertainty there.
pub(super) fn compare(
    part: &Part,
    assessed: &Assessed,
    areas_mm2: Option<&[f64]>,
    unmeasured: [&Unmeasured; 2],
    figures: &mut Vec<FormFigure>,
) -> Verdict {
    let guard = part.judging.guard;
    let over = Over { aperture: &part.aperture, areas_mm2 };
    let mut verdict = without_checks(part);
    for limit in part.limits() {
        let figure = naming::of_limit(limit);
        let name = figure.words();
        let (uncertainty, unmeasured) = match assessed.uncertainty_for(limit, part) {
            Ok((uncertainty, from_design)) => (uncertainty, unmeasured[usize::from(from_design)]),
            Err(why) => {
                super::undecide(&mut verdict, format!("{name}: {why}"));
                continue;
            }
        };
        let found = finding(limit, uncertainty, &part.nominal, over, &assessed.draws);
        let found = match found {
            Ok(Ok(found)) => Finding { hidden: unmeasured.hidden(limit), ..found },
            Ok(Err(unknown)) => {
                super::undecide(&mut verdict, format!("{name}: {unknown}"));
                continue;
            }
            Err(error) => return without(&error),
        };
        beside(limit, &found, figures);
        let of_zone = naming::of_zone(limit, found.value);
        figures.extend(of_zone.map(|figure| FormFigure { u: found.u, ..figure }));
        let covers = errors::covers(errors::model(part), limit.definition, assessed.places[0]);
        let held = Held { covers: Some(covers), ..Held::new(figure, limit, found, unmeasured) };
        hold(&mut verdict, guard, held);
    }
    verdict
}

/// Writes the uncertainty of a limited figure of the whole aperture where it stands already.
fn beside(limit: &Limit, found: &Finding, figures: &mut [FormFigure]) {
    let Limit { definition, zone, less, .. } = *limit;
    // Slopes in the figures may be over another length.
    if zone != Aperture::None || definition.unit() != Unit::Nanometres {
        return;
    }
    let removed: Vec<String> = less.list().iter().map(ToString::to_string).collect();
    let is_it =
        |figure: &&mut FormFigure| figure.id == definition.id() && figure.removed == removed;
    for figure in figures.iter_mut().filter(is_it) {
        figure.u = figure.u.or(found.u);
    }
}

/// The verdict where the uncertainty that limits need cannot be worked out.
pub(super) fn unknown(error: &UncertaintyError) -> Verdict {
    without(&LimitError::Uncertainty(error.clone()))
}

fn without(error: &LimitError) -> Verdict {
    Verdict {
        status: Status::Undecided,
        checks: Vec::new(),
        outlook: None,
        reasons: vec![format!("the limits cannot be judged: {}", error_chain(error))],
    }
}

/// Probability of coverage of the intervals told.
pub(super) const COVERAGE: f64 = 0.95;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_turn_with_the_plane() {
        let plane = Plane::new([1.0, 2.0, 3.0], [1.0, 0.5, -0.2]).unwrap();
        let effect = Effect { about_mm: [4.0, 0.0, -1.0], ..Effect::squareness(0, 2, 1e-3) };
        let turned = in_plane(&effect, &plane);
        // Displacing in the plane's frame is displacing in the measured one.
        let displaced = |effect: &Effect, at: PointMm| -> PointMm {
            let from: PointMm = std::array::from_fn(|i| at[i] - effect.about_mm[i]);
            let row = |row: [f64; 3]| (0..3).map(|j| row[j] * from[j]).sum::<f64>();
            let moved = effect.displacement.map(row);
            std::array::from_fn(|i| at[i] + moved[i])
        };
        for point in [[5.0, -7.0, 11.0], [0.0; 3]] {
            let truth = plane.to_plane(displaced(&effect, point));
            let found = displaced(&turned, plane.to_plane(point));
            for axis in 0..3 {
                assert!((found[axis] - truth[axis]).abs() < 1e-13);
            }
        }
    }
}
