//! Limits of figures that are made of more than deviations.

use asphera_report::{FigureName, Verdict};
use asphera_uncertainty::verdict::{Finding, Limit};

use super::Standards;
use crate::Part;
use crate::decision::{self, Held};
use crate::naming;
use crate::undecide;
use crate::unmeasured::Unmeasured;

/// Those of a part: figures and largest values allowed.
pub(crate) fn limits(part: &Part) -> impl Iterator<Item = (FigureName, f64)> {
    let judging = &part.judging;
    let of_points = judging.of_points.iter();
    let of_points = of_points.map(|(of, limit)| (naming::of_figure(*of, part), *limit));
    let texture = judging.texture.iter().map(|(of, limit)| (naming::of_texture(*of), *limit));
    of_points.chain(texture)
}

/// Holds them against what was found, and adds that to the verdict. `dof` are the degrees of freedom of the uncertainties.
/// With a guard band a figure without an uncertainty proves neither. What was not measured counts in figures of points as in
/// the PV; what it does to texture is not told.
pub(crate) fn hold(
    verdict: &mut Verdict,
    part: &Part,
    standards: Option<&Standards>,
    dof: f64,
    unmeasured: &Unmeasured,
) {
    let judging = &part.judging;
    let of_points = judging.of_points.iter().map(|(definition, limit)| {
        let found = standards.and_then(|found| found.of_points(*definition));
        let whole = Limit::of_whole(*definition, *limit);
        (found, unmeasured.hidden(&whole), Some(unmeasured.why(&whole)))
    });
    let texture = judging.texture.iter().map(|(definition, _)| {
        let found = standards.and_then(|found| found.texture_of(*definition));
        (found.map(|figure| (figure, None)), Some(0.0), None)
    });
    let found = of_points.chain(texture);
    for ((of, limit), (found, hidden, why)) in limits(part).zip(found) {
        let name = of.words();
        let Some((figure, least)) = found else {
            undecide(verdict, format!("{name}: the figure is not known"));
            continue;
        };
        let (value, u) = (figure.value, figure.u);
        let by_noise = figure.simulated.as_ref().map_or(0.0, |simulated| simulated.bias.max(0.0));
        let bias = least.map_or(0.0, |least| value - least) + by_noise;
        let finding = Finding { u, dof, bias, hidden, ..Finding::of_value(value) };
        let held = Held {
            figure: of,
            limit,
            finding,
            hidden: hidden.filter(|hidden| *hidden > 0.0),
            covers: figure.simulated.as_ref().map(|simulated| simulated.covers.clone()),
            why,
        };
        decision::hold(verdict, judging.guard, held);
    }
}
