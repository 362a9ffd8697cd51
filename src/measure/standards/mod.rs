//! Figures of standards that need more than deviations: minimum zone, spectrum of the map, texture; and their limits.

mod indication;
mod limits;
mod spectrum;
mod texture;
mod uncertain;
mod zone;

use asphera_figures::{Definition, texture as texture_kernel};
use asphera_form::Fit;
use asphera_geometry::{PointMm, VertexId};
pub(super) use indication::found;
pub(super) use limits::{hold, limits};
pub(super) use spectrum::q_spectrum;
use uncertain::Uncertain;

use asphera_report::{FormFigure, StandardFigures, error_chain};

use super::deviation_map::DeviationMap;
use super::uncertainties::Assessed;
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

/// Those that the nominal file asks for, with their uncertainties.
#[derive(Default)]
pub(super) struct Standards {
    pub(super) figures: StandardFigures,
    /// Definitions of the parameters of texture, in the order of their figures.
    texture: Vec<texture_kernel::Definition>,
    /// Why others are not known.
    pub(super) unknown: Vec<String>,
}

impl Standards {
    /// A figure of points and nominal, and the least it may be where it may still be too large; `None` where it is not known.
    fn of_points(&self, definition: Definition) -> Option<(&FormFigure, Option<f64>)> {
        match definition {
            Definition::MinimumZone => self.figures.minimum_zone.as_ref().map(zone::held),
            _ => None,
        }
    }

    /// A parameter of texture; `None` where it is not known.
    fn texture_of(&self, definition: texture_kernel::Definition) -> Option<&FormFigure> {
        let place = self.texture.iter().position(|one| *one == definition)?;
        self.figures.texture.as_ref()?.figures.get(place)
    }
}

/// Figures that the nominal file asks for, with their uncertainties where a budget gives some.
pub(super) fn standards(measured: &Measured<'_>, assessed: Option<&Assessed>) -> Standards {
    let Measured { part, map, .. } = *measured;
    let mut standards = Standards::default();
    let unknown = &mut standards.unknown;
    let zone = part.asks_for(Definition::MinimumZone).then(|| zone::found(measured));
    let zone = zone.and_then(|found| match found {
        Ok(found) => Some(found),
        Err(why) => {
            unknown.push(format!("minimum zone: {}", error_chain(&why)));
            None
        }
    });
    if part.figures.psd {
        let map = map.ok_or("there is no map of the deviation".to_owned());
        let found = map.and_then(|map| {
            let noise =
                measured.noise_nm.map(|nm| spectrum::noise_nm2_mm2(nm, map, measured.areas_mm2));
            spectrum::psd(map, noise).map_err(|why| why.to_string())
        });
        match found {
            Ok(found) => standards.figures.psd = Some(found),
            Err(why) => unknown.push(format!("PSD: {why}")),
        }
    }
    let texture = part.figures.texture.as_ref();
    let texture = texture.and_then(|settings| match texture::found(measured, settings) {
        Ok(found) => {
            unknown.extend(found.unknown.iter().cloned());
            Some((settings, found))
        }
        Err(why) => {
            unknown.push(format!("texture: {why}"));
            None
        }
    });
    let sure = assessed.map_or_else(Uncertain::default, |assessed| {
        Uncertain::of(zone.as_ref(), texture.as_ref(), assessed, part)
    });
    unknown.extend(sure.unknown);
    standards.figures.minimum_zone = zone.map(|found| zone::figures(measured, &found, sure.zone));
    if let Some((settings, found)) = texture {
        standards.texture = found.figures.iter().map(|figure| figure.definition).collect();
        standards.figures.texture = Some(texture::figures(settings, found, &sure.texture));
    }
    standards
}

#[cfg(test)]
mod spectra_tests;
#[cfg(test)]
mod tests;
