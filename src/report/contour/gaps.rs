//! Gaps between ends of a contour.

use serde::{Deserialize, Serialize};

/// A gap between two ends of a curve, and the curve across it. It is no measured part of the contour: chains, lengths and areas
/// are without it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct GapFigures {
    /// Rows of the points at its ends.
    pub ends: [u32; 2],
    /// Their distance in mm.
    pub width_mm: f64,
    /// `corner`, where both sides go on straight, or `smooth`; of strokes `straight`.
    pub kind: String,
    /// Length of the curve across it in mm.
    pub length_mm: f64,
    /// Places along the curve in mm, both ends among them.
    pub points_mm: Vec<[f64; 2]>,
}
