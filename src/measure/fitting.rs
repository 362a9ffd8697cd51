//! The final fit of a part: of its nominal, or of a surface made from the points where none is known.

use asphera_figures::{Subject, Treatment, is_motion};
use asphera_form::{
    Aperture, Fit, FitError, FitSettings, Parameter, Reference, ReferenceError, along_normal_mm,
    fit_weighted, reference,
};
use asphera_geometry::PointMm;
use asphera_surface::Plane;
use thiserror::Error;

use super::figures::termination;
use super::heights::up;
use super::origin;
use super::running::fit_settings;
use crate::{Part, Weights};

/// A fit and what it was made with.
pub(super) struct Fitted {
    pub(super) fit: Fit,
    /// The surface the points made, where no design is known.
    pub(super) reference: Option<Reference>,
    /// The standard uncertainty of every point along the normal, mm, where they are the weights.
    pub(super) uncertainties_mm: Option<Vec<f64>>,
    /// The aperture it was made in: that of the part, or a narrower one where points lay on its edge.
    pub(super) aperture: Aperture,
    /// How much narrower, mm.
    pub(super) narrowed_mm: Option<f64>,
    /// Where parameters of the shape were free, the same fit with the shape held at the design.
    pub(super) design: Option<Result<Fit, FitError>>,
}

impl Fitted {
    /// The fit that figures of a subject are formed of, or why there is none.
    pub(super) fn fit_for(&self, subject: Subject, part: &Part) -> Result<&Fit, String> {
        match (&self.design, subject.treatment(&part.free)) {
            (Some(design), Treatment::FromDesign) => {
                let found = design.as_ref();
                let found =
                    found.map_err(|error| against_design(&asphera_report::error_chain(error)))?;
                if !found.termination.is_converged() {
                    return Err(against_design(&termination(&found.termination)));
                }
                Ok(found)
            }
            _ => Ok(&self.fit),
        }
    }

    /// A fit of the nominal, and against the design.
    fn new(
        fit: Fit,
        uncertainties_mm: Option<Vec<f64>>,
        points: &[PointMm],
        part: &Part,
    ) -> Fitted {
        let motions: Vec<Parameter> =
            part.free.iter().copied().filter(|&parameter| is_motion(parameter)).collect();
        let design = (motions.len() < part.free.len()).then(|| {
            let settings =
                FitSettings { free: motions, start: fit.pose, search: false, ..fit_settings(part) };
            fit_weighted(points, uncertainties_mm.as_deref(), &part.nominal, &settings)
        });
        Fitted {
            fit,
            reference: None,
            uncertainties_mm,
            aperture: part.aperture.clone(),
            narrowed_mm: None,
            design,
        }
    }
}

/// Why there is no figure against the design.
fn against_design(why: &str) -> String {
    format!("the fit with the shape held at the design failed: {why}")
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
        "weights = \"uncertainty\", but the points carry none. Add a column u_z[mm] to the file, or set weights = \"none\""
    )]
    NoUncertainties,
    /// A profile that runs along neither axis, over a part that has axes.
    #[error(
        "the points lie on an oblique line. A freeform and a rectangular aperture need a profile along x or y"
    )]
    Oblique,
    /// The points are those of no surface over its plane.
    #[error("{0}")]
    Folded(String),
}

/// Fits the part to the vertices of a mesh in the frame of `plane`. `heights_mm` are the standard uncertainties of their
/// heights, where all have one.
pub(super) fn fitted(
    points: &[PointMm],
    part: &Part,
    plane: &Plane,
    heights_mm: Option<&[f64]>,
) -> Result<Fitted, NoFit> {
    edge::settled(part, |part| fitted_within(points, part, plane, heights_mm))
}

/// As [`fitted`], in the aperture of the part.
fn fitted_within(
    points: &[PointMm],
    part: &Part,
    plane: &Plane,
    heights_mm: Option<&[f64]>,
) -> Result<Fitted, NoFit> {
    if let Some(settings) = &part.reference {
        let reference = reference(points, settings)?;
        let fit = reference.fit.clone();
        return Ok(Fitted {
            fit,
            reference: Some(reference),
            uncertainties_mm: None,
            aperture: part.aperture.clone(),
            narrowed_mm: None,
            design: None,
        });
    }
    let start = origin::start_of(part, points);
    let settings = FitSettings { start, ..fit_settings(part) };
    let first = laid(points, None, part, &settings)?;
    match part.criterion.weights {
        Weights::None => Ok(Fitted::new(first, None, points, part)),
        Weights::Uncertainty => {
            let heights_mm = heights_mm.ok_or(NoFit::NoUncertainties)?;
            let u_mm = along_normal_mm(points, heights_mm, up(plane), &first);
            let fit = laid(points, Some(&u_mm), part, &settings)?;
            Ok(Fitted::new(fit, Some(u_mm), points, part))
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

mod edge;
#[cfg(test)]
mod tests;
