//! The verdict: limits held against values, and what stands in the way of an answer.

use asphera_form::figures::Definition;
use asphera_form::verdict::{Doubt, Finding, Guard, Limit, decide};
use asphera_form::{Figures, Reason, Status as FormStatus, Tolerance, verdict};
use asphera_mesh::Mesh;
use asphera_report::{Check, MeshFigures, ProjectionFigures, SamplingFigures, Status, Verdict};

use super::errors::ErrorsOfFigures;
use super::figures;
use super::fit_details::forbids_verdict;
use super::fitting::{Fitted, NoFit};
use super::naming;
use super::unmeasured::Unmeasured;
use crate::config::Part;

/// What stands in the way of a verdict that limits and figures give.
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
        Err(error) => doubt(&mut verdict, format!("no fit: {}", crate::error_chain(error))),
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
pub(crate) fn doubt(verdict: &mut Verdict, reason: String) {
    verdict.status = Status::Undecided;
    verdict.reasons.push(reason);
}

/// Something is not known: a pass becomes undecided. A fail stands, for what is measured already breaks a
/// limit.
pub(crate) fn undecide(verdict: &mut Verdict, reason: String) {
    if verdict.status == Status::Pass {
        verdict.status = Status::Undecided;
    }
    verdict.reasons.push(reason);
}

/// PV and RMS held against their limits as they are, what is not measured regarded. `errors` are told, and do not count.
/// Passes without either where there are limits of other figures, which are held later.
pub(super) fn compare(
    part: &Part,
    found: Option<&Figures>,
    errors: Option<&ErrorsOfFigures>,
    unmeasured: &Unmeasured,
) -> Verdict {
    let tolerance = Tolerance { pv_nm: part.pv_nm, rms_nm: part.rms_nm };
    if tolerance == Tolerance::default() && part.judging.has_limits_of_standards() {
        return Verdict { status: Status::Pass, ..Verdict::default() };
    }
    let plain = verdict(found, &tolerance);
    let mut verdict = Verdict {
        status: match plain.status {
            FormStatus::Pass => Status::Pass,
            FormStatus::Fail => Status::Fail,
            FormStatus::Undecided if plain.reason == Some(Reason::NoTolerance) => Status::None,
            FormStatus::Undecided => Status::Undecided,
        },
        reasons: plain.reason.map(|reason| reason.to_string()).into_iter().collect(),
        ..Verdict::default()
    };
    for (check, limit) in plain.checks.iter().zip(part.limits()) {
        let hidden = unmeasured.hidden(&limit);
        let finding =
            Finding { value: check.value, u: None, dof: f64::INFINITY, bias: 0.0, hidden };
        let doubt = decide(&finding, check.limit, Guard::None).ok().and_then(|found| found.doubt);
        if let Some(doubt) = doubt {
            undecide(
                &mut verdict,
                said(&naming::of_limit(&limit).words(), &limit, doubt, unmeasured),
            );
        }
        verdict.checks.push(Check {
            figure: naming::of_limit(&limit),
            limit: check.limit,
            value: check.value,
            ok: check.ok && doubt.is_none(),
            u: errors.map(|errors| match limit.definition {
                Definition::PeakToValley => errors.u_pv_nm,
                _ => errors.u_rms_nm,
            }),
            u_covers: errors.map(|errors| errors.covers(limit.definition)),
            guard_band: None,
            rule: None,
            hidden,
            doubt: doubt.map(|doubt| doubt.to_string()),
        });
    }
    verdict
}

/// Why a limit is not proven.
pub(super) fn said(name: &str, limit: &Limit, doubt: Doubt, unmeasured: &Unmeasured) -> String {
    match doubt {
        Doubt::Unmeasured => format!("{name}: {doubt}: {}", unmeasured.why(limit)),
        _ => format!("{name}: {doubt}"),
    }
}
