//! The adaptive scan on simulated parts: the same goal with fewer points, and an early end where the part fails.
//!
//! All five parts are the benchmark `adaptive`; this is the small version.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

#[expect(dead_code, unreachable_pub, reason = "shared with the benchmark")]
mod study;

use asphera_plan::{Ending, VerdictState};

#[test]
fn a_freeform_is_covered_with_half_the_points() {
    let part = study::all().into_iter().find(|part| part.name == "freeform").unwrap();
    let adaptive = study::adaptive(&part);
    assert_eq!(adaptive.ending, Some(Ending::Reached), "{adaptive:?}");
    assert!(study::is_reached(&part, &adaptive.seen), "{:?}", adaptive.seen);
    // A raster of twice as many points does not reach it.
    let pitch_mm = (part.aperture.area_mm2() / (2.0 * adaptive.points as f64)).sqrt();
    let uniform = study::uniform(&part, pitch_mm);
    assert!(uniform.points > 2 * adaptive.points, "{} {}", uniform.points, adaptive.points);
    assert!(!study::is_reached(&part, &uniform.seen), "{:?}", uniform.seen);
    assert!(uniform.time_s > 0.0 && adaptive.time_s > 0.0);
}

#[test]
fn a_part_that_fails_is_left_after_the_coarse_scan() {
    let part = study::all().into_iter().find(|part| part.name == "part that fails").unwrap();
    let adaptive = study::adaptive(&part);
    assert_eq!(adaptive.ending, Some(Ending::FailCertain), "{adaptive:?}");
    assert_eq!((adaptive.looks, adaptive.seen.verdict), (1, VerdictState::FailCertain));
    assert!(adaptive.points < 100, "{}", adaptive.points);
}
