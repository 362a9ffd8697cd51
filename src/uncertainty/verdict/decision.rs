//! Whether a figure proves that a limit holds or is broken, its uncertainty regarded.
//!
//! ISO 14253-1:2017, clauses 4 and 5: the acceptance zone is the tolerance less a guard band, the rejection zone begins
//! a guard band beyond it; between them neither is proven.

use std::fmt;

use thiserror::Error;

use super::status::Status;
use crate::{MeanSquare, student_quantile};

/// The decision rule: how wide the guard band is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Guard {
    /// None: the uncertainty is not regarded.
    None,
    /// A multiple k of the standard uncertainty. ISO 14253-1:1998 took 2.
    Factor(f64),
    /// As wide as conformity, or nonconformity, needs to have at least this probability, above 0.5 and below 1: one
    /// limit of Student's distribution. ISO 14253-1:2017 takes 0.95 where nothing is agreed, 1.645·u.
    Probability(f64),
}

/// A guard band that is none.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum GuardError {
    /// A factor below zero or not finite.
    #[error("guard factor is {found}, expected a finite number not below 0 such as 2")]
    Factor {
        /// The factor.
        found: f64,
    },
    /// A probability that proves nothing.
    #[error("guard probability is {found}, expected above 0.5 and below 1 such as 0.95")]
    Probability {
        /// The probability.
        found: f64,
    },
}

impl Default for Guard {
    /// 95 %: what ISO 14253-1:2017 takes where nothing is agreed.
    fn default() -> Guard {
        Guard::Probability(0.95)
    }
}

impl Guard {
    /// Fails unless the factor is not negative, or the probability above one half and below 1.
    pub fn validate(&self) -> Result<(), GuardError> {
        match *self {
            Guard::Factor(found) if !(found.is_finite() && found >= 0.0) => {
                Err(GuardError::Factor { found })
            }
            Guard::Probability(found) if !(found > 0.5 && found < 1.0) => {
                Err(GuardError::Probability { found })
            }
            _ => Ok(()),
        }
    }

    /// Guard band over standard uncertainty, for an uncertainty known with `dof` degrees of freedom.
    pub fn factor(&self, dof: f64) -> f64 {
        match *self {
            Guard::None => 0.0,
            Guard::Factor(k) => k,
            Guard::Probability(p) => student_quantile(p, dof),
        }
    }
}

/// As reports name the rule.
impl fmt::Display for Guard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Guard::None => f.write_str("no guard band"),
            Guard::Factor(k) => write!(f, "guard band {k}·u"),
            Guard::Probability(p) => {
                write!(f, "guard band for {} % (ISO 14253-1:2017)", (p * 1e6).round() / 1e4)
            }
        }
    }
}

/// A figure as found, with what is known of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    /// Its value.
    pub value: f64,
    /// Its standard uncertainty; `None` if it is not known.
    pub u: Option<f64>,
    /// Degrees of freedom of `u`, infinite if it is certain.
    pub dof: f64,
    /// What noise, and the places of the points, have added to the value. It is taken off before a limit is called broken, but
    /// not before it is called kept, for it is an estimate and the limit is for the figure as defined. Where it is below 0,
    /// for places that make the value too small, it is added before a limit is called kept.
    pub bias: f64,
    /// The most that what is not measured can add; `None` if that is not known. A limit can then be broken, but not
    /// kept.
    pub hidden: Option<f64>,
    /// Whether it averages over the area, so that `bias` is all that moved it.
    pub is_average: bool,
    /// The mean square it is the root of, of an average of squares: near nothing its interval is not the same to either side.
    pub square: Option<MeanSquare>,
}

impl Finding {
    /// A figure without an uncertainty.
    pub fn of_value(value: f64) -> Finding {
        let dof = f64::INFINITY;
        Finding { value, u: None, dof, bias: 0.0, hidden: None, is_average: false, square: None }
    }

    /// The value less what noise and places have added to it.
    pub fn left(&self) -> f64 {
        self.value - self.bias
    }

    /// The same with an error that all points have together: `u` is its standard uncertainty of the figure, taken as certain, and
    /// independent of all else.
    #[must_use]
    pub fn with_systematic(self, u: f64) -> Finding {
        let Some(own) = self.u else { return self };
        let square = self.square.map(|square| square.with_systematic(u));
        // Welch and Satterthwaite (JCGM 100:2008, G.4); of an average of squares near nothing u is less than the sum.
        let dof =
            if own > 0.0 { self.dof * (1.0 + (u / own).powi(2)).powi(2) } else { f64::INFINITY };
        let u = square.map_or(own.hypot(u), |square| square.u());
        Finding { u: Some(u), dof: if u > 0.0 { dof } else { self.dof }, square, ..self }
    }

    /// An interval that holds the figure of the part, without noise and over the area, with probability `p`, above 0 and below
    /// 1; never below 0, as no figure that has a limit is. `None` without an uncertainty, and of what is no average.
    pub fn interval(&self, p: f64) -> Option<[f64; 2]> {
        if !self.is_average {
            return None;
        }
        let k = student_quantile(0.5 + 0.5 * p, self.dof);
        let half = k * self.u?;
        if let Some(square) = self.square {
            return Some(square.interval(k));
        }
        Some([(self.left() - half).max(0.0), self.left() + half])
    }
}

/// Proof that a figure gives of its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decision {
    /// Pass if the limit is proven to hold, fail if it is proven to be broken.
    pub status: Status,
    /// The largest value allowed.
    pub limit: f64,
    /// The figure.
    pub finding: Finding,
    /// The rule.
    pub guard: Guard,
    /// Guard band over standard uncertainty.
    pub k: f64,
    /// Width of the guard band, in the unit of the figure; `None` without an uncertainty.
    pub band: Option<f64>,
    /// Why it is undecided; `None` if it is not.
    pub doubt: Option<Doubt>,
}

/// Why neither is proven.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doubt {
    /// The figure lies within a guard band of its limit.
    WithinGuardBand,
    /// The rule needs an uncertainty, and there is none.
    NoUncertainty,
    /// The limit would hold, but what is not measured might break it.
    Unmeasured,
    /// A number is NaN.
    NotANumber,
}

/// A sentence fragment for a report.
impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Doubt::WithinGuardBand => "the figure is nearer to its limit than its guard band",
            Doubt::NoUncertainty => "the guard band needs an uncertainty, and none is known",
            Doubt::Unmeasured => "places that are not measured might break the limit",
            Doubt::NotANumber => "a limit or a figure is not a number",
        })
    }
}

/// Holds a figure against the largest value allowed. With g = k·u it passes if value + hidden + g ≤ limit, and fails if
/// value − bias − g > limit; a bias below 0 counts in the first in place of the second.
pub fn decide(finding: &Finding, limit: f64, guard: Guard) -> Result<Decision, GuardError> {
    guard.validate()?;
    let k = guard.factor(finding.dof);
    let band = if guard == Guard::None { Some(0.0) } else { finding.u.map(|u| k * u) };
    let (status, doubt) = outcome(finding, limit, band);
    Ok(Decision { status, limit, finding: *finding, guard, k, band, doubt })
}

fn outcome(finding: &Finding, limit: f64, band: Option<f64>) -> (Status, Option<Doubt>) {
    let undecided = |doubt| (Status::Undecided, Some(doubt));
    let Some(band) = band else { return undecided(Doubt::NoUncertainty) };
    let low = finding.value - finding.bias.max(0.0) - band;
    let high = finding.value - finding.bias.min(0.0) + band;
    if limit.is_nan() || low.is_nan() || high.is_nan() {
        return undecided(Doubt::NotANumber);
    }
    if low > limit {
        return (Status::Fail, None);
    }
    if high > limit {
        return undecided(Doubt::WithinGuardBand);
    }
    match finding.hidden {
        Some(hidden) if high + hidden <= limit => (Status::Pass, None),
        _ => undecided(Doubt::Unmeasured),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(value: f64, u: Option<f64>) -> Finding {
        Finding { u, hidden: Some(0.0), ..Finding::of_value(value) }
    }

    fn status(finding: &Finding, guard: Guard) -> (Status, Option<Doubt>) {
        let decision = decide(finding, 100.0, guard).unwrap();
        (decision.status, decision.doubt)
    }

    #[test]
    fn the_guard_band_lies_on_both_sides_of_the_limit() {
        let guard = Guard::Factor(2.0);
        let pass = (Status::Pass, None);
        let fail = (Status::Fail, None);
        let between = (Status::Undecided, Some(Doubt::WithinGuardBand));
        for (value, expected) in
            [(89.9, pass), (90.0, pass), (90.1, between), (110.0, between), (110.1, fail)]
        {
            assert_eq!(status(&found(value, Some(5.0)), guard), expected, "{value}");
        }
        assert_eq!(status(&found(99.9, Some(5.0)), Guard::None), pass);
        assert_eq!(status(&found(100.1, None), Guard::None), fail);
        let unknown = (Status::Undecided, Some(Doubt::NoUncertainty));
        assert_eq!(status(&found(1.0, None), guard), unknown);
        let nan = (Status::Undecided, Some(Doubt::NotANumber));
        assert_eq!(status(&found(f64::NAN, Some(1.0)), guard), nan);
    }

    #[test]
    fn what_is_hidden_forbids_a_pass_and_a_bias_a_fail() {
        let hidden = |hidden| Finding { hidden, ..found(80.0, Some(5.0)) };
        let guard = Guard::Factor(2.0);
        assert_eq!(status(&hidden(Some(10.0)), guard).0, Status::Pass);
        let unmeasured = (Status::Undecided, Some(Doubt::Unmeasured));
        assert_eq!(status(&hidden(Some(10.1)), guard), unmeasured);
        assert_eq!(status(&hidden(None), guard), unmeasured);
        let over = Finding { hidden: None, ..found(120.0, Some(5.0)) };
        assert_eq!(status(&over, guard).0, Status::Fail);
        assert_eq!(status(&Finding { bias: 10.0, ..over }, guard).0, Status::Undecided);
    }

    #[test]
    fn factors_are_one_sided_and_named() {
        let guard = Guard::default();
        assert!((guard.factor(f64::INFINITY) - 1.644_853_627).abs() < 1e-9);
        assert!((guard.factor(7.0) - 1.894_578_605).abs() < 1e-9);
        assert_eq!(guard.to_string(), "guard band for 95 % (ISO 14253-1:2017)");
        assert_eq!(Guard::Factor(2.0).to_string(), "guard band 2·u");
        for bad in [Guard::Factor(-1.0), Guard::Probability(0.5), Guard::Probability(f64::NAN)] {
            assert!(decide(&found(1.0, None), 1.0, bad).is_err());
        }
    }
}
