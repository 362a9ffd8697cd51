//! What is certain of the final figure while points still arrive.
//!
//! *Fail is certain.* The best fit of all points leaves at least what the best fit of some of them leaves on
//! these. So the sum of squares cannot fall, and of the RMS at least the root of their share remains; and the
//! minimum zone of some points is never wider than that of all, which is never wider than the PV of any fit of all.
//! Both need every parameter free now that is free in the end. [`super::least()`] says the same over zones and with terms
//! removed.
//!
//! *Pass is certain from a coverage on.* That needs assumptions, of two kinds. Between the points there are, the
//! deviation bends no more than anywhere at them ([`crate::unmeasured()`]). Where none are, it is of the same
//! random kind ([`super::forecast()`]); and a PV also waits until little is left: of patches that are exchangeable each is
//! as likely as any other to hold the maximum, so the share 1 − c not measured holds it, or the minimum, with a
//! probability of at most 2·(1 − c).

use super::decision::{Finding, Guard, GuardError, decide};
use super::forecast::Predicted;
use super::status::Status;
use crate::student_quantile;

/// Statement that can be made already.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prospect {
    /// Whether a fail is certain: the bound of the final figure already breaks the limit by the guard band.
    pub fail_is_certain: bool,
    /// The coverage of the aperture, 0 to 1, from which on a pass is certain with [`Prospect::p`], if the assumptions hold; not
    /// above the present one if it is so already. `None` if that cannot be said.
    pub pass_from_coverage: Option<f64>,
    /// The probability of that.
    pub p: f64,
}

/// A figure so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Running<'a> {
    /// Its value for the fit of the points so far, in nm.
    pub value_nm: f64,
    /// The final value will be at least this, in nm; `None` if that cannot be said.
    pub at_least_nm: Option<f64>,
    /// Its standard uncertainty in nm; `None` if it is not known.
    pub u_nm: Option<f64>,
    /// Degrees of freedom of that.
    pub dof: f64,
    /// What noise adds to it, as the decision takes it off before it calls a limit broken: [`Finding::bias`].
    pub raised: Raised,
    /// Height that may stand out between the points so far, in nm; `None` if that is not known.
    pub between_nm: Option<f64>,
    /// What the part that was not measured may add to an RMS at the probability asked for, as the final decision has it (at least
    /// what independent patches say: [`rms_of_whole_nm`]), in nm; 0 for a PV; `None` if that is not known.
    pub beyond_nm: Option<f64>,
    /// Share of the aperture that is measured, 0 to 1.
    pub coverage: f64,
    /// Of a figure over a zone.
    pub zone: Option<Zone>,
    /// Range in the end; `None` if that is not known.
    pub predicted: Option<&'a Predicted>,
}

/// How much of a zone is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Zone {
    /// Share of it, 0 to 1.
    pub coverage: f64,
    /// Its area over that of the aperture, above 0 and at most 1.
    pub area: f64,
}

/// Share of noise in a figure, by its kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Raised {
    /// To a range: so much, in nm.
    Range {
        /// By how much noise widens it.
        bias_nm: f64,
    },
    /// To a root mean square: its own, in squares.
    Rms {
        /// The noise of a point in nm; 0 if it is not taken off.
        noise_nm: f64,
    },
}

/// What is certain of a final figure: `p`, above 0.5 and below 1, is the probability of a pass.
pub fn prospect(
    running: &Running<'_>,
    limit_nm: f64,
    guard: Guard,
    p: f64,
) -> Result<Prospect, GuardError> {
    Guard::Probability(p).validate()?;
    let finding = |value: f64| {
        let bias = match running.raised {
            Raised::Range { bias_nm } => bias_nm,
            Raised::Rms { noise_nm } => {
                value - (value * value - noise_nm * noise_nm).max(0.0).sqrt()
            }
        };
        let (u, dof, hidden) = (running.u_nm, running.dof, running.between_nm);
        Finding { u, dof, bias, hidden, ..Finding::of_value(value) }
    };
    let fail_is_certain = match running.at_least_nm {
        Some(least_nm) => decide(&finding(least_nm), limit_nm, guard)?.status == Status::Fail,
        None => false,
    };
    let now = decide(&finding(running.value_nm), limit_nm, guard)?;
    let known = running.coverage > 0.0 && running.coverage <= 1.0;
    let beyond_nm = running.beyond_nm.filter(|_| known && now.status == Status::Pass);
    let pass_from_coverage = match (now.band, running.between_nm, beyond_nm, running.predicted) {
        (Some(band_nm), Some(between_nm), Some(beyond_nm), Some(predicted)) => {
            let room_nm = limit_nm - band_nm - between_nm;
            match running.raised {
                Raised::Range { .. } => range_from(running, room_nm, predicted, p),
                Raised::Rms { .. } => {
                    let by_patches_nm = running.value_nm + beyond_nm;
                    rms_from(running, room_nm, predicted.quantile_nm(p).max(by_patches_nm))
                }
            }
        }
        _ => None,
    };
    Ok(Prospect { fail_is_certain, pass_from_coverage, p })
}

/// The coverage from which on an RMS that may be `upper_nm` stays within `room_nm`. What the rest may add to its square is
/// taken to shrink with the rest.
fn rms_from(running: &Running<'_>, room_nm: f64, upper_nm: f64) -> Option<f64> {
    if upper_nm <= room_nm {
        return Some(running.coverage);
    }
    let square = |nm: f64| nm * nm - running.value_nm * running.value_nm;
    let rest = 1.0 - running.coverage;
    (rest > 0.0).then(|| 1.0 - rest * square(room_nm) / square(upper_nm))
}

/// The same of a PV. The chance that it does not is taken to shrink with the rest.
fn range_from(running: &Running<'_>, room_nm: f64, predicted: &Predicted, p: f64) -> Option<f64> {
    // Half of what may fail is for the maximum and half for the minimum.
    let wanted = 1.0 - 0.5 * (1.0 - p);
    let wanted = match running.zone {
        None => wanted,
        Some(zone) if zone.coverage >= wanted => running.coverage,
        // Nobody knows when the zone will be measured: at the worst, last.
        Some(zone) => 1.0 - (1.0 - wanted) * zone.area,
    };
    let (broken, rest) = (predicted.beyond(room_nm), 1.0 - running.coverage);
    if broken <= 1.0 - p {
        return Some(wanted);
    }
    (rest > 0.0).then(|| wanted.max(1.0 - rest * (1.0 - p) / broken))
}

/// The RMS in nm of the whole aperture that is not exceeded with probability `p`, above 0.5 and below 1, where `coverage`
/// of it, 0 to 1, was measured and has an RMS of `rms_nm`, and the rest is like it: patch by patch, which are taken for independent (Hahn & Meeker, Statistical Intervals, 4.8).
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

/// Fewer patches tell no spread.
const LEAST_PATCHES: f64 = 8.0;

#[cfg(test)]
mod tests;
