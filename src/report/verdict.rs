//! The verdict and the limits it stands on.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{FigureName, Outlook};

/// Whether the part is good.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// The answer.
    pub status: Status,
    /// The limits and the values held against them.
    pub checks: Vec<Check>,
    /// Why it is undecided, or what a reader must know beside the answer.
    pub reasons: Vec<String>,
    /// In a snapshot while points arrive: what can already be said. Never in a report.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outlook: Option<Outlook>,
}

/// The answer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Every limit holds.
    Pass,
    /// A limit is broken.
    Fail,
    /// There is no answer; [`Verdict::reasons`] says why.
    #[default]
    Undecided,
    /// Nothing was asked: no limits are given.
    None,
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Status::Pass => "pass",
            Status::Fail => "fail",
            Status::Undecided => "undecided",
            Status::None => "none",
        })
    }
}

/// One limit and the value held against it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// Which figure, of what.
    #[serde(flatten)]
    pub figure: FigureName,
    /// The largest value allowed.
    pub limit: f64,
    /// The value found.
    pub value: f64,
    /// Whether it holds; with a guard band, whether that is proven.
    pub ok: bool,
    /// Standard uncertainty (k = 1) of the value; absent where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
    /// Scope of `u`, in words; absent without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_covers: Option<String>,
    /// 95 % interval of the figure of the part, without noise and over the area; scope as of `u`. Absent of what does not average
    /// over the area.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval_95: Option<[f64; 2]>,
    /// Width of the guard band on either side of the limit; absent without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guard_band: Option<f64>,
    /// The decision rule in words; absent without a guard band.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rule: Option<String>,
    /// Amount that the unmeasured part of the aperture may add to the value, at the probability of
    /// [`UnmeasuredFigures::p`](crate::UnmeasuredFigures::p); absent where that is not known, and for slopes, of which it is not told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hidden: Option<f64>,
    /// Why neither is proven, in words; absent where it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubt: Option<String>,
}

impl Check {
    /// Whether the limit is certainly broken: by more than the guard band, where there is one, and what noise and places
    /// have added. What neither holds nor is broken is not proven.
    pub fn is_broken(&self) -> bool {
        let beyond = self.value > self.limit + self.guard_band.unwrap_or(0.0);
        !self.ok && self.doubt.is_none() && beyond
    }
}

#[cfg(test)]
mod tests {
    use super::{Check, FigureName};

    #[test]
    fn within_the_guard_band_a_limit_neither_holds_nor_is_broken() {
        let check = |value, ok, guard_band| Check {
            figure: FigureName::default(),
            limit: 100.0,
            value,
            ok,
            u: None,
            u_covers: None,
            guard_band,
            interval_95: None,
            rule: None,
            hidden: None,
            doubt: None,
        };
        assert!(!check(90.0, true, Some(5.0)).is_broken());
        assert!(!check(97.0, false, Some(5.0)).is_broken());
        assert!(!check(103.0, false, Some(5.0)).is_broken());
        assert!(check(106.0, false, Some(5.0)).is_broken());
        assert!(check(100.1, false, None).is_broken() && !check(100.0, true, None).is_broken());
    }
}
