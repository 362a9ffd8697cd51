//! Directions of the parameters that the points determine, each of which moves the surface by 1 mm root
//! mean square.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::exchange::Rows;
use super::residuals::Residuals;
use super::scan::BLOCK;
use crate::fit::freedoms::Freedoms;
use crate::fit::solve::System;
use crate::fit::svd::Svd;
use crate::fit::triangle::Triangle;

/// Orthogonal directions: with them a step in mm means the same for a shift as for a conic constant.
#[derive(Clone, Debug)]
pub(super) struct Directions {
    /// One row a parameter and, if it floats, one for the offset; one column a direction.
    matrix: DMatrix<f64>,
    /// Indices of the parameters that no direction changes.
    pub(super) indeterminate: Vec<usize>,
    /// Whether the middle of the zone may leave the surface as an unknown of its own. It need not where the
    /// parameters can make up for it.
    pub(super) floating: bool,
}

impl Directions {
    /// Directions at a place, `within` those of a fit. Parameters are admitted in the order of `priority`, an offset, if
    /// wanted, after them. `None` if a point has no distance or the numbers overflow. `O(n·p²)`.
    pub(super) fn new<R: Residuals>(
        problem: &R,
        at: &R::Place,
        (within, priority): (&Freedoms, &[Vec<usize>]),
        offset: bool,
        rank_tolerance: f64,
    ) -> Option<Directions> {
        let parameters = problem.parameters();
        let unknowns = parameters + usize::from(offset);
        let triangle = factor(problem, at, unknowns)?;
        let mut order = priority.to_vec();
        order.extend(offset.then(|| vec![parameters]));
        let system = System::new(&triangle);
        let freedoms = within.with_offset(offset);
        // Combinations that the fit has left out stay out; else parameters are admitted by themselves.
        let (turned, order) = if freedoms.is_combined() {
            let every = (0..freedoms.count()).map(|direction| vec![direction]).collect();
            (system.turned(&freedoms), every)
        } else {
            (system, order)
        };
        let kept = turned.determinate(&order, rank_tolerance);
        let svd = Svd::new(turned.columns(&kept));
        let root = (problem.len() as f64).sqrt();
        let along = DMatrix::from_fn(freedoms.count(), kept.len(), |i, k| {
            kept.iter()
                .position(|&column| column == i)
                .map_or(0.0, |row| svd.v[(row, k)] * root / (svd.sigma[k] * turned.length(i)))
        });
        let matrix = match freedoms.directions() {
            Some(directions) => directions * along,
            None => along,
        };
        let changes = |row: usize| matrix.row(row).iter().any(|entry| *entry != 0.0);
        let floating = offset && changes(parameters);
        let indeterminate = (0..parameters).filter(|&index| !changes(index)).collect();
        Some(Directions { matrix, indeterminate, floating })
    }

    /// Number of directions.
    pub(super) fn count(&self) -> usize {
        self.matrix.ncols()
    }

    /// The step of the parameters for so many mm along every direction.
    pub(super) fn step(&self, y_mm: &[f64], parameters: usize) -> Vec<f64> {
        (0..parameters)
            .map(|row| y_mm.iter().enumerate().map(|(k, y)| self.matrix[(row, k)] * y).sum())
            .collect()
    }

    /// Rows of derivatives along the directions, from rows of `parameters` derivatives and a distance. The
    /// distances count from `centre_mm` in units of `unit_mm`, and so do steps.
    pub(super) fn turn(
        &self,
        rows: &[f64],
        parameters: usize,
        centre_mm: f64,
        unit_mm: f64,
    ) -> Rows {
        let columns = self.count();
        let mut entries = Vec::with_capacity(rows.len() / (parameters + 1) * (columns + 1));
        for row in rows.chunks_exact(parameters + 1) {
            for k in 0..columns {
                // The distance from the middle of the zone falls as its offset grows.
                let by_offset = if self.matrix.nrows() > parameters {
                    -self.matrix[(parameters, k)]
                } else {
                    0.0
                };
                let along = (0..parameters).map(|i| row[i] * self.matrix[(i, k)]);
                entries.push(along.fold(by_offset, |sum, term| sum + term));
            }
            entries.push((row[parameters] - centre_mm) / unit_mm);
        }
        Rows { columns, entries }
    }
}

/// Triangular factor of the derivatives, those by the offset if `unknowns` has it, and the distances.
fn factor<R: Residuals>(problem: &R, at: &R::Place, unknowns: usize) -> Option<Triangle> {
    let parameters = problem.parameters();
    let chunks: Vec<Option<Triangle>> = (0..problem.len().div_ceil(BLOCK))
        .into_par_iter()
        .map(|chunk| {
            let range = chunk * BLOCK..((chunk + 1) * BLOCK).min(problem.len());
            let mut rows = Vec::with_capacity(range.len() * (parameters + 1));
            problem.rows(at, range, &mut rows)?;
            let mut triangle = Triangle::new(unknowns + 1);
            let mut wide = vec![-1.0; unknowns + 1];
            for row in rows.chunks_exact(parameters + 1) {
                wide[..parameters].copy_from_slice(&row[..parameters]);
                wide[unknowns] = row[parameters];
                triangle.push(&wide);
            }
            triangle.flush();
            Some(triangle)
        })
        .collect();
    let mut all = Triangle::new(unknowns + 1);
    let mut row = vec![0.0; unknowns + 1];
    for chunk in chunks {
        let chunk = chunk?;
        for i in 0..=unknowns {
            row.iter_mut().enumerate().for_each(|(j, entry)| *entry = chunk.entry(i, j));
            all.push(&row);
        }
    }
    all.flush();
    all.is_finite().then_some(all)
}
