//! The verdict: limits held against values, and what stands in the way of an answer.

use asphera_form::{Caution, Figures, Status as FormStatus, Tolerance, verdict};
use asphera_surface::Mesh;

use super::figures;
use super::fitting::{Fitted, NoFit};
use crate::config::Part;
use crate::report::{Check, MeshFigures, ProjectionFigures, SamplingFigures, Status, Verdict};

/// What stands in the way of a verdict that limits and figures give.
pub(super) fn judge(
    mut verdict: Verdict,
    part: &Part,
    mesh: &Mesh,
    fitted: Result<&Fitted, &NoFit>,
    seen: &MeshFigures,
    sampling: &SamplingFigures,
) -> Verdict {
    match fitted.map(|fitted| &fitted.fit) {
        Err(error) => verdict.reasons.push(format!("no fit: {}", crate::error_chain(error))),
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
                match caution {
                    Caution::UpsideDown | Caution::Mirrored { .. } | Caution::Units(_) => {
                        doubt(&mut verdict, caution.to_string());
                    }
                    // What is left out shows in the coverage, and a weak combination in its uncertainty.
                    Caution::BeyondDomain { .. } | Caution::IllConditioned { .. } => {}
                }
            }
        }
    }
    if let Ok(Fitted { reference: Some(reference), .. }) = fitted {
        // The limits hold of what is left, and whoever reads the verdict must know of what.
        verdict.reasons.push(figures::made_from_points(reference));
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
    if let [fold, ..] = &seen.relief.folds[..] {
        let [x, y, z] = fold.at_mm;
        let count = seen.relief.folds.len();
        let along = seen.relief.projection.as_deref().unwrap_or("in no other plane either");
        doubt(
            &mut verdict,
            format!(
                "not projectable: folds in {count} places, the largest about ({x:.4}, {y:.4}, {z:.4}) mm; {along}"
            ),
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

/// PV and RMS held against their limits as they are. Passes without either where there are limits of other figures,
/// which are held later.
pub(super) fn compare(part: &Part, found: Option<&Figures>) -> Verdict {
    let tolerance = Tolerance { pv_nm: part.pv_nm, rms_nm: part.rms_nm };
    if tolerance == Tolerance::default() && part.judging.has_bare_limits() {
        return Verdict { status: Status::Pass, ..Verdict::default() };
    }
    let verdict = verdict(found, &tolerance);
    Verdict {
        status: match verdict.status {
            FormStatus::Pass => Status::Pass,
            FormStatus::Fail => Status::Fail,
            FormStatus::Undecided => Status::Undecided,
        },
        checks: verdict
            .checks
            .iter()
            .map(|check| Check {
                name: check.name.to_owned(),
                limit: check.limit,
                value: check.value,
                ok: check.ok,
                u: None,
                guard_band: None,
                rule: None,
            })
            .collect(),
        reasons: verdict.reason.map(|reason| reason.to_string()).into_iter().collect(),
    }
}
