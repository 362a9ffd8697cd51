//! Uncertainties with the contributions of systematic errors in them.

use std::collections::BTreeMap;

use asphera_report::{
    CovarianceFigures, ParameterFigures, SimulatedFigures, SystematicFigures, UncertaintyFigures,
};

use super::Contributions;
use crate::fit_details;
use crate::judged::AllJudged;

impl Contributions {
    /// The uncertainties of a PV and of the RMS with them.
    pub(crate) fn with_heights(&self, known: UncertaintyFigures, pv_nm: f64) -> UncertaintyFigures {
        if !self.is_counted() {
            return known;
        }
        let [u_pv_nm, u_rms_nm] = self.heights_nm();
        UncertaintyFigures {
            u_pv_nm: known.u_pv_nm.hypot(u_pv_nm),
            pv_95_nm: wider(known.pv_95_nm, pv_nm, u_pv_nm),
            pv_covers: covering(&known.pv_covers),
            u_rms_nm: known.u_rms_nm.hypot(u_rms_nm),
            rms_95_nm: wider(known.rms_95_nm, known.rms_without_noise_nm, u_rms_nm),
            rms_covers: covering(&known.rms_covers),
            ..known
        }
    }

    /// Counts them in what was found of limits. Where a contribution is not known, neither is the uncertainty.
    pub(crate) fn count_limits(&self, all: &mut AllJudged<'_>) {
        if !self.is_counted() {
            return;
        }
        for one in all.iter_mut().flatten() {
            let Ok(found) = &mut one.found else { continue };
            *found = match self.limit(&one.limit.name()) {
                Some(u) => found.with_systematic(u),
                None => asphera_uncertainty::verdict::Finding { u: None, ..*found },
            };
            one.covers = one.covers.as_deref().map(covering);
        }
    }

    /// Counts an upper bound of them in a simulated figure of the deviations in nm.
    pub(crate) fn count_simulated(
        &self,
        (value, u): (f64, f64),
        simulated: &mut SimulatedFigures,
        at_most_nm: f64,
    ) -> f64 {
        if !self.is_counted() {
            return u;
        }
        let [low, high] = wider([simulated.low, simulated.high], value, at_most_nm);
        (simulated.low, simulated.high) = (low, high);
        simulated.covers = covering(&simulated.covers);
        u.hypot(at_most_nm)
    }

    /// Counts them in the uncertainties of pose and shape.
    pub(crate) fn count_parameters(
        &self,
        parameters: &mut BTreeMap<String, ParameterFigures>,
        covariance: Option<&mut CovarianceFigures>,
        covers: &mut Option<String>,
    ) {
        if !self.is_counted() {
            return;
        }
        for (name, u) in self.parameters() {
            let Some(figures) = parameters.get_mut(name) else { continue };
            figures.u = figures.u.map(|own| own.hypot(u));
            figures.expanded_95 = figures.expanded_95.map(|half| half.hypot(NORMAL * u));
        }
        if let Some(covariance) = covariance {
            fit_details::add(covariance, &self.covariance());
        }
        *covers = covers.as_deref().map(covering);
    }
}

/// An interval of 95 % about a value, wider by an independent error. It stays above 0, as sizes do.
fn wider([low, high]: [f64; 2], value: f64, u: f64) -> [f64; 2] {
    let about = value.clamp(low, high.max(low));
    let half = NORMAL * u;
    [(about - (about - low).hypot(half)).max(0.0), about + (high - about).hypot(half)]
}

/// The scope of an uncertainty, with systematic errors in it.
fn covering(scope: &str) -> String {
    format!("{scope}; {}", SystematicFigures::COVERED)
}

/// Half width of an interval of 95 % over the standard uncertainty.
const NORMAL: f64 = 1.959_963_984_540_054;
