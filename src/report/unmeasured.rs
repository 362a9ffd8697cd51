//! What the part of the aperture that was not measured may hide.

use serde::{Deserialize, Serialize};

/// Amounts that may be missing from PV and RMS because points are where they are and not elsewhere.
///
/// Between points that lie densely enough a bound holds: the deviation lies within ½·bend·gap² of the planes through
/// them, if it bends no more between the points than anywhere at them. Of the rest of the aperture it is assumed
/// that it is like what was measured, patch by patch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct UnmeasuredFigures {
    /// Share of the aperture that was not sampled densely enough, 0 to 1; absent where the coverage is not known.
    pub share: Option<f64>,
    /// Its area in mm², projected.
    pub area_mm2: Option<f64>,
    /// The largest gap in mm of what was sampled densely enough.
    pub gap_mm: Option<f64>,
    /// The largest second derivative of the deviation that the points tell, in nm/mm².
    pub bend_nm_per_mm2: Option<f64>,
    /// Height that may stand out between the points at either end, in nm: ½·bend·gap².
    pub between_nm: Option<f64>,
    /// The PV may be larger by this between the points, in nm: twice that.
    pub pv_hidden_nm: Option<f64>,
    /// The rest of the aperture holds the highest or the lowest place with at most this probability: twice its share.
    pub extreme_missed_p: Option<f64>,
    /// The RMS may be larger by this in nm, at the probability `p`.
    pub rms_hidden_nm: Option<f64>,
    /// The probability asked of a verdict.
    pub p: f64,
    /// Why something is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unknown: Vec<String>,
}
