//! Power spectral density.

use serde::{Deserialize, Serialize};

use super::{Standard, StandardFigure};
use crate::FormFigures;
use crate::view::Chapter;
use crate::words::{percent, short};

/// The radial average of a two-sided power spectral density.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PsdFigures {
    /// Definition in one sentence.
    pub definition: String,
    /// Terms removed from the map before: `piston, tilt, power`.
    pub removed: String,
    /// The window: `Hann`.
    pub window: String,
    /// Where the heights come from: as measured, or interpolated between the points.
    #[serde(default)]
    pub source: String,
    /// Distance of the nodes of the map along its two axes, mm.
    pub spacing_mm: [f64; 2],
    /// Highest frequency up to which the density is given, cycles per mm: half a cycle over the coarser distance, or less
    /// where interpolation leaves too little of the waves.
    #[serde(default)]
    pub up_to_per_mm: f64,
    /// Empty nodes of a raster that were filled from well-sampled neighbours.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub bridged: u64,
    /// Share of the rectangle of the map that is measured. What is not acts as a window too.
    pub measured: f64,
    /// Density of the noise of the points, nm²·mm², at all frequencies alike. It is in the density below; absent where the
    /// noise is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_nm2_mm2: Option<f64>,
    /// RMS under the window, nm: of a raster over all frequencies, in the corners beyond the last ring too; of scattered
    /// points over those given.
    pub rms_nm: f64,
    /// Middle of each ring of frequencies, cycles per mm, ascending.
    pub frequency_per_mm: Vec<f64>,
    /// Mean density over the ring, nm²·mm².
    pub density_nm2_mm2: Vec<f64>,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl StandardFigure for PsdFigures {
    fn chapter(&self, _: &FormFigures) -> Option<Chapter> {
        let mut chapter = Chapter::of_standard(Standard::Psd, "Power spectral density");
        let noise = self.noise_nm2_mm2.map_or(String::new(), |noise| {
            format!(
                " Of the density, {} nm²·mm² at every frequency are noise of the points.",
                short(noise)
            )
        });
        chapter.note(format!(
            "Power spectral density: {}; {}. Taken out before: {}. {} window; {} of the rectangle of the map is measured, nodes \
             {} × {} mm apart. Given up to {} cycles per mm. RMS {} nm.{noise}",
            self.definition,
            self.source,
            self.removed,
            self.window,
            percent(self.measured),
            short(self.spacing_mm[0]),
            short(self.spacing_mm[1]),
            short(self.up_to_per_mm),
            short(self.rms_nm),
        ));
        Some(chapter)
    }
}
