//! The adaptive scan on simulated parts: the same goal with fewer points, and an early end where the part fails.
//!
//! All parts are the benchmark `adaptive`; this is the small version.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

#[expect(dead_code, unreachable_pub, reason = "shared with the benchmark")]
mod study;

use asphera_plan::{Ending, VerdictState};

#[test]
fn a_steep_asphere_is_covered_with_half_the_points() {
    let part = study::all().into_iter().find(|part| part.name == "steep asphere").unwrap();
    let adaptive = study::adaptive(&part);
    assert_eq!(adaptive.ending, Some(Ending::Reached), "{adaptive:?}");
    assert!(study::is_reached(&part, &adaptive.findings), "{:?}", adaptive.findings);
    let planned = study::uniform(&part, study::planned_mm(&part.part));
    assert!(study::is_reached(&part, &planned.findings), "{:?}", planned.findings);
    assert!(planned.points > 2 * adaptive.points, "{} {}", planned.points, adaptive.points);
    assert!(planned.stopping_s > 2.0 * adaptive.stopping_s);
    // A coarse raster alone does not reach it.
    let coarse = study::uniform(&part, part.coarse_mm);
    assert!(!study::is_reached(&part, &coarse.findings), "{:?}", coarse.findings);
}

#[test]
fn a_part_that_fails_is_left_after_the_coarse_scan() {
    let part = study::all().into_iter().find(|part| part.name == "part that fails").unwrap();
    let adaptive = study::adaptive(&part);
    assert_eq!(adaptive.ending, Some(Ending::FailCertain), "{adaptive:?}");
    assert_eq!((adaptive.looks, adaptive.findings.verdict), (1, VerdictState::FailCertain));
    assert!(adaptive.points < 100, "{}", adaptive.points);
}
