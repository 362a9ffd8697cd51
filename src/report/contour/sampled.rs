//! Whether the points suffice for the curve that was found.

use serde::{Deserialize, Serialize};

/// ε, ρ and u of the points for the curve found, and whether they meet the condition of the method. Lengths are mm.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct SampledFigures {
    /// The condition under which the method is proven to find smooth closed curves; `None` if none is known.
    pub condition: Option<String>,
    /// Whether the points meet it and the curve has no ends; `None` without a condition.
    pub holds: Option<bool>,
    /// The largest distance of a place of the curve to the points over its local feature size; `None` where that is zero.
    pub epsilon: Option<f64>,
    /// The same over the reach, the least local feature size between two points.
    pub rho: Option<f64>,
    /// The largest ratio of distances that follow each other.
    pub uniformity: Option<f64>,
    /// The least local feature size; `None` of a straight line.
    pub lfs_least_mm: Option<f64>,
    /// Where the condition comes nearest to failing or fails most; without a condition, where ρ is largest.
    pub at_mm: Option<[f64; 2]>,
    /// At how many places the condition fails.
    pub failing: usize,
    /// The first of them, worst first.
    pub failures: Vec<FailureFigures>,
}

/// A place where the condition fails.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub struct FailureFigures {
    /// The place.
    pub at_mm: [f64; 2],
    /// What fails: ε, ρ, u, or the longest distance over the least feature size.
    pub quantity: String,
    /// Its value; `None` where it is infinite.
    pub found: Option<f64>,
    /// What it must be below.
    pub bound: f64,
}
