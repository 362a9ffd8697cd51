//! The only file of this benchmark that reads the clock.

use std::time::Instant;

/// Result of `work`, and how many seconds it took.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    #[expect(clippy::disallowed_methods, reason = "a benchmark measures time")]
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// Seconds this thread has worked so far: others on the machine do not show, where the system tells.
pub(crate) fn working() -> f64 {
    // What ran until now is counted when the thread gives way.
    std::thread::yield_now();
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let worked_ns = told.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    worked_ns.map_or_else(since_start, |ns| 1e-9 * ns)
}

#[expect(clippy::disallowed_methods, reason = "a benchmark measures time")]
fn since_start() -> f64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}
