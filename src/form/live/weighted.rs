//! What points of unequal uncertainty add to the running sums.

use crate::fit::solve::System;
use crate::fit::triangle::Triangle;
use crate::live::LiveWeights;
use crate::live::problem::{Problem, Sums};

/// The rows of all points so far times the roots of their weights 1/u², beside the sums of points that count alike:
/// these give RMS, PV and map, which know no weights.
#[derive(Clone, Debug)]
pub(crate) struct Weighted {
    /// A point of this uncertainty weighs 1. A power of two: to count by another costs no rounding.
    unit_mm: f64,
    triangle: Triangle,
    cells: Vec<Option<Cell>>,
    /// Sums of the weights and of their squares.
    sum: f64,
    square: f64,
    /// Smallest and largest.
    u_mm: [f64; 2],
    /// Scratch for one row.
    row: Vec<f64>,
}

#[derive(Clone, Debug)]
struct Cell {
    rows: Box<[f64]>,
    weight: f64,
}

impl Weighted {
    /// Without points, for rows of `columns` entries; the first point will have an uncertainty of `first_u_mm`.
    pub(crate) fn new(columns: usize, cells: usize, first_u_mm: f64) -> Weighted {
        Weighted {
            unit_mm: power_of_two(first_u_mm),
            triangle: Triangle::new(columns),
            cells: vec![None; cells],
            sum: 0.0,
            square: 0.0,
            u_mm: [f64::INFINITY, 0.0],
            row: vec![0.0; columns],
        }
    }

    /// Adds the row of a point in a cell, whose uncertainty along the normal is positive and finite.
    pub(crate) fn add(&mut self, row: &[f64], u_mm: f64, cell: usize) {
        self.add_by(row, self.unit_mm / u_mm, cell);
        self.u_mm = [self.u_mm[0].min(u_mm), self.u_mm[1].max(u_mm)];
    }

    /// Adds the row of a point in a cell, times the root of its weight.
    pub(crate) fn add_by(&mut self, row: &[f64], root: f64, cell: usize) {
        let weight = root * root;
        self.row.iter_mut().zip(row).for_each(|(scaled, entry)| *scaled = root * entry);
        self.triangle.push(&self.row);
        self.sum += weight;
        self.square += weight * weight;
        let empty = || Cell { rows: vec![0.0; row.len()].into(), weight: 0.0 };
        let cell = self.cells[cell].get_or_insert_with(empty);
        cell.weight += weight;
        cell.rows.iter_mut().zip(row).for_each(|(sum, entry)| *sum += weight * entry);
    }

    /// Everything of another at the same reference, to the rounding of the sums.
    pub(crate) fn merge(&mut self, mut other: Weighted) {
        let root = self.unit_mm / other.unit_mm;
        let factor = root * root;
        other.triangle.scale(root);
        self.triangle.flush();
        other.triangle.flush();
        self.triangle.join(&other.triangle);
        self.sum += factor * other.sum;
        self.square += factor * factor * other.square;
        self.u_mm = [self.u_mm[0].min(other.u_mm[0]), self.u_mm[1].max(other.u_mm[1])];
        for (cell, other) in self.cells.iter_mut().zip(other.cells) {
            let Some(other) = other else { continue };
            let empty = || Cell { rows: vec![0.0; other.rows.len()].into(), weight: 0.0 };
            let cell = cell.get_or_insert_with(empty);
            cell.weight += factor * other.weight;
            cell.rows.iter_mut().zip(&other.rows).for_each(|(sum, part)| *sum += factor * part);
        }
    }

    /// Points taken.
    pub(crate) fn count(&self) -> usize {
        self.triangle.rows()
    }

    /// The problem by weights; `None` where the sums overflow.
    pub(crate) fn problem(&self) -> Option<Problem<'_>> {
        let mut triangle = self.triangle.clone();
        triangle.flush();
        if !triangle.is_finite() {
            return None;
        }
        let cells = self.cells.iter().map(|cell| {
            let cell = cell.as_ref()?;
            Some(Sums { rows: &cell.rows, weight: cell.weight })
        });
        Some(Problem {
            system: System::new(&triangle),
            cells: cells.collect(),
            root_weight: (self.sum / triangle.rows() as f64).sqrt(),
        })
    }

    /// The uncertainty of a point of weight 1.
    pub(crate) fn unit_mm(&self) -> f64 {
        self.unit_mm
    }

    /// (Σw)²/Σw²; 0 without any weight.
    pub(crate) fn effective_points(&self) -> f64 {
        if self.square > 0.0 { self.sum * self.sum / self.square } else { 0.0 }
    }

    /// What is told of the weights: `sigma` is the standard deviation of distance over uncertainty, in units of
    /// [`Weighted::problem`].
    pub(crate) fn told(&self, sigma: Option<f64>) -> LiveWeights {
        LiveWeights {
            u_min_mm: self.u_mm[0],
            u_max_mm: self.u_mm[1],
            reduced_chi_square: sigma.map(|sigma| (sigma / self.unit_mm).powi(2)),
        }
    }
}

/// The largest power of two that is not above a normal positive number.
fn power_of_two(value: f64) -> f64 {
    f64::from_bits(value.to_bits() & f64::INFINITY.to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two_are_below() {
        for (value, power) in [(1.0, 1.0), (1.9, 1.0), (3e-5, 2.0_f64.powi(-16)), (7.0, 4.0)] {
            assert_eq!(power_of_two(value), power);
        }
    }

    /// Parts whose weights count by different units: as by one.
    #[test]
    fn the_unit_does_not_matter() {
        let rows = [[1.0, 0.5, 2.0], [0.25, -1.0, 3.0], [1.5, 1.0, -0.5], [-2.0, 1.0, 0.125]];
        let u_mm = [1e-6, 3e-5, 2e-4, 7e-6];
        let of = |some: &[usize]| {
            let mut weighted = Weighted::new(3, 2, u_mm[some[0]]);
            some.iter().for_each(|&i| weighted.add(&rows[i], u_mm[i], i % 2));
            weighted
        };
        let whole = of(&[0, 1, 2, 3]);
        let mut merged = of(&[0]);
        merged.merge(of(&[2, 1]));
        merged.merge(of(&[3]));
        assert_eq!((merged.count(), merged.unit_mm), (4, whole.unit_mm));
        let (merged_problem, whole_problem) = (merged.problem().unwrap(), whole.problem().unwrap());
        let change = [0.3, -0.7];
        let [a, b] = [&merged_problem, &whole_problem].map(|p| p.system.square_after(&change));
        assert!((a / b - 1.0).abs() < 1e-13);
        // By hand, in the unit of the first point.
        let square = |i: usize| {
            let [a, b, d] = rows[i];
            (whole.unit_mm / u_mm[i] * (d + change[0] * a + change[1] * b)).powi(2)
        };
        assert!((b / (0..4).map(square).sum::<f64>() - 1.0).abs() < 1e-13);
        for (a, b) in merged_problem.cells.iter().zip(&whole_problem.cells) {
            let (a, b) = (a.unwrap(), b.unwrap());
            assert!((a.weight / b.weight - 1.0).abs() < 1e-14);
            a.rows.iter().zip(b.rows).for_each(|(a, b)| assert!((a / b - 1.0).abs() < 1e-13));
        }
        assert_eq!(merged.told(None).u_max_mm, 2e-4);
        let effective = merged.effective_points();
        assert!((effective / whole.effective_points() - 1.0).abs() < 1e-13);
    }
}
