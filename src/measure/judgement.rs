//! The verdict: limits held against values, and what stands in the way of an answer.

use asphera_figures::{Definition, Treatment};
use asphera_form::{Figures, Nominal};
use asphera_mesh::Mesh;
use asphera_report::error_chain;
use asphera_report::{MeshFigures, ProjectionFigures, SamplingFigures, Status, Verdict};
use asphera_uncertainty::verdict::{Finding, Limit, Over, Reason};

use super::errors::ErrorsOfFigures;
use super::figures;
use super::fit_details::forbids_verdict;
use super::fitting::{Fitted, NoFit};
use super::judged::{AllJudged, Judged};
use crate::Part;

/// Obstacles to a verdict that limits and figures give.
pub(super) fn judge(
    mut verdict: Verdict,
    part: &Part,
    mesh: &Mesh,
    fitted: Result<&Fitted, &NoFit>,
    seen: &MeshFigures,
    sampling: &SamplingFigures,
) -> Verdict {
    if let Err(NoFit::Folded(why)) = fitted {
        let advice = seen.relief.projection.as_deref().unwrap_or_default();
        doubt(&mut verdict, format!("{why}; {advice}"));
        return verdict;
    }
    match fitted.map(|fitted| &fitted.fit) {
        Err(error) => {
            doubt(&mut verdict, format!("no fit: {}", error_chain(error)));
        }
        Ok(fit) if !fit.termination.is_converged() => {
            let why = figures::termination(&fit.termination);
            doubt(&mut verdict, format!("the fit did not converge: {why}"));
        }
        Ok(fit) if fit.dof == 0 => {
            let used = fit.used;
            doubt(
                &mut verdict,
                format!("{used} points determine {used} parameters and no deviation"),
            );
        }
        Ok(fit) => {
            for caution in &fit.cautions {
                if forbids_verdict(caution) {
                    doubt(&mut verdict, caution.to_string());
                }
            }
            // The sampling counts them, for they were measured; but no limit was held against them.
            let beyond = fit.excluded.outside_domain;
            let share = fit.used as f64 / (fit.used + beyond) as f64;
            if share < part.coverage_min {
                undecide(
                    &mut verdict,
                    format!(
                        "only {:.1} % of the points in the aperture stand over the nominal, {:.1} % are wanted",
                        100.0 * share,
                        100.0 * part.coverage_min
                    ),
                );
            }
        }
    }
    if let Ok(Fitted { reference: Some(reference), .. }) = fitted {
        // The limits hold of what is left, and whoever reads the verdict must know of what.
        verdict.reasons.push(figures::made_from_points(&reference.into()));
    }
    match sampling.coverage {
        None => undecide(
            &mut verdict,
            match sampling.unknown.first() {
                Some(why) => why.clone(),
                None => "the points span no area".to_owned(),
            },
        ),
        Some(coverage) if coverage < part.coverage_min => undecide(
            &mut verdict,
            format!(
                "only {:.1} % of the aperture is sampled densely enough, {:.1} % are wanted",
                100.0 * coverage,
                100.0 * part.coverage_min
            ),
        ),
        Some(_) => {}
    }
    if let Some(unfitted @ ProjectionFigures::Unfitted { .. }) = &seen.projection {
        doubt(&mut verdict, format!("projected {unfitted}"));
    }
    if !mesh.projectable() {
        let conflicts = mesh.counts().conflicts;
        doubt(
            &mut verdict,
            format!("not projectable: {conflicts} points stand above or below others"),
        );
    }
    verdict
}

/// The figures themselves are in doubt: neither a pass nor a fail can be said.
pub fn doubt(verdict: &mut Verdict, reason: String) {
    verdict.status = Status::Undecided;
    verdict.reasons.push(reason);
}

/// Something is not known: a pass becomes undecided. A fail stands, for what is measured already breaks a
/// limit.
pub fn undecide(verdict: &mut Verdict, reason: String) {
    if verdict.status == Status::Pass {
        verdict.status = Status::Undecided;
        // It stands first: it is what a light has room for.
        verdict.reasons.insert(0, reason);
        return;
    }
    verdict.reasons.push(reason);
}

/// Something with limits of its own was held against them, so the answer is no longer that nothing was asked.
pub fn ask(verdict: &mut Verdict) {
    if verdict.status == Status::None {
        verdict.status = Status::Pass;
        let nothing = Reason::NoTolerance.to_string();
        verdict.reasons.retain(|reason| *reason != nothing);
    }
}

/// Deviations that limits are of.
#[derive(Clone, Copy)]
pub(super) struct Deviating<'a> {
    /// Places in the part frame, mm.
    pub(super) places_mm: &'a [[f64; 2]],
    /// At each place, NaN where a point does not count.
    pub(super) deviations_mm: &'a [f64],
    /// The area that each place stands for.
    pub(super) areas_mm2: &'a [f64],
    pub(super) nominal: &'a Nominal,
}

/// Values that limits are held against where no uncertainty is asked for.
pub(super) struct Plain<'a> {
    /// PV and RMS of the deviation; `None` without a fit.
    pub(super) found: Option<&'a Figures>,
    /// Their errors. They are shown, and do not count.
    pub(super) errors: Option<&'a ErrorsOfFigures>,
    /// The deviation that the fit leaves.
    pub(super) left: Option<Deviating<'a>>,
    /// The deviation from the design, where the shape was free; else why it is not known.
    pub(super) design: Option<Result<Deviating<'a>, String>>,
}

impl<'a> Plain<'a> {
    /// PV and RMS alone.
    pub(super) fn of_heights(found: Option<&'a Figures>) -> Plain<'a> {
        Plain { found, errors: None, left: None, design: None }
    }

    /// The value of a limited figure, and whether it is of the deviation from the design.
    fn value(&self, limit: &Limit, part: &Part) -> Result<(f64, bool), String> {
        if limit.is_of_whole() {
            match (limit.definition, self.found) {
                (Definition::PeakToValley, Some(found)) => return Ok((found.pv_nm, false)),
                (Definition::RmsOverPoints, Some(found)) => return Ok((found.rms_nm, false)),
                _ => {}
            }
        }
        let (of, from_design) =
            match (&self.design, limit.definition.subject().treatment(&part.free)) {
                (Some(design), Treatment::FromDesign) => (Some(design.clone()?), true),
                _ => (self.left, false),
            };
        let of = of.ok_or_else(|| Reason::NoFigures.to_string())?;
        let over = Over { aperture: &part.aperture, areas_mm2: Some(of.areas_mm2) };
        match limit.figure_of(of.places_mm, of.deviations_mm, over, of.nominal) {
            Ok(Ok(figure)) => Ok((figure.value, from_design)),
            Ok(Err(unknown)) => Err(unknown.to_string()),
            Err(error) => Err(error_chain(&error)),
        }
    }
}

/// What was found of the limits where no uncertainty is asked for: values as they are.
pub(super) fn plainly<'a>(part: &'a Part, plain: &Plain<'_>) -> AllJudged<'a> {
    let limits = part.limits();
    if !limits.is_empty() && plain.found.is_none() {
        return Err(Reason::NoFigures.to_string());
    }
    let judged = |limit: &'a Limit| {
        let errors = plain.errors.filter(|_| limit.is_of_whole());
        let u = errors.and_then(|errors| match limit.definition {
            Definition::PeakToValley => Some(errors.u_pv_nm),
            Definition::RmsOverPoints => Some(errors.u_rms_nm),
            _ => None,
        });
        let (found, from_design) = match plain.value(limit, part) {
            Ok((value, from_design)) => {
                let found = Finding { u, ..Finding::of_value(value) };
                (Ok(found), from_design)
            }
            Err(why) => (Err(why), false),
        };
        let covers = errors.map(|errors| errors.covers(limit.definition));
        Judged { limit, found, from_design, covers }
    };
    Ok(limits.iter().map(judged).collect())
}

/// A verdict before any limit was held: a pass if there are limits.
pub(super) fn without_checks(part: &Part) -> Verdict {
    if part.has_limits() {
        return Verdict { status: Status::Pass, ..Verdict::default() };
    }
    Verdict {
        status: Status::None,
        reasons: vec![Reason::NoTolerance.to_string()],
        ..Verdict::default()
    }
}
