//! Samples of known curves: dense as a condition asks, disturbed as wanted. So every method can be tried without data.

mod border;
mod disturb;
mod fine;
mod step;

pub use self::border::borders;
pub use self::disturb::{Disturbance, Disturbed};
pub use self::fine::TrueCurve;
pub use self::step::Spacing;
use crate::PlaceMm;

/// A line of cubic Bézier curves, each by its four control points in mm.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierLine {
    /// The curves in order; each begins where the one before ended.
    pub pieces: Vec<[PlaceMm; 4]>,
    /// Whether the last one ends where the first begins.
    pub closed: bool,
}

/// Samples of one line of a curve, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampledLine {
    /// Their places in mm.
    pub places_mm: Vec<PlaceMm>,
    /// The normal of the curve at each.
    pub normals: Vec<[f64; 2]>,
    /// The local feature size at each in mm.
    pub lfs_mm: Vec<f64>,
    /// Whether the line is closed.
    pub closed: bool,
}
