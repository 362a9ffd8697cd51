//! Figures held against limits: plainly, with the guard band of ISO 14253-1, and before the last point.
//!
//! A [`Limit`] is of any figure, over the aperture or a zone of it. [`Limit::figure_of`] gives the value alone, [`finding()`]
//! the value with its uncertainty. [`decide`] holds it against the limit: nothing else does. [`prospect()`] says what is certain while points
//! still arrive: by [`least()`], which no more points can lower, and by a [`forecast()`] of the part that was not measured.
//! [`rms_of_whole_nm`] says what that may add to a final RMS.

mod by_places;
mod decision;
mod forecast;
mod least;
mod limit;
mod prospect;
mod status;

pub use decision::{Decision, Doubt, Finding, Guard, GuardError, decide};
pub use forecast::{Deviations, Forecast, Predicted, forecast};
pub use least::{Least, least, least_square_nm2};
pub use limit::{Limit, LimitError, Over, finding};
pub use prospect::{Prospect, Raised, Running, Zone, prospect, rms_of_whole_nm};
pub use status::{Reason, Status};
