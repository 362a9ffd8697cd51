//! Local feature size of a freeform nominal, as a table over the places of its aperture.
//!
//! The medial balls of the surface over the aperture are found once, on a raster of [`RASTER`] steps across, each
//! refined to [`TOLERANCE`] (see `asphera_surface::lfs`); the local feature size is then taken, as the distance to
//! the nearest of their centres, at the nodes of a coarser grid, and interpolated bilinearly between them.
//!
//! **Error.** Centres are about a step apart, so the nearest is too far by second order in the step over the
//! local feature size. That changes by no more than the way gone, so a value between nodes is off by at
//! most the way to the farthest corner of the cell, whatever the surface; where it is smooth by second order of
//! that. A nominal with features narrower than the raster sees gives no table: the points then tell more.

use asphera_geometry::{BoundsMm, place};
use std::sync::Arc;

use asphera_form::shape::Shape;
use asphera_form::{Aperture, Nominal, PointMm, Pose};
use asphera_surface::lfs::{Jet, Lfs, LfsError, NominalLfs};
use rayon::prelude::*;
use thiserror::Error;

use crate::HIGHEST_MM;

/// Why there is no local feature size of a freeform.
#[derive(Clone, Debug, Error, PartialEq)]
pub(super) enum FreeformError {
    /// The nominal is none.
    #[error("a {kind} is rotational")]
    Rotational {
        /// Kind of the source.
        kind: &'static str,
    },
    /// It is too small or not defined at a place.
    #[error(
        "at ({x_mm}, {y_mm}) mm it is below what a raster of {step_mm} mm shows, or the nominal is not defined"
    )]
    Hidden {
        /// x in mm.
        x_mm: f64,
        /// y in mm.
        y_mm: f64,
        /// Step of the raster in mm.
        step_mm: f64,
    },
    /// It stands so high that it is no surface of a part.
    #[error(
        "at ({x_mm}, {y_mm}) mm the nominal is {height_mm:e} mm high: correct its coefficients, or give an aperture in \
         which it is a surface"
    )]
    TooHigh {
        /// x in mm.
        x_mm: f64,
        /// y in mm.
        y_mm: f64,
        /// Its height there in mm.
        height_mm: f64,
    },
    /// The kernel found none.
    #[error(transparent)]
    Lfs(#[from] LfsError),
}

/// The places a nominal is looked at: a rectangle of the part frame, or the disc about the vertex in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Footprint {
    low_mm: [f64; 2],
    high_mm: [f64; 2],
    /// Infinite where it is no disc.
    rim_mm: f64,
}

impl Footprint {
    /// That of an aperture, a ring with its hole; where every point counts, the box about the points in the part frame, a
    /// little widened so that it seldom changes while they come.
    pub(super) fn of(aperture: &Aperture, points: &[PointMm], pose: &Pose) -> Footprint {
        let about =
            |[x, y]: [f64; 2], rim_mm| Footprint { low_mm: [-x, -y], high_mm: [x, y], rim_mm };
        match aperture.half_extents_mm() {
            Some(half_mm) if aperture.is_round() => about(half_mm, half_mm[0]),
            Some(half_mm) => about(half_mm, f64::INFINITY),
            None => Footprint::about_points(points, pose),
        }
    }

    fn about_points(points: &[PointMm], pose: &Pose) -> Footprint {
        let places = points.iter().map(|&point| place(pose.to_part(point)));
        let BoundsMm { low: mut low_mm, high: mut high_mm } = BoundsMm::about(places);
        for axis in 0..2 {
            // From one power of two to the next the box grows in eight steps.
            let quantum_mm = (high_mm[axis] - low_mm[axis]).log2().ceil().exp2() / 8.0;
            if quantum_mm > 0.0 && quantum_mm.is_finite() {
                low_mm[axis] = (low_mm[axis] / quantum_mm).floor() * quantum_mm;
                high_mm[axis] = (high_mm[axis] / quantum_mm).ceil() * quantum_mm;
            }
        }
        Footprint { low_mm, high_mm, rim_mm: f64::INFINITY }
    }

    fn size_mm(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.high_mm[axis] - self.low_mm[axis])
    }
}

/// Refuses a shape that is far higher on the border of its footprint than parts are: its medial balls would be looked for without
/// an end. Where the border lies beyond the shape, the end of the shape counts.
fn must_be_level(shape: &dyn Shape, footprint: Footprint) -> Result<(), FreeformError> {
    let [width_mm, length_mm] = footprint.size_mm();
    let most_mm = HIGHEST_MM.max(width_mm + length_mm);
    let rim_mm = footprint.rim_mm.min(WITHIN * shape.domain_mm());
    let [[x0, y0], [x1, y1]] = [footprint.low_mm, footprint.high_mm];
    let [x, y] = [0.5 * (x0 + x1), 0.5 * (y0 + y1)];
    for [x_mm, y_mm] in [[x0, y0], [x0, y1], [x1, y0], [x1, y1], [x0, y], [x1, y], [x, y0], [x, y1]]
    {
        let inwards = (rim_mm / x_mm.hypot(y_mm)).min(1.0);
        let (x_mm, y_mm) = (inwards * x_mm, inwards * y_mm);
        if let Some(height_mm) = shape.sag_mm(x_mm, y_mm).filter(|z_mm| z_mm.abs() > most_mm) {
            return Err(FreeformError::TooHigh { x_mm, y_mm, height_mm });
        }
    }
    Ok(())
}

/// The local feature size over a footprint.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Freeform {
    footprint: Footprint,
    /// Nodes per mm along x and y.
    scale_per_mm: [f64; 2],
    /// Nodes along x and y, two at least.
    size: [usize; 2],
    /// At each node in mm, row by row; infinite over a plane.
    nodes_mm: Vec<f64>,
}

impl Freeform {
    /// That of a nominal over its footprint.
    ///
    /// # Errors
    ///
    /// When the nominal is rotational, the footprint has no area, or there is a place at which the local feature
    /// size is not known.
    pub(super) fn of(nominal: &Nominal, footprint: Footprint) -> Result<Freeform, FreeformError> {
        let Some(shape) = nominal.freeform() else {
            return Err(FreeformError::Rotational { kind: nominal.kind() });
        };
        must_be_level(shape.as_ref(), footprint)?;
        let [width_mm, height_mm] = footprint.size_mm();
        let middle_mm = (width_mm * height_mm).sqrt();
        // Of a strip the raster is to see the width as well.
        let across_mm = width_mm.min(height_mm) / STRIP;
        let step_mm = across_mm.clamp(middle_mm / FINEST, middle_mm / RASTER);
        let over = Over { shape: Arc::clone(shape), footprint };
        let lfs = NominalLfs::new(over, step_mm, TOLERANCE)?;
        let size = footprint.size_mm().map(|side_mm| {
            ((side_mm * NODES / middle_mm).ceil() as usize).clamp(1, MOST_NODES) + 1
        });
        let cell_mm = [0, 1].map(|axis| footprint.size_mm()[axis] / (size[axis] - 1) as f64);
        let reach_mm = (WITHIN * shape.domain_mm()).min((1.0 - f64::EPSILON) * footprint.rim_mm);
        let node = |index: usize| {
            let [x, y] = [index % size[0], index / size[0]];
            let at = |axis: usize, node: usize| {
                // The last one is not to fall off the footprint by rounding.
                let at_mm = footprint.low_mm[axis] + node as f64 * cell_mm[axis];
                at_mm.min(footprint.high_mm[axis])
            };
            let (x_mm, y_mm) = (at(0, x), at(1, y));
            // A corner beyond the rim has the value of the rim nearest to it.
            let inwards = (reach_mm / x_mm.hypot(y_mm)).min(1.0);
            let (x_mm, y_mm) = (inwards * x_mm, inwards * y_mm);
            let known = shape.sag_mm(x_mm, y_mm).map(|z_mm| lfs.axis().at([x_mm, y_mm, z_mm]));
            match known {
                Some(Lfs::Known { mm, .. }) => Ok(mm),
                Some(Lfs::Beyond { .. }) => Ok(f64::INFINITY),
                Some(Lfs::Hidden { .. } | Lfs::Unknown(_)) | None => {
                    Err(FreeformError::Hidden { x_mm, y_mm, step_mm })
                }
            }
        };
        let nodes_mm: Result<Vec<f64>, FreeformError> =
            (0..size[0] * size[1]).into_par_iter().map(node).collect();
        let scale_per_mm = cell_mm.map(f64::recip);
        Ok(Freeform { footprint, scale_per_mm, size, nodes_mm: nodes_mm? })
    }

    /// The places it is over.
    pub(super) fn footprint(&self) -> &Footprint {
        &self.footprint
    }

    /// At a place of the part frame in mm; beyond the footprint that at its border. `None` where the place is
    /// not a number.
    pub(super) fn at(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        if x_mm.is_nan() || y_mm.is_nan() {
            return None;
        }
        let along = |axis: usize, at_mm: f64| {
            let last = self.size[axis] - 1;
            let at = (at_mm - self.footprint.low_mm[axis]) * self.scale_per_mm[axis];
            let at = at.clamp(0.0, last as f64);
            let node = (at as usize).min(last - 1);
            (node, at - node as f64)
        };
        let ((column, right), (row, up)) = (along(0, x_mm), along(1, y_mm));
        let first = row * self.size[0] + column;
        let corners = [
            (first, (1.0 - right) * (1.0 - up)),
            (first + 1, right * (1.0 - up)),
            (first + self.size[0], (1.0 - right) * up),
            (first + self.size[0] + 1, right * up),
        ];
        // Infinite nodes do not count where their weight is 0.
        let of = |(node, share): (usize, f64)| {
            if share > 0.0 { share * self.nodes_mm[node] } else { 0.0 }
        };
        Some(corners.into_iter().map(of).sum())
    }

    /// The smallest in mm over the footprint without a hole of this radius about the vertex; infinite over a plane.
    /// Never above the true minimum of [`Freeform::at`]; below it by no more than a cell changes, at the border
    /// of the hole.
    pub(super) fn least_mm(&self, hole_mm: f64) -> f64 {
        let cell_mm = self.scale_per_mm.map(f64::recip);
        // A node in the hole counts as long as it is a corner of a cell that reaches out of it.
        let hole_mm = hole_mm - cell_mm[0].hypot(cell_mm[1]);
        let counts = |&(node, _): &(usize, &f64)| {
            let place = [node % self.size[0], node / self.size[0]];
            let [x_mm, y_mm] =
                [0, 1].map(|axis| self.footprint.low_mm[axis] + place[axis] as f64 * cell_mm[axis]);
            x_mm.hypot(y_mm) >= hole_mm
        };
        let nodes_mm = self.nodes_mm.iter().enumerate().filter(counts).map(|(_, mm)| *mm);
        nodes_mm.fold(f64::INFINITY, f64::min)
    }
}

/// A shape over a footprint.
struct Over {
    shape: Arc<dyn Shape>,
    footprint: Footprint,
}

impl asphera_surface::lfs::Nominal for Over {
    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let Footprint { low_mm: [left, down], high_mm: [right, up], rim_mm } = self.footprint;
        let inside = (left..=right).contains(&x_mm) && (down..=up).contains(&y_mm);
        if !inside || x_mm.hypot(y_mm) > rim_mm {
            return None;
        }
        let jet = self.shape.jet(x_mm, y_mm)?;
        // At the end of its domain a shape may stand upright.
        let [p, q] = jet.gradient;
        (jet.z_mm + p + q + jet.hessian_per_mm.iter().sum::<f64>()).is_finite().then_some(Jet {
            height_mm: jet.z_mm,
            slope: jet.gradient,
            bend_per_mm: jet.hessian_per_mm,
        })
    }

    fn extent_mm(&self) -> [[f64; 2]; 2] {
        [self.footprint.low_mm, self.footprint.high_mm]
    }
}

/// Steps of the raster across a square footprint.
const RASTER: f64 = 48.0;
/// Steps across a strip, and how much finer than [`RASTER`] the raster may become for it.
const STRIP: f64 = 8.0;
const FINEST: f64 = 200.0;
/// Cells across a square footprint.
const NODES: f64 = 32.0;
/// Cells along a side.
const MOST_NODES: usize = 512;
/// How far values are refined, as a share.
const TOLERANCE: f64 = 1e-3;
/// The end of a domain may stand upright.
const WITHIN: f64 = 1.0 - 1e-6;

#[cfg(test)]
mod tests;
