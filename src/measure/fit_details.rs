//! What a fit says of itself, as reports write it.

use asphera_form::{Caution, Combination, Covariance, Fit, LiveEstimate, Nominal, Undetermined};
use asphera_report::{
    CautionFigures, CombinationFigures, CovarianceFigures, FitDetails, ShareFigures,
    UndeterminedFigures,
};

use super::design;
use super::figures::made_from_points;
use super::running::MadeReference;
use crate::{Criterion, Part, Weights};

/// Details of the final fit.
pub(super) fn of_fit(fit: &Fit, reference: Option<&MadeReference<'_>>, part: &Part) -> FitDetails {
    FitDetails {
        converged: Some(fit.termination.is_converged()),
        evaluations: Some(fit.evaluations as u64),
        condition: Some(fit.condition).filter(|condition| condition.is_finite()),
        dof: Some(fit.dof as u64),
        sigma_nm: (fit.dof > 0).then_some(1e6 * fit.sigma_mm),
        cautions: (fit.cautions.iter().map(caution))
            .chain(combinations(&fit.undetermined))
            .chain(design::caution(part))
            .chain(of_reference(reference))
            .collect(),
        weakest: fit.weakest.as_ref().map(combination),
        undetermined: undetermined(&fit.undetermined, &fit.nominal),
        covariance: fit.covariance.as_ref().map(|found| covariance(found, fit)),
        ..FitDetails::default()
    }
}

/// Details of the running fit: what it lacks is known, and how the final one will differ.
pub(super) fn of_running(
    estimate: &LiveEstimate,
    reference: Option<&MadeReference<'_>>,
    part: &Part,
) -> FitDetails {
    let named = reference.map_or(&estimate.nominal, |reference| &reference.base_fit.nominal);
    FitDetails {
        cautions: (provisional(estimate, part).into_iter())
            .chain(combinations(&estimate.undetermined))
            .chain(design::caution(part))
            .chain(of_reference(reference))
            .collect(),
        undetermined: undetermined(&estimate.undetermined, named),
        ..FitDetails::default()
    }
}

/// Whether a fit to be read with it allows no verdict: the part may lie elsewhere. What is left out shows in the coverage, and a
/// weak combination in its uncertainty.
pub(super) fn forbids_verdict(caution: &Caution) -> bool {
    match caution {
        Caution::UpsideDown { allowed } => !allowed,
        Caution::Mirrored { .. } | Caution::Units(_) | Caution::FewCount { .. } => true,
        Caution::BeyondDomain { .. } | Caution::IllConditioned { .. } => false,
    }
}

fn caution(caution: &Caution) -> CautionFigures {
    let kind = match caution {
        Caution::UpsideDown { .. } => "upside_down",
        Caution::Mirrored { .. } => "mirrored",
        Caution::BeyondDomain { .. } => "beyond_domain",
        Caution::Units(_) => "units",
        Caution::FewCount { .. } => "few_count",
        Caution::IllConditioned { .. } => "ill_conditioned",
    };
    CautionFigures {
        kind: kind.to_owned(),
        text: caution.to_string(),
        forbids_verdict: forbids_verdict(caution),
    }
}

fn combination(combination: &Combination) -> CombinationFigures {
    let terms = combination.names.iter().zip(&combination.terms);
    CombinationFigures {
        text: combination.to_string(),
        shares: terms
            .map(|(name, (_, share))| ShareFigures { parameter: name.clone(), share: *share })
            .collect(),
        ratio: combination.ratio,
    }
}

fn undetermined(all: &[Undetermined], nominal: &Nominal) -> Vec<UndeterminedFigures> {
    let figures = |one: &Undetermined| UndeterminedFigures {
        parameter: one.parameter.name(nominal),
        text: one.text.clone(),
        combined: one.is_combined,
        by_shape: one.by_shape,
        combination: combination(&one.combination),
    };
    all.iter().map(figures).collect()
}

/// Covariances of the estimates of a fit, in its order.
pub(super) fn covariance(found: &Covariance, fit: &Fit) -> CovarianceFigures {
    let size = found.size();
    let names = fit.estimates.iter().map(|estimate| estimate.parameter.name(&fit.nominal));
    let units = fit.estimates.iter().map(|estimate| estimate.parameter.unit(&fit.nominal));
    let entry = |row: usize, column: usize| found.entry(row, column).unwrap_or(f64::NAN);
    CovarianceFigures {
        parameters: names.collect(),
        units: units.map(Option::unwrap_or_default).collect(),
        covariance: (0..size).map(|i| (0..size).map(|j| entry(i, j)).collect()).collect(),
        correlation: (0..size)
            .map(|i| (0..size).map(|j| found.correlation(i, j)).collect())
            .collect(),
    }
}

/// Adds further covariances of the same estimates.
pub(super) fn add(figures: &mut CovarianceFigures, further: &Covariance) {
    for (i, row) in figures.covariance.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry += further.entry(i, j).unwrap_or(0.0);
        }
    }
    let all = &figures.covariance;
    for (i, row) in figures.correlation.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            let correlation = all[i][j] / (all[i][i] * all[j][j]).sqrt();
            *entry = correlation.is_finite().then(|| correlation.clamp(-1.0, 1.0));
        }
    }
}

/// Combinations of motions at their start: the aperture's place rests on them.
fn combinations(all: &[Undetermined]) -> impl Iterator<Item = CautionFigures> {
    let combined = all.iter().filter(|one| one.is_combined);
    combined.map(|one| mild("held_combination", one.text.clone()))
}

/// Parameters that stayed at their start, each in a few words.
pub(super) fn held(all: &[Undetermined]) -> Vec<String> {
    all.iter().map(|one| one.what.clone()).collect()
}

/// Cautions about a surface that was made from the points.
fn of_reference(reference: Option<&MadeReference<'_>>) -> Vec<CautionFigures> {
    let Some(reference) = reference else { return Vec::new() };
    let spline = reference.spline;
    // At the other end a surface needs no more than its base.
    let coarse = (spline.at_limit && spline.lambda < 1.0).then(|| {
        "the points have form that these knots cannot follow, and the noise contains some of it. Finer knots follow it"
            .to_owned()
    });
    let made = mild("made_from_points", made_from_points(reference));
    [made].into_iter().chain(coarse.map(|text| mild("coarse_knots", text))).collect()
}

/// In what the running fit is not the final one.
fn provisional(estimate: &LiveEstimate, part: &Part) -> Vec<CautionFigures> {
    let Criterion { weights, .. } = part.criterion;
    let kept_up = part.reference.is_some().then_some(
        "while points arrive the reference has at most 40 cells of knots over the longer side. At the end it is made anew from all points",
    );
    let alike = (weights == Weights::Uncertainty && estimate.weights.is_none()).then_some(
        "weights = \"uncertainty\", but the points carry none. Until the end they count alike; at the end there is no fit. Set weights = \"none\"",
    );
    let all = kept_up.into_iter().chain(alike);
    all.map(|text| mild("provisional", text.to_owned())).collect()
}

/// A caution that forbids no verdict.
pub(super) fn mild(kind: &str, text: String) -> CautionFigures {
    CautionFigures { kind: kind.to_owned(), text, forbids_verdict: false }
}

#[cfg(test)]
mod tests;
