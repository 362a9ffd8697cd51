//! The figures of a profile: points on a straight line in plan.

use serde::{Deserialize, Serialize};

/// A profile: fitted, sampled and judged along its line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ProfileFigures {
    /// Measured quantity: `heights`, or `slopes, integrated by the trapezoidal rule`.
    pub source: String,
    /// Direction of the line against x, in degrees.
    pub direction_deg: f64,
    /// Whether the fit was made in a frame turned about z so that x runs along the line. Its parameters are then those of
    /// that frame.
    pub turned: bool,
    /// Free parameters that a profile does not feel; they stayed at their start.
    pub held: Vec<String>,
    /// Length of the line in the aperture, mm.
    pub length_mm: Option<f64>,
    /// Length of it that is sampled densely enough, mm.
    pub covered_mm: Option<f64>,
    /// Root of the mean square slope of the deviation, µrad.
    pub slope_rms_urad: Option<f64>,
    /// RMS about the mean slope, µrad.
    pub slope_rms_about_mean_urad: Option<f64>,
    /// Largest slope of the deviation, µrad.
    pub slope_max_urad: Option<f64>,
    /// Standard deviation in nm that deviations vary by from point to point, by third differences; `None` of measured slopes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_sigma_nm: Option<f64>,
    /// RMS in µrad that this alone gives slopes between neighbours.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slope_noise_urad: Option<f64>,
    /// How slopes were formed.
    pub slope_rule: String,
}
