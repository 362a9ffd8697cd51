//! Limits of figures that are made of more than deviations.

use asphera_report::{FigureName, Verdict};
use asphera_uncertainty::verdict::{Finding, Limit};

use super::Limited;
use crate::Part;
use crate::decision::{self, Held};
use crate::details::FormDetails;
use crate::naming;
use crate::undecide;
use crate::unmeasured::Unmeasured;

/// Limits of a part: figures and largest values allowed.
pub(crate) fn limits(part: &Part) -> impl Iterator<Item = (FigureName, f64)> {
    let limits = part.judging.standards.iter();
    limits.map(|(definition, limit)| (naming::of_figure(*definition, part), *limit))
}

/// Holds the limits against what was found, and adds that to the verdict. `dof` are the degrees of freedom of the
/// uncertainties. With a guard band a figure without an uncertainty proves neither.
pub(crate) fn hold(
    verdict: &mut Verdict,
    part: &Part,
    details: Option<&FormDetails>,
    dof: f64,
    unmeasured: &Unmeasured,
) {
    for ((definition, value), (name, _)) in part.judging.standards.iter().zip(limits(part)) {
        let mut all = details.into_iter().flat_map(|details| &details.limited);
        let Some(found) = all.find(|found| found.definition == *definition) else {
            undecide(verdict, format!("{}: the figure is not known", name.words()));
            continue;
        };
        let limit = Limit::of_whole(*definition, *value);
        let hidden = unmeasured.hidden(&limit);
        let Limited { u, bias, .. } = *found;
        let finding = Finding { u, dof, bias, hidden, ..Finding::of_value(found.value) };
        let held = Held {
            hidden: hidden.filter(|hidden| *hidden > 0.0),
            covers: found.covers.clone(),
            ..Held::new(name, &limit, finding, unmeasured)
        };
        decision::hold(verdict, part.judging.guard, held);
    }
}
