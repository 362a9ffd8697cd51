//! What is certain of the final figure while points still arrive.
//!
//! *Fail is certain.* The best fit of all points leaves at least what the best fit of some of them leaves on
//! these. So the sum of squares cannot fall, and of the RMS at least the root of their share remains; and the
//! minimum zone of some points is never wider than that of all, which is never wider than the PV of any fit of all.
//! Both need every parameter free now that is free in the end, and the zone is a local minimum.
//!
//! *Pass is certain from a coverage on.* That needs an assumption: what is still to come is like what has come,
//! patch by patch. For the PV nothing else is needed: of patches that are exchangeable each is as likely as any other to hold
//! the maximum, so the share 1 − c not measured holds it, or the minimum, with a probability of at most 2·(1 − c).
//! For the RMS the mean square of the rest is predicted from the spread of the patches by Student's
//! distribution (Hahn & Meeker, Statistical Intervals, 4.8).

use super::decision::{Finding, Guard, GuardError, decide};
use super::tolerance::Status;
use crate::uncertainty::student_quantile;

/// What can be said already.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prospect {
    /// The final figure will be at least this, in nm; `None` if that cannot be said.
    pub at_least_nm: Option<f64>,
    /// Whether a fail is certain: that bound already breaks the limit by the guard band.
    pub fail_is_certain: bool,
    /// The coverage, 0 to 1, from which on a pass is certain with [`Prospect::p`], if the rest is like what is
    /// measured; not above the present one if it is so already. `None` if that cannot be said.
    pub pass_from_coverage: Option<f64>,
    /// The probability of that.
    pub p: f64,
}

/// The RMS so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunningRms<'a> {
    /// RMS of the least-squares fit of the points so far, in nm.
    pub rms_nm: f64,
    /// Its standard uncertainty in nm; `None` if it is not known.
    pub u_nm: Option<f64>,
    /// Degrees of freedom of that.
    pub dof: f64,
    /// The noise of a point in nm, if the decision takes its share off before it calls a limit broken:
    /// [`Finding::bias`]; 0 if it does not.
    pub noise_nm: f64,
    /// Whether every parameter of the final fit was free and determinate.
    pub complete: bool,
    /// Points so far over points in the end; `None` if nobody knows how many will come.
    pub share: Option<f64>,
    /// Share of the aperture that is measured, 0 to 1.
    pub coverage: f64,
    /// Mean square of the deviation in nm², for patches of about equal area.
    pub patches_nm2: &'a [f64],
}

/// The PV so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunningPv {
    /// PV of the fit of the points so far, in nm.
    pub pv_nm: f64,
    /// Its standard uncertainty in nm; `None` if it is not known.
    pub u_nm: Option<f64>,
    /// What noise has added to it, in nm.
    pub bias_nm: f64,
    /// Degrees of freedom of the uncertainty.
    pub dof: f64,
    /// Lower bound of the minimum zone (of the range) of these points in nm, every parameter of the final fit free:
    /// [`crate::Certificate::lower_mm`]. `None` if it was not looked for.
    pub zone_nm: Option<f64>,
    /// Share of the aperture that is measured, 0 to 1.
    pub coverage: f64,
}

/// What is certain of the final RMS: `p`, above 0.5 and below 1, is the probability of a pass.
///
/// The pass needs 8 patches at least.
pub fn rms_prospect(
    running: &RunningRms<'_>,
    limit_nm: f64,
    guard: Guard,
    p: f64,
) -> Result<Prospect, GuardError> {
    Guard::Probability(p).validate()?;
    let finding = |value: f64| {
        let form_nm = (value * value - running.noise_nm * running.noise_nm).max(0.0).sqrt();
        let bias = value - form_nm;
        Finding { value, u: running.u_nm, dof: running.dof, bias, hidden: Some(0.0) }
    };
    let share = running.share.filter(|share| running.complete && (0.0..=1.0).contains(share));
    let at_least_nm = share.map(|share| share.sqrt() * running.rms_nm);
    let fail_is_certain = fails(at_least_nm.map(finding), limit_nm, guard)?;

    let passes = |rms_nm: f64| {
        decide(&finding(rms_nm), limit_nm, guard).map(|found| found.status == Status::Pass)
    };
    let now = running.coverage;
    let mut pass_from_coverage = None;
    if let Some(patches) = Patches::new(running.patches_nm2, now, p)
        && passes(running.rms_nm)?
    {
        for step in 0..=STEPS {
            let coverage = now + (1.0 - now) * f64::from(step) / f64::from(STEPS);
            if passes(patches.rms_nm(running.rms_nm, coverage))? {
                pass_from_coverage = Some(coverage);
                break;
            }
        }
    }
    Ok(Prospect { at_least_nm, fail_is_certain, pass_from_coverage, p })
}

/// The RMS in nm of the whole aperture that is not exceeded with probability `p`, above 0.5 and below 1, where `coverage`
/// of it, 0 to 1, was measured and has an RMS of `rms_nm`, and the rest is like it: see [`rms_prospect`].
/// `None` with less than 8 patches, unless nothing is missing.
pub fn rms_of_whole_nm(rms_nm: f64, patches_nm2: &[f64], coverage: f64, p: f64) -> Option<f64> {
    if coverage == 1.0 {
        return Some(rms_nm);
    }
    Patches::new(patches_nm2, coverage, p).map(|patches| patches.rms_nm(rms_nm, coverage))
}

/// The spread of the mean square over patches.
struct Patches {
    count: f64,
    mean: f64,
    deviation: f64,
    t: f64,
    /// Share of the aperture they are of.
    coverage: f64,
}

impl Patches {
    fn new(patches_nm2: &[f64], coverage: f64, p: f64) -> Option<Patches> {
        let count = patches_nm2.len() as f64;
        if !(count >= LEAST_PATCHES && coverage > 0.0 && coverage <= 1.0) {
            return None;
        }
        let mean = patches_nm2.iter().sum::<f64>() / count;
        let square: f64 = patches_nm2.iter().map(|patch| (patch - mean).powi(2)).sum();
        let deviation = (square / (count - 1.0)).sqrt();
        Some(Patches { count, mean, deviation, t: student_quantile(p, count - 1.0), coverage })
    }

    /// Of the whole, once `coverage` of it has an RMS of `rms_nm`.
    fn rms_nm(&self, rms_nm: f64, coverage: f64) -> f64 {
        // Patches measured by then, and those left.
        let seen = self.count * coverage / self.coverage;
        let left = self.count * (1.0 - coverage) / self.coverage;
        let rest = if left > 0.0 {
            self.mean + self.t * self.deviation * (1.0 / seen + 1.0 / left).sqrt()
        } else {
            0.0
        };
        (coverage * rms_nm.powi(2) + (1.0 - coverage) * rest).sqrt()
    }
}

/// What is certain of the final PV: `p`, above 0.5 and below 1, is the probability of a pass.
pub fn pv_prospect(
    running: &RunningPv,
    limit_nm: f64,
    guard: Guard,
    p: f64,
) -> Result<Prospect, GuardError> {
    Guard::Probability(p).validate()?;
    let finding = |value| Finding {
        value,
        u: running.u_nm,
        dof: running.dof,
        bias: running.bias_nm,
        hidden: Some(0.0),
    };
    let fail_is_certain = fails(running.zone_nm.map(finding), limit_nm, guard)?;
    let kept = decide(&finding(running.pv_nm), limit_nm, guard)?.status == Status::Pass;
    // Half of what may fail is for the maximum and half for the minimum.
    let wanted = 1.0 - 0.5 * (1.0 - p);
    let known = kept && running.coverage > 0.0 && running.coverage <= 1.0;
    let pass_from_coverage = known.then_some(wanted);
    Ok(Prospect { at_least_nm: running.zone_nm, fail_is_certain, pass_from_coverage, p })
}

fn fails(least: Option<Finding>, limit_nm: f64, guard: Guard) -> Result<bool, GuardError> {
    let Some(least) = least else { return Ok(false) };
    Ok(decide(&least, limit_nm, guard)?.status == Status::Fail)
}

/// Fewer patches tell no spread.
const LEAST_PATCHES: f64 = 8.0;
/// Steps in which a coverage is looked for.
const STEPS: u32 = 1000;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::uncertainty::student_quantile;

    fn running(patches_nm2: &[f64]) -> RunningRms<'_> {
        RunningRms {
            rms_nm: (patches_nm2.iter().sum::<f64>() / patches_nm2.len() as f64).sqrt(),
            u_nm: Some(0.0),
            dof: f64::INFINITY,
            noise_nm: 0.0,
            complete: true,
            share: Some(0.25),
            coverage: 0.25,
            patches_nm2,
        }
    }

    #[test]
    fn a_fail_is_certain_once_the_rest_cannot_help() {
        // A quarter of the points leaves at least half of its RMS.
        let prospect = |limit_nm| {
            rms_prospect(&running(&[400.0; 9]), limit_nm, Guard::Factor(2.0), 0.95).unwrap()
        };
        assert_eq!(prospect(10.1).at_least_nm, Some(10.0));
        assert!(!prospect(10.1).fail_is_certain && prospect(9.9).fail_is_certain);
        // 6 of the 10 nm are noise, and 8 are left.
        let noisy = RunningRms { noise_nm: 6.0, ..running(&[400.0; 9]) };
        let fails = |limit_nm| {
            let found = rms_prospect(&noisy, limit_nm, Guard::Factor(2.0), 0.95).unwrap();
            found.fail_is_certain
        };
        assert!(fails(7.9) && !fails(8.1));
        let partly = RunningRms { complete: false, ..running(&[400.0; 9]) };
        let found = rms_prospect(&partly, 1.0, Guard::Factor(2.0), 0.95).unwrap();
        assert_eq!((found.at_least_nm, found.fail_is_certain), (None, false));
    }

    #[test]
    fn a_pass_of_the_rms_waits_for_the_spread() {
        let even = rms_prospect(&running(&[100.0; 9]), 10.5, Guard::None, 0.95).unwrap();
        assert_eq!(even.pass_from_coverage, Some(0.25));
        let patches = [20.0, 300.0, 60.0, 150.0, 40.0, 80.0, 120.0, 30.0];
        let pass = |limit_nm| {
            let found = rms_prospect(&running(&patches), limit_nm, Guard::None, 0.95).unwrap();
            found.pass_from_coverage
        };
        // By hand: mean 100, deviation 92.43, t of 7 degrees of freedom 1.8946; at half the aperture 16 patches
        // are seen and 16 left, so the rest is 100 + 1.8946·92.43·√(1/8) = 161.9 and the RMS √131.0 = 11.444.
        let t = student_quantile(0.95, 7.0);
        assert!((t - 1.894_6).abs() < 1e-4);
        let from = pass(11.444).unwrap();
        assert!((from - 0.5).abs() < 2e-3, "{from}");
        assert!(pass(10.2).unwrap() > from);
        // Half of the aperture measured by 8 patches, which leaves 8.
        let rest = 100.0 + t * (59_800.0_f64 / 7.0).sqrt() * 0.5;
        let whole_nm = rms_of_whole_nm(10.0, &patches, 0.5, 0.95).unwrap();
        assert!((whole_nm - (50.0 + 0.5 * rest).sqrt()).abs() < 1e-5, "{whole_nm}");
        assert_eq!(rms_of_whole_nm(10.0, &[], 1.0, 0.95), Some(10.0));
        assert_eq!(rms_of_whole_nm(10.0, &patches[1..], 0.99, 0.95), None);
        assert_eq!(pass(9.9), None);
        assert_eq!(
            rms_prospect(&running(&patches[..7]), 1e3, Guard::None, 0.95)
                .unwrap()
                .pass_from_coverage,
            None
        );
    }

    #[test]
    fn pv_by_the_zone_and_by_exchangeable_patches() {
        let running = RunningPv {
            pv_nm: 90.0,
            u_nm: Some(2.0),
            bias_nm: 3.0,
            dof: f64::INFINITY,
            zone_nm: Some(80.0),
            coverage: 0.4,
        };
        let prospect = |limit_nm| pv_prospect(&running, limit_nm, Guard::Factor(2.0), 0.9).unwrap();
        assert_eq!(prospect(94.0).pass_from_coverage, Some(0.95));
        assert_eq!(prospect(93.9).pass_from_coverage, None);
        // 80 less a bias of 3 and a band of 4.
        assert!(prospect(72.9).fail_is_certain && !prospect(73.0).fail_is_certain);
        let blind = RunningPv { zone_nm: None, ..running };
        assert!(!pv_prospect(&blind, 1.0, Guard::None, 0.9).unwrap().fail_is_certain);
        assert!(pv_prospect(&running, 1.0, Guard::None, 0.4).is_err());
    }
}
