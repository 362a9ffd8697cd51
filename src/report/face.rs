//! The face of a volume that was measured.

use serde::{Deserialize, Serialize};

use crate::{ParameterFigures, Report};

/// The face of a volume that a nominal describes: how its points came about, and their errors. Errors are standard uncertainties
/// along the normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaceFigures {
    /// Columns, rows and slices of the volume.
    pub size: [u64; 3],
    /// Its spacing along them.
    pub spacing_mm: [f64; 3],
    /// The grey value of the surface.
    pub threshold: f64,
    /// Its origin: `halfway` between the levels, or `stated`.
    pub threshold_source: String,
    /// Grey values inside and outside of the face, beyond its blur.
    pub material: f64,
    /// The same outside.
    pub background: f64,
    /// Standard deviation of the Gaussian by which the grey values were smoothed; 0: not at all.
    pub smoothing_mm: f64,
    /// Points of the face.
    pub points: u64,
    /// Points that fit the nominal, but hang together with none of these.
    pub apart: u64,
    /// Points near the nominal that stand steeper than 30° to it, left out.
    pub steep: u64,
    /// Points within a tenth of a spacing of the border of the aperture, left out: noise decides on which side they lie.
    pub on_border: u64,
    /// Share of the aperture that the face fills, roughly.
    pub filled: f64,
    /// The direction from which the face is seen.
    pub along: [f64; 3],
    /// Standard deviation of the blur of the edge, smoothing included.
    pub blur_um: f64,
    /// Fall of the grey value across the face.
    pub slope_per_um: f64,
    /// Largest correction for the shift of a curved edge by its blur: by the curvature of design and deviation.
    pub curvature_correction_nm: f64,
    /// Standard uncertainty of the threshold, grey values.
    pub u_threshold: f64,
    /// Its origin: `levels over the face`, or `stated`.
    pub u_threshold_source: String,
    /// Shift of the whole face by the threshold.
    pub u_shift_nm: f64,
    /// Errors by levels that differ over the face, and the width over which they do.
    pub u_uneven_nm: f64,
    /// That width.
    pub uneven_length_mm: f64,
    /// Errors by noise, and their correlation length: neighbouring points share them.
    pub u_noise_nm: f64,
    /// That length.
    pub noise_length_mm: f64,
    /// What must be known to read the figures.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reasons: Vec<String>,
    /// The other face of the part, where it was measured too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second: Option<SecondFigures>,
}

/// Another face of the same part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SecondFigures {
    /// How it lies to the first; absent where one of the two has no fit.
    pub lies: Option<FacesFigures>,
    /// Its own figures.
    pub report: Box<Report>,
}

/// How two faces lie to each other. Each figure has its standard uncertainty.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FacesFigures {
    /// The line along which thickness counts: `axis of the first face` and so on.
    pub along: String,
    /// Distance of the two faces along that line, mm.
    pub centre_thickness: ParameterFigures,
    /// Angle between that line and the normal of the other face where it meets it, arcmin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wedge: Option<ParameterFigures>,
    /// Angle between the axes of the two, arcmin.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt: Option<ParameterFigures>,
    /// Distance of the other face's vertex from that line, µm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decentre: Option<ParameterFigures>,
    /// Why a figure is absent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unknown: Vec<String>,
}
