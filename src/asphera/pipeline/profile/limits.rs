//! Limits of a profile beside PV and RMS: those of slopes are held, those of surfaces refused.

use asphera_form::Status as FormStatus;
use asphera_form::figures::Definition;
use asphera_form::verdict::{Finding, Guard, Limit, decide};
use asphera_report::{Check, Status, Verdict};

use super::along::{self, Station};
use crate::config::Part;
use crate::pipeline::judgement::undecide;
use crate::pipeline::naming;
use crate::pipeline::unmeasured::Unmeasured;

/// Holds limits of slopes; of other figures says that a profile has none.
pub(super) fn hold_others(
    verdict: &mut Verdict,
    (judged, part): (&Part, &Part),
    stations: &[Station],
    unmeasured: &Unmeasured,
) {
    if !judged.has_limits() && part.has_limits() {
        // That there is no tolerance was said of PV and RMS alone.
        *verdict = Verdict { status: Status::Pass, ..Verdict::default() };
    }
    let limits = part.judging.limits.iter();
    let zone = part.judging.minimum_zone_nm.map(|_| naming::of_zone_width().words());
    let texture =
        part.judging.texture.iter().map(|(definition, _)| naming::of_texture(*definition).words());
    let mut refused: Vec<String> = zone.into_iter().chain(texture).collect();
    for limit in limits {
        match slope_of(limit, stations) {
            Some(value) => hold_slope(verdict, part, limit, value, unmeasured),
            None => refused.push(naming::of_limit(limit).words()),
        }
    }
    for name in refused {
        undecide(
            verdict,
            format!(
                "{name}: not formed of a profile; give limits of pv_nm, rms_nm, slope_max_urad, slope_rms_urad"
            ),
        );
    }
}

/// The slope that a limit is of, in µrad.
fn slope_of(limit: &Limit, stations: &[Station]) -> Option<f64> {
    if !limit.is_of_whole() {
        return None;
    }
    let [_, rms, most] = along::summed(&along::slopes_over(stations, &limit.slope?))?;
    match limit.definition {
        Definition::MeridionalSlopeMax => Some(1e6 * most),
        Definition::MeridionalSlopeRms => Some(1e6 * rms),
        _ => None,
    }
}

fn hold_slope(
    verdict: &mut Verdict,
    part: &Part,
    limit: &Limit,
    value: f64,
    unmeasured: &Unmeasured,
) {
    let guard = part.judging.guard.unwrap_or(Guard::None);
    let hidden = unmeasured.figures().share.map(|_| 0.0);
    let finding = Finding { value, u: None, dof: f64::INFINITY, bias: 0.0, hidden };
    let Ok(decision) = decide(&finding, limit.value, guard) else { return };
    match decision.status {
        FormStatus::Fail => verdict.status = Status::Fail,
        FormStatus::Undecided => {
            let doubt = decision.doubt.map_or_else(String::new, |doubt| doubt.to_string());
            undecide(verdict, format!("{}: {doubt}", naming::of_limit(limit).words()));
        }
        FormStatus::Pass => {}
    }
    verdict.checks.push(Check {
        figure: naming::of_limit(limit),
        limit: limit.value,
        value,
        ok: decision.status == FormStatus::Pass,
        u: None,
        u_covers: None,
        guard_band: None,
        rule: part.judging.guard.map(|guard| guard.to_string()),
        hidden,
        doubt: decision.doubt.map(|doubt| doubt.to_string()),
    });
}
