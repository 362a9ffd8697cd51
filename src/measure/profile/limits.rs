//! Limits of a profile beside PV and RMS: those of slopes are held, those of surfaces refused.

use asphera_figures::Definition;
use asphera_report::Verdict;
use asphera_uncertainty::verdict::{Finding, Limit};

use super::along::{self, Station};
use crate::Part;
use crate::decision::{Held, hold};
use crate::judgement::{undecide, without_checks};
use crate::naming;
use crate::standards;
use crate::unmeasured::Unmeasured;

/// Holds limits of slopes; of other figures says that a profile has none.
pub(super) fn hold_others(
    verdict: &mut Verdict,
    (judged, part): (&Part, &Part),
    stations: &[Station],
    unmeasured: &Unmeasured,
) {
    if !judged.has_limits() {
        // That there is no limit was said of PV and RMS alone.
        *verdict = without_checks(part);
    }
    let limits = part.limits().iter().filter(|limit| !is_of_deviation(limit));
    let of_standards = standards::limits(part);
    let mut refused: Vec<String> = of_standards.map(|(figure, _)| figure.words()).collect();
    for limit in limits {
        match slope_of(limit, stations) {
            Some(value) => hold_slope(verdict, part, limit, value, unmeasured),
            None => refused.push(naming::of_limit(limit, part).words()),
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

/// Whether a limit is of PV or RMS of the whole line.
pub(super) fn is_of_deviation(limit: &Limit) -> bool {
    let definition = limit.definition;
    let is_known = matches!(definition, Definition::PeakToValley | Definition::RmsOverPoints);
    is_known && limit.is_of_whole()
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
    let hidden = unmeasured.figures().share.map(|_| 0.0);
    let finding = Finding { hidden, ..Finding::of_value(value) };
    let held = Held::new(naming::of_limit(limit, part), limit, finding, unmeasured);
    hold(verdict, part.judging.guard, held);
}
