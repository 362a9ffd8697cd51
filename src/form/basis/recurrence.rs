//! Families of polynomials of one variable by recurrence: values of many places, or value and derivatives.
//!
//! Everything of this folder is made of such families: Chebyshev and Legendre polynomials and powers along
//! x and y, Jacobi polynomials and those of Forbes along the square of the radius. A recurrence is stable
//! where closed formulas with factorials cancel (n above 20), and differentiating it costs two more
//! recurrences with the same coefficients.

use super::LANES;
use crate::taylor::Taylor;

/// `p_{k+1} = (a + b·x)·p_k − c·p_{k−1} − d·p_{k−2}`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Step {
    pub(super) a: f64,
    pub(super) b: f64,
    pub(super) c: f64,
    pub(super) d: f64,
}

/// `q_k = (p_k − g·q_{k−1} − h·q_{k−2}) / f`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mix {
    pub(super) f: f64,
    pub(super) g: f64,
    pub(super) h: f64,
}

/// Polynomials q_0 to q_N of one variable.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Family {
    /// p_0.
    start: f64,
    /// From p_k to p_{k+1}, at k.
    steps: Vec<Step>,
    /// From p_k to q_k, at k; none where they are the same.
    mixes: Vec<Mix>,
}

impl Family {
    /// The family of p_0 = 1 and the steps.
    pub(super) fn new(steps: Vec<Step>) -> Family {
        Family { start: 1.0, steps, mixes: Vec::new() }
    }

    /// The family of the constant p_0 = `start` and the steps, mixed. There must be one more mix than steps.
    pub(super) fn mixed(start: f64, steps: Vec<Step>, mixes: Vec<Mix>) -> Family {
        debug_assert_eq!(mixes.len(), steps.len() + 1);
        Family { start, steps, mixes }
    }

    /// Shows every q_k at the places `x` to `visit`, from q_0 on.
    pub(super) fn each<const N: usize>(
        &self,
        x: &[f64; N],
        mut visit: impl FnMut(usize, &[f64; N]),
    ) {
        // The last three of each; what is three back makes room for the next.
        let mut p = [[self.start; N], [0.0; N], [0.0; N]];
        let mut q = [[0.0; N]; 3];
        let [mut now, mut before, mut next] = [0, 1, 2];
        for k in 0..=self.steps.len() {
            if let Some(mix) = self.mixes.get(k) {
                let share = mix.f.recip();
                let [q_now, q_last, q_earlier] = disjoint(&mut q, [now, before, next]);
                for i in 0..N {
                    q_now[i] = (p[now][i] - mix.g * q_last[i] - mix.h * q_earlier[i]) * share;
                }
                visit(k, &q[now]);
            } else {
                visit(k, &p[now]);
            }
            let Some(step) = self.steps.get(k) else { break };
            let [p_now, p_before, p_next] = disjoint(&mut p, [now, before, next]);
            for i in 0..N {
                p_next[i] =
                    (step.a + step.b * x[i]) * p_now[i] - step.c * p_before[i] - step.d * p_next[i];
            }
            [now, before, next] = [next, now, before];
        }
    }

    /// Shows every q_k with its derivatives at `x` to `visit`, from q_0 on.
    pub(super) fn each_taylor(&self, x: f64, mut visit: impl FnMut(usize, Taylor)) {
        let mut p = [Taylor::constant(self.start), Taylor::default(), Taylor::default()];
        let mut q = [Taylor::default(); 2];
        for k in 0..=self.steps.len() {
            if let Some(mix) = self.mixes.get(k) {
                let share = mix.f.recip();
                let blend =
                    |p: f64, now: f64, before: f64| (p - mix.g * now - mix.h * before) * share;
                let next = Taylor {
                    value: blend(p[0].value, q[0].value, q[1].value),
                    first: blend(p[0].first, q[0].first, q[1].first),
                    second: blend(p[0].second, q[0].second, q[1].second),
                };
                q = [next, q[0]];
                visit(k, next);
            } else {
                visit(k, p[0]);
            }
            let Some(step) = self.steps.get(k) else { break };
            let slope = step.a + step.b * x;
            let ahead = |now: f64, before: f64, earlier: f64| {
                slope * now - step.c * before - step.d * earlier
            };
            let next = Taylor {
                value: ahead(p[0].value, p[1].value, p[2].value),
                first: ahead(p[0].first, p[1].first, p[2].first) + step.b * p[0].value,
                second: ahead(p[0].second, p[1].second, p[2].second) + 2.0 * step.b * p[0].first,
            };
            p = [next, p[0], p[1]];
        }
    }
}

fn disjoint<const N: usize>(rows: &mut [[f64; N]; 3], order: [usize; 3]) -> [&mut [f64; N]; 3] {
    rows.get_disjoint_mut(order).expect("the order is a permutation")
}

/// `values[i] · factor[i] · scale` for a block.
pub(super) fn scaled(
    values: &[f64; LANES],
    factor: &[f64; LANES],
    scale: f64,
    out: &mut [f64; LANES],
) {
    for i in 0..LANES {
        out[i] = values[i] * factor[i] * scale;
    }
}
