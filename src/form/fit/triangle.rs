//! The triangular factor of a tall matrix, built up row by row.
//!
//! A QR factorisation by Householder reflections that keeps only R: blocks of rows are annihilated against
//! the R of all rows before them (Golub & Van Loan, Matrix Computations, 4th ed., 5.1 and 6.5). Against the
//! normal equations this keeps the condition of the matrix unsquared; a column's scale does not matter.
//! Joining factors in a fixed order gives a fixed result: Demmel et al., SIAM J. Sci. Comput. 34 (2012) A206.

use rayon::prelude::*;

use crate::PointMm;
use crate::fit::model::Model;

/// R of the rows so far. Invariant: no NaN unless a row had one or overflowed.
#[derive(Clone, Debug)]
pub struct Triangle {
    columns: usize,
    /// Column after column, `columns` rows each; zero below the diagonal.
    r: Vec<f64>,
    /// Rows that have been absorbed or wait in `pending`.
    rows: usize,
    /// Rows not yet absorbed, column after column, `BLOCK` rows each.
    pending: Vec<f64>,
    pending_rows: usize,
}

impl Triangle {
    /// The factor of no rows.
    pub fn new(columns: usize) -> Triangle {
        Triangle {
            columns,
            r: vec![0.0; columns * columns],
            rows: 0,
            pending: vec![0.0; columns * BLOCK],
            pending_rows: 0,
        }
    }

    /// The factor of the rows of `model` for all points, each times the root of its weight if there are
    /// weights, and the spread of the distances; `None` if a point has no foot. The result does not depend
    /// on the number of threads.
    pub fn of_points(
        model: &Model,
        points: &[PointMm],
        roots: Option<&[f64]>,
    ) -> Option<(Triangle, Spread)> {
        let of_chunk = |(index, chunk): (usize, &[PointMm])| {
            let mut triangle = Triangle::new(model.columns());
            let mut spread = Spread::default();
            let mut row = vec![0.0; model.columns()];
            for (place, &point) in (CHUNK * index..).zip(chunk) {
                model.row(point, &mut row)?;
                spread.add(row[model.columns() - 1]);
                if let Some(roots) = roots {
                    row.iter_mut().for_each(|entry| *entry *= roots[place]);
                }
                triangle.push(&row);
            }
            triangle.flush();
            Some((triangle, spread))
        };
        let chunks: Vec<Option<(Triangle, Spread)>> =
            points.par_chunks(CHUNK).enumerate().map(of_chunk).collect();
        let (mut all, mut spread) = (Triangle::new(model.columns()), Spread::default());
        for chunk in chunks {
            let (triangle, found) = chunk?;
            all.join(&triangle);
            spread = spread.with(found);
        }
        Some((all, spread))
    }

    /// Rows of the tall matrix so far.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Columns of the tall matrix.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Adds one row of `columns` entries. Amortised `O(columns²)`.
    pub fn push(&mut self, row: &[f64]) {
        for (column, &entry) in row.iter().enumerate() {
            self.pending[column * BLOCK + self.pending_rows] = entry;
        }
        self.pending_rows += 1;
        self.rows += 1;
        if self.pending_rows == BLOCK {
            self.flush();
        }
    }

    /// Absorbs the waiting rows; entries of R are complete only after that.
    pub fn flush(&mut self) {
        let mut pending = std::mem::take(&mut self.pending);
        self.absorb(&mut pending, BLOCK, self.pending_rows);
        self.pending = pending;
        self.pending_rows = 0;
    }

    /// Entry of R. Zero below the diagonal.
    pub fn entry(&self, row: usize, column: usize) -> f64 {
        self.r[column * self.columns + row]
    }

    /// Sum of the squares of a column of the tall matrix.
    pub fn column_square(&self, column: usize) -> f64 {
        self.r[column * self.columns..][..=column].iter().map(|entry| entry * entry).sum()
    }

    /// Whether no row had an entry that is not finite, and none overflowed.
    pub fn is_finite(&self) -> bool {
        self.r.iter().all(|entry| entry.is_finite())
    }

    /// Both must be flushed.
    pub fn join(&mut self, other: &Triangle) {
        let mut rows = other.r.clone();
        self.absorb(&mut rows, self.columns, self.columns);
        self.rows += other.rows;
    }

    /// Multiplies every row by the same factor.
    pub fn scale(&mut self, factor: f64) {
        self.r.iter_mut().chain(&mut self.pending).for_each(|entry| *entry *= factor);
    }

    /// Annihilates `count` rows, given column after column with `stride` rows each, against R.
    fn absorb(&mut self, block: &mut [f64], stride: usize, count: usize) {
        for j in 0..self.columns {
            let (left, right) = block.split_at_mut((j + 1) * stride);
            let reflector = &left[j * stride..][..count];
            let tail = dot(reflector, reflector);
            if tail == 0.0 {
                continue;
            }
            let diagonal = self.r[j * self.columns + j];
            let norm = (diagonal * diagonal + tail).sqrt();
            let head = diagonal + norm.copysign(diagonal);
            let factor = 2.0 / (head * head + tail);
            self.r[j * self.columns + j] = -norm.copysign(diagonal);
            for l in j + 1..self.columns {
                let column = &mut right[(l - j - 1) * stride..][..count];
                let entry = &mut self.r[l * self.columns + j];
                let weight = factor * (head * *entry + dot(reflector, column));
                *entry -= weight * head;
                for (value, along) in column.iter_mut().zip(reflector) {
                    *value -= weight * along;
                }
            }
        }
    }
}

/// Smallest and largest of the distances in mm, and the sum of their squares, whatever their weights; the
/// range is empty without any.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    /// The smallest distance.
    pub low_mm: f64,
    /// The largest distance.
    pub high_mm: f64,
    /// Sum of the squares.
    pub square_mm2: f64,
}

impl Default for Spread {
    fn default() -> Spread {
        Spread { low_mm: f64::INFINITY, high_mm: f64::NEG_INFINITY, square_mm2: 0.0 }
    }
}

impl Spread {
    fn add(&mut self, distance_mm: f64) {
        self.low_mm = self.low_mm.min(distance_mm);
        self.high_mm = self.high_mm.max(distance_mm);
        self.square_mm2 += distance_mm * distance_mm;
    }

    fn with(self, other: Spread) -> Spread {
        Spread {
            low_mm: self.low_mm.min(other.low_mm),
            high_mm: self.high_mm.max(other.high_mm),
            square_mm2: self.square_mm2 + other.square_mm2,
        }
    }
}

/// A dot product in eight interleaved sums, an order the compiler can turn into vector instructions.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a_head, a_tail) = a.as_chunks::<8>();
    let (b_head, b_tail) = b.as_chunks::<8>();
    for (a, b) in a_head.iter().zip(b_head) {
        for k in 0..8 {
            lanes[k] += a[k] * b[k];
        }
    }
    for (k, (a, b)) in a_tail.iter().zip(b_tail).enumerate() {
        lanes[k] += a * b;
    }
    ((lanes[0] + lanes[4]) + (lanes[1] + lanes[5]))
        + ((lanes[2] + lanes[6]) + (lanes[3] + lanes[7]))
}

/// Points a parallel task works on. Fixed, because the result depends on it in the last bits.
pub const CHUNK: usize = 4096;
/// Rows absorbed together: small enough for the first-level cache at 18 columns.
const BLOCK: usize = 128;

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;

    fn entry(row: usize, column: usize) -> f64 {
        ((row * 37 + column * 101 + 7 * row * column) % 211) as f64 / 211.0 - 0.4
    }

    #[test]
    fn gram_matrix_of_the_factor_is_that_of_the_rows() {
        for rows in [0, 1, 3, 127, 128, 129, 700] {
            let matrix = DMatrix::from_fn(rows, 5, entry);
            let mut triangle = Triangle::new(5);
            for row in matrix.row_iter() {
                triangle.push(&row.iter().copied().collect::<Vec<_>>());
            }
            triangle.flush();
            let r = DMatrix::from_fn(5, 5, |i, j| triangle.entry(i, j));
            let difference = (r.transpose() * &r - matrix.transpose() * &matrix).amax();
            assert!(difference < 1e-12, "{rows} rows: {difference:e}");
            assert_eq!(triangle.rows(), rows);
            for i in 0..5 {
                for j in 0..i {
                    assert_eq!(triangle.entry(i, j), 0.0);
                }
            }
        }
    }

    #[test]
    fn joined_factors_hold_all_rows() {
        let (mut whole, mut left, mut right) =
            (Triangle::new(4), Triangle::new(4), Triangle::new(4));
        for row in 0..300 {
            let values: Vec<f64> = (0..4).map(|column| entry(row, column)).collect();
            whole.push(&values);
            if row < 110 { left.push(&values) } else { right.push(&values) }
        }
        whole.flush();
        left.flush();
        right.flush();
        left.join(&right);
        assert_eq!(left.rows(), 300);
        for i in 0..4 {
            for j in i..4 {
                assert!((left.entry(i, j).abs() - whole.entry(i, j).abs()).abs() < 1e-12);
            }
        }
    }
}
