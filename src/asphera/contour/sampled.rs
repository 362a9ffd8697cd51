//! Whether the points suffice for the curve that was found.

use asphera_contour::{CurveSampling, Failure, Method, Quantity, Verdict};
use asphera_report::contour::{FailureFigures, SampledFigures};

/// So many places of failure are listed.
const MOST_LISTED: usize = 100;

/// The figures of a curve found by a method.
pub(super) fn sampled(sampling: &CurveSampling, method: Method) -> SampledFigures {
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
        failures: failures.take(MOST_LISTED).map(failure_of).collect(),
    }
}

/// A place where the condition fails.
fn failure_of(failure: &Failure) -> FailureFigures {
    FailureFigures {
        at_mm: failure.at_mm,
        quantity: failure.quantity.to_string(),
        found: failure.found.is_finite().then_some(failure.found),
        bound: failure.bound,
    }
}
