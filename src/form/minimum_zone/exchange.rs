//! The linear minimax problem, solved exactly by the exchange of constraints.
//!
//! Minimise t over y and t, subject to |b_i + J_i·y| ≤ t for every row and |y_j| ≤ reach. Its dual asks
//! for multipliers λ ≥ 0 of the bounds with Σ λ_i = 1 over the rows and Σ λ_i·s_i·J_i + (those of the box)
//! = 0, where s_i is the side. The simplex method on the dual keeps as many bounds as there are unknowns,
//! all met as equations: the most violated bound enters and, so that every λ stays ≥ 0, one leaves. t never
//! falls, and at any time it is a lower bound of the answer (Stiefel, Numer. Math. 1 (1959) 1; Watson,
//! Approximation Theory and Numerical Methods, Wiley 1980, ch. 2). Because of the box nothing is asked of
//! the rank of J: a direction the rows do not bind is bound by the box.
//!
//! The equations are solved anew in every step, so that rounding does not pile up. Where t does not grow
//! for long, Bland's rule (Math. Oper. Res. 2 (1977) 103) excludes an endless round.

use nalgebra::{DMatrix, DVector};

/// The rows b_i + J_i·y: `columns` entries of J_i and then b_i, row after row.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    pub(super) columns: usize,
    pub(super) entries: Vec<f64>,
}

/// The answer to a linear minimax problem.
#[derive(Clone, Debug)]
pub(super) struct Optimum {
    pub(super) y: Vec<f64>,
    /// The largest |b_i + J_i·y|.
    pub(super) reached: f64,
    /// Rows with a positive multiplier, ascending.
    pub(super) held: Vec<Held>,
    /// Length of Σ λ_i·s_i·J_i over the rows: what the box has to hold.
    pub(super) pull: f64,
}

/// A row that holds the answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Held {
    pub(super) row: usize,
    /// Whether b_i + J_i·y is at +t, not −t.
    pub(super) high: bool,
    pub(super) multiplier: f64,
}

impl Held {
    /// 1 or −1.
    pub(super) fn side(self) -> f64 {
        sign(self.high)
    }
}

impl Rows {
    pub(super) fn count(&self) -> usize {
        self.entries.len() / (self.columns + 1)
    }

    fn row(&self, index: usize) -> (&[f64], f64) {
        let row = &self.entries[index * (self.columns + 1)..][..=self.columns];
        (&row[..self.columns], row[self.columns])
    }

    /// b_i.
    pub(super) fn start(&self, index: usize) -> f64 {
        self.row(index).1
    }

    /// J_i.
    pub(super) fn slopes(&self, index: usize) -> &[f64] {
        self.row(index).0
    }

    /// The best y in the box. There must be a row, all finite and of order 1; `reach` is positive.
    /// `O(columns³ + rows·columns)` an exchange.
    pub(super) fn minimax(&self, reach: f64) -> Optimum {
        let mut basis = self.corner();
        let mut best = self.vertex(&basis, reach);
        let mut idle = 0;
        for _ in 0..EXCHANGES_PER_COLUMN * (self.columns + 4) {
            let Some(vertex) = &best else { break };
            let cautious = idle > IDLE_PER_COLUMN * (self.columns + 4);
            let Some(entering) = self.entering(vertex, reach, cautious) else { break };
            let Some(leaving) = self.leaving(&basis, vertex, entering, cautious) else { break };
            let mut exchanged = basis.clone();
            exchanged[leaving] = entering;
            let Some(next) = self.vertex(&exchanged, reach) else { break };
            idle = if next.t > vertex.t { 0 } else { idle + 1 };
            (basis, best) = (exchanged, Some(next));
        }
        self.optimum(&basis, best, reach)
    }

    /// The row with the largest |b_i| on its side, and the sides of the box that hold it.
    fn corner(&self) -> Vec<Bound> {
        let mut largest = 0;
        for index in 1..self.count() {
            if self.row(index).1.abs() > self.row(largest).1.abs() {
                largest = index;
            }
        }
        let (slopes, b) = self.row(largest);
        let high = b >= 0.0;
        let sides = slopes.iter().enumerate();
        let sides = sides.map(|(axis, &slope)| Bound::Box { axis, high: (slope > 0.0) != high });
        std::iter::once(Bound::Row { row: largest, high }).chain(sides).collect()
    }

    /// Where the bounds of the basis meet, and their multipliers. `None` if they do not meet in one point.
    fn vertex(&self, basis: &[Bound], reach: f64) -> Option<Vertex> {
        let size = basis.len();
        let mut matrix = DMatrix::zeros(size, size);
        let mut limits = DVector::zeros(size);
        for (k, &bound) in basis.iter().enumerate() {
            matrix.set_row(k, &self.coefficients(bound).transpose());
            limits[k] = self.limit(bound, reach);
        }
        let transposed = matrix.transpose().lu();
        let factors = matrix.lu();
        let solution = factors.solve(&limits)?;
        let mut objective = DVector::zeros(size);
        objective[size - 1] = -1.0;
        let multipliers = transposed.solve(&objective)?;
        let t = solution[size - 1];
        let finite = solution.iter().chain(multipliers.iter()).all(|entry| entry.is_finite());
        finite.then(|| Vertex {
            y: solution.rows(0, size - 1).into_owned(),
            t,
            multipliers,
            transposed,
        })
    }

    /// The bound the vertex violates most; the first one if `cautious`. `None` if it violates none.
    fn entering(&self, vertex: &Vertex, reach: f64, cautious: bool) -> Option<Bound> {
        let mut worst = None;
        let mut most = FEASIBLE * (1.0 + vertex.t.abs());
        for row in 0..self.count() {
            let value = self.value(row, vertex.y.as_slice());
            let violation = value.abs() - vertex.t;
            if violation > most {
                worst = Some(Bound::Row { row, high: value > 0.0 });
                if cautious {
                    return worst;
                }
                most = violation;
            }
        }
        for (axis, &y) in vertex.y.iter().enumerate() {
            let violation = y.abs() - reach;
            if violation > most {
                worst = Some(Bound::Box { axis, high: y > 0.0 });
                if cautious {
                    return worst;
                }
                most = violation;
            }
        }
        worst
    }

    /// Place in the basis of the bound whose multiplier falls to 0 first as that of `entering` grows. Of
    /// several the one with the largest share, for the sake of rounding; the first one if `cautious`.
    fn leaving(
        &self,
        basis: &[Bound],
        vertex: &Vertex,
        entering: Bound,
        cautious: bool,
    ) -> Option<usize> {
        let shares = vertex.transposed.solve(&self.coefficients(entering))?;
        let least_share = PIVOT * shares.amax();
        let candidates = || (0..basis.len()).filter(|&k| shares[k] > least_share);
        let ratio = |k: usize| vertex.multipliers[k].max(0.0) / shares[k];
        let smallest = candidates().map(ratio).fold(f64::INFINITY, f64::min);
        let tied = candidates().filter(|&k| ratio(k) <= smallest + TIE);
        if cautious {
            tied.min_by_key(|&k| basis[k])
        } else {
            tied.max_by(|&a, &b| shares[a].total_cmp(&shares[b]))
        }
    }

    fn optimum(&self, basis: &[Bound], vertex: Option<Vertex>, reach: f64) -> Optimum {
        let value =
            |y: &[f64]| (0..self.count()).map(|row| self.value(row, y).abs()).fold(0.0, f64::max);
        let Some(vertex) = vertex else {
            let y = vec![0.0; self.columns];
            let reached = value(&y);
            return Optimum { y, reached, held: Vec::new(), pull: f64::INFINITY };
        };
        let y: Vec<f64> = vertex.y.iter().map(|y| y.clamp(-reach, reach)).collect();
        let mut held = Vec::new();
        let mut pull = vec![0.0; self.columns];
        for (&bound, &multiplier) in basis.iter().zip(vertex.multipliers.iter()) {
            if let Bound::Row { row, high } = bound
                && multiplier > 0.0
            {
                held.push(Held { row, high, multiplier });
                for (sum, slope) in pull.iter_mut().zip(self.slopes(row)) {
                    *sum += multiplier * sign(high) * slope;
                }
            }
        }
        held.sort_by_key(|held| held.row);
        Optimum { reached: value(&y), y, held, pull: length(&pull) }
    }

    fn value(&self, row: usize, y: &[f64]) -> f64 {
        let (slopes, b) = self.row(row);
        slopes.iter().zip(y).fold(b, |sum, (slope, y)| sum + slope * y)
    }

    /// A bound as coefficients·(y, t) ≤ limit.
    fn coefficients(&self, bound: Bound) -> DVector<f64> {
        let mut coefficients = DVector::zeros(self.columns + 1);
        match bound {
            Bound::Row { row, high } => {
                let side = sign(high);
                for (entry, slope) in coefficients.iter_mut().zip(self.slopes(row)) {
                    *entry = side * slope;
                }
                coefficients[self.columns] = -1.0;
            }
            Bound::Box { axis, high } => coefficients[axis] = sign(high),
        }
        coefficients
    }

    fn limit(&self, bound: Bound, reach: f64) -> f64 {
        match bound {
            Bound::Row { row, high } => -sign(high) * self.row(row).1,
            Bound::Box { .. } => reach,
        }
    }
}

/// One of the inequalities. The order is that of Bland's rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Bound {
    Row { row: usize, high: bool },
    Box { axis: usize, high: bool },
}

/// The point where the bounds of a basis meet.
struct Vertex {
    y: DVector<f64>,
    t: f64,
    multipliers: DVector<f64>,
    /// Factors of the transposed equations.
    transposed: nalgebra::LU<f64, nalgebra::Dyn, nalgebra::Dyn>,
}

fn length(vector: &[f64]) -> f64 {
    vector.iter().map(|entry| entry * entry).sum::<f64>().sqrt()
}

fn sign(high: bool) -> f64 {
    if high { 1.0 } else { -1.0 }
}

/// A violation below this, relative to values of order 1, is rounding.
const FEASIBLE: f64 = 1e-13;
/// Entries below this share of the largest do not exchange.
const PIVOT: f64 = 1e-9;
/// Ratios nearer than this are tied.
const TIE: f64 = 1e-13;
/// Three or four a column are usual.
const EXCHANGES_PER_COLUMN: usize = 100;
/// Exchanges without growth, a column, until Bland's rule takes over.
const IDLE_PER_COLUMN: usize = 3;
