//! asphera: form of optical surfaces while they are measured.

use std::process::ExitCode;

fn main() -> ExitCode {
    #[cfg(target_env = "gnu")]
    limit_heaps();
    asphera::cli::main()
}

/// Number of heaps of the allocator, at most. With one for each thread, a daemon keeps some KiB more after every session.
#[cfg(target_env = "gnu")]
const HEAPS: i32 = 2;

/// Sets the number of heaps, as `MALLOC_ARENA_MAX` of the environment does.
#[cfg(target_env = "gnu")]
#[expect(unsafe_code, reason = "no safe call sets the number of heaps of glibc")]
fn limit_heaps() {
    // SAFETY: `mallopt` takes two numbers and changes a setting of the allocator, and no other thread runs yet.
    unsafe { libc::mallopt(libc::M_ARENA_MAX, HEAPS) };
}
