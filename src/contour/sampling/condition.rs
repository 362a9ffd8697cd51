//! Conditions on samples, and whether they are met.

use std::fmt;

use super::CurveSampling;
use crate::PlaceMm;

/// Condition under which a method is proven to find the curve. Bounds are strict.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Condition {
    /// The bound of ε.
    pub epsilon: Option<f64>,
    /// The bound of ρ.
    pub rho: Option<f64>,
    /// The bound of u, the ratio of edges that follow each other.
    pub uniformity: Option<f64>,
    /// The bound of the longest edge over the least local feature size of the curve.
    pub spacing: Option<f64>,
}

/// Quantity that a condition bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// ε.
    Epsilon,
    /// ρ.
    Rho,
    /// u.
    Uniformity,
    /// Edge over least local feature size.
    Spacing,
    /// Ends: what is proven is proven of closed curves.
    End,
}

/// Place where a condition is not met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Failure {
    /// The place in mm.
    pub at_mm: PlaceMm,
    /// What fails.
    pub quantity: Quantity,
    /// Its value; of an end 1.
    pub found: f64,
    /// The bound that it must be below; of an end 0.
    pub bound: f64,
}

/// Outcome of a condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Where the condition comes nearest to failing, or fails most; none without edges.
    pub worst: Option<Failure>,
    /// Where it fails, worst first; ends come last.
    pub failures: Vec<Failure>,
}

impl Verdict {
    /// Whether the samples meet the condition.
    pub fn holds(&self) -> bool {
        self.failures.is_empty()
    }
}

impl Condition {
    /// Every quantity that is bounded, at every place, against its bound.
    pub(super) fn judge(&self, sampling: &CurveSampling) -> Verdict {
        let mut all: Vec<Failure> = Vec::new();
        let mut add = |quantity,
                       bound: Option<f64>,
                       values: &mut dyn Iterator<Item = (PlaceMm, f64)>| {
            if let Some(bound) = bound {
                all.extend(values.map(|(at_mm, found)| Failure { at_mm, quantity, found, bound }));
            }
        };
        let edges = || sampling.edges().iter();
        add(Quantity::Epsilon, self.epsilon, &mut edges().map(|edge| (edge.at_mm, edge.epsilon)));
        add(Quantity::Rho, self.rho, &mut edges().map(|edge| (edge.at_mm, edge.rho)));
        let least_mm = sampling.least_lfs_mm();
        let spacing = |edge: &super::EdgeSampling| (edge.at_mm, edge.length_mm / least_mm);
        add(Quantity::Spacing, self.spacing, &mut edges().map(spacing));
        let steps = sampling.steps().iter().map(|step| (step.at_mm, step.ratio));
        add(Quantity::Uniformity, self.uniformity, &mut { steps });
        let share = |failure: &Failure| failure.found / failure.bound;
        // Stable: of equal ones the first edge stays first.
        all.sort_by(|a, b| share(b).total_cmp(&share(a)));
        let worst = all.first().copied();
        all.retain(|value| value.found >= value.bound);
        all.extend(sampling.ends_mm().iter().map(|&at_mm| Failure {
            at_mm,
            quantity: Quantity::End,
            found: 1.0,
            bound: 0.0,
        }));
        Verdict { worst, failures: all }
    }
}

impl fmt::Display for Condition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bounds = [
            (Quantity::Epsilon, self.epsilon),
            (Quantity::Rho, self.rho),
            (Quantity::Uniformity, self.uniformity),
            (Quantity::Spacing, self.spacing),
        ];
        let bounds = bounds.iter().filter_map(|(quantity, bound)| Some((quantity, (*bound)?)));
        let words: Vec<String> =
            bounds.map(|(quantity, bound)| format!("{quantity} < {}", rounded(bound))).collect();
        f.write_str(&words.join(", "))
    }
}

/// A bound as it is written: 1/3 as such, others with up to three digits.
fn rounded(bound: f64) -> String {
    match bound == 1.0 / 3.0 {
        true => "1/3".to_owned(),
        false => format!("{}", (bound * 1e3).round() / 1e3),
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Quantity::Epsilon => "ε",
            Quantity::Rho => "ρ",
            Quantity::Uniformity => "u",
            Quantity::Spacing => "edge / least feature size",
            Quantity::End => "end",
        })
    }
}
