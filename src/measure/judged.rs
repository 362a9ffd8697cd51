//! The limits of a part with what was found of each, before what was not measured is regarded.

use asphera_figures::{Definition, Subject, Term, Unit};
use asphera_form::Aperture;
use asphera_report::{FormFigure, Status, Verdict};
use asphera_uncertainty::verdict::{Finding, Guard, Limit};

use super::decision::{Held, hold};
use super::judgement::{undecide, without_checks};
use super::naming;
use super::unmeasured::Unmeasured;
use crate::Part;

/// A limit with what was found of its figure.
pub(super) struct Judged<'a> {
    pub(super) limit: &'a Limit,
    /// The figure without an allowance for what was not measured, or why it is not known.
    pub(super) found: Result<Finding, String>,
    /// Whether the figure is of the deviation from the design.
    pub(super) from_design: bool,
    /// Scope of its standard uncertainty.
    pub(super) covers: Option<String>,
}

/// The limits of a part, or why none of them can be judged.
pub(super) type AllJudged<'a> = Result<Vec<Judged<'a>>, String>;

/// Figures of limits over a length, a part of the aperture or with terms removed, but for those that `known` has.
pub(super) fn of_narrow_limits(all: &AllJudged<'_>, known: &[FormFigure]) -> Vec<FormFigure> {
    let figure = |one: &Judged<'_>| {
        let found = one.found.as_ref().ok()?;
        let figure = naming::of_narrow_limit(one.limit, found.value)?;
        let is_same =
            |other: &FormFigure| (&other.id, &other.variant) == (&figure.id, &figure.variant);
        (!known.iter().any(is_same)).then_some(FormFigure { u: found.u, ..figure })
    };
    all.iter().flatten().filter_map(figure).collect()
}

/// The verdict by the limits: of figures of what the fit leaves with the first allowance, of those from the design with the
/// second.
pub(super) fn verdict(
    part: &Part,
    guard: Option<Guard>,
    all: AllJudged<'_>,
    unmeasured: [&Unmeasured; 2],
) -> Verdict {
    let all = match all {
        Ok(all) => all,
        Err(why) => {
            return Verdict { status: Status::Undecided, reasons: vec![why], ..Verdict::default() };
        }
    };
    let mut verdict = without_checks(part);
    for Judged { limit, found, from_design, covers } in all {
        let figure = naming::of_limit(limit, part);
        let unmeasured = unmeasured[usize::from(from_design)];
        match found {
            Ok(found) => {
                let found = Finding { hidden: unmeasured.hidden(limit), ..found };
                let held = Held { covers, ..Held::new(figure, limit, found, unmeasured) };
                hold(&mut verdict, guard, held);
            }
            Err(why) => undecide(&mut verdict, format!("{}: {why}", figure.words())),
        }
    }
    verdict
}

/// Leaves a pass by a limit of slopes undecided where `missing` says that these are not those of the whole aperture.
pub(super) fn hold_slopes(verdict: &mut Verdict, part: &Part, missing: Option<&str>) {
    let of_slopes = part.limits().iter().find(|limit| limit.definition.subject() == Subject::Slope);
    if let Some((limit, why)) = of_slopes.zip(missing) {
        undecide(verdict, format!("{}: no {why}", naming::of_limit(limit, part).words()));
    }
}

/// Standard uncertainties, known before the first figure is written.
#[derive(Default)]
pub(super) struct Sure {
    /// Of PV and RMS over the points.
    heights_nm: Option<[f64; 2]>,
    /// Of further figures that have a limit over the whole aperture.
    limits: Vec<(Limit, f64)>,
}

impl Sure {
    /// `heights_nm` are those of PV and RMS over the points, where they are known.
    pub(super) fn new(heights_nm: Option<[f64; 2]>, all: &AllJudged<'_>) -> Sure {
        let limit = |one: &Judged<'_>| {
            // Slopes among the figures may be over another length.
            let is_whole =
                one.limit.zone == Aperture::None && one.limit.definition.unit() == Unit::Nanometres;
            Some((one.limit.clone(), one.found.as_ref().ok()?.u?)).filter(|_| is_whole)
        };
        Sure { heights_nm, limits: all.iter().flatten().filter_map(limit).collect() }
    }

    /// Of a figure over the whole aperture with terms removed; `None` where it is not known.
    pub(super) fn of(&self, definition: Definition, removed: &[Term]) -> Option<f64> {
        let of_heights = self.heights_nm.filter(|_| removed.is_empty());
        let of_heights = of_heights.and_then(|[pv, rms]| match definition {
            Definition::PeakToValley => Some(pv),
            Definition::RmsOverPoints => Some(rms),
            _ => None,
        });
        of_heights.or_else(|| {
            let is_it = |(limit, _): &&(Limit, f64)| {
                limit.definition == definition && limit.less.list() == removed
            };
            self.limits.iter().find(is_it).map(|(_, u)| *u)
        })
    }
}
