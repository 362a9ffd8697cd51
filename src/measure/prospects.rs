//! What can be said of the limits while points still arrive: fail certain, pass certain from a coverage on, or open; or
//! that a figure is only known at the end.
//!
//! The reasoning is that of `asphera_form::verdict`. What was certain once stays so: a bound of the final figure that
//! held for fewer points holds for more. It rests on these points staying in the fit, which they do unless the mesh
//! finds them above each other; then nothing is said.

mod evidence;
mod words;

use std::collections::BTreeMap;

use asphera_figures::Definition;
use asphera_form::{Aperture, FitSettings, LiveEstimate, ZoneSettings, minimum_zone};
use asphera_geometry::PointMm;
use asphera_uncertainty::verdict::{Guard, Limit, Prospect, Raised, Running, Zone, prospect};

pub(super) use self::evidence::Evidence;
use asphera_report::{FigureName, Outlook, ProspectFigures, ProspectState};

use self::evidence::{KnownLimits, OfLimit};
use super::errors::ErrorsOfFigures;
use super::naming;
use super::running::fit_settings;
use super::standards;
use crate::Part;

/// Outlook so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Prospects {
    said: BTreeMap<String, Said>,
    seen: KnownLimits,
    /// The least coverage from which on something more can be told, as of the last time it was said.
    next_coverage: Option<f64>,
}

/// Outlook for one limit.
#[derive(Clone, Copy, Debug, Default)]
struct Said {
    /// The largest bound there was.
    at_least_nm: Option<f64>,
    fail_is_certain: bool,
}

/// State of a measurement, to go by.
pub(super) struct Now<'a> {
    pub(super) part: &'a Part,
    pub(super) estimate: &'a LiveEstimate,
    /// Points that hold the deviation at its worst.
    pub(super) extremes: &'a dyn Fn() -> Vec<PointMm>,
    pub(super) errors: Option<ErrorsOfFigures>,
    /// Coverage as of the last look.
    pub(super) coverage: Option<f64>,
    /// Points there will be, at most; `None` if nobody knows.
    pub(super) expected_points: Option<u64>,
    /// Doubt of the figures themselves.
    pub(super) doubt: Option<&'static str>,
}

impl Prospects {
    /// Takes what a look at all points tells of the limits.
    pub(super) fn see(&mut self, look: &Evidence<'_>) {
        let certain = |name: &str| self.said.get(name).is_some_and(|said| said.fail_is_certain);
        self.seen = KnownLimits::of(look, certain);
    }

    /// Whether a look at all points would tell a pass, if so much is covered by now.
    pub(super) fn awaits(&self, coverage: f64) -> bool {
        self.next_coverage.is_some_and(|from| coverage >= from)
    }

    /// Outlook now; `None` where there is no limit.
    pub(super) fn look(&mut self, now: &Now<'_>) -> Option<Outlook> {
        let part = now.part;
        let mut limits: Vec<ProspectFigures> = part
            .limits()
            .iter()
            .map(|limit| match is_foreseen(limit) {
                true => self.of_limit(limit, now),
                false => at_end(naming::of_limit(limit, part), limit.value, now),
            })
            .collect();
        let of_standards = standards::limits(part);
        limits.extend(of_standards.map(|(figure, limit)| at_end(figure, limit, now)));
        let later = limits.iter().filter(|limit| limit.state == ProspectState::PassFrom);
        let from = later.filter_map(|limit| limit.pass_from_coverage);
        self.next_coverage = from.min_by(f64::total_cmp);
        words::outlook(limits)
    }

    fn of_limit(&mut self, limit: &Limit, now: &Now<'_>) -> ProspectFigures {
        let of = naming::of_limit(limit, now.part);
        let name = of.name.clone();
        let seen = self.seen.of_limit(&name);
        let value = if limit.is_of_whole() {
            Some(figure_nm(limit.definition, now.estimate))
        } else {
            seen.map(|seen| seen.value_nm)
        };
        let mut found = blank(of, limit.value, now.coverage);
        found.value = value;
        let Some(value_nm) = value.filter(|_| now.doubt.is_none()) else {
            let why = now.doubt.unwrap_or("too few points to look at");
            found.text = format!("open: {why}");
            return found;
        };
        let said = self.said.entry(name).or_default();
        let running = running(limit, value_nm, seen, said.fail_is_certain, now);
        // A guard band that is none was refused with the nominal file.
        let Ok(prospect) = prospect(&running, limit.value, guard(now.part), P) else {
            return found;
        };
        said.at_least_nm = match (said.at_least_nm, running.at_least_nm) {
            (Some(before), Some(now)) => Some(before.max(now)),
            (before, now) => before.or(now),
        };
        said.fail_is_certain |= prospect.fail_is_certain;
        found.at_least = said.at_least_nm;
        tell(&mut found, said.fail_is_certain, prospect, &words::Why { limit, running, now });
        found
    }
}

/// Writes what a prospect says.
fn tell(found: &mut ProspectFigures, fails: bool, prospect: Prospect, why: &words::Why<'_>) {
    if fails {
        found.state = ProspectState::FailCertain;
        found.text = words::fail_is_certain(found);
        return;
    }
    let part = why.now.part;
    let least = part.coverage_min;
    found.pass_from_coverage = prospect
        .pass_from_coverage
        .filter(|_| found.coverage.is_some() && part.criterion.is_plain())
        .map(|from| from.max(least));
    match (found.pass_from_coverage, found.coverage) {
        (Some(from), Some(coverage)) if coverage >= from => {
            found.state = ProspectState::PassCertain;
            found.text = words::pass_is_certain();
        }
        (Some(from), Some(coverage)) => {
            found.state = ProspectState::PassFrom;
            found.text = words::pass_from(from, Some(coverage));
        }
        _ => found.text = format!("open: {}", why.is_open(&found.figure)),
    }
}

/// The figure of a limit as it runs. `is_certain`: of a fail that was told before no better bound is looked for.
fn running<'a>(
    limit: &Limit,
    value_nm: f64,
    seen: Option<&'a OfLimit>,
    is_certain: bool,
    now: &Now<'_>,
) -> Running<'a> {
    let of_range = limit.definition == Definition::PeakToValley;
    let errors = if limit.is_of_whole() {
        let of_figures = |errors: ErrorsOfFigures| {
            let u_nm = if of_range { errors.u_pv_nm } else { errors.u_rms_nm };
            (u_nm, errors.noise.pv_bias_at_most_nm, errors.noise.noise_nm)
        };
        now.errors.map(of_figures)
    } else {
        seen.and_then(|seen| seen.errors)
            .map(|errors| (errors.u_nm, errors.pv_bias_at_most_nm, errors.noise_nm))
    };
    // Only a budget takes the noise off.
    let taken_off = errors.filter(|_| now.part.judging.uncertainty.is_some());
    let raised = if of_range {
        Raised::Range { bias_nm: taken_off.map_or(0.0, |(_, bias_nm, _)| bias_nm) }
    } else {
        Raised::Rms { noise_nm: taken_off.map_or(0.0, |(_, _, noise_nm)| noise_nm) }
    };
    let at_least_nm = match (limit.is_of_whole(), of_range) {
        (false, _) => seen.and_then(|seen| seen.at_least_nm),
        (true, true) => {
            // No bound of a PV that is within its limit can break it.
            let broken = value_nm > limit.value && now.estimate.is_complete() && !is_certain;
            broken.then(|| zone_nm(now)).flatten()
        }
        (true, false) => {
            let share =
                now.expected_points.map(|expected| now.estimate.count as f64 / expected as f64);
            let share = share.filter(|share| now.estimate.is_complete() && *share <= 1.0);
            // What weights of all points will choose nobody knows; no pose leaves less than that of points that count
            // alike.
            share.map(|share| share.sqrt() * now.estimate.least_rms_nm())
        }
    };
    // Without an aperture nobody knows how much there is to come.
    let coverage = now.coverage.filter(|_| now.part.aperture != Aperture::None);
    let zone = (limit.zone != Aperture::None).then(|| Zone {
        coverage: seen.and_then(|seen| seen.coverage).unwrap_or(0.0),
        area: (limit.zone.area_mm2() / now.part.aperture.area_mm2()).min(1.0),
    });
    Running {
        value_nm,
        at_least_nm,
        u_nm: errors.map(|(u_nm, ..)| u_nm),
        dof: f64::INFINITY,
        raised,
        between_nm: seen.and_then(|seen| seen.between_nm),
        beyond_nm: seen.and_then(|seen| seen.beyond_nm),
        coverage: coverage.unwrap_or(0.0),
        zone,
        predicted: seen.and_then(|seen| seen.predicted.as_ref()),
    }
}

/// Whether anything is said of a limit before the end: those of PV and RMS, over a zone and with terms removed too.
pub(super) fn is_foreseen(limit: &Limit) -> bool {
    matches!(limit.definition, Definition::PeakToValley | Definition::RmsOverPoints)
}

fn figure_nm(definition: Definition, estimate: &LiveEstimate) -> f64 {
    match definition {
        Definition::PeakToValley => estimate.figures.pv_nm,
        _ => estimate.figures.rms_nm,
    }
}

fn blank(of: FigureName, limit: f64, coverage: Option<f64>) -> ProspectFigures {
    ProspectFigures {
        figure: of,
        limit,
        value: None,
        state: ProspectState::Open,
        at_least: None,
        pass_from_coverage: None,
        coverage,
        p: P,
        text: String::new(),
    }
}

fn at_end(of: FigureName, limit: f64, now: &Now<'_>) -> ProspectFigures {
    ProspectFigures {
        state: ProspectState::AtEnd,
        text: words::at_end(&of),
        ..blank(of, limit, now.coverage)
    }
}

fn guard(part: &Part) -> Guard {
    part.judging.guard.unwrap_or(Guard::None)
}

/// A lower bound of the minimum zone of the points, from a few hundred that lie farthest out.
fn zone_nm(now: &Now<'_>) -> Option<f64> {
    let fit = FitSettings {
        aperture: Aperture::None,
        start: now.estimate.pose,
        search: false,
        ..fit_settings(now.part)
    };
    let settings =
        ZoneSettings { fit, tolerance: ZONE_TOLERANCE, max_scans: 20, ..ZoneSettings::default() };
    let zone = minimum_zone(&(now.extremes)(), &now.estimate.nominal, &settings).ok()?;
    let complete = zone.least_squares.undetermined.iter().all(|one| one.by_shape);
    complete.then_some(1e6 * zone.certificate.lower_mm)
}

/// Mean squares in nm² of patches given as the number of their points and the sum of the squares. Those with less
/// than half as many points as the median have are left out: they are cut by the border of what is measured.
pub(super) fn patches_nm2(blocks: &[(f64, f64)]) -> Vec<f64> {
    let mut counts: Vec<f64> =
        blocks.iter().map(|(count, _)| *count).filter(|count| *count > 0.0).collect();
    counts.sort_by(f64::total_cmp);
    let Some(median) = counts.get(counts.len() / 2) else { return Vec::new() };
    let whole = blocks.iter().filter(|(count, _)| *count > 0.0 && 2.0 * count >= *median);
    whole.map(|(count, square)| square / count).collect()
}

/// The probability of a pass that is called certain.
pub(super) const P: f64 = 0.95;
/// Share of the zone by which the bound may fall short of it.
const ZONE_TOLERANCE: f64 = 1e-3;

#[cfg(test)]
mod early_pass_study;
#[cfg(test)]
mod tests;
#[cfg(test)]
pub(super) mod truth;
