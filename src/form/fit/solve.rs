//! The small least-squares problem that is left of the large one: which parameters are determinate, the
//! step, its uncertainty.

use nalgebra::{DMatrix, DVector};

use crate::fit::freedoms::Freedoms;
use crate::fit::svd::Svd;
use crate::fit::triangle::Triangle;

/// The linear problem |J·δ + d| → min, reduced to the triangular factor of [J | d] with columns of J
/// scaled to unit length.
#[derive(Clone, Debug)]
pub struct System {
    scaled: DMatrix<f64>,
    /// Length of each column of J; 0 for a parameter without any influence.
    lengths: Vec<f64>,
    rhs: DVector<f64>,
    square: f64,
    /// Part of `square` that no change of parameters removes.
    beyond: f64,
    rows: usize,
}

/// A solution of the linear problem for some of the parameters.
#[derive(Clone, Debug)]
pub struct Step {
    /// Change of each kept parameter.
    pub change: Vec<f64>,
    /// Root mean square of J·δ in mm: how far the surface moves at the points.
    pub motion_mm: f64,
    /// Diagonal of (JᵀJ)⁻¹ for each kept parameter.
    pub variance_factors: Vec<f64>,
    /// The combination of the kept parameters, in columns of unit length, that moves the surface least: a
    /// unit vector; empty without parameters.
    pub weakest: Vec<f64>,
    /// A root W of (JᵀJ)⁻¹ = W·Wᵀ for the kept parameters.
    root: DMatrix<f64>,
    /// Largest over smallest singular value of the scaled Jacobian; 1 without parameters.
    pub condition: f64,
}

impl Step {
    /// (JᵀJ)⁻¹·g for a gradient g of the kept parameters.
    pub fn undo_gram(&self, gradient: &[f64]) -> Vec<f64> {
        let gradient = DVector::from_column_slice(gradient);
        (&self.root * self.root.tr_mul(&gradient)).iter().copied().collect()
    }

    /// (JᵀJ)⁻¹ of the kept parameters, column after column.
    pub fn inverse_gram(&self) -> Vec<f64> {
        (&self.root * self.root.transpose()).iter().copied().collect()
    }
}

impl System {
    /// The factor must be flushed and finite.
    pub fn new(triangle: &Triangle) -> System {
        let p = triangle.columns() - 1;
        let lengths: Vec<f64> = (0..p).map(|j| triangle.column_square(j).sqrt()).collect();
        let scaled = DMatrix::from_fn(p, p, |i, j| {
            if lengths[j] > 0.0 { triangle.entry(i, j) / lengths[j] } else { 0.0 }
        });
        System {
            scaled,
            lengths,
            rhs: DVector::from_fn(p, |i, _| triangle.entry(i, p)),
            square: triangle.column_square(p),
            beyond: triangle.entry(p, p) * triangle.entry(p, p),
            rows: triangle.rows(),
        }
    }

    /// Some of the columns of the factor, of unit length.
    pub fn columns(&self, some: &[usize]) -> DMatrix<f64> {
        self.scaled.select_columns(some)
    }

    /// Rows of the tall matrix.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Length of a column of the tall matrix.
    pub fn length(&self, column: usize) -> f64 {
        self.lengths[column]
    }

    /// Sum of the squares of the distances in mm².
    pub fn square(&self) -> f64 {
        self.square
    }

    /// The parameters the rows determine, ascending. Parameters are admitted in the order of the groups of
    /// `priority` as long as the smallest singular value of the scaled columns stays above `tolerance` times
    /// the largest; the others are indeterminate. Within a group the one that is determined best comes first.
    pub fn determinate(&self, priority: &[Vec<usize>], tolerance: f64) -> Vec<usize> {
        let mut kept: Vec<usize> = Vec::new();
        for group in priority {
            let mut left = group.clone();
            while kept.len() < self.rows {
                let ratios = left.iter().enumerate().map(|(at, &candidate)| {
                    let columns: Vec<usize> = kept.iter().copied().chain([candidate]).collect();
                    (at, self.ratio(&columns))
                });
                let best = ratios.reduce(|best, next| if next.1 > best.1 { next } else { best });
                match best {
                    Some((at, ratio)) if ratio > tolerance => kept.push(left.remove(at)),
                    _ => break,
                }
            }
        }
        kept.sort_unstable();
        kept
    }

    /// Smallest over largest singular value of some of the scaled columns; 0 if one is empty.
    fn ratio(&self, columns: &[usize]) -> f64 {
        if columns.iter().any(|&column| self.lengths[column] == 0.0) {
            return 0.0;
        }
        let (largest, smallest) = Svd::new(self.scaled.select_columns(columns)).extremes();
        smallest / largest
    }

    /// The combination of the `kept` parameters and one more, in columns of unit length, that moves the
    /// surface least, as a unit vector in that order; and its singular value as a share of the largest.
    pub fn combination(&self, kept: &[usize], other: usize) -> (Vec<f64>, f64) {
        if self.lengths[other] == 0.0 {
            let mut alone = vec![0.0; kept.len()];
            alone.push(1.0);
            return (alone, 0.0);
        }
        let columns: Vec<usize> = kept.iter().copied().chain([other]).collect();
        let svd = Svd::new(self.scaled.select_columns(&columns));
        let (largest, smallest) = svd.extremes();
        (svd.weakest(), smallest / largest)
    }

    /// The step for the `kept` parameters, which must be determinate, damped by `damping` relative to the
    /// unit columns (Levenberg-Marquardt; 0 is Gauss-Newton).
    pub fn solve(&self, kept: &[usize], damping: f64) -> Step {
        let svd = Svd::new(self.scaled.select_columns(kept));
        let square = |k: usize| svd.sigma[k] * svd.sigma[k];
        let along = svd.scaled_u.tr_mul(&self.rhs);
        let turned = DVector::from_fn(kept.len(), |k, _| -along[k] / (square(k) + damping));
        let moved = (0..kept.len()).map(|k| turned[k] * turned[k] * square(k)).sum::<f64>().sqrt();
        let scaled_change = &svd.v * turned;
        let change = kept.iter().zip(scaled_change.iter()).map(|(&j, step)| step / self.lengths[j]);
        let root = DMatrix::from_fn(kept.len(), kept.len(), |i, k| {
            svd.v[(i, k)] / (svd.sigma[k] * self.lengths[kept[i]])
        });
        let (largest, smallest) = svd.extremes();
        Step {
            weakest: svd.weakest(),
            change: change.collect(),
            motion_mm: moved / (self.rows as f64).sqrt(),
            variance_factors: root.row_iter().map(|row| row.norm_squared()).collect(),
            root,
            condition: if kept.is_empty() { 1.0 } else { largest / smallest },
        }
    }

    /// As [`System::solve`], for the directions of `freedoms`, which must be determinate; the step is that of the
    /// parameters these move.
    pub fn solve_along(&self, freedoms: &Freedoms, damping: f64) -> Step {
        let Some(directions) = freedoms.directions() else {
            return self.solve(freedoms.moving(), damping);
        };
        let moving = freedoms.moving();
        let turned = self.turned(freedoms);
        let every: Vec<usize> = (0..directions.ncols()).collect();
        let step = turned.solve(&every, damping);
        let root = directions * &step.root;
        let change = directions * DVector::from_column_slice(&step.change);
        // In columns of unit length of the parameters.
        let along = step.weakest.iter().zip(&turned.lengths).map(|(share, length)| share / length);
        let weakest = directions * DVector::from_iterator(every.len(), along);
        let mut weakest =
            DVector::from_fn(moving.len(), |i, _| weakest[i] * self.lengths[moving[i]]);
        let size = weakest.norm();
        weakest /= if size > 0.0 { size } else { 1.0 };
        Step {
            change: change.iter().copied().collect(),
            variance_factors: root.row_iter().map(|row| row.norm_squared()).collect(),
            weakest: weakest.iter().copied().collect(),
            root,
            ..step
        }
    }

    /// The problem with the directions for columns.
    pub fn turned(&self, freedoms: &Freedoms) -> System {
        let moving = freedoms.moving();
        let mut columns = self.scaled.select_columns(moving);
        for (mut column, &index) in columns.column_iter_mut().zip(moving) {
            column *= self.lengths[index];
        }
        if let Some(directions) = freedoms.directions() {
            columns *= directions;
        }
        let lengths: Vec<f64> = columns.column_iter().map(|column| column.norm()).collect();
        for (mut column, &length) in columns.column_iter_mut().zip(&lengths) {
            if length > 0.0 {
                column /= length;
            }
        }
        System { scaled: columns, lengths, ..self.clone() }
    }

    /// The change of `count` parameters, of some and one more, that moves the surface least.
    pub fn least_felt(&self, some: &[usize], other: usize, count: usize) -> Vec<f64> {
        let (shares, _) = self.combination(some, other);
        let mut change = vec![0.0; count];
        for (&index, share) in some.iter().chain([&other]).zip(shares) {
            // A column of zeros stands alone in its combination.
            let length = self.lengths[index];
            change[index] = if length > 0.0 { share / length } else { share };
        }
        change
    }

    /// Sum of the squares of d + J·δ for a change of all parameters.
    pub fn square_after(&self, change: &[f64]) -> f64 {
        self.beyond + self.remainder(change).norm_squared()
    }

    /// Jᵀ·(d + J·δ) for a change of all parameters.
    pub fn gradient(&self, change: &[f64]) -> Vec<f64> {
        let along = self.scaled.tr_mul(&self.remainder(change));
        along.iter().zip(&self.lengths).map(|(entry, length)| entry * length).collect()
    }

    /// The part of d + J·δ that lies in the span of J.
    fn remainder(&self, change: &[f64]) -> DVector<f64> {
        let scaled = DVector::from_iterator(
            change.len(),
            change.iter().zip(&self.lengths).map(|(step, length)| step * length),
        );
        &self.rhs + &self.scaled * scaled
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn system(rows: &[&[f64]]) -> System {
        let mut triangle = Triangle::new(rows[0].len());
        rows.iter().for_each(|row| triangle.push(row));
        triangle.flush();
        System::new(&triangle)
    }

    #[test]
    fn straight_line_through_four_points() {
        // y = a + b·x through (0,1) (1,3) (2,4) (3,4): b = 1, a = 1.5, residual square 1.
        let rows: [[f64; 3]; 4] = [[-1., 0., 1.], [-1., -1., 3.], [-1., -2., 4.], [-1., -3., 4.]];
        let system = system(&rows.each_ref().map(|row| &row[..]));
        let kept = system.determinate(&[vec![0], vec![1]], 1e-10);
        assert_eq!(kept, [0, 1]);
        let step = system.solve(&kept, 0.0);
        assert!((step.change[0] - 1.5).abs() < 1e-14 && (step.change[1] - 1.0).abs() < 1e-14);
        assert!((system.square_after(&step.change) - 1.0).abs() < 1e-13);
        // (JᵀJ)⁻¹ of x = 0, 1, 2, 3 is [[0.7, −0.3], [−0.3, 0.2]].
        assert!((step.variance_factors[0] - 0.7).abs() < 1e-14);
        assert!((step.variance_factors[1] - 0.2).abs() < 1e-14);
        let undone = step.undo_gram(&[1.0, 2.0]);
        assert!((undone[0] - 0.1).abs() < 1e-14 && (undone[1] - 0.1).abs() < 1e-14);
        // Jᵀ·d at δ = 0, and none at the solution.
        assert!((system.gradient(&[0.0, 0.0])[1] + 23.0).abs() < 1e-13);
        assert!(system.gradient(&step.change).iter().all(|entry| entry.abs() < 1e-13));
    }

    #[test]
    fn dependent_and_empty_columns_are_indeterminate_by_priority() {
        let rows: Vec<[f64; 5]> = (0..9)
            .map(|i| {
                let x = f64::from(i);
                [1.0, x, 0.0, 1e-9 * (2.0 + 3.0 * x), 0.5 * x * x]
            })
            .collect();
        let rows: Vec<&[f64]> = rows.iter().map(|row| &row[..]).collect();
        let system = system(&rows);
        let one_by_one = |order: [usize; 4]| order.map(|index| vec![index]);
        assert_eq!(system.determinate(&one_by_one([0, 1, 2, 3]), 1e-10), [0, 1]);
        assert_eq!(system.determinate(&one_by_one([3, 2, 1, 0]), 1e-10), [1, 3]);
    }

    #[test]
    fn within_a_group_the_best_determined_comes_first() {
        // The second is the first but for a hundredth of the third.
        let rows: Vec<[f64; 4]> = (0..9)
            .map(|i| {
                let x = f64::from(i) - 4.0;
                [1.0, 1.0 + 0.01 * x, x, 0.0]
            })
            .collect();
        let rows: Vec<&[f64]> = rows.iter().map(|row| &row[..]).collect();
        let system = system(&rows);
        assert_eq!(system.determinate(&[vec![0, 1, 2]], 1e-10), [0, 2]);
        assert_eq!(system.determinate(&[vec![0], vec![1], vec![2]], 1e-10), [0, 1]);
    }
}
