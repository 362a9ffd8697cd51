//! Ways of a probe over an aperture: paths, their time, short orders of places, and what to measure next.
//!
//! [`lay`] turns a [`Path`] over an [`Aperture`] into [`Piece`]s: lines, arcs and spirals. [`schedule`] runs them within the limits of
//! a [`Machine`] and says where and when each point is taken. [`axis_runs`] gives the runs of the axes along them.
//! [`short_order`] puts scattered places into a short path.
//! [`AdaptiveScan::next_step`] decides, from what is known of a part, which places to measure next or why to end.
//!
//! ```
//! use asphera_plan::{Aperture, Axis, Limits, Machine, Path, Spacing, lay, schedule};
//!
//! let aperture = Aperture::Rectangle { width_mm: 10.0, height_mm: 4.0 };
//! let pieces = lay(&Path::Raster { pitch_mm: 1.0, one_way: false }, &aperture, [0.0, 0.0])?;
//! let axis = Axis { low: -20.0, high: 20.0, speed: 10.0, acceleration: 100.0 };
//! let machine = Machine::Cartesian { x: axis, y: axis };
//! let limits = Limits { machine, scan_speed_mm_s: 5.0, dwell_s: 0.0 };
//! let found = schedule(&pieces, Spacing::AtMost { mm: 0.5 }, &limits, None)?;
//! // Five lines of 21 points, each 10 mm at 5 mm/s and 0.05 s for both ramps.
//! assert_eq!((pieces.len(), found.points.len()), (5, 105));
//! assert!((found.scan_s - 5.0 * 2.05).abs() < 1e-9);
//! # Ok::<(), asphera_plan::PlanError>(())
//! ```
//!
//! Places are (x, y) in mm in the frame of the machine; z follows the surface and is no matter of the plan. The crate reads no clock, does
//! no input or output and draws no random numbers. The same places give the same bits, whatever their order.

#![forbid(unsafe_code)]

mod adaptive;
mod aperture;
mod error;
mod lattice;
mod machine;
mod order;
mod path;
mod piece;
mod polygon;
mod run;
mod schedule;
mod speed;
mod strokes;
mod trapezoid;

pub use adaptive::{AdaptiveScan, Batch, Ending, Goal, Known, Step, VerdictState, WantedRegion};
pub use aperture::Aperture;
pub use error::PlanError;
pub use lattice::Lattice;
pub use machine::{Axis, Machine};
pub use order::{MOST_PLACES, path_length_mm, short_order};
pub use path::{Path, Way, lay};
pub use piece::Piece;
pub use polygon::Polygon;
pub use run::{AxisRun, RunKind, axis_runs};
pub use schedule::{Limits, MOST_POINTS, Schedule, Spacing, TimedPoint, schedule, schedule_each};
pub use strokes::strokes;
pub use trapezoid::Trapezoid;

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;
