//! Figures that standards define beside PV and RMS: a file each, which has its type in reports and its words.
//!
//! A new one is such a file, a field of [`StandardFigures`], a place in `StandardFigures::all` and, for a chapter of its
//! own, a name in [`Standard`]. Terminal, page, paper and QIF draw it without a change.

mod indication;
mod minimum_zone;
mod psd;
mod q_spectrum;
mod texture;

pub use indication::IndicationFigures;
pub use minimum_zone::{ContactFigures, MinimumZoneFigures};
pub use psd::PsdFigures;
pub use q_spectrum::QFigures;
use serde::{Deserialize, Serialize};
pub use texture::TextureFigures;

use crate::view::{Chapter, ChapterId};
use crate::{FormFigure, FormFigures};

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

/// Figures with a chapter of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standard {
    /// Minimum zone.
    MinimumZone,
    /// Surface texture.
    Texture,
    /// Power spectral density.
    Psd,
    /// Spectrum of slopes by Forbes' polynomials.
    QSpectrum,
}

/// Outputs of a figure.
trait StandardFigure {
    /// Its chapter in words.
    fn chapter(&self, _form: &FormFigures) -> Option<Chapter> {
        None
    }

    /// Values that an exchange file lists.
    fn figures(&self) -> &[FormFigure] {
        &[]
    }

    /// Facts that must be known to read them, each with its name.
    fn facts(&self) -> Vec<(&'static str, String)> {
        Vec::new()
    }
}

impl StandardFigures {
    /// Those that there are, in the order of reports.
    fn all(&self) -> impl Iterator<Item = &dyn StandardFigure> {
        let StandardFigures { minimum_zone, indication, psd, q_spectrum, texture } = self;
        let all =
            [known(minimum_zone), known(texture), known(psd), known(q_spectrum), known(indication)];
        all.into_iter().flatten()
    }

    /// Values that an exchange file lists.
    pub fn figures(&self) -> impl Iterator<Item = &FormFigure> {
        self.all().flat_map(StandardFigure::figures)
    }

    /// Facts that must be known to read them, each with its name.
    pub fn facts(&self) -> Vec<(&'static str, String)> {
        self.all().flat_map(StandardFigure::facts).collect()
    }

    /// Their chapters; `form` is what they belong to.
    pub(crate) fn chapters(&self, form: &FormFigures) -> Vec<Chapter> {
        self.all().filter_map(|figure| figure.chapter(form)).collect()
    }
}

fn known(figure: &Option<impl StandardFigure>) -> Option<&dyn StandardFigure> {
    figure.as_ref().map(|figure| figure as &dyn StandardFigure)
}

impl Standard {
    /// Its word in a short summary.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Standard::MinimumZone => "zone",
            Standard::Texture => "texture",
            Standard::Psd | Standard::QSpectrum => "spectrum",
        }
    }

    /// Chapter whose place its words share. Curves have places of their own.
    pub(crate) fn placed_under(self) -> Option<ChapterId> {
        match self {
            Standard::Psd | Standard::QSpectrum => None,
            _ => Some(ChapterId::Figures),
        }
    }
}
