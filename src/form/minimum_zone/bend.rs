//! The step where fewer points hold the zone than there are unknowns: the bend of the surface decides.
//!
//! With the contacts taken for equations and their multipliers for known, t + ½·yᵀ·H·y is made stationary,
//! H being the second derivative of Σ λ_i·s_i·d_i (the second stage of Hald & Madsen, Math. Programming 20
//! (1981) 49, with H by differences instead of updates: there are few contacts, and rows are exact).

use nalgebra::{DMatrix, DVector};

use super::directions::Directions;
use super::exchange::{Held, Rows};
use super::residuals::Residuals;

/// The points that hold a zone.
pub(super) struct Contacts<'a> {
    pub(super) held: &'a [Held],
    /// Their indices in the problem.
    pub(super) indices: &'a [usize],
}

/// The step in half widths from `at`, where the zone of the contacts is `half_mm` on either side. `None` if the equations
/// have no single solution or a point loses its distance.
pub(super) fn step<R: Residuals>(
    problem: &R,
    directions: &Directions,
    at: &R::Place,
    rows: &Rows,
    Contacts { held, indices }: Contacts<'_>,
    half_mm: f64,
) -> Option<Vec<f64>> {
    let columns = rows.columns;
    let here = gradient(columns, held, |k| rows.slopes(held[k].row));
    let mut hessian = DMatrix::zeros(columns, columns);
    for column in 0..columns {
        let mut nudge_mm = vec![0.0; columns];
        nudge_mm[column] = NUDGE * half_mm;
        let place = problem.moved(at, &directions.step(&nudge_mm, problem.parameters()))?;
        let mut entries = Vec::new();
        problem.rows(&place, indices.iter().copied(), &mut entries)?;
        let there = directions.turn(&entries, problem.parameters(), 0.0, half_mm);
        let bend = (gradient(columns, held, |k| there.slopes(k)) - &here) / NUDGE;
        hessian.set_column(column, &bend);
    }
    // Differences leave it not quite symmetric.
    let hessian = 0.5 * (&hessian + hessian.transpose());
    let mut active = held.to_vec();
    while !active.is_empty() {
        let solution = stationary(rows, &active, &hessian)?;
        let multipliers = solution.rows_range(columns + 1..);
        if multipliers.min() >= 0.0 {
            return Some(solution.iter().take(columns).copied().collect());
        }
        // A contact that would have to pull does not hold the zone.
        active.remove(multipliers.imin());
    }
    None
}

/// y, t and multipliers at which t + ½·yᵀ·H·y is stationary while all of `active` touch.
fn stationary(rows: &Rows, active: &[Held], hessian: &DMatrix<f64>) -> Option<DVector<f64>> {
    let columns = rows.columns;
    let size = columns + 1 + active.len();
    let mut matrix = DMatrix::zeros(size, size);
    let mut rhs = DVector::zeros(size);
    matrix.view_mut((0, 0), (columns, columns)).copy_from(hessian);
    for (k, held) in (columns + 1..).zip(active) {
        for (j, slope) in rows.slopes(held.row).iter().enumerate() {
            matrix[(k, j)] = held.side() * slope;
            matrix[(j, k)] = held.side() * slope;
        }
        matrix[(k, columns)] = -1.0;
        matrix[(columns, k)] = -1.0;
        rhs[k] = -held.side() * rows.start(held.row);
    }
    rhs[columns] = -1.0;
    let solution = matrix.lu().solve(&rhs)?;
    solution.iter().all(|entry| entry.is_finite()).then_some(solution)
}

/// Σ λ·s·J over the contacts.
fn gradient<'a>(
    columns: usize,
    held: &[Held],
    slopes: impl Fn(usize) -> &'a [f64],
) -> DVector<f64> {
    let mut sum = DVector::zeros(columns);
    for (k, held) in held.iter().enumerate() {
        for (entry, slope) in sum.iter_mut().zip(slopes(k)) {
            *entry += held.multiplier * held.side() * slope;
        }
    }
    sum
}

/// Length of the differences in half widths: short, because along nearly dependent shape parameters the
/// linear model ends soon, and long enough for rounding.
const NUDGE: f64 = 1e-4;
