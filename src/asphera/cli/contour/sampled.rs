//! Whether the points suffice for the curve that was found, as the command writes it.

use std::fmt::Write as _;

use asphera_contour::{CurveSampling, Failure, Method, PlaceMm, Quantity, Verdict};
use serde::{Deserialize, Serialize};

use crate::cli::summary::short;

/// ε, ρ and u of the points for the curve found, and whether they meet the condition of the method. Lengths are mm.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
pub(in crate::cli) struct SampledFigures {
    /// The condition under which the method is proven to find smooth closed curves; `None` if none is known.
    pub(in crate::cli) condition: Option<String>,
    /// Whether the points meet it and the curve has no ends; `None` without a condition.
    pub(in crate::cli) holds: Option<bool>,
    /// The largest distance of a place of the curve to the points over its local feature size; `None` where that is zero.
    pub(in crate::cli) epsilon: Option<f64>,
    /// The same over the reach, the least local feature size between two points.
    pub(in crate::cli) rho: Option<f64>,
    /// The largest ratio of distances that follow each other.
    pub(in crate::cli) uniformity: Option<f64>,
    /// The least local feature size; `None` of a straight line.
    pub(in crate::cli) lfs_least_mm: Option<f64>,
    /// Where the condition comes nearest to failing or fails most; without a condition, where ρ is largest.
    pub(in crate::cli) at_mm: Option<PlaceMm>,
    /// At how many places the condition fails.
    pub(in crate::cli) failing: usize,
    /// The first of them, worst first.
    pub(in crate::cli) failures: Vec<FailureFigures>,
}

/// A place where the condition fails.
#[derive(Debug, Deserialize, PartialEq, Serialize)]
pub(in crate::cli) struct FailureFigures {
    /// The place.
    pub(in crate::cli) at_mm: PlaceMm,
    /// What fails: ε, ρ, u, or the longest distance over the least feature size.
    pub(in crate::cli) quantity: String,
    /// Its value; `None` where it is infinite.
    pub(in crate::cli) found: Option<f64>,
    /// What it must be below.
    pub(in crate::cli) bound: f64,
}

/// So many places of failure are listed.
const MOST_LISTED: usize = 100;

impl SampledFigures {
    /// The figures of a curve found by a method.
    pub(super) fn new(sampling: &CurveSampling, method: Method) -> SampledFigures {
        let condition = method.condition();
        let verdict = condition.map(|condition| sampling.against(&condition));
        let finite = |value: f64| value.is_finite().then_some(value);
        let worst = match &verdict {
            Some(verdict) => verdict.worst.map(|worst| worst.at_mm),
            None => sampling.rho().map(|edge| edge.at_mm),
        };
        let failures = verdict.iter().flat_map(|verdict| &verdict.failures);
        let failures = failures.filter(|failure| failure.quantity != Quantity::End);
        SampledFigures {
            condition: condition.map(|condition| condition.to_string()),
            holds: verdict.as_ref().map(Verdict::holds),
            epsilon: sampling.epsilon().and_then(|edge| finite(edge.epsilon)),
            rho: sampling.rho().and_then(|edge| finite(edge.rho)),
            uniformity: sampling.uniformity().map(|step| step.ratio),
            lfs_least_mm: finite(sampling.least_lfs_mm()),
            at_mm: worst,
            failing: failures.clone().count(),
            failures: failures.take(MOST_LISTED).map(FailureFigures::new).collect(),
        }
    }

    /// The line of the summary.
    pub(super) fn write_summary(&self, text: &mut String) -> std::fmt::Result {
        let value = |value: Option<f64>| value.map_or("∞".to_owned(), short);
        let (epsilon, rho) = (value(self.epsilon), value(self.rho));
        write!(text, "sampling   ε {epsilon}, ρ {rho}")?;
        if let Some(uniformity) = self.uniformity {
            write!(text, ", u {}", short(uniformity))?;
        }
        let at =
            self.at_mm.map_or(String::new(), |[x, y]| format!(" at {}, {} mm", short(x), short(y)));
        match (&self.condition, self.holds) {
            (Some(condition), Some(true)) => writeln!(text, ": {condition} holds, closest{at}"),
            (Some(condition), Some(false)) if self.failing == 0 => {
                writeln!(
                    text,
                    ": {condition} holds, but it is proven for closed curves, and this one has ends"
                )
            }
            (Some(condition), Some(false)) => {
                writeln!(text, ": {condition} fails at {} places, most{at}", self.failing)
            }
            _ => writeln!(text, ", largest ρ{at}; no condition to check"),
        }
    }
}

impl FailureFigures {
    fn new(failure: &Failure) -> FailureFigures {
        FailureFigures {
            at_mm: failure.at_mm,
            quantity: failure.quantity.to_string(),
            found: failure.found.is_finite().then_some(failure.found),
            bound: failure.bound,
        }
    }
}
