//! The form: nominal, fit and what remains.

use serde::{Deserialize, Serialize};

use crate::{
    DeviationFigures, FitFigures, FormFigure, HistogramFigures, OriginFigures, ReferenceFigures,
    RingFigures, StandardFigures, ZernikeFigures,
};

/// Nominal, fit and deviation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FormFigures {
    /// The design surface in words: `asphere R 11.65 mm, conic -1.1, …`.
    pub nominal: String,
    /// The surface that was made from the points where no design is known; final only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceFigures>,
    /// How the nominal was laid into the points.
    pub fit: FitFigures,
    /// Where places of the part, rings, Zernike terms and slopes along the meridian count from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<OriginFigures>,
    /// Deviation from the fitted nominal.
    pub deviation: DeviationFigures,
    /// Whether these are running figures, to be replaced by a full fit at the end.
    pub provisional: bool,
    /// The figures of standards and optical shops, final only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<FormFigure>,
    /// The deviation in Zernike terms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zernike: Option<ZernikeFigures>,
    /// Why the Zernike terms are not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zernike_unknown: Option<String>,
    /// How many points have which deviation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub histogram: Option<HistogramFigures>,
    /// Mean deviation by distance from the origin, the innermost ring first; final only.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rings: Vec<RingFigures>,
    /// Minimum zone, spectra, texture and the indication of the drawing; final only.
    #[serde(flatten)]
    pub standards: StandardFigures,
    /// Why a figure is not known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unknown: Vec<String>,
}
