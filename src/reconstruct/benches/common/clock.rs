//! Times of a benchmark.

/// What work gives, and processor seconds of this thread.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = processor_s();
    let made = work();
    (made, processor_s() - start)
}

/// Processor time of this thread (Linux). Giving way brings the kernel's count up to date.
fn processor_s() -> f64 {
    std::thread::yield_now();
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split_whitespace().next().and_then(|field| field.parse::<f64>().ok());
    1e-9 * nanoseconds.expect("/proc/thread-self/schedstat must begin with nanoseconds")
}
