//! The final fit of a part: of its nominal, or of a surface made from the points where none is known.

use asphera_form::{
    Fit, FitError, Reference, ReferenceError, along_normal_mm, fit, fit_weighted, reference,
};
use asphera_surface::{Plane, PointMm};
use thiserror::Error;

use super::heights::{Heights, up};
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
    let settings = fit_settings(part);
    match part.criterion.weights {
        Weights::None => {
            let fit = fit(points, &part.nominal, &settings)?;
            Ok(Fitted { fit, reference: None, uncertainties_mm: None })
        }
        Weights::Uncertainty => {
            let heights_mm = heights.of_all(points, plane).ok_or(NoFit::NoUncertainties)?;
            let first = fit(points, &part.nominal, &settings)?;
            let u_mm = along_normal_mm(points, &heights_mm, up(plane), &first);
            let fit = fit_weighted(points, Some(&u_mm), &part.nominal, &settings)?;
            Ok(Fitted { fit, reference: None, uncertainties_mm: Some(u_mm) })
        }
    }
}

#[cfg(test)]
mod tests;
