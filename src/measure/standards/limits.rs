//! Limits of the minimum zone and of texture.

use asphera_figures::Definition;
use asphera_report::Verdict;
use asphera_uncertainty::verdict::{Finding, Limit};

use super::Standards;
use crate::Part;
use crate::decision::{self, Held};
use crate::naming;
use crate::undecide;
use crate::unmeasured::Unmeasured;

/// Holds them against what was found, and adds that to the verdict. `dof` are the degrees of freedom of the uncertainties.
/// With a guard band a figure without an uncertainty proves neither. What was not measured counts in the zone as in the PV;
/// what it does to texture is not told.
pub(crate) fn hold(
    verdict: &mut Verdict,
    part: &Part,
    standards: Option<&Standards>,
    dof: f64,
    unmeasured: &Unmeasured,
) {
    let judging = &part.judging;
    let zone = judging.minimum_zone_nm.map(|limit| {
        let found = standards.and_then(|found| found.figures.minimum_zone.as_ref());
        // A zone that may still be too wide proves no limit broken.
        let least = found.filter(|zone| !zone.settled).map(|zone| zone.lower_nm);
        let hidden = unmeasured.hidden(&Limit::of_whole(Definition::MinimumZone, limit));
        (naming::of_zone_width(), limit, found.map(|zone| &zone.width), least, hidden)
    });
    let texture = judging.texture.iter().map(|(definition, limit)| {
        let found = standards.and_then(|found| found.texture_of(*definition));
        (naming::of_texture(*definition), *limit, found, None, Some(0.0))
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
        let finding = Finding { u, dof, bias, hidden, ..Finding::of_value(value) };
        // Only of the minimum zone it is known what was not measured.
        let of_zone = Limit::of_whole(Definition::MinimumZone, limit);
        let held = Held {
            hidden: hidden.filter(|hidden| *hidden > 0.0),
            covers: figure.simulated.as_ref().map(|simulated| simulated.covers.clone()),
            ..Held::new(of, &of_zone, finding, unmeasured)
        };
        decision::hold(verdict, judging.guard, held);
    }
}
