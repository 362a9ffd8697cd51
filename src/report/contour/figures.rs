//! Circle of the points, and deviation from a nominal outline.

use serde::{Deserialize, Serialize};

/// The circle of the points of one curve. Lengths are mm; `u_` are standard uncertainties by the scatter of the points.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct CircleFigures {
    /// Number of points it is fitted to.
    pub points: usize,
    /// Centre of the least-squares circle.
    pub centre_mm: [f64; 2],
    /// Uncertainty of its coordinates.
    pub u_centre_mm: [f64; 2],
    /// Diameter of the least-squares circle.
    pub diameter_mm: f64,
    /// Uncertainty of the diameter.
    pub u_diameter_mm: f64,
    /// Roundness deviation about it, unfiltered: noise makes it too large, by 2·u at most in 95 of 100 cases.
    pub roundness_mm: f64,
    /// Uncertainty of the roundness deviation.
    pub u_roundness_mm: f64,
    /// Roundness deviation about the centre of the minimum zone; its uncertainty is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roundness_zone_mm: Option<f64>,
    /// Noise of the points, from neighbours.
    pub noise_sigma_mm: f64,
    /// Angle that the points span: 360 of a closed curve.
    pub span_deg: f64,
}

/// Deviations from the nominal outline as it lies: outside, and in its holes, above 0. Lengths are mm.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct DeviationFigures {
    /// The file of the outline.
    pub outline: String,
    /// Number of points held against it.
    pub points: usize,
    /// Number of points beyond the ends of an open line of it: they lie on neither side, and have no deviation.
    #[serde(default)]
    pub beyond_ends: usize,
    /// Largest deviation.
    pub largest_mm: f64,
    /// Place of the largest.
    pub largest_at_mm: [f64; 2],
    /// Least deviation.
    pub least_mm: f64,
    /// Place of the least.
    pub least_at_mm: [f64; 2],
    /// Mean of the deviations.
    pub mean_mm: f64,
    /// Root mean square of the deviations.
    pub rms_mm: f64,
    /// Standard uncertainty of the deviation of a point: its noise. Absent where noise was not estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub u_mm: Option<f64>,
    /// x, y and deviation of every point that has one, by x, then y.
    pub deviations_mm: Vec<[f64; 3]>,
}
