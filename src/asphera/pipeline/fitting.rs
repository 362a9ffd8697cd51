//! The final fit of a part: of its nominal, or of a surface made from the points where none is known.

use std::collections::HashMap;

use asphera_form::{Fit, FitError, Reference, ReferenceError, fit, fit_weighted, reference};
use asphera_surface::{Plane, PointMm};
use thiserror::Error;

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
}

/// Fits the part to the vertices of a mesh in the frame of `plane`. `measured` are the standard uncertainties of the
/// heights of points in the measured frame, where they carry some.
pub(super) fn fitted(
    points: &[PointMm],
    part: &Part,
    plane: &Plane,
    measured: &[(PointMm, f64)],
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
            let heights_mm = of_vertices(points, plane, measured).ok_or(NoFit::NoUncertainties)?;
            let first = fit(points, &part.nominal, &settings)?;
            let u_mm = along_normal(points, &first, plane, &heights_mm);
            let fit = fit_weighted(points, Some(&u_mm), &part.nominal, &settings)?;
            Ok(Fitted { fit, reference: None, uncertainties_mm: Some(u_mm) })
        }
    }
}

/// The uncertainty of the height of every vertex; `None` if one has none. A place measured more than once has that of
/// its first measurement, which is the vertex.
fn of_vertices(points: &[PointMm], plane: &Plane, measured: &[(PointMm, f64)]) -> Option<Vec<f64>> {
    let key = |point: PointMm| point.map(|coordinate| (coordinate + 0.0).to_bits());
    let mut known = HashMap::with_capacity(measured.len());
    for (point, u_mm) in measured {
        known.entry(key(plane.to_plane(*point))).or_insert(*u_mm);
    }
    points.iter().map(|point| known.get(&key(*point)).copied()).collect()
}

/// Uncertainties along z of the measured frame as uncertainties along the normal of the nominal as fitted. Where that
/// stands all but upright on z, the height says nothing of the distance; a tenth of it is taken at least.
fn along_normal(points: &[PointMm], fit: &Fit, plane: &Plane, heights_mm: &[f64]) -> Vec<f64> {
    let (turn, z) = (fit.pose.rotation(), plane.axes().map(|axis| axis[2]));
    let share = |point: &PointMm| {
        let [x, y, _] = fit.pose.to_part(*point);
        let [p, q] = fit.nominal.gradient(x, y);
        if !(p.is_finite() && q.is_finite()) {
            return 1.0;
        }
        let length = (1.0 + p * p + q * q).sqrt();
        let normal = turn.map(|row| (row[2] - row[0] * p - row[1] * q) / length);
        let along: f64 = normal.iter().zip(&z).map(|(a, b)| a * b).sum();
        along.abs().max(0.1)
    };
    points.iter().zip(heights_mm).map(|(point, u_mm)| share(point) * u_mm).collect()
}

#[cfg(test)]
mod tests;
