//! What can be said of limits, in sentences.

use asphera_figures::Definition;
use asphera_form::Aperture;
use asphera_report::{FigureName, Outlook, ProspectFigures, ProspectState};
use asphera_uncertainty::verdict::{Guard, Limit, Running};

use super::{Now, P, guard};

/// Reason why a limit is open.
pub(super) struct Why<'a> {
    pub(super) limit: &'a Limit,
    pub(super) running: Running<'a>,
    pub(super) now: &'a Now<'a>,
}

impl Why<'_> {
    pub(super) fn is_open(&self, of: &FigureName) -> String {
        let Why { limit, running, now } = self;
        let (value_nm, limit_nm) = (running.value_nm, limit.value);
        let unsure = if guard(now.part) != Guard::None && running.u_nm.is_none() {
            Some("the guard band needs an uncertainty, and none is known yet")
        } else if !now.estimate.is_complete() {
            Some("the points do not determine the fit yet")
        } else {
            None
        };
        let name = of.words();
        if value_nm > limit_nm {
            let beyond = format!("{name} is {value_nm:.1} nm so far, {limit_nm} nm are allowed");
            let of_rms = limit.definition == Definition::RmsOverPoints;
            let why = unsure.unwrap_or(if of_rms && now.expected_points.is_none() {
                "how many points will come is not known"
            } else {
                "the fit of all points may still leave less"
            });
            return format!("{beyond}; {why}");
        }
        if let Some(why) = unsure {
            return why.to_owned();
        }
        match running.between_nm {
            _ if now.part.aperture == Aperture::None => {
                "without an aperture the rest is unknown: set [nominal.aperture]".to_owned()
            }
            _ if running.coverage == 0.0 => "the coverage is not known".to_owned(),
            _ if !now.part.criterion.is_plain() => {
                "points have weights, and the rest of the points will change them".to_owned()
            }
            None => "too few points to know what stands out between them".to_owned(),
            Some(nm) if value_nm + nm > limit_nm => format!(
                "{name} is {value_nm:.1} nm so far and {nm:.1} nm may stand out between the points, {limit_nm} nm \
                 are allowed"
            ),
            _ if running.predicted.is_none() || running.beyond_nm.is_none() => {
                "too few places are measured to foresee the rest".to_owned()
            }
            _ if running.coverage == 1.0 => {
                format!("{name} may still change by more than the room to its limit")
            }
            _ => format!("{name} is nearer to its limit than its guard band"),
        }
    }
}

pub(super) fn fail_is_certain(found: &ProspectFigures) -> String {
    let least = found.at_least.unwrap_or(found.limit);
    let (name, limit) = (found.figure.words(), found.limit);
    format!("fail is certain: {name} is at least {least:.1} nm in the end, {limit} nm are allowed")
}

pub(super) fn pass_is_certain() -> String {
    format!("on course: {} certain if the rest is like what is measured", percent(P))
}

pub(super) fn pass_from(from: f64, coverage: Option<f64>) -> String {
    let now = coverage.map_or(String::new(), |now| format!(", now {}", percent(now)));
    format!("on course: can be decided at {} coverage{now}", percent(from))
}

pub(super) fn at_end(of: &FigureName) -> String {
    format!("known at the end: {} is worked out from all points", of.words())
}

/// Outlook by all limits together: first whether there is a decision.
pub(super) fn outlook(limits: Vec<ProspectFigures>) -> Option<Outlook> {
    limits.first()?;
    let having = |state| limits.iter().filter(move |limit| limit.state == state);
    let text = |state| having(state).next().map(|limit| limit.text.clone());
    let later = having(ProspectState::PassFrom);
    let latest = later
        .filter_map(|limit| Some((limit.pass_from_coverage?, limit.coverage)))
        .max_by(|one, other| one.0.total_cmp(&other.0));
    let names: Vec<String> =
        having(ProspectState::AtEnd).map(|limit| limit.figure.words()).collect();
    let (state, text) = if let Some(text) = text(ProspectState::FailCertain) {
        (ProspectState::FailCertain, text.replacen("fail is certain", "FAIL is certain", 1))
    } else if let Some(text) = text(ProspectState::Open) {
        (ProspectState::Open, text.replacen("open: ", "No decision yet: ", 1))
    } else {
        let passes = match latest {
            Some((from, now)) => Some((ProspectState::PassFrom, pass_from(from, now))),
            None => text(ProspectState::PassCertain).map(|text| (ProspectState::PassCertain, text)),
        };
        let passes = passes.map(|(state, text)| (state, text.replacen("on course", ON_COURSE, 1)));
        // No more is certain of the part than of its last limit.
        let later =
            format!("No decision before the end: of all points comes {}.", names.join(", "));
        match passes {
            Some((state, text)) if names.is_empty() => (state, format!("No decision yet. {text}.")),
            Some((_, text)) => (ProspectState::AtEnd, format!("{later} {text}.")),
            None => (ProspectState::AtEnd, later),
        }
    };
    Some(Outlook { state, text, limits })
}

const ON_COURSE: &str = "On course for PASS";

/// To a tenth of a percent, and 100 % only where nothing is missing.
fn percent(share: f64) -> String {
    let shown = (1e3 * share).round() / 10.0;
    format!("{} %", if share < 1.0 { shown.min(99.9) } else { shown })
}
