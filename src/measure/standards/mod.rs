//! Figures of standards that need more than deviations: minimum zone, spectrum of the map, texture; and their limits.

mod indication;
mod limits;
mod spectrum;
mod texture;
mod uncertain;
mod zone;

use asphera_figures::texture::Mesh;
use asphera_form::{Fit, ZoneFit};
use asphera_geometry::{PointMm, VertexId};
pub(super) use indication::found;
pub(super) use limits::hold;
pub(super) use spectrum::q_spectrum;
pub(super) use uncertain::tell;

use asphera_report::FormFigures;
use asphera_report::error_chain;

use super::deviation_map::DeviationMap;
use crate::Part;

/// Ingredients of the figures, in the frame the fit was made in.
#[derive(Clone, Copy)]
pub(super) struct Measured<'a> {
    pub(super) part: &'a Part,
    pub(super) fit: &'a Fit,
    pub(super) points: &'a [PointMm],
    /// Deviation of every point, NaN for none.
    pub(super) deviations_mm: &'a [f64],
    pub(super) triangles: &'a [[VertexId; 3]],
    /// Whether each triangle is sampled densely enough.
    pub(super) covered: &'a [bool],
    /// The area each point stands for.
    pub(super) areas_mm2: &'a [f64],
    pub(super) map: Option<&'a DeviationMap>,
    /// Noise of a point, where it is known.
    pub(super) noise_nm: Option<f64>,
}

/// Intermediate results that the uncertainties need.
#[derive(Default)]
pub(super) struct Found {
    pub(super) zone: Option<ZoneFit>,
    /// The scale-limited surface.
    pub(super) texture: Option<Mesh>,
}

/// Adds those that the nominal file asks for to the figures of the form, or why they are not known.
pub(super) fn add(form: &mut FormFigures, measured: &Measured<'_>) -> Found {
    let Measured { part, map, .. } = *measured;
    let (standards, unknown) = (&mut form.standards, &mut form.unknown);
    let mut found = Found::default();
    if part.figures.minimum_zone || part.judging.minimum_zone_nm.is_some() {
        match zone::of(measured) {
            Ok((figures, zone)) => {
                standards.minimum_zone = Some(figures);
                found.zone = Some(zone);
            }
            Err(why) => {
                unknown.push(format!("minimum zone: {}", error_chain(&why)));
            }
        }
    }
    if part.figures.psd {
        let map = map.ok_or("there is no map of the deviation".to_owned());
        let found = map.and_then(|map| {
            let noise =
                measured.noise_nm.map(|nm| spectrum::noise_nm2_mm2(nm, map, measured.areas_mm2));
            spectrum::psd(map, noise).map_err(|why| why.to_string())
        });
        match found {
            Ok(found) => standards.psd = Some(found),
            Err(why) => unknown.push(format!("PSD: {why}")),
        }
    }
    if let Some(settings) = &part.figures.texture {
        match texture::of(measured, settings) {
            Ok((figures, lacking, surface)) => {
                standards.texture = Some(figures);
                found.texture = Some(surface);
                unknown.extend(lacking);
            }
            Err(why) => unknown.push(format!("texture: {why}")),
        }
    }
    found
}

#[cfg(test)]
mod spectra_tests;
#[cfg(test)]
mod tests;
