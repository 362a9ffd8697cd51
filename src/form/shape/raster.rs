//! Equal rectangular cells, side by side: where a place lies in them, how far they reach, and sums of products
//! of weights along x and y over one.

use super::Jet;

/// Cells from a corner on, of equal size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Raster {
    /// Lowest x and y in mm.
    pub(super) min_mm: [f64; 2],
    /// Width and height of a cell in mm.
    pub(super) step_mm: [f64; 2],
    /// Cells along x and along y.
    pub(super) cells: [usize; 2],
}

impl Raster {
    /// A start that is not finite, or a step that is not a positive finite number, by its name.
    pub(super) fn fault(&self) -> Option<(&'static str, f64)> {
        let mut starts = ["x_min", "y_min"].into_iter().zip(self.min_mm);
        let mut steps = ["step_x", "step_y"].into_iter().zip(self.step_mm);
        let bad_start = starts.find(|(_, value)| !value.is_finite());
        bad_start.or_else(|| steps.find(|(_, value)| !(value.is_finite() && *value > 0.0)))
    }

    /// Column and row of the cell at a place, and the place within it, from 0 to 1; the last borders belong to
    /// the last cells. `None` outside.
    pub(super) fn find(&self, x_mm: f64, y_mm: f64) -> Option<([usize; 2], [f64; 2])> {
        let (i, u) = self.along(0, x_mm)?;
        let (j, v) = self.along(1, y_mm)?;
        Some(([i, j], [u, v]))
    }

    fn along(&self, axis: usize, at_mm: f64) -> Option<(usize, f64)> {
        let at = (at_mm - self.min_mm[axis]) / self.step_mm[axis];
        let cells = self.cells[axis];
        if !(-EDGE..=cells as f64 + EDGE).contains(&at) {
            return None;
        }
        let index = (at.max(0.0) as usize).min(cells - 1);
        Some((index, (at - index as f64).clamp(0.0, 1.0)))
    }

    /// Distance from the origin within which every cell is `defined` (row after row, x runs faster), in mm; 0 if
    /// one about the origin is not.
    pub(super) fn reach_mm(&self, defined: &[bool]) -> f64 {
        let border_mm =
            |axis: usize, index: usize| self.min_mm[axis] + index as f64 * self.step_mm[axis];
        let beside = [0, 1].map(|axis| (-self.min_mm[axis]).min(border_mm(axis, self.cells[axis])));
        let edge_mm = beside[0].min(beside[1]).max(0.0);
        // The nearest place of every cell that is not defined.
        let holes = defined.iter().enumerate().filter(|(_, defined)| !**defined);
        let near = holes.map(|(cell, _)| {
            let nearest = |axis: usize, index: usize| {
                0_f64.clamp(border_mm(axis, index), border_mm(axis, index + 1))
            };
            nearest(0, cell % self.cells[0]).hypot(nearest(1, cell / self.cells[0]))
        });
        near.fold(edge_mm, f64::min)
    }

    /// The jet of a sum over rows of `values·along·across`: value, slope and second derivative of every weight are
    /// by the coordinates of the cell. `along` are those of the columns, and each row has its own of `across`.
    pub(super) fn jet<'a, const N: usize>(
        &self,
        along: [&[f64; N]; 3],
        rows: impl Iterator<Item = (&'a [f64], [f64; 3])>,
    ) -> Jet {
        let mut jet = Jet::default();
        for (values, across) in rows {
            let sum = |weights: &[f64; N]| -> f64 {
                values.iter().zip(weights).map(|(value, weight)| value * weight).sum()
            };
            let [value, slope, bend] = along.map(sum);
            jet.z_mm += across[0] * value;
            jet.gradient[0] += across[0] * slope;
            jet.gradient[1] += across[1] * value;
            jet.hessian_per_mm[0] += across[0] * bend;
            jet.hessian_per_mm[1] += across[1] * slope;
            jet.hessian_per_mm[2] += across[2] * value;
        }
        let [dx, dy] = self.step_mm;
        jet.gradient = [jet.gradient[0] / dx, jet.gradient[1] / dy];
        let [xx, xy, yy] = jet.hessian_per_mm;
        jet.hessian_per_mm = [xx / (dx * dx), xy / (dx * dy), yy / (dy * dy)];
        jet
    }
}

/// A place on the border that rounding has put outside belongs to the cells.
const EDGE: f64 = 1e-9;
