//! The contour of a session that runs or has ended.

use serde::Serialize;

use super::ContourReport;

/// The contour of a session, as of so many points.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SessionContour {
    /// Number of points that had been received when it was formed.
    pub as_of_points: u64,
    /// Whether its places are x and y of the measured frame, not of another plane.
    pub in_xy: bool,
    /// The contour.
    pub contour: ContourReport,
}

/// Which contour there is; it is too large to come with every snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ContourState {
    /// As in [`SessionContour`]: another number means another contour.
    pub as_of_points: u64,
}
