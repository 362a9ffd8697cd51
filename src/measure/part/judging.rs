//! Limits beyond PV and RMS, the decision rule, and the error budget.

use asphera_figures::{Definition, Indication};
use asphera_uncertainty::verdict::{Guard, Limit};
use asphera_uncertainty::{Budget, Draws};

/// Correlation of errors that uncertainties of pose and parameters count.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CorrelationFrom {
    /// None: what is correlated in the deviations is form of this part, and no error.
    Nothing,
    /// That of the budget, its long wave.
    #[default]
    Budget,
    /// That of the deviations, as they are.
    Deviations,
}

/// Limits of a part, and how they are held.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judging {
    /// Limits of figures of the deviation: of the whole, of zones, and with terms removed.
    pub limits: Vec<Limit>,
    /// The decision rule; `None`: values are held against limits as they are.
    pub guard: Option<Guard>,
    /// Indication of a drawing by ISO 10110-5; its limits are among [`Judging::limits`].
    pub indication: Option<Indication>,
    /// Limits of figures that are made of more than deviations ([`Definition::AT_END`]), in their units.
    pub standards: Vec<(Definition, f64)>,
    /// The errors of the points, and how many measurements are simulated. Where none are stated, those of the noise
    /// alone, as the points tell it, if a guard band needs them.
    pub uncertainty: Option<(Budget, Draws)>,
    /// Correlated errors that uncertainties of pose and parameters count.
    pub correlated: CorrelationFrom,
}

impl Judging {
    /// Whether there is a limit of anything.
    pub fn has_limits(&self) -> bool {
        !self.limits.is_empty() || !self.standards.is_empty()
    }

    /// The largest PV of the whole deviation allowed, nm; `None` without such a limit.
    pub fn pv_limit_nm(&self) -> Option<f64> {
        let of_whole = |limit: f64| Limit::of_whole(Definition::PeakToValley, limit);
        self.limits
            .iter()
            .map(|limit| limit.value)
            .zip(&self.limits)
            .find_map(|(value, limit)| (*limit == of_whole(value)).then_some(value))
    }
}
