//! Figures held against a tolerance.

use crate::Figures;

/// The largest values allowed; `None` is no limit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tolerance {
    /// Limit of the peak-to-valley deviation in nm.
    pub pv_nm: Option<f64>,
    /// Limit of the root mean square deviation in nm.
    pub rms_nm: Option<f64>,
}

/// Whether a part is good.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The answer.
    pub status: Status,
    /// The limits and the values held against them.
    pub checks: Vec<Check>,
    /// Why there is no answer; `None` if there is one.
    pub reason: Option<Reason>,
}

/// The answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Every limit holds.
    Pass,
    /// A limit is broken.
    Fail,
    /// There is no answer; [`Verdict::reason`] says why.
    Undecided,
}

/// One limit and the value held against it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Check {
    /// Name with unit: `pv_nm` or `rms_nm`.
    pub name: &'static str,
    /// The largest value allowed.
    pub limit: f64,
    /// The value found.
    pub value: f64,
    /// Whether the value is at most the limit.
    pub ok: bool,
}

/// Why a verdict is undecided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The tolerance has no limit.
    NoTolerance,
    /// There are no figures.
    NoFigures,
    /// A limit or a value is NaN.
    NotANumber,
}

/// Holds figures against a tolerance. A value equal to its limit passes. Measurement uncertainty is not
/// taken off the limits.
pub fn verdict(figures: Option<&Figures>, tolerance: &Tolerance) -> Verdict {
    let undecided =
        |reason, checks| Verdict { status: Status::Undecided, checks, reason: Some(reason) };
    if *tolerance == Tolerance::default() {
        return undecided(Reason::NoTolerance, Vec::new());
    }
    let Some(figures) = figures else {
        return undecided(Reason::NoFigures, Vec::new());
    };
    let check = |name, limit: Option<f64>, value: f64| {
        limit.map(|limit| Check { name, limit, value, ok: value <= limit })
    };
    let checks: Vec<Check> = [
        check("pv_nm", tolerance.pv_nm, figures.pv_nm),
        check("rms_nm", tolerance.rms_nm, figures.rms_nm),
    ]
    .into_iter()
    .flatten()
    .collect();
    if checks.iter().any(|check| check.limit.is_nan() || check.value.is_nan()) {
        return undecided(Reason::NotANumber, checks);
    }
    let status = if checks.iter().all(|check| check.ok) { Status::Pass } else { Status::Fail };
    Verdict { status, checks, reason: None }
}

/// A sentence fragment for a report.
impl std::fmt::Display for Reason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Reason::NoTolerance => "no limits are given",
            Reason::NoFigures => "there are no figures",
            Reason::NotANumber => "a limit or a figure is not a number",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figures(pv_nm: f64, rms_nm: f64) -> Figures {
        Figures {
            pv_nm,
            rms_nm,
            max_nm: pv_nm,
            min_nm: 0.0,
            at_max_mm: [0.0; 3],
            at_min_mm: [0.0; 3],
            count: 1,
        }
    }

    #[test]
    fn every_given_limit_is_checked_and_must_hold() {
        let both = Tolerance { pv_nm: Some(200.0), rms_nm: Some(20.0) };
        let pass = verdict(Some(&figures(200.0, 19.0)), &both);
        assert_eq!((pass.status, pass.reason), (Status::Pass, None));
        assert_eq!(pass.checks.len(), 2);
        let fail = verdict(Some(&figures(150.0, 20.5)), &both);
        assert_eq!(fail.status, Status::Fail);
        assert_eq!(fail.checks[1], Check { name: "rms_nm", limit: 20.0, value: 20.5, ok: false });
        assert!(fail.checks[0].ok);
        let only_pv = Tolerance { pv_nm: Some(200.0), rms_nm: None };
        assert_eq!(verdict(Some(&figures(150.0, 1e9)), &only_pv).status, Status::Pass);
    }

    #[test]
    fn without_limit_or_figures_it_is_undecided() {
        let reason = |figures: Option<&Figures>, pv_nm| {
            let verdict = verdict(figures, &Tolerance { pv_nm, rms_nm: None });
            assert_eq!(verdict.status, Status::Undecided);
            verdict.reason
        };
        assert_eq!(reason(Some(&figures(1.0, 1.0)), None), Some(Reason::NoTolerance));
        assert_eq!(reason(None, Some(1.0)), Some(Reason::NoFigures));
        assert_eq!(reason(Some(&figures(1.0, 1.0)), Some(f64::NAN)), Some(Reason::NotANumber));
        assert_eq!(reason(Some(&figures(f64::NAN, 1.0)), Some(1.0)), Some(Reason::NotANumber));
    }
}
