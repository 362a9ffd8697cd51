//! Limits of the minimum zone and of texture.

use asphera_form::Status as FormStatus;
use asphera_form::figures::Definition;
use asphera_form::verdict::{Finding, Guard, Limit, decide};
use asphera_report::{Check, FormFigure, FormFigures, Status, Verdict};

use crate::config::Part;
use crate::pipeline::judgement::said;
use crate::pipeline::naming;
use crate::pipeline::undecide;
use crate::pipeline::unmeasured::Unmeasured;

/// Holds them against what was found, and adds that to the verdict. `dof` are the degrees of freedom of the uncertainties.
/// With a guard band a figure without an uncertainty proves neither. What was not measured counts in the zone as in the PV;
/// what it does to texture is not told.
pub(in crate::pipeline) fn hold(
    verdict: &mut Verdict,
    part: &Part,
    form: Option<&FormFigures>,
    dof: f64,
    unmeasured: &Unmeasured,
) {
    let judging = &part.judging;
    let guard = judging.guard.unwrap_or(Guard::None);
    let zone = judging.minimum_zone_nm.map(|limit| {
        let found = form.and_then(|form| form.standards.minimum_zone.as_ref());
        // A zone that may still be too wide proves no limit broken.
        let least = found.filter(|zone| !zone.settled).map(|zone| zone.lower_nm);
        let hidden = unmeasured.hidden(&Limit::of_whole(Definition::MinimumZone, limit));
        (naming::of_zone_width(), limit, found.map(|zone| &zone.width), least, hidden)
    });
    let texture = judging.texture.iter().map(|(definition, limit)| {
        let found = form.and_then(|form| form.standards.texture.as_ref());
        let id = definition.id();
        let named = |figure: &&FormFigure| figure.id == id;
        (
            naming::of_texture(*definition),
            *limit,
            found.and_then(|found| found.figures.iter().find(named)),
            None,
            Some(0.0),
        )
    });
    for (of, limit, found, least, hidden) in zone.into_iter().chain(texture) {
        let name = of.words();
        let Some(figure) = found else {
            undecide(verdict, format!("{name}: the figure is not known"));
            continue;
        };
        let (value, u) = (figure.value, figure.u);
        let by_noise = figure.simulated.as_ref().map_or(0.0, |simulated| simulated.bias.max(0.0));
        let bias = least.map_or(0.0, |least| value - least) + by_noise;
        let finding = Finding { value, u, dof, bias, hidden };
        let decision = match decide(&finding, limit, guard) {
            Ok(decision) => decision,
            Err(error) => {
                undecide(verdict, format!("{name}: {error}"));
                continue;
            }
        };
        if let Some(doubt) = decision.doubt {
            // Only of the minimum zone it is told what was not measured.
            let limit = Limit::of_whole(Definition::MinimumZone, limit);
            undecide(verdict, said(&name, &limit, doubt, unmeasured));
        }
        if decision.status == FormStatus::Fail {
            verdict.status = Status::Fail;
        }
        verdict.checks.push(Check {
            figure: of,
            limit,
            value,
            ok: decision.status == FormStatus::Pass,
            u,
            u_covers: figure.simulated.as_ref().map(|simulated| simulated.covers.clone()),
            guard_band: decision.band.filter(|_| judging.guard.is_some()),
            rule: judging.guard.map(|guard| guard.to_string()),
            hidden: hidden.filter(|hidden| *hidden > 0.0),
            doubt: decision.doubt.map(|doubt| doubt.to_string()),
        });
    }
}
