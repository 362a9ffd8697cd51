//! What u of pose and parameters is made of, and whether it counts that deviations are correlated.

use std::collections::BTreeMap;

use asphera_form::{Covariance, Parameter, Pose};
use asphera_geometry::PointMm;
use asphera_report::{
    CautionFigures, CorrelationFigures, CovarianceFigures, FitDetails, ParameterFigures,
};
use asphera_uncertainty::{TypeA, UncertaintyError, glance, type_a};

use super::errors;
use super::figures::parameters_of;
use super::fit_details;
use super::fitting::Fitted;
use super::systematic::Contributions;
use super::uncertainties::{Assessed, COVERAGE, covers_parameters};
use crate::{CorrelationFrom, Part};

/// What a fit says of its uncertainties: those of its parameters, and what these are made of.
pub(super) struct Sources {
    /// Every free parameter, by name.
    pub(super) parameters: BTreeMap<String, ParameterFigures>,
    pub(super) u_model: &'static str,
    /// Covariances other than those by the residuals.
    pub(super) covariance: Option<CovarianceFigures>,
    /// Scope of the expanded uncertainties.
    pub(super) expanded_covers: Option<String>,
    pub(super) caution: Option<CautionFigures>,
    pub(super) correlation: Option<CorrelationFigures>,
    /// Why something of this is not known.
    pub(super) unknown: Vec<String>,
}

impl Sources {
    /// Of parameters whose uncertainties are by the residuals alone.
    pub(super) fn by_residuals(fitted: &Fitted) -> Sources {
        Sources {
            parameters: parameters_of(fitted),
            u_model: FitDetails::BY_RESIDUALS,
            covariance: None,
            expanded_covers: None,
            caution: None,
            correlation: None,
            unknown: Vec::new(),
        }
    }

    /// Those of the deviations as the nominal file asks, else what they would be where these are plainly correlated and
    /// nothing counts it. `points` and `deviations_mm` are those of the fit; `assessed` what a budget made of it.
    pub(super) fn new(
        part: &Part,
        fitted: &Fitted,
        (points, deviations_mm): (&[PointMm], &[f64]),
        assessed: Option<&Assessed>,
    ) -> Sources {
        let fit = &fitted.fit;
        let mut sources = Sources::by_residuals(fitted);
        if let Some(assessed) = assessed {
            sources.budget(part, assessed);
        }
        if fitted.reference.is_some() {
            // Its parameters are those of the base alone, about which most of the form remains.
            return sources;
        }
        if let Some(assessed) = assessed {
            sources.u_model = errors::model(part);
            sources.covariance = Some(fit_details::covariance(assessed.covariance(), fit));
        }
        let weights = fitted.uncertainties_mm.as_deref();
        match part.judging.correlated {
            CorrelationFrom::Nothing => {}
            CorrelationFrom::Deviations => match type_a(points, fit, &part.aperture, weights) {
                Ok(found) => sources.count(part, fitted, &found, assessed),
                Err(error) => sources.unknown.push(unknown(&error)),
            },
            CorrelationFrom::Budget if errors::has_correlated(part) => {}
            // Of the pose alone nothing is claimed but where a budget gives it an interval.
            CorrelationFrom::Budget
                if assessed.is_none()
                    && !fit.estimates.iter().any(|of| is_of_shape(of.parameter)) => {}
            CorrelationFrom::Budget => {
                match glance(points, deviations_mm, fit, &part.aperture, weights) {
                    Ok(Some(found)) => sources.compare(part, &found),
                    // Too few points to tell by.
                    Ok(None) => {}
                    Err(error) => sources.unknown.push(unknown(&error)),
                }
            }
        }
        sources
    }

    /// The same with systematic errors counted in the uncertainties of the parameters.
    pub(super) fn with_systematic(mut self, fitted: &Fitted, counted: &Contributions) -> Sources {
        if counted.is_counted() && fitted.reference.is_none() && self.covariance.is_none() {
            let found = fitted.fit.covariance.as_ref();
            self.covariance = found.map(|found| fit_details::covariance(found, &fitted.fit));
        }
        let Sources { parameters, covariance, expanded_covers, .. } = &mut self;
        counted.count_parameters(parameters, covariance.as_mut(), expanded_covers);
        self
    }

    /// Takes the uncertainties of the parameters from the budget.
    fn budget(&mut self, part: &Part, assessed: &Assessed) {
        self.expanded_covers = covers_parameters(assessed, part);
        for of in &assessed.uncertainty.parameters {
            if let Some(figures) = self.parameters.get_mut(&of.parameter.name(&part.nominal)) {
                figures.u = Some(of.u).filter(|u| u.is_finite());
                figures.expanded_95 =
                    Some(of.expanded(COVERAGE).expanded).filter(|u| u.is_finite());
            }
        }
    }

    /// Takes the uncertainties of the parameters from the deviations, and beside them the effects of the machine.
    fn count(&mut self, part: &Part, fitted: &Fitted, found: &TypeA, assessed: Option<&Assessed>) {
        let fit = &fitted.fit;
        let effects = assessed.map(Assessed::correlated);
        let ratio = largest_ratio(found, |parameter| {
            fit.estimates.iter().find(|estimate| estimate.parameter == parameter)?.u
        });
        for (index, of) in found.parameters.iter().enumerate() {
            let u = effects.and_then(|effects| effects.entry(index, index)).unwrap_or(0.0).sqrt();
            if let Some(figures) = self.parameters.get_mut(&of.parameter.name(&part.nominal)) {
                figures.u = Some(of.u.hypot(u)).filter(|u| u.is_finite());
                // The squares of half widths add up as those of standard deviations, nearly.
                let half = of.expanded(COVERAGE).expanded.hypot(NORMAL * u);
                figures.expanded_95 = Some(half).filter(|half| half.is_finite());
            }
        }
        let mut covariance = fit_details::covariance(&found.covariance, fit);
        if let Some(effects) = effects {
            fit_details::add(&mut covariance, effects);
        }
        self.covariance = Some(covariance);
        let beside = effects.is_some_and(varies);
        let model =
            if beside { FitDetails::BY_DEVIATIONS_AND_MACHINE } else { FitDetails::BY_DEVIATIONS };
        self.u_model = model;
        self.expanded_covers = Some(FitDetails::COVERS_MAKE.to_owned());
        self.correlation = Some(figures(found, part, ratio, true));
    }

    /// Where the deviations are plainly correlated, tells what form like this does to the parameters, and warns where u as told
    /// proves one of the shape off its design and these do not.
    ///
    /// Of the pose there is no warning: it has no design, and says where this very part lay.
    fn compare(&mut self, part: &Part, found: &TypeA) {
        if found.independence.is_none_or(|found| found.p > PLAIN) {
            return;
        }
        let told = |parameter: Parameter| self.parameters.get(&parameter.name(&part.nominal));
        // Where the shape is free, it is what the deviations are about.
        let shape_is_free = found.parameters.iter().any(|of| is_of_shape(of.parameter));
        let counts = |parameter: Parameter| is_of_shape(parameter) || !shape_is_free;
        let of_those = |parameter| told(parameter).filter(|_| counts(parameter))?.u;
        let Some((parameter, ratio)) = largest_ratio(found, of_those) else { return };
        if ratio < LEAST_RATIO {
            return;
        }
        let of_shape = found.parameters.iter().filter(|of| is_of_shape(of.parameter));
        let unproven = of_shape.filter_map(|of| {
            let told = told(of.parameter)?;
            let design = of.parameter.value(&Pose::default(), &part.nominal)?;
            let (off, half) = ((told.value - design).abs(), of.expanded(COVERAGE).expanded);
            let half_told = told.expanded_95.or(told.u.map(|u| NORMAL * u))?;
            let unit = if told.unit == "1" { String::new() } else { format!(" {}", told.unit) };
            (half_told < off && off <= half).then(|| {
                let name = of.parameter.name(&part.nominal);
                let [off, half_told, half] = [off, half_told, half].map(two_digits);
                format!(
                    "{name} is {off}{unit} off its design; u allows {half_told}, form error like that of this part {half}"
                )
            })
        });
        let unproven: Vec<String> = unproven.collect();
        if !unproven.is_empty() {
            self.caution = Some(CautionFigures {
                kind: "correlated".to_owned(),
                text: format!(
                    "{} (at 95 %). So it is not proven that the design is missed. Deviations are correlated over about {} mm, and u \
                     does not include that. Set correlation = \"deviations\" in the table uncertainty to include it",
                    unproven.join("; "),
                    two_digits(found.correlation.length_mm),
                ),
                forbids_verdict: false,
            });
        }
        self.correlation = Some(figures(found, part, Some((parameter, ratio)), false));
        for of in &found.parameters {
            if let Some(figures) = self.parameters.get_mut(&of.parameter.name(&part.nominal)) {
                figures.u_by_form = Some(of.u).filter(|u| u.is_finite());
            }
        }
    }
}

fn unknown(error: &UncertaintyError) -> String {
    format!("uncertainties by the deviations: {error}")
}

/// The parameter whose uncertainty by the deviations is the most times that told, and how many.
fn largest_ratio(
    found: &TypeA,
    told: impl Fn(Parameter) -> Option<f64>,
) -> Option<(Parameter, f64)> {
    ratios(found, told).reduce(|most, one| if one.1 > most.1 { one } else { most })
}

/// How many times that told the uncertainty of each parameter is by the deviations.
fn ratios(
    found: &TypeA,
    told: impl Fn(Parameter) -> Option<f64>,
) -> impl Iterator<Item = (Parameter, f64)> {
    found.parameters.iter().filter_map(move |of| {
        let ratio = of.u / told(of.parameter)?;
        ratio.is_finite().then_some((of.parameter, ratio))
    })
}

fn figures(
    found: &TypeA,
    part: &Part,
    ratio: Option<(Parameter, f64)>,
    counted: bool,
) -> CorrelationFigures {
    let correlation = &found.correlation;
    CorrelationFigures {
        counted,
        kernel: correlation.kernel.name().to_owned(),
        length_mm: correlation.length_mm,
        sigma_nm: 1e6 * correlation.sigma_mm,
        rest_nm: 1e6 * correlation.rest_mm,
        kernels: found.kernels.iter().map(|(kernel, p)| (kernel.name().to_owned(), *p)).collect(),
        patches: found.patches as u64,
        patch_ratio: found.independence.map(|found| found.ratio),
        independent_p: found.independence.map(|found| found.p),
        largest_ratio: ratio.map(|(_, ratio)| ratio),
        largest_ratio_of: ratio.map(|(parameter, _)| parameter.name(&part.nominal)),
    }
}

fn varies(covariance: &Covariance) -> bool {
    (0..covariance.size()).any(|i| covariance.entry(i, i).is_some_and(|variance| variance > 0.0))
}

/// Whether a parameter is one of the part, and not of where it lies.
fn is_of_shape(parameter: Parameter) -> bool {
    !Parameter::POSE.contains(&parameter)
}

/// A number above 0 to two digits, and no less than its integral part.
fn two_digits(value: f64) -> String {
    if value < 1e-3 {
        return format!("{value:.1e}");
    }
    let places = (1.0 - value.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.places$}")
}

/// Deviations are plainly correlated where independent ones would look so by a chance smaller than this.
const PLAIN: f64 = 1e-3;
/// By so many times an uncertainty must be larger by the deviations to be worth a word.
const LEAST_RATIO: f64 = 2.0;
/// Half the width of an interval of 95 % in standard deviations.
const NORMAL: f64 = 1.959_963_984_540_054;

#[cfg(test)]
mod tests;
