//! The verdict and the limits it stands on.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::Outlook;

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
    /// Name with unit: `pv_nm`.
    pub name: String,
    /// The largest value allowed.
    pub limit: f64,
    /// The value found.
    pub value: f64,
    /// Whether it holds; with a guard band, whether that is proven.
    pub ok: bool,
    /// Standard uncertainty (k = 1) of the value; absent where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
    /// What `u` covers, in words; absent without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_covers: Option<String>,
    /// Width of the guard band on either side of the limit; absent without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guard_band: Option<f64>,
    /// The decision rule in words; absent without a guard band.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rule: Option<String>,
    /// What the part of the aperture that was not measured may add to the value, at the probability of
    /// [`UnmeasuredFigures::p`](super::UnmeasuredFigures::p); absent where that is not known, and for slopes, of which it is not told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hidden: Option<f64>,
    /// Why neither is proven, in words; absent where it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubt: Option<String>,
}

impl Check {
    /// Its name, its unit and of what it is, if not of the whole: `RMS`, `nm`, `from 0-4.5 mm` of a ring or `less piston`.
    pub fn words(&self) -> (String, &'static str, Option<String>) {
        words_of(&self.name)
    }

    /// Whether the limit is certainly broken: by more than the guard band, where there is one, and what noise and places
    /// have added. What neither holds nor is broken is not proven.
    pub fn is_broken(&self) -> bool {
        let beyond = self.value > self.limit + self.guard_band.unwrap_or(0.0);
        !self.ok && self.doubt.is_none() && beyond
    }
}

/// The name of a limit as [`Check::words`].
pub(crate) fn words_of(name: &str) -> (String, &'static str, Option<String>) {
    let (name, of) = match name.split_once(' ') {
        Some((name, less)) if less.starts_with("less ") => (name, Some(less.to_owned())),
        Some((name, ring)) => (name, Some(format!("from {ring}"))),
        None => (name, None),
    };
    let (name, unit) = match name.rsplit_once('_') {
        Some((name, "nm")) => (name, "nm"),
        Some((name, "urad")) => (name, "µrad"),
        _ => (name, ""),
    };
    let name = match name {
        "minimum_zone" => "minimum zone".to_owned(),
        "sa" | "sq" | "sz" => format!("S{}", &name[1..]),
        "rmst" | "rmsi" | "rmsa" => format!("RMS{}", &name[3..]),
        name => name.replace('_', " ").to_uppercase(),
    };
    (name, unit, of)
}

#[cfg(test)]
mod tests {
    use super::Check;

    #[test]
    fn within_the_guard_band_a_limit_neither_holds_nor_is_broken() {
        let check = |value, ok, guard_band| Check {
            name: "pv_nm".to_owned(),
            limit: 100.0,
            value,
            ok,
            u: None,
            u_covers: None,
            guard_band,
            rule: None,
            hidden: None,
            doubt: None,
        };
        assert!(!check(90.0, true, Some(5.0)).is_broken());
        assert!(!check(97.0, false, Some(5.0)).is_broken());
        assert!(!check(103.0, false, Some(5.0)).is_broken());
        assert!(check(106.0, false, Some(5.0)).is_broken());
        let ring = Check { name: "rms_nm 0-4.5 mm".to_owned(), ..check(1.0, true, None) };
        assert_eq!(ring.words(), ("RMS".to_owned(), "nm", Some("from 0-4.5 mm".to_owned())));
        let slope = Check { name: "slope_max_urad".to_owned(), ..ring };
        assert_eq!(slope.words(), ("SLOPE MAX".to_owned(), "µrad", None));
        let words = |name: &str| Check { name: name.to_owned(), ..slope.clone() }.words();
        assert_eq!(words("rms_nm less piston").2, Some("less piston".to_owned()));
        let names = ["minimum_zone_nm", "sq_nm", "rmsi_nm", "pvr_nm"].map(|name| words(name).0);
        assert_eq!(names, ["minimum zone", "Sq", "RMSi", "PVR"]);
        assert!(check(100.1, false, None).is_broken() && !check(100.0, true, None).is_broken());
    }
}
