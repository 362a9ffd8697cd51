//! A surface of cubic B-splines over a rectangle.
//!
//! Products of uniform cubic B-splines along x and y (de Boor, A Practical Guide to Splines, chapter IX): over
//! a cell the surface is a sum of 4 by 4 products, and its second derivatives are continuous.

use std::sync::Arc;

use thiserror::Error;

use super::argument::count;
use super::at_first_use::AtFirstUse;
use super::raster::Raster;
use super::{Jet, Shape, ShapeError, ShapeParameter};

/// The cells over which splines live: `nx` by `ny` of equal size from a corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// x of the first border in mm.
    pub x_min_mm: f64,
    /// y of the first border in mm.
    pub y_min_mm: f64,
    /// Width of a cell in mm.
    pub step_x_mm: f64,
    /// Height of a cell in mm.
    pub step_y_mm: f64,
    /// Cells along x.
    pub nx: usize,
    /// Cells along y.
    pub ny: usize,
}

impl Cells {
    /// Number of B-splines: (nx + 3)·(ny + 3).
    pub fn splines(&self) -> usize {
        (self.nx + 3) * (self.ny + 3)
    }

    /// Index of the cell at a place, row after row with x running faster, and the place within it (0 to 1);
    /// `None` outside.
    pub(crate) fn at(&self, x_mm: f64, y_mm: f64) -> Option<(usize, [f64; 2])> {
        let ([i, j], within) = self.raster().find(x_mm, y_mm)?;
        Some((j * self.nx + i, within))
    }

    /// Index of the first of the 4 by 4 splines of a cell; a row of splines has `nx + 3`.
    pub(crate) fn first_spline(&self, cell: usize) -> usize {
        cell / self.nx * (self.nx + 3) + cell % self.nx
    }
}

/// A spline surface. It has no parameters: its coefficients are too many to be fitted with a pose.
#[derive(Clone, Debug, PartialEq)]
pub struct SplineSurface {
    cells: Cells,
    coefficients_mm: Arc<[f64]>,
    defined: Arc<[bool]>,
    domain: AtFirstUse,
}

/// Why numbers make no spline surface.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum SplineError {
    /// A corner that is not finite, or a cell size that is not a positive finite number.
    #[error(
        "{name} of the spline cells is {value_mm} mm, expected a finite number, for a step above zero"
    )]
    Place {
        /// Which: `x_min`, `y_min`, `step_x`, `step_y`.
        name: &'static str,
        /// Its value in mm.
        value_mm: f64,
    },
    /// No cells, or more than can be handled.
    #[error("{nx} by {ny} spline cells, expected 1 to {LARGEST_SIDE} each way")]
    Cells {
        /// Cells along x.
        nx: usize,
        /// Cells along y.
        ny: usize,
    },
    /// A wrong number of coefficients or of cells said to be defined.
    #[error("{found} {what}, expected {expected}")]
    Count {
        /// `coefficients` or `cells`.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// A coefficient that is not finite.
    #[error("spline coefficient {index} is {value_mm} mm, expected a finite number")]
    Coefficient {
        /// Its index.
        index: usize,
        /// Its value in mm.
        value_mm: f64,
    },
}

impl Cells {
    /// Fails unless the numbers are in range.
    pub fn validate(&self) -> Result<(), SplineError> {
        if let Some((name, value_mm)) = self.raster().fault() {
            return Err(SplineError::Place { name, value_mm });
        }
        let (nx, ny) = (self.nx, self.ny);
        if nx.min(ny) == 0 || nx.max(ny) > LARGEST_SIDE {
            return Err(SplineError::Cells { nx, ny });
        }
        Ok(())
    }

    fn raster(&self) -> Raster {
        Raster {
            min_mm: [self.x_min_mm, self.y_min_mm],
            step_mm: [self.step_x_mm, self.step_y_mm],
            cells: [self.nx, self.ny],
        }
    }
}

impl SplineSurface {
    /// The surface of the coefficients of all splines, row after row with x running faster, where the cells
    /// are `defined`, in the same order.
    pub fn new(
        cells: Cells,
        coefficients_mm: &[f64],
        defined: &[bool],
    ) -> Result<SplineSurface, SplineError> {
        cells.validate()?;
        let counts = [
            ("coefficients", coefficients_mm.len(), cells.splines()),
            ("cells", defined.len(), cells.nx * cells.ny),
        ];
        for (what, found, expected) in counts {
            if found != expected {
                return Err(SplineError::Count { what, found, expected });
            }
        }
        if let Some(index) = coefficients_mm.iter().position(|value| !value.is_finite()) {
            return Err(SplineError::Coefficient { index, value_mm: coefficients_mm[index] });
        }
        Ok(SplineSurface {
            cells,
            coefficients_mm: coefficients_mm.into(),
            defined: defined.into(),
            domain: AtFirstUse::default(),
        })
    }

    /// The cells.
    pub fn cells(&self) -> Cells {
        self.cells
    }

    /// The coefficient of every spline in mm.
    pub fn coefficients_mm(&self) -> &[f64] {
        &self.coefficients_mm
    }

    /// Whether each cell is defined.
    pub fn defined(&self) -> &[bool] {
        &self.defined
    }
}

impl Shape for SplineSurface {
    fn kind(&self) -> &'static str {
        "spline surface"
    }

    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let (cell, [u, v]) = self.cells.at(x_mm, y_mm)?;
        if !self.defined[cell] {
            return None;
        }
        let (along, across) = (weights(u), weights(v));
        let first = self.cells.first_spline(cell);
        let rows = transposed(&across).into_iter().enumerate().map(|(row, across)| {
            (&self.coefficients_mm[first + row * (self.cells.nx + 3)..][..4], across)
        });
        Some(self.cells.raster().jet(along.each_ref(), rows))
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        Vec::new()
    }

    fn by_parameters(&self, x_mm: f64, y_mm: f64, _derivatives: &mut [f64]) -> Option<()> {
        let (cell, _) = self.cells.at(x_mm, y_mm)?;
        self.defined[cell].then_some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        count(self.kind(), values, 0)?;
        Ok(Arc::new(self.clone()))
    }

    /// 0 if a cell about the origin is not defined.
    fn domain_mm(&self) -> f64 {
        self.domain.or_find(|| self.cells.raster().reach_mm(&self.defined))
    }
}

/// Value, slope and second derivative of each.
fn transposed(weights: &[[f64; 4]; 3]) -> [[f64; 3]; 4] {
    std::array::from_fn(|k| weights.each_ref().map(|row| row[k]))
}

/// Values, slopes and second derivatives of the four B-splines of a cell at a place in it (0 to 1).
pub(crate) fn weights(t: f64) -> [[f64; 4]; 3] {
    let u = 1.0 - t;
    [
        [
            u * u * u / 6.0,
            (4.0 - 3.0 * t * t * (2.0 - t)) / 6.0,
            (4.0 - 3.0 * u * u * (2.0 - u)) / 6.0,
            t * t * t / 6.0,
        ],
        [-0.5 * u * u, 0.5 * t * (3.0 * t - 4.0), -0.5 * u * (3.0 * u - 4.0), 0.5 * t * t],
        [u, 3.0 * t - 2.0, 3.0 * u - 2.0, t],
    ]
}

/// The largest number of cells along a side: the matrix of a fit has a band of four rows of splines,
/// here 55 MB.
pub const LARGEST_SIDE: usize = 128;
