//! The features of a graph by the paper of the Point Cloud Graph: symmetric polynomials of its spectrum.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::graph::PointGraph;

/// Figures of a graph that the paper compares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraphFeatures {
    /// The Euclidean norm of the feature matrix B.
    pub norm: f64,
    /// Nodes of the graph: B has as many rows and columns.
    pub nodes: usize,
}

impl GraphFeatures {
    /// The distance D of the paper: by how much the norms differ. It is symmetric and keeps the triangle inequality; 0 does not mean
    /// that the graphs are the same. Graphs of different numbers of strips differ by their size alone.
    pub fn distance(&self, other: &GraphFeatures) -> f64 {
        (self.norm - other.norm).abs()
    }
}

/// The features of a graph; n³ time for n nodes.
///
/// The graph Laplacian, degrees less adjacency, has the eigenvalues λᵢ and the unit eigenvectors eᵢ. Of each vector √λᵢ·eᵢ the
/// elementary symmetric polynomials S₁ to Sₙ are taken, and of these sign(S)·ln(1 + |S|). An eigenvector has the sign by which its
/// first entry that is not 0 is above it. Inside a multiple eigenvalue the vectors are those of the solver: the norm then hangs on
/// it.
pub fn graph_features<const D: usize>(graph: &PointGraph<D>) -> GraphFeatures {
    let nodes = graph.nodes().len();
    let mut laplacian = DMatrix::<f64>::zeros(nodes, nodes);
    for arc in graph.arcs() {
        let [a, b] = arc.nodes.map(|node| node as usize);
        laplacian[(a, a)] += 1.0;
        laplacian[(b, b)] += 1.0;
        laplacian[(a, b)] -= 1.0;
        laplacian[(b, a)] -= 1.0;
    }
    GraphFeatures { norm: norm(laplacian), nodes }
}

fn norm(laplacian: DMatrix<f64>) -> f64 {
    let found = SymmetricEigen::new(laplacian);
    let mut order: Vec<usize> = (0..found.eigenvalues.len()).collect();
    order.sort_by(|&a, &b| found.eigenvalues[a].total_cmp(&found.eigenvalues[b]));
    let mut square = 0.0;
    for at in order {
        let root = found.eigenvalues[at].max(0.0).sqrt();
        let vector = found.eigenvectors.column(at);
        let first = vector.iter().copied().find(|entry| entry.abs() > ROUNDING);
        let sign = if first.is_some_and(|entry| entry < 0.0) { -root } else { root };
        let entries: Vec<f64> = vector.iter().map(|entry| sign * entry).collect();
        square += logarithms(&entries).iter().map(|value| value * value).sum::<f64>();
    }
    square.sqrt()
}

/// sign(S)·ln(1 + |S|) of the elementary symmetric polynomials S₁ to Sₙ of some values.
fn logarithms(values: &[f64]) -> Vec<f64> {
    let mut polynomials = vec![Scaled::ONE];
    for &value in values {
        polynomials.push(Scaled::ZERO);
        for at in (1..polynomials.len()).rev() {
            polynomials[at] = polynomials[at].plus(polynomials[at - 1].times(value));
        }
    }
    polynomials[1..].iter().map(Scaled::logarithm).collect()
}

/// A number with an exponent of its own: polynomials of some hundred values leave the range of a double.
#[derive(Clone, Copy)]
struct Scaled {
    mantissa: f64,
    exponent: i64,
}

impl Scaled {
    const ONE: Scaled = Scaled { mantissa: 1.0, exponent: 0 };
    const ZERO: Scaled = Scaled { mantissa: 0.0, exponent: 0 };

    fn times(self, factor: f64) -> Scaled {
        Scaled { mantissa: self.mantissa * factor, ..self }.normal()
    }

    fn plus(self, other: Scaled) -> Scaled {
        if self.mantissa == 0.0 {
            return other;
        }
        if other.mantissa == 0.0 {
            return self;
        }
        let (large, small) =
            if self.exponent >= other.exponent { (self, other) } else { (other, self) };
        let apart = (small.exponent - large.exponent).max(-2 * STEP) as i32;
        let mantissa = large.mantissa + small.mantissa * f64::from(apart).exp2();
        Scaled { mantissa, ..large }.normal()
    }

    /// Keeps the mantissa between 2⁻⁵¹² and 2⁵¹².
    fn normal(mut self) -> Scaled {
        let half = (STEP as f64).exp2();
        if self.mantissa.abs() >= half {
            self.mantissa /= half;
            self.exponent += STEP;
        } else if self.mantissa != 0.0 && self.mantissa.abs() < 1.0 / half {
            self.mantissa *= half;
            self.exponent -= STEP;
        }
        self
    }

    fn logarithm(&self) -> f64 {
        let value = self.mantissa * (self.exponent.clamp(-4 * STEP, STEP) as f64).exp2();
        let size = if value.is_finite() && value.abs() < (STEP as f64).exp2() {
            value.abs().ln_1p()
        } else {
            self.mantissa.abs().ln() + self.exponent as f64 * std::f64::consts::LN_2
        };
        size.copysign(self.mantissa)
    }
}

/// Bits by which an exponent changes.
const STEP: i64 = 512;
/// Entries of an eigenvector below this are rounding.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_those_of_the_product() {
        // Π (1 + vx) = 1 + 6x + 11x² + 6x³ for 1, 2, 3.
        let found = logarithms(&[1.0, 2.0, 3.0]);
        for (found, expected) in found.iter().zip([6.0_f64, 11.0, 6.0]) {
            assert!((found - expected.ln_1p()).abs() < 1e-14);
        }
        // Signs: (1 − x)(1 + 2x) = 1 + x − 2x².
        let found = logarithms(&[-1.0, 2.0]);
        assert!((found[0] - 2.0_f64.ln()).abs() < 1e-15 && (found[1] + 3.0_f64.ln()).abs() < 1e-15);
    }

    #[test]
    fn hundreds_of_values_neither_overflow_nor_vanish() {
        // (1 + 9x)ⁿ: the coefficient in the middle is C(n, n/2)·9^(n/2), the last 9ⁿ.
        let found = logarithms(&[9.0; 800]);
        let ln_binomial: f64 =
            (1..=400).map(|at| ((400 + at) as f64).ln() - f64::from(at).ln()).sum();
        let middle = ln_binomial + 400.0 * 9.0_f64.ln();
        assert!((found[399] / middle - 1.0).abs() < 1e-12, "{} {middle}", found[399]);
        assert!((found[799] / (800.0 * 9.0_f64.ln()) - 1.0).abs() < 1e-12);
        let small = logarithms(&[1e-3; 800]);
        assert!(small[799].abs() < 1e-300 && (small[0] - 0.8_f64.ln_1p()).abs() < 1e-12);
    }

    #[test]
    fn a_path_of_three_nodes_is_worked_out_by_hand() {
        // Eigenvalues 0, 1, 3; eigenvectors (1, 0, −1)/√2 and (1, −2, 1)/√6.
        let path =
            DMatrix::from_row_slice(3, 3, &[1.0, -1.0, 0.0, -1.0, 2.0, -1.0, 0.0, -1.0, 1.0]);
        let of = |values: [f64; 3]| {
            let [a, b, c] = values;
            let signed = |s: f64| s.signum() * s.abs().ln_1p();
            [signed(a + b + c), signed(a * b + a * c + b * c), signed(a * b * c)]
        };
        let half = 0.5_f64.sqrt();
        let all = [of([half, 0.0, -half]), of([half, -2.0 * half, half])];
        let expected: f64 = all.iter().flatten().map(|value| value * value).sum::<f64>().sqrt();
        assert!((norm(path) - expected).abs() < 1e-12);
    }
}
