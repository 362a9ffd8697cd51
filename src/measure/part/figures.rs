//! Settings of the figures beside fit, PV and RMS.

use std::num::NonZeroU8;

use asphera_figures::texture::{Datum, Scale};
use asphera_figures::{Definition, FringeCount, SlopeSettings};
use asphera_form::Aperture;

/// Which figures are formed, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureSettings {
    /// Figures of points and nominal that are asked for, among [`Definition::OF_POINTS`].
    pub of_points: Vec<Definition>,
    /// How slopes are formed; none: over a twentieth of the aperture's width, in steps of half of that.
    pub slope: Option<SlopeSettings>,
    /// Whether the power spectral density of the deviation map is formed.
    pub psd: bool,
    /// Zernike terms that are fitted together.
    pub zernike: FringeCount,
    /// Q-bfs polynomials of the slope spectrum; none: it is not formed.
    pub q_terms: Option<NonZeroU8>,
    /// The scale of the surface texture; none: its parameters are not formed.
    pub texture: Option<TextureSettings>,
}

/// Between which wavelengths, and about what, surface texture is described.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureSettings {
    /// Terms removed from the deviation from the nominal before the filters.
    pub f_operation: Datum,
    /// The filters.
    pub scale: Scale,
}

impl Default for FigureSettings {
    /// What costs little beside the mesh.
    fn default() -> FigureSettings {
        FigureSettings {
            of_points: Vec::new(),
            slope: None,
            psd: true,
            zernike: FringeCount::ThirtySix,
            q_terms: NonZeroU8::new(Q_TERMS),
            texture: None,
        }
    }
}

impl FigureSettings {
    /// How slopes are formed over an aperture whose sample reaches to this radius; `None` if it has no width.
    pub fn slope_over(&self, aperture: &Aperture, radius_mm: f64) -> Option<SlopeSettings> {
        let width_mm = match *aperture {
            Aperture::Outline { .. } => 2.0 * aperture.half_width_mm(),
            Aperture::Rectangle { width_mm, height_mm } => width_mm.min(height_mm),
            _ => 2.0 * radius_mm,
        };
        let integration_mm = width_mm / 20.0;
        self.slope.or_else(|| SlopeSettings::new(integration_mm, integration_mm / 2.0).ok())
    }
}

/// Q polynomials fitted by default. They follow some eight waves along the radius.
pub const Q_TERMS: u8 = 24;
