//! A figure held against its limit, and what the verdict says of it: the one place.

use asphera_report::{Check, FigureName, Status, Verdict};
use asphera_uncertainty::verdict::{
    Decision, Doubt, Finding, Guard, Limit, Status as FormStatus, decide,
};

use crate::judgement::undecide;
use crate::uncertainties::COVERAGE;
use crate::unmeasured::Unmeasured;

/// A figure as found, and its limit.
pub(super) struct Held {
    pub(super) figure: FigureName,
    /// The largest value allowed, in the unit of the figure.
    pub(super) limit: f64,
    pub(super) finding: Finding,
    /// Reported allowance for what was not measured.
    pub(super) hidden: Option<f64>,
    /// Scope of its standard uncertainty.
    pub(super) covers: Option<String>,
    /// Why what was not measured might break it; asked only where that is so.
    pub(super) why: Option<String>,
}

impl Held {
    /// The finding for a limit, with what was not measured.
    pub(super) fn new(
        figure: FigureName,
        limit: &Limit,
        finding: Finding,
        unmeasured: &Unmeasured,
    ) -> Held {
        let why = Some(unmeasured.why(limit));
        let hidden = finding.hidden;
        Held { figure, limit: limit.value, finding, hidden, covers: None, why }
    }
}

/// Holds a figure that nothing unmeasured can break against its limit, and adds the check to the verdict: the rule of a part for figures of
/// other kinds. `covers` is the scope of its standard uncertainty.
pub fn hold_whole(
    verdict: &mut Verdict,
    guard: Option<Guard>,
    figure: FigureName,
    limit: f64,
    finding: Finding,
    covers: &str,
) {
    let finding = Finding { hidden: Some(0.0), ..finding };
    let covers = Some(covers.to_owned());
    hold(verdict, guard, Held { figure, limit, finding, hidden: None, covers, why: None });
}

/// Holds a figure against its limit, by the guard band if there is one, and adds the check to the verdict.
pub(super) fn hold(verdict: &mut Verdict, guard: Option<Guard>, held: Held) {
    match decide(&held.finding, held.limit, guard.unwrap_or(Guard::None)) {
        Ok(decision) => add(verdict, guard, held, &decision),
        Err(error) => undecide(verdict, format!("{}: {error}", held.figure.words())),
    }
}

fn add(verdict: &mut Verdict, guard: Option<Guard>, held: Held, decision: &Decision) {
    let Held { figure, limit, finding, hidden, covers, why } = held;
    if let Some(doubt) = decision.doubt {
        let name = figure.words();
        undecide(
            verdict,
            match why.filter(|_| doubt == Doubt::Unmeasured) {
                Some(why) => format!("{name}: {doubt}: {why}"),
                None => format!("{name}: {doubt}"),
            },
        );
    }
    if decision.status == FormStatus::Fail {
        verdict.status = Status::Fail;
    }
    verdict.checks.push(Check {
        figure,
        limit,
        value: finding.value,
        ok: decision.status == FormStatus::Pass,
        u: finding.u,
        u_covers: finding.u.and(covers),
        interval_95: finding.interval(COVERAGE),
        guard_band: decision.band.filter(|_| guard.is_some()),
        rule: guard.map(|guard| guard.to_string()),
        hidden,
        doubt: decision.doubt.map(|doubt| doubt.to_string()),
    });
}
