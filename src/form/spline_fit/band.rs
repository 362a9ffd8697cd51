//! Symmetric positive definite matrices whose entries lie near the diagonal: factor, solution, inverse.

/// The lower triangle of a symmetric matrix within a band.
#[derive(Clone, Debug)]
pub(super) struct Band {
    size: usize,
    /// Entries left of the diagonal.
    width: usize,
    /// Row after row: columns `i − width` to `i`; those left of the first column stay 0.
    entries: Vec<f64>,
}

impl Band {
    pub(super) fn new(size: usize, width: usize) -> Band {
        Band { size, width, entries: vec![0.0; size * (width + 1)] }
    }

    /// Adds to the entry (row, column); the column must not be right of the row nor beyond the band.
    pub(super) fn add(&mut self, row: usize, column: usize, value: f64) {
        let start = row * (self.width + 1);
        self.entries[start + self.width + column - row] += value;
    }

    pub(super) fn trace(&self) -> f64 {
        (0..self.size).map(|row| self.row(row)[self.width]).sum()
    }

    /// `self + factor·other`.
    pub(super) fn plus(&self, factor: f64, other: &Band) -> Band {
        let pairs = self.entries.iter().zip(&other.entries);
        Band { entries: pairs.map(|(a, b)| a + factor * b).collect(), ..*self }
    }

    /// The product with a vector.
    pub(super) fn times(&self, vector: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.size];
        for row in 0..self.size {
            let from = row.saturating_sub(self.width);
            let left = &self.row(row)[self.width + from - row..self.width];
            product[row] += self.row(row)[self.width] * vector[row] + dot(left, &vector[from..row]);
            for (sum, entry) in product[from..row].iter_mut().zip(left) {
                *sum += entry * vector[row];
            }
        }
        product
    }

    /// L of L·Lᵀ = self; `None` if the matrix is not positive definite to rounding.
    /// `O(size·width²)`.
    pub(super) fn factor(&self) -> Option<Factor> {
        let mut lower = self.clone();
        let width = self.width;
        for i in 0..self.size {
            let (done, rest) = lower.entries.split_at_mut(i * (width + 1));
            let row = &mut rest[..=width];
            let diagonal = row[width];
            for j in i.saturating_sub(width)..i {
                let other = &done[j * (width + 1)..][..=width];
                // Columns both rows have, left of j.
                let from = i.saturating_sub(width);
                let (here, there) =
                    (&row[width + from - i..width + j - i], &other[width + from - j..width]);
                let sum = dot(here, there);
                row[width + j - i] = (row[width + j - i] - sum) / other[width];
            }
            let square = diagonal - dot(&row[..width], &row[..width]);
            if square.is_nan() || square <= SMALLEST_PIVOT * diagonal {
                return None;
            }
            row[width] = square.sqrt();
        }
        Some(Factor { lower })
    }

    fn row(&self, row: usize) -> &[f64] {
        &self.entries[row * (self.width + 1)..][..=self.width]
    }
}

/// The Cholesky factor of a band matrix.
#[derive(Clone, Debug)]
pub(super) struct Factor {
    lower: Band,
}

impl Factor {
    /// The solution of L·Lᵀ·x = rhs.
    pub(super) fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        let (size, width) = (self.lower.size, self.lower.width);
        let mut x = rhs.to_vec();
        for i in 0..size {
            let from = i.saturating_sub(width);
            let row = self.lower.row(i);
            x[i] = (x[i] - dot(&row[width + from - i..width], &x[from..i])) / row[width];
        }
        for i in (0..size).rev() {
            let from = i.saturating_sub(width);
            let row = self.lower.row(i);
            x[i] /= row[width];
            let known = x[i];
            for (value, entry) in x[from..i].iter_mut().zip(&row[width + from - i..width]) {
                *value -= entry * known;
            }
        }
        x
    }

    /// Trace of (L·Lᵀ)⁻¹·other, for a matrix of the same band. `O(size·width²)`.
    ///
    /// Only the entries of the inverse within the band are needed, and they follow from each other from the
    /// last column backwards (Takahashi, Fagan & Chin 1973; Erisman & Tinney, Comm. ACM 18 (1975) 177).
    pub(super) fn trace_of_solution(&self, other: &Band) -> f64 {
        let (size, width) = (self.lower.size, self.lower.width);
        let stride = 2 * width + 1;
        // Entry (i, j) of the inverse at i·stride + width + j − i, on both sides of the diagonal.
        let mut inverse = vec![0.0; size * stride];
        let mut column = vec![0.0; width];
        for j in (0..size).rev() {
            let below = width.min(size - 1 - j);
            for (k, entry) in column[..below].iter_mut().enumerate() {
                *entry = self.lower.row(j + 1 + k)[width - 1 - k];
            }
            let pivot = self.lower.row(j)[width];
            for i in (j + 1..=j + below).rev() {
                let row = &inverse[i * stride + width + j + 1 - i..][..below];
                let entry = -dot(&column[..below], row) / pivot;
                inverse[i * stride + width + j - i] = entry;
                inverse[j * stride + width + i - j] = entry;
            }
            let beside = &inverse[j * stride + width + 1..][..below];
            inverse[j * stride + width] = (pivot.recip() - dot(&column[..below], beside)) / pivot;
        }
        (0..size)
            .map(|i| {
                let row = other.row(i);
                let here = &inverse[i * stride..][..=width];
                2.0 * dot(&row[..width], &here[..width]) + row[width] * here[width]
            })
            .sum()
    }
}

/// A dot product in four interleaved sums, an order the compiler can turn into vector instructions.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (a_head, a_tail) = a.as_chunks::<4>();
    let (b_head, b_tail) = b.as_chunks::<4>();
    for (a, b) in a_head.iter().zip(b_head) {
        for k in 0..4 {
            lanes[k] += a[k] * b[k];
        }
    }
    for (k, (a, b)) in a_tail.iter().zip(b_tail).enumerate() {
        lanes[k] += a * b;
    }
    (lanes[0] + lanes[2]) + (lanes[1] + lanes[3])
}

/// A pivot below this share of its diagonal is rounding.
const SMALLEST_PIVOT: f64 = 1e-13;

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    fn entry(i: usize, j: usize) -> f64 {
        ((i * 31 + j * 17 + i * j) % 13) as f64 / 13.0 - 0.5
    }

    fn dense(band: &Band) -> DMatrix<f64> {
        DMatrix::from_fn(band.size, band.size, |i, j| {
            let (row, column) = (i.max(j), i.min(j));
            if row - column > band.width { 0.0 } else { band.row(row)[band.width + column - row] }
        })
    }

    #[test]
    fn solutions_and_traces_are_those_of_dense_matrices() {
        for (size, width) in [(1, 0), (1, 3), (5, 1), (9, 4), (12, 11), (40, 7)] {
            let (mut band, mut other) = (Band::new(size, width), Band::new(size, width));
            for i in 0..size {
                for j in i.saturating_sub(width)..=i {
                    band.add(
                        i,
                        j,
                        entry(i, j) + if i == j { 2.0 * width as f64 + 1.0 } else { 0.0 },
                    );
                    other.add(i, j, entry(j, i + 2));
                }
            }
            let sum = band.plus(0.25, &other);
            assert!((dense(&sum) - (dense(&band) + dense(&other) * 0.25)).amax() < 1e-15);
            let vector: Vec<f64> = (0..size).map(|i| entry(i, 3)).collect();
            let rhs = band.times(&vector);
            assert!(
                (DVector::from_vec(rhs.clone()) - dense(&band) * DVector::from_vec(vector.clone()))
                    .amax()
                    < 1e-13
            );
            let factor = band.factor().unwrap();
            for (found, truth) in factor.solve(&rhs).iter().zip(&vector) {
                assert!((found - truth).abs() < 1e-13);
            }
            let trace = (dense(&band).try_inverse().unwrap() * dense(&other)).trace();
            assert!((factor.trace_of_solution(&other) - trace).abs() < 1e-12, "{size} {width}");
            assert!((band.trace() - dense(&band).trace()).abs() < 1e-12);
        }
    }

    #[test]
    fn a_singular_matrix_has_no_factor() {
        let mut band = Band::new(2, 1);
        for (i, j) in [(0, 0), (1, 0), (1, 1)] {
            band.add(i, j, 0.1);
        }
        assert!(band.factor().is_none());
        assert!(Band::new(3, 1).factor().is_none());
    }
}
