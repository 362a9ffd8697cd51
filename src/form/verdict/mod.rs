//! Figures held against limits: plainly, with the guard band of ISO 14253-1, and before the last point.
//!
//! [`verdict`](crate::verdict()) compares PV and RMS with a [`Tolerance`], uncertainty aside. [`judge`] takes any
//! [`Limit`], over the aperture or a zone of it, with its uncertainty. [`rms_prospect`] and [`pv_prospect`] say
//! what is certain while points still arrive, and
//! [`rms_of_whole_nm`] what the part of the aperture that was not measured may add to the RMS.

mod decision;
mod limit;
mod prospect;
mod tolerance;

pub use decision::{Decision, Doubt, Finding, Guard, GuardError, decide};
pub use limit::{Judged, Limit, LimitError, judge};
pub use prospect::{Prospect, RunningPv, RunningRms, pv_prospect, rms_of_whole_nm, rms_prospect};
pub use tolerance::{Check, Reason, Status, Tolerance, Verdict, verdict};
