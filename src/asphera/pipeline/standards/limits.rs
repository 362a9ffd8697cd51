//! Limits of figures that have no uncertainty: minimum zone, texture.

use asphera_form::Status as FormStatus;
use asphera_form::verdict::{Finding, Guard, decide};

use crate::config::Part;
use crate::pipeline::undecide;
use crate::report::{Check, FormFigure, FormFigures, Status, Verdict};

/// Holds them against what was found, and adds that to the verdict. With a guard band neither is proven: it needs an
/// uncertainty.
pub(in crate::pipeline) fn hold(verdict: &mut Verdict, part: &Part, form: Option<&FormFigures>) {
    let judging = &part.judging;
    let guard = judging.guard.unwrap_or(Guard::None);
    let zone = judging.minimum_zone_nm.map(|limit| {
        let found = form.and_then(|form| form.standards.minimum_zone.as_ref());
        // A zone that may still be too wide proves no limit broken.
        let least = found.filter(|zone| !zone.settled).map(|zone| zone.lower_nm);
        ("minimum_zone_nm", limit, found.map(|zone| &zone.width), least)
    });
    let texture = judging.texture.iter().map(|(key, definition, limit)| {
        let found = form.and_then(|form| form.standards.texture.as_ref());
        let named = |figure: &&FormFigure| figure.name == definition.to_string();
        (&key[..], *limit, found.and_then(|found| found.figures.iter().find(named)), None)
    });
    for (name, limit, found, least) in zone.into_iter().chain(texture) {
        let Some(figure) = found else {
            undecide(verdict, format!("{name}: the figure is not known"));
            continue;
        };
        let value = figure.value;
        let bias = least.map_or(0.0, |least| value - least);
        let finding = Finding { value, u: None, dof: f64::INFINITY, bias, hidden: Some(0.0) };
        let decision = match decide(&finding, limit, guard) {
            Ok(decision) => decision,
            Err(error) => {
                undecide(verdict, format!("{name}: {error}"));
                continue;
            }
        };
        if let Some(doubt) = decision.doubt {
            undecide(verdict, format!("{name}: {doubt}"));
        }
        if decision.status == FormStatus::Fail {
            verdict.status = Status::Fail;
        }
        verdict.checks.push(Check {
            name: name.to_owned(),
            limit,
            value,
            ok: decision.status == FormStatus::Pass,
            u: None,
            guard_band: None,
            rule: judging.guard.map(|guard| guard.to_string()),
            hidden: None,
            doubt: decision.doubt.map(|doubt| doubt.to_string()),
        });
    }
}
