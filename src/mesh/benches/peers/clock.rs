//! The only file of this benchmark that reads the clock.

use std::time::Instant;

/// Result of `work`, and how many seconds it took.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    #[expect(clippy::disallowed_methods, reason = "a benchmark measures time")]
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}
