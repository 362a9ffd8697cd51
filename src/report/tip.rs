//! Compensation of the radius of a ball tip.

use serde::{Deserialize, Serialize};

/// Compensation of the radius of a ball tip: points are contacts of the ball with the surface, not its centres.
///
/// Not corrected are the form of the ball, contacts on edges, and valleys that are narrower than the ball.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TipFigures {
    /// Radius of the ball, mm.
    pub radius_mm: f64,
    /// Its standard uncertainty, mm.
    pub u_radius_mm: f64,
    /// Place of the ball that a reading gives: `lowest` or `centre`.
    pub reads: String,
    /// Why points are the lowest points of the ball and not its contacts; absent where they are contacts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub uncompensated: Option<String>,
    /// Centres that have a contact; absent where points are not contacts. Where it is 0, so is all below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contacts: Option<u64>,
    /// Fits until no contact moved; 0 where points are not contacts.
    pub passes: u32,
    /// Farthest way of a contact in the last of them, nm.
    pub last_move_nm: f64,
    /// Steepest place touched, as the angle between normal and probe, °.
    pub steepest_deg: f64,
    /// Largest error in height that the compensation removed, r·(1/cos α − 1) at the steepest place, nm.
    pub largest_height_nm: f64,
    /// Largest shift of a contact across the probe, r·sin α, nm.
    pub largest_shift_nm: f64,
    /// The contact at the steepest place, measured frame, mm.
    pub steepest_at_mm: [f64; 3],
    /// Radius of the ball over the smallest radius of curvature of the nominal where it is hollow; a ball fits below 1. Absent
    /// where it is hollow nowhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hollow_share: Option<f64>,
    /// The centre of the ball at that place, measured frame, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hollow_at_mm: Option<[f64; 3]>,
    /// Contribution of the radius to u of PV, nm: u counts it. Absent where the radius has no stated uncertainty.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_pv_nm: Option<f64>,
    /// The same of RMS.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u_rms_nm: Option<f64>,
    /// Error in height that is left because normals are those of the nominal, r·θ²/2 with θ the RMS slope of the deviation, nm.
    /// Noise of the heights makes it larger. Absent where slopes are not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub neglected_nm: Option<f64>,
}
