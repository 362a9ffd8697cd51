//! Spectrum of slopes by Forbes' polynomials.

use serde::{Deserialize, Serialize};

use super::{Standard, StandardFigure};
use crate::FormFigures;
use crate::view::Chapter;
use crate::words::short;

/// Coefficients of Forbes' slope-orthogonal polynomials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct QFigures {
    /// Definitions in one sentence.
    pub definition: String,
    /// Radius of the disc they refer to, mm.
    pub radius_mm: f64,
    /// Rise of the power fitted beside them from the origin to the rim, nm.
    pub power_nm: f64,
    /// Terms asked for.
    #[serde(default)]
    pub asked: u64,
    /// Why there are fewer than that.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// Coefficients a₀, a₁ …, nm; none for one that noise makes more uncertain than all of the deviation is.
    pub coefficients_nm: Vec<Option<f64>>,
    /// Their standard uncertainties by independent noise of the points, or by what the series leaves, if that is more, nm.
    #[serde(default)]
    pub u_nm: Vec<f64>,
    /// The noise of a point that was taken, nm.
    #[serde(default)]
    pub noise_nm: f64,
    /// Whether that is the RMS of what the series leaves, because no noise was known or this is more.
    #[serde(default)]
    pub noise_of_residuals: bool,
    /// Whether the last quarter of the terms asked for holds less than a tenth of the sum of their squares, noise taken
    /// off. If not, the deviation has more waves along the radius than they can follow, and that bends all of them.
    pub ends: bool,
    /// Root of the sum of their squares over the radius, noise taken off, µrad: an RMS slope along the meridian that
    /// stresses the rim. Absent where a coefficient is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slope_rms_urad: Option<f64>,
    /// Share of noise alone, µrad; taken off in squares.
    #[serde(default)]
    pub slope_noise_urad: f64,
    /// The interval of 95 %, µrad.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slope_95_urad: Option<[f64; 2]>,
}

impl StandardFigure for QFigures {
    fn chapter(&self, _: &FormFigures) -> Option<Chapter> {
        let mut chapter = Chapter::of_standard(Standard::QSpectrum, "Slope spectrum");
        let note = self.note.as_ref().map_or(String::new(), |note| format!(" {note}."));
        let end = if self.ends {
            ""
        } else {
            " The series does not end here: the deviation has more waves along the radius than these terms can follow, and \
             that changes all of them. Set a larger q_terms in the table [figures] of the nominal."
        };
        chapter.note(format!(
            "Q spectrum: {}. Radius {} mm, power {} nm. {}{note}{end}",
            self.definition,
            short(self.radius_mm),
            short(self.power_nm),
            slope(self),
        ));
        Some(chapter)
    }
}

/// The RMS slope with what noise does to it, and whence the noise is.
fn slope(q: &QFigures) -> String {
    let by = if q.noise_of_residuals { "what the series leaves" } else { "noise of the points" };
    let taken = format!("Lines: standard uncertainties by {by}, {} nm.", short(q.noise_nm));
    match (q.slope_rms_urad, q.slope_95_urad) {
        (Some(slope), Some([low, high])) => format!(
            "RMS slope of the series {} µrad (95 %: {} to {} µrad), {} µrad of noise taken off. {taken}",
            short(slope),
            short(low),
            short(high),
            short(q.slope_noise_urad)
        ),
        _ => format!("RMS slope of the series not known: noise makes terms too uncertain. {taken}"),
    }
}
