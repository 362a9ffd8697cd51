//! What can be said of the limits while points still arrive: fail certain, pass certain from a coverage on, or open.
//!
//! The reasoning is that of `asphera_form::verdict`. What was certain once stays so: a bound of the final figure that
//! held for fewer points holds for more. It rests on these points staying in the fit, which they do unless the mesh
//! finds them above each other; then nothing is said.

use std::collections::BTreeMap;

use asphera_form::verdict::{
    Guard, GuardError, Prospect, RunningPv, RunningRms, pv_prospect, rms_prospect,
};
use asphera_form::{Aperture, FitSettings, LiveEstimate, ZoneSettings, minimum_zone};
use asphera_surface::PointMm;

use super::errors::ErrorsOfFigures;
use super::running::fit_settings;
use crate::config::Part;
use crate::report::{Outlook, ProspectFigures, ProspectState};

/// What was said so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Prospects {
    said: BTreeMap<&'static str, Said>,
}

/// Of one limit.
#[derive(Clone, Copy, Debug, Default)]
struct Said {
    /// The largest bound there was.
    at_least_nm: Option<f64>,
    fail_is_certain: bool,
}

/// What there is to go by.
pub(super) struct Now<'a> {
    pub(super) part: &'a Part,
    pub(super) estimate: &'a LiveEstimate,
    /// Points that hold the deviation at its worst.
    pub(super) extremes: &'a dyn Fn() -> Vec<PointMm>,
    pub(super) errors: Option<ErrorsOfFigures>,
    /// As of the last look.
    pub(super) coverage: Option<f64>,
    /// Points there will be, at most; `None` if nobody knows.
    pub(super) expected_points: Option<u64>,
    /// What puts the figures themselves in doubt.
    pub(super) doubt: Option<&'static str>,
}

impl Prospects {
    /// What can be said now; `None` where there is no limit.
    pub(super) fn look(&mut self, now: &Now<'_>) -> Option<Outlook> {
        let part = now.part;
        let mut limits = Vec::new();
        let whole = [(PV, part.pv_nm), (RMS, part.rms_nm)];
        for (name, limit_nm) in whole.into_iter().filter_map(|(name, nm)| Some((name, nm?))) {
            limits.push(self.of_whole(name, limit_nm, now));
        }
        for (name, limit) in &part.judging.limits {
            limits.push(ProspectFigures {
                name: name.clone(),
                limit: limit.value,
                value: None,
                state: ProspectState::Open,
                at_least: None,
                pass_from_coverage: None,
                coverage: now.coverage,
                p: P,
                text: "open: this figure is worked out at the end".to_owned(),
            });
        }
        outlook(limits)
    }

    fn of_whole(&mut self, name: &'static str, limit_nm: f64, now: &Now<'_>) -> ProspectFigures {
        let figures = &now.estimate.figures;
        let value = if name == PV { figures.pv_nm } else { figures.rms_nm };
        let mut found = ProspectFigures {
            name: name.to_owned(),
            limit: limit_nm,
            value: Some(value),
            state: ProspectState::Open,
            at_least: None,
            pass_from_coverage: None,
            coverage: now.coverage,
            p: P,
            text: String::new(),
        };
        if let Some(doubt) = now.doubt {
            found.text = format!("open: {doubt}");
            return found;
        }
        // A guard band that is none was refused with the nominal file.
        let said = self.said.entry(name).or_default();
        let prospect = match name {
            PV => pv(limit_nm, said.fail_is_certain, now),
            _ => rms(limit_nm, now),
        };
        let Ok(prospect) = prospect else { return found };
        said.at_least_nm = match (said.at_least_nm, prospect.at_least_nm) {
            (Some(before), Some(now)) => Some(before.max(now)),
            (before, now) => before.or(now),
        };
        said.fail_is_certain |= prospect.fail_is_certain;
        found.at_least = said.at_least_nm;
        if said.fail_is_certain {
            found.state = ProspectState::FailCertain;
            let least = found.at_least.unwrap_or(value);
            found.text = format!(
                "fail is certain: {} is at least {least:.1} nm in the end, {limit_nm} nm are allowed",
                words(name)
            );
            return found;
        }
        let from = prospect.pass_from_coverage.map(|from| from.max(now.part.coverage_min));
        found.pass_from_coverage = from.filter(|_| now.coverage.is_some());
        match (found.pass_from_coverage, now.coverage) {
            (Some(from), Some(coverage)) if coverage >= from => {
                found.state = ProspectState::PassCertain;
                found.text = format!(
                    "pass is certain at {} if the rest is like what is measured",
                    percent(P)
                );
            }
            (Some(from), Some(coverage)) => {
                found.state = ProspectState::PassFrom;
                found.text = format!(
                    "pass is certain at {} from {} coverage on, now {}",
                    percent(P),
                    percent(from),
                    percent(coverage)
                );
            }
            _ => found.text = format!("open: {}", why_open(name, value, limit_nm, now)),
        }
        found
    }
}

fn guard(part: &Part) -> Guard {
    part.judging.guard.unwrap_or(Guard::None)
}

fn rms(limit_nm: f64, now: &Now<'_>) -> Result<Prospect, GuardError> {
    let estimate = now.estimate;
    // Only a budget takes the noise off.
    let budget = now.part.judging.uncertainty.is_some();
    let noise_nm = now.errors.filter(|_| budget).map_or(0.0, |errors| errors.noise.noise_nm);
    let running = RunningRms {
        rms_nm: estimate.figures.rms_nm,
        u_nm: now.errors.map(|errors| errors.u_rms_nm),
        dof: f64::INFINITY,
        noise_nm,
        complete: estimate.is_complete(),
        share: now.expected_points.map(|expected| estimate.count as f64 / expected as f64),
        coverage: known_coverage(now).unwrap_or(0.0),
        patches_nm2: &of_cells(estimate),
    };
    let found = rms_prospect(&running, limit_nm, guard(now.part), P)?;
    if estimate.weights.is_none() {
        return Ok(found);
    }
    // What the weights of all points will choose nobody knows; no pose leaves less than that of points that count alike.
    let least = RunningRms { rms_nm: estimate.least_rms_nm(), ..running };
    let bound = rms_prospect(&least, limit_nm, guard(now.part), P)?;
    Ok(Prospect { pass_from_coverage: found.pass_from_coverage, ..bound })
}

/// `is_certain`: of a fail that was told before no better bound is looked for.
fn pv(limit_nm: f64, is_certain: bool, now: &Now<'_>) -> Result<Prospect, GuardError> {
    let figures = &now.estimate.figures;
    let budget = now.part.judging.uncertainty.is_some();
    // No bound of a PV that is within its limit can break it.
    let broken = figures.pv_nm > limit_nm && now.estimate.is_complete() && !is_certain;
    let bias_nm =
        now.errors.filter(|_| budget).map_or(0.0, |errors| errors.noise.pv_bias_at_most_nm);
    let running = RunningPv {
        pv_nm: figures.pv_nm,
        u_nm: now.errors.map(|errors| errors.u_pv_nm),
        bias_nm,
        dof: f64::INFINITY,
        zone_nm: broken.then(|| zone_nm(now)).flatten(),
        coverage: known_coverage(now).unwrap_or(0.0),
    };
    pv_prospect(&running, limit_nm, guard(now.part), P)
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

/// Without an aperture nobody knows how much there is to come.
fn known_coverage(now: &Now<'_>) -> Option<f64> {
    now.coverage.filter(|_| now.part.aperture != Aperture::None)
}

fn why_open(name: &str, value: f64, limit_nm: f64, now: &Now<'_>) -> String {
    let unsure = if guard(now.part) != Guard::None && now.errors.is_none() {
        Some("the guard band needs an uncertainty, and none is known yet".to_owned())
    } else if !now.estimate.is_complete() {
        Some("the points do not determine the fit yet".to_owned())
    } else {
        None
    };
    if value > limit_nm {
        let beyond = format!("{} is {value:.1} nm so far, {limit_nm} nm are allowed", words(name));
        let why = unsure.unwrap_or_else(|| match (name, now.expected_points) {
            (RMS, None) => "how many points will come is not known".to_owned(),
            _ => "the fit of all points may still leave less".to_owned(),
        });
        return format!("{beyond}; {why}");
    }
    unsure.unwrap_or_else(|| {
        if now.part.aperture == Aperture::None {
            "without an aperture nobody knows how much is to come".to_owned()
        } else if now.coverage.is_none() {
            "the coverage is not known".to_owned()
        } else {
            format!("{} is too near to its limit, or too few places are measured", words(name))
        }
    })
}

/// The mean square of blocks of the cells of the running map, in nm².
fn of_cells(estimate: &LiveEstimate) -> Vec<f64> {
    let map = &estimate.map;
    let columns = map.grid.nx.div_ceil(BLOCK);
    let mut blocks = vec![(0.0, 0.0); columns * map.grid.ny.div_ceil(BLOCK)];
    for (cell, (&square_nm2, &count)) in
        estimate.mean_squares_nm2.iter().zip(&map.counts).enumerate()
    {
        if count > 0 {
            let block = cell / map.grid.nx / BLOCK * columns + cell % map.grid.nx / BLOCK;
            blocks[block].0 += count as f64;
            blocks[block].1 += count as f64 * square_nm2;
        }
    }
    patches_nm2(&blocks)
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

/// What all limits say together.
fn outlook(limits: Vec<ProspectFigures>) -> Option<Outlook> {
    let states = || limits.iter().map(|limit| limit.state);
    let text = |state| {
        let found = limits.iter().find(|limit| limit.state == state);
        found.map(|limit| limit.text.clone()).unwrap_or_default()
    };
    let from = limits.iter().filter_map(|limit| limit.pass_from_coverage).fold(0.0, f64::max);
    limits.first()?;
    let (state, text) = if states().any(|state| state == ProspectState::FailCertain) {
        (ProspectState::FailCertain, text(ProspectState::FailCertain))
    } else if states().any(|state| state == ProspectState::Open) {
        (ProspectState::Open, text(ProspectState::Open))
    } else if states().all(|state| state == ProspectState::PassCertain) {
        (ProspectState::PassCertain, text(ProspectState::PassCertain))
    } else {
        let now = limits[0].coverage.map_or(String::new(), |now| format!(", now {}", percent(now)));
        let text =
            format!("pass is certain at {} from {} coverage on{now}", percent(P), percent(from));
        (ProspectState::PassFrom, text)
    };
    Some(Outlook { state, text, limits })
}

/// `pv_nm` as `PV`.
fn words(name: &str) -> String {
    name.trim_end_matches("_nm").to_uppercase()
}

/// To a tenth of a percent, and 100 % only where nothing is missing.
fn percent(share: f64) -> String {
    let shown = (1e3 * share).round() / 10.0;
    format!("{} %", if share < 1.0 { shown.min(99.9) } else { shown })
}

const PV: &str = "pv_nm";
const RMS: &str = "rms_nm";
/// The probability of a pass that is called certain.
pub(super) const P: f64 = 0.95;
/// Cells of a patch along either side.
const BLOCK: usize = 8;
/// Share of the zone by which the bound may fall short of it.
const ZONE_TOLERANCE: f64 = 1e-3;

#[cfg(test)]
mod tests;
