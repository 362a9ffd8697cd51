//! Figures that standards define beside PV and RMS: minimum zone, spectra, texture, the indication of a drawing.

use serde::{Deserialize, Serialize};

use crate::FormFigure;

/// Figures that were asked for and are known; of the others `form.unknown` says why.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StandardFigures {
    /// The narrowest zone that holds every point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub minimum_zone: Option<MinimumZoneFigures>,
    /// Found values, as a drawing would state it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub indication: Option<IndicationFigures>,
    /// How the deviation is spread over spatial frequencies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub psd: Option<PsdFigures>,
    /// The slope spectrum of the rotational part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub q_spectrum: Option<QFigures>,
    /// Areal surface texture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub texture: Option<TextureFigures>,
}

impl StandardFigures {
    /// Figures of points and of texture, in the order of reports.
    pub fn figures(&self) -> impl Iterator<Item = &FormFigure> {
        let zone = self.minimum_zone.iter().map(|zone| &zone.width);
        zone.chain(self.texture.iter().flat_map(|texture| &texture.figures))
    }

    /// Facts that must be known to read them, each with its name.
    pub fn facts(&self) -> Vec<(&'static str, String)> {
        let mut facts = Vec::new();
        if let Some(zone) = &self.minimum_zone {
            facts.push(("minimum zone, lower bound / nm", zone.lower_nm.to_string()));
        }
        if let Some(texture) = &self.texture {
            facts.push(("texture, surface", texture.surface.clone()));
            facts.extend(texture.filters.iter().map(|filter| ("texture, filter", filter.clone())));
        }
        if let Some(indication) = &self.indication {
            facts.push(("ISO 10110-5, found", indication.found.clone()));
            facts
                .extend(indication.asked.iter().map(|asked| ("ISO 10110-5, asked", asked.clone())));
        }
        facts
    }
}

/// A minimum zone with what shows that no place near by has a narrower one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MinimumZoneFigures {
    /// Its width, with its definition.
    pub width: FormFigure,
    /// The criterion in words.
    pub method: String,
    /// Why the search ended.
    pub termination: String,
    /// Whether the width exceeds its lower bound by no more than the tolerance of the search.
    pub settled: bool,
    /// No zone near by is narrower than this, nm: a bound by the multipliers of the contacts, to first order.
    pub lower_nm: f64,
    /// Width less that bound, nm.
    pub gap_nm: f64,
    /// Middle of the zone above the nominal, nm. It is large where the zone makes up for a wrong radius.
    pub offset_nm: f64,
    /// Points that were all held against the zone in the end.
    pub points: u64,
    /// How often that was done.
    pub passes: u64,
    /// PV of the same points at the least-squares fit, nm.
    pub least_squares_pv_nm: f64,
    /// Points that hold the zone, the largest share first.
    pub contacts: Vec<ContactFigures>,
}

/// A point that touches the border of a zone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContactFigures {
    /// Where, in the part frame of the least-squares fit, mm.
    pub at_mm: [f64; 3],
    /// Which border: `high`, on the +z side, or `low`.
    pub side: String,
    /// Its share in holding the zone, 0 to 1; all of them add up to 1.
    pub share: f64,
}

/// `3/A(B/C)` with its RMS, by ISO 10110-5.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct IndicationFigures {
    /// Indication of the drawing, if the nominal file has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked: Option<String>,
    /// Found values, in the unit of what is asked, else in nm.
    pub found: String,
}

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

/// Parameters of ISO 25178-2 of a surface between two scales.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TextureFigures {
    /// Which surface: `S-F`, `S-L`, or `all wavelengths measured`.
    pub surface: String,
    /// Meaning of the heights: the deviation from the fitted nominal, less this.
    pub f_operation: String,
    /// Nesting index of the S-filter, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub s_mm: Option<f64>,
    /// Nesting index of the L-filter, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub l_mm: Option<f64>,
    /// The filters in words, with what they had to do without.
    pub filters: Vec<String>,
    /// Points that count.
    pub points: u64,
    /// Share of the area of the mesh in the aperture that is measured densely enough and counts.
    pub measured: f64,
    /// The parameters.
    pub figures: Vec<FormFigure>,
}
