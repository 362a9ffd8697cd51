//! Figures of a deviation: analytic truths, laws, degenerate input, and figures by other software.

mod degenerate;
mod known;
mod laws;
mod noisy;
mod oracle;
mod raster;
mod spectra;

use asphera_figures::Sample;
use asphera_form::Aperture;

use crate::common::spiral;

pub(crate) const DISC: Aperture = Aperture::Circle { radius_mm: 5.0 };

/// Heights in nm at evenly spread places of a disc of radius 5 mm.
pub(crate) fn disc(count: usize, height_nm: impl Fn(f64, f64) -> f64) -> Sample {
    part(&spiral(count, 5.0), height_nm)
}

/// Heights in nm at places in mm within the disc.
pub(crate) fn part(places_mm: &[[f64; 2]], height_nm: impl Fn(f64, f64) -> f64) -> Sample {
    let deviations: Vec<f64> = places_mm.iter().map(|p| height_nm(p[0], p[1]) * 1e-6).collect();
    Sample::new(places_mm, &deviations, None, &DISC).unwrap()
}
