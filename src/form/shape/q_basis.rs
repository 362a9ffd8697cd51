//! Forbes' polynomials Q^bfs and Q^con by recurrences, and sums of them with two derivatives.

use super::taylor::Taylor;

/// Q^bfs_0 … Q^bfs_M, slope-orthogonal, after Forbes, Opt. Express 18 (2010) 19700.
///
/// They are built from P_m with P_0 = 2, P_1 = 6 − 8x, P_m = (2 − 4x)·P_{m−1} − P_{m−2} by
/// `P_m = f_m·Q_m + g_{m−1}·Q_{m−1} + h_{m−2}·Q_{m−2}` (eq. A.14 to A.16).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SlopeOrthogonal {
    f: Vec<f64>,
    g: Vec<f64>,
    h: Vec<f64>,
}

impl SlopeOrthogonal {
    pub(super) fn new(terms: usize) -> SlopeOrthogonal {
        let mut basis = SlopeOrthogonal { f: Vec::new(), g: Vec::new(), h: Vec::new() };
        for m in 0..terms {
            let n = m as f64;
            let f = match m {
                0 => 2.0,
                1 => 0.5 * 19_f64.sqrt(),
                _ => {
                    let (g, h) = (basis.g[m - 1], basis.h[m - 2]);
                    (n * (n + 1.0) + 3.0 - g * g - h * h).sqrt()
                }
            };
            let g = if m == 0 { -0.5 } else { -(1.0 + basis.g[m - 1] * basis.h[m - 1]) / f };
            basis.f.push(f);
            basis.g.push(g);
            basis.h.push(-(n + 2.0) * (n + 1.0) / (2.0 * f));
        }
        basis
    }

    /// The coefficients b of `Σ b_m·P_m = Σ a_m·Q_m` (eq. 3.2 to 3.5).
    pub(super) fn auxiliary(&self, a: &[f64]) -> Vec<f64> {
        let mut b = vec![0.0; a.len() + 2];
        for m in (0..a.len()).rev() {
            b[m] = (a[m] - self.g[m] * b[m + 1] - self.h[m] * b[m + 2]) / self.f[m];
        }
        b.truncate(a.len());
        b
    }

    /// `Σ b_m·P_m(x)` by Clenshaw's recurrence, differentiated twice.
    pub(super) fn sum(b: &[f64], x: f64) -> Taylor {
        let k = 2.0 - 4.0 * x;
        let (mut one, mut two) = (Taylor::default(), Taylor::default());
        for b in b.iter().rev() {
            let next = Taylor {
                value: b + k * one.value - two.value,
                first: k * one.first - two.first - 4.0 * one.value,
                second: k * one.second - two.second - 8.0 * one.first,
            };
            (two, one) = (one, next);
        }
        let sum = one.plus(two);
        Taylor { value: 2.0 * sum.value, first: 2.0 * sum.first, second: 2.0 * sum.second }
    }

    /// `Σ b_m·P_m(x)` alone.
    pub(super) fn value(b: &[f64], x: f64) -> f64 {
        let k = 2.0 - 4.0 * x;
        let (one, two) = b.iter().rev().fold((0.0, 0.0), |(one, two), b| (b + k * one - two, one));
        2.0 * (one + two)
    }

    /// Writes Q_0(x), Q_1(x) ….
    pub(super) fn values(&self, x: f64, values: &mut [f64]) {
        let k = 2.0 - 4.0 * x;
        let (mut p, mut next_p) = (2.0, 6.0 - 8.0 * x);
        let (mut one, mut two) = (0.0, 0.0);
        for (m, value) in values.iter_mut().enumerate() {
            let g = if m > 0 { self.g[m - 1] } else { 0.0 };
            let h = if m > 1 { self.h[m - 2] } else { 0.0 };
            *value = (p - g * one - h * two) / self.f[m];
            (two, one) = (one, *value);
            (p, next_p) = (next_p, k * next_p - p);
        }
    }
}

/// Q^con_m(x) = P_m^{(0,4)}(2x − 1), a Jacobi polynomial (Forbes, Opt. Express 15 (2007) 5218).
///
/// `Q_{m+1} = (α_m·(2x−1) + β_m)·Q_m − γ_m·Q_{m−1}`, Q_0 = 1 (DLMF 18.9.2 with α = 0, β = 4).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SagOrthogonal {
    steps: Vec<[f64; 3]>,
}

impl SagOrthogonal {
    pub(super) fn new(terms: usize) -> SagOrthogonal {
        let step = |m: usize| {
            let n = m as f64;
            let divisor = (n + 1.0) * (n + 5.0) * (2.0 * n + 4.0);
            [
                (2.0 * n + 5.0) * (n + 3.0) * (2.0 * n + 4.0) / divisor,
                -8.0 * (2.0 * n + 5.0) / divisor,
                n * (n + 4.0) * (2.0 * n + 6.0) / divisor,
            ]
        };
        SagOrthogonal { steps: (0..terms + 1).map(step).collect() }
    }

    /// `Σ a_m·Q_m(x)` by Clenshaw's recurrence, differentiated twice by x.
    pub(super) fn sum(&self, a: &[f64], x: f64) -> Taylor {
        let centred = 2.0 * x - 1.0;
        let (mut one, mut two) = (Taylor::default(), Taylor::default());
        for (m, a) in a.iter().enumerate().rev() {
            let [alpha, beta, _] = self.steps[m];
            let [_, _, gamma] = self.steps[m + 1];
            let k = alpha * centred + beta;
            let next = Taylor {
                value: a + k * one.value - gamma * two.value,
                first: k * one.first - gamma * two.first + 2.0 * alpha * one.value,
                second: k * one.second - gamma * two.second + 4.0 * alpha * one.first,
            };
            (two, one) = (one, next);
        }
        one
    }

    /// `Σ a_m·Q_m(x)` alone.
    pub(super) fn value(&self, a: &[f64], x: f64) -> f64 {
        let centred = 2.0 * x - 1.0;
        let terms = a.iter().zip(&self.steps).zip(&self.steps[1..]).rev();
        let sum = terms.fold((0.0, 0.0), |(one, two), ((a, step), above)| {
            (a + (step[0] * centred + step[1]) * one - above[2] * two, one)
        });
        sum.0
    }

    /// Writes Q_0(x), Q_1(x) ….
    pub(super) fn values(&self, x: f64, values: &mut [f64]) {
        let centred = 2.0 * x - 1.0;
        let (mut one, mut two) = (1.0, 0.0);
        for (value, [alpha, beta, gamma]) in values.iter_mut().zip(&self.steps) {
            *value = one;
            (one, two) = ((alpha * centred + beta) * one - gamma * two, one);
        }
    }
}
