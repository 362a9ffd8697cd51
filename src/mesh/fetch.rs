//! Memory asked for before it is read.

/// Asks for what is read in a moment, so that the wait for it passes while something else is done.
///
/// Elsewhere than on x86-64 no safe function does that, and it is read at once, by `read`: the waits for
/// several overlap, but nothing else is done meanwhile.
#[inline(always)]
pub(crate) fn fetch<T, R>(item: &T, read: impl FnOnce(&T) -> R) {
    #[cfg(target_arch = "x86_64")]
    {
        drop(read);
        safe_arch::prefetch_t0(item);
    }
    #[cfg(not(target_arch = "x86_64"))]
    std::hint::black_box(read(item));
}
