//! The final fit of a part: of its nominal, or of a surface made from the points where none is known.

use asphera_form::{
    Fit, FitError, FitSettings, Reference, ReferenceError, along_normal_mm, fit_weighted, reference,
};
use asphera_surface::{Plane, PointMm};
use thiserror::Error;

use super::heights::{Heights, up};
use super::origin;
use super::running::fit_settings;
use crate::config::{Part, Weights};

/// A fit and what it was made with.
pub(super) struct Fitted {
    pub(super) fit: Fit,
    /// The surface the points made, where no design is known.
    pub(super) reference: Option<Reference>,
    /// The standard uncertainty of every point along the normal, mm, where they are the weights.
    pub(super) uncertainties_mm: Option<Vec<f64>>,
}

/// Why there is no fit.
#[derive(Clone, Debug, Error, PartialEq)]
pub(super) enum NoFit {
    /// The nominal cannot be laid into the points.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The points make no surface.
    #[error(transparent)]
    Reference(#[from] ReferenceError),
    /// Weights are asked for, but points have no uncertainties.
    #[error(
        "weights by uncertainty are asked for, but the points carry none: expected a column u_z[mm] in the file, or weights = \"none\""
    )]
    NoUncertainties,
    /// A profile that runs along neither axis, over a part that has axes.
    #[error(
        "the points lie on an oblique line: expected a profile along x or y of a freeform, of a rectangular aperture, and \
         with weights by uncertainty"
    )]
    Oblique,
    /// The points are those of no surface over its plane.
    #[error("{0}")]
    Folded(String),
}

/// Fits the part to the vertices of a mesh in the frame of `plane`.
pub(super) fn fitted(
    points: &[PointMm],
    part: &Part,
    plane: &Plane,
    heights: &mut Heights,
) -> Result<Fitted, NoFit> {
    if let Some(settings) = &part.reference {
        let reference = reference(points, settings)?;
        let fit = reference.fit.clone();
        return Ok(Fitted { fit, reference: Some(reference), uncertainties_mm: None });
    }
    let start = origin::start_of(part, points);
    let settings = FitSettings { start, ..fit_settings(part) };
    let first = laid(points, None, part, &settings)?;
    match part.criterion.weights {
        Weights::None => Ok(Fitted { fit: first, reference: None, uncertainties_mm: None }),
        Weights::Uncertainty => {
            let heights_mm = heights.of_all(points, plane).ok_or(NoFit::NoUncertainties)?;
            let u_mm = along_normal_mm(points, &heights_mm, up(plane), &first);
            let fit = laid(points, Some(&u_mm), part, &settings)?;
            Ok(Fitted { fit, reference: None, uncertainties_mm: Some(u_mm) })
        }
    }
}

/// The fit, with its origin where the settings start.
fn laid(
    points: &[PointMm],
    u_mm: Option<&[f64]>,
    part: &Part,
    settings: &FitSettings,
) -> Result<Fit, FitError> {
    let first = fit_weighted(points, u_mm, &part.nominal, settings)?;
    match origin::moved_along(part, &first, &settings.start) {
        Some(start) => {
            let settings = FitSettings { start, search: false, ..settings.clone() };
            fit_weighted(points, u_mm, &part.nominal, &settings)
        }
        None => Ok(first),
    }
}

#[cfg(test)]
mod tests;
