//! Figures held against limits: plainly, with the guard band of ISO 14253-1, and before the last point.
//!
//! [`verdict`](crate::verdict()) compares PV and RMS with a [`Tolerance`], uncertainty aside. [`judge`] takes any
//! [`Limit`], over the aperture or a zone of it, with its uncertainty. [`prospect()`] says what is certain while points
//! still arrive: by [`least()`], which no more points can lower, and by a [`forecast()`] of the part that was not measured.
//! [`rms_of_whole_nm`] says what that may add to a final RMS.

mod by_places;
mod decision;
mod forecast;
mod least;
mod limit;
mod prospect;
mod tolerance;

pub use decision::{Decision, Doubt, Finding, Guard, GuardError, decide};
pub use forecast::{Deviations, Forecast, Predicted, forecast};
pub use least::{Least, least, least_square_nm2};
pub use limit::{DecisionRule, Judged, Limit, LimitError, Over, judge};
pub use prospect::{Prospect, Raised, Running, Zone, prospect, rms_of_whole_nm};
pub use tolerance::{Check, Reason, Status, Tolerance, Verdict, verdict};
