//! What each systematic error adds to the uncertainties of a measurement.

use std::collections::{BTreeMap, BTreeSet};

use asphera_figures::{Definition, Statistic};
use asphera_form::{Covariance, NM_PER_MM, Nominal, Parameter};
use asphera_geometry::vector::Vector;
use asphera_report::SystematicFigures;
use asphera_report::systematic::ContributionFigures;

use super::refit::{Refit, Refitted};
use super::{Effect, Moving, Systematic};

/// Contributions of all sources.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contributions {
    all: Vec<Contribution>,
    /// Names and units of the parameters, in the order of their changes.
    parameters: Vec<(String, String)>,
}

/// Contributions of one source, or why there are none.
#[derive(Clone, Debug)]
struct Contribution {
    source: String,
    /// One entry an error of the source.
    found: Result<Vec<Change>, String>,
}

/// Changes by one standard uncertainty; all but those of the parameters are sizes.
#[derive(Clone, Debug)]
struct Change {
    pv_nm: f64,
    rms_nm: f64,
    /// Range and RMS of the change of the deviations: no figure changes by more.
    deviations_nm: [f64; 2],
    limits: BTreeMap<String, f64>,
    /// Half the difference of both sides, with its sign.
    parameters: Vec<f64>,
}

impl Contributions {
    /// Moves the points of a measurement by every source. Two fits a source, and one.
    pub(crate) fn new(all: &[Systematic], moving: Moving<'_>) -> Contributions {
        if all.is_empty() {
            return Contributions::default();
        }
        let refit = Refit::new(moving);
        let still = refit.figures(0.0, &vec![[0.0; 3]; refit.points.len()]);
        let found = |effect: &Effect| match effect {
            Effect::Unknown(why) => Err(why.clone()),
            _ => {
                let moved = still.as_ref().and_then(|still| changes(&refit, still, effect));
                moved.ok_or_else(|| NO_FIT.to_owned())
            }
        };
        let contribution =
            |of: &Systematic| Contribution { source: of.source.clone(), found: found(&of.effect) };
        let estimates = still.as_ref().map_or(&[][..], |still| &still.estimates);
        let base = moving.fitted.reference.as_ref().map(|reference| &reference.base_fit);
        let nominal = &base.unwrap_or(&moving.fitted.fit).nominal;
        let parameters = estimates.iter().map(|one| named(one.parameter, nominal));
        Contributions {
            parameters: parameters.collect(),
            all: all.iter().map(contribution).collect(),
        }
    }

    /// Of a measurement whose figures count none of them, and why.
    pub(crate) fn none(all: &[Systematic], why: &str) -> Contributions {
        let contribution = |of: &Systematic| {
            let why = match &of.effect {
                Effect::Unknown(why) => why,
                _ => why,
            };
            Contribution { source: of.source.clone(), found: Err(why.to_owned()) }
        };
        Contributions { all: all.iter().map(contribution).collect(), parameters: Vec::new() }
    }

    /// Whether any source is counted.
    pub(crate) fn is_counted(&self) -> bool {
        self.changes().next().is_some()
    }

    fn changes(&self) -> impl Iterator<Item = &Change> + Clone {
        self.all.iter().filter_map(|one| one.found.as_ref().ok()).flatten()
    }

    /// Standard uncertainties of PV and RMS by all sources, nm.
    pub(super) fn heights_nm(&self) -> [f64; 2] {
        heights_nm(self.changes())
    }

    /// The same of a figure that has a limit, by its name; `None` where it is not known of a source.
    pub(super) fn limit(&self, name: &str) -> Option<f64> {
        limit(self.changes(), name)
    }

    /// An upper bound of it for a figure of the deviations in nm: ranges change by the range of the change at most, averages by its
    /// RMS.
    pub(crate) fn at_most_nm(&self, definition: Definition) -> f64 {
        let which = usize::from(definition.statistic() != Statistic::Extreme);
        root_sum(self.changes().map(|of| of.deviations_nm[which]))
    }

    /// Standard uncertainties of the parameters by all sources, by name.
    pub(super) fn parameters(&self) -> impl Iterator<Item = (&str, f64)> {
        let u = |index: usize| root_sum(self.changes().map(move |of| of.parameters[index]));
        self.parameters.iter().enumerate().map(move |(index, (name, _))| (&name[..], u(index)))
    }

    /// Covariances of the parameters by all sources, in their order.
    pub(super) fn covariance(&self) -> Covariance {
        let size = self.parameters.len();
        let entry = |at: usize| {
            let of = |change: &Change| change.parameters[at % size] * change.parameters[at / size];
            self.changes().map(of).sum::<f64>()
        };
        let entries: Vec<f64> = (0..size * size).map(entry).collect();
        Covariance::new(size, &entries, 1.0)
    }

    /// As reports list them.
    pub(crate) fn figures(&self) -> Vec<SystematicFigures> {
        let figures = |one: &Contribution| match &one.found {
            Err(why) => SystematicFigures::not_counted(&one.source, why),
            Ok(changes) => self.listed(&one.source, changes),
        };
        self.all.iter().map(figures).collect()
    }

    fn listed(&self, source: &str, changes: &[Change]) -> SystematicFigures {
        let [u_pv_nm, u_rms_nm] = heights_nm(changes.iter());
        let names: BTreeSet<&String> = changes.iter().flat_map(|of| of.limits.keys()).collect();
        let limits = names.into_iter().filter_map(|name| {
            let u = limit(changes.iter(), name)?;
            Some((name.clone(), u))
        });
        let of_parameter = |(index, (name, unit)): (usize, &(String, String))| {
            let u = root_sum(changes.iter().map(|of| of.parameters[index]));
            (name.clone(), ContributionFigures { u, unit: unit.clone() })
        };
        SystematicFigures {
            source: source.to_owned(),
            u_pv_nm: Some(u_pv_nm),
            u_rms_nm: Some(u_rms_nm),
            limits: limits.collect(),
            parameters: self.parameters.iter().enumerate().map(of_parameter).collect(),
            not_counted: None,
        }
    }
}

fn heights_nm<'a>(changes: impl Iterator<Item = &'a Change> + Clone) -> [f64; 2] {
    [root_sum(changes.clone().map(|of| of.pv_nm)), root_sum(changes.map(|of| of.rms_nm))]
}

fn limit<'a>(changes: impl Iterator<Item = &'a Change>, name: &str) -> Option<f64> {
    let all: Option<Vec<f64>> = changes.map(|of| of.limits.get(name).copied()).collect();
    all.map(|all| root_sum(all.into_iter()))
}

/// Changes of the figures by each error of a source; `None` where one is not known.
fn changes(refit: &Refit<'_>, still: &Refitted, effect: &Effect) -> Option<Vec<Change>> {
    let errors = refit.displacements_mm(effect)?;
    errors.iter().map(|by_mm| change(refit, still, by_mm)).collect()
}

/// Changes of the figures by one error; `None` where the moved points have no fit.
fn change(refit: &Refit<'_>, still: &Refitted, by_mm: &[Vector]) -> Option<Change> {
    if by_mm.iter().flatten().all(|mm| *mm == 0.0) {
        return Some(Change {
            pv_nm: 0.0,
            rms_nm: 0.0,
            deviations_nm: [0.0; 2],
            limits: still.limits.keys().map(|name| (name.clone(), 0.0)).collect(),
            parameters: vec![0.0; still.estimates.len()],
        });
    }
    let sides = [refit.figures(1.0, by_mm)?, refit.figures(-1.0, by_mm)?];
    let same = |side: &Refitted| side.estimates.len() == still.estimates.len();
    if !sides.iter().all(same) {
        return None;
    }
    let larger = |of: &dyn Fn(&Refitted) -> f64| {
        sides.iter().map(|side| (of(side) - of(still)).abs()).fold(0.0, f64::max)
    };
    let limits = still.limits.keys().filter(|name| {
        // A figure that is not formed of a side is not known.
        sides.iter().all(|side| side.limits.contains_key(*name))
    });
    let limits = limits.map(|name| (name.clone(), larger(&|of| of.limits[name])));
    let ranges: Vec<[f64; 2]> = sides.iter().map(|side| spread_nm(side, still)).collect();
    let [above, below] = &sides;
    let pairs = above.estimates.iter().zip(&below.estimates);
    Some(Change {
        pv_nm: larger(&|of| of.pv_nm),
        rms_nm: larger(&|of| of.rms_nm),
        deviations_nm: [0, 1].map(|which| ranges.iter().map(|of| of[which]).fold(0.0, f64::max)),
        limits: limits.collect(),
        parameters: pairs.map(|(above, below)| 0.5 * (above.value - below.value)).collect(),
    })
}

/// Range and RMS of the change of the deviations, nm.
fn spread_nm(side: &Refitted, still: &Refitted) -> [f64; 2] {
    let pairs = || side.deviations_mm.iter().zip(&still.deviations_mm);
    let changes = || pairs().map(|(moved, still)| NM_PER_MM * (moved - still));
    let [low, high] = changes()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], nm| [low.min(nm), high.max(nm)]);
    let square: f64 = changes().map(|nm| nm * nm).sum();
    [high - low, (square / side.deviations_mm.len() as f64).sqrt()]
}

fn named(parameter: Parameter, nominal: &Nominal) -> (String, String) {
    (parameter.name(nominal), parameter.unit(nominal).unwrap_or_default())
}

fn root_sum(all: impl Iterator<Item = f64>) -> f64 {
    all.map(|one| one * one).sum::<f64>().sqrt()
}

const NO_FIT: &str = "the points moved by it have no fit";
