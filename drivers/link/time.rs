//! Monotonic time as the core knows it.

use std::fmt;
use std::ops::{Add, Sub};
use std::time::Duration;

/// Nanoseconds since the station started, on the host's monotonic clock.
///
/// A recording carries the same numbers, so a replay hands its drivers the times of the live run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Nanos(u64);

impl Nanos {
    /// The start of the station.
    pub const ZERO: Nanos = Nanos(0);

    /// From nanoseconds since the station started.
    pub const fn from_nanos(ns: u64) -> Nanos {
        Nanos(ns)
    }

    /// From milliseconds since the station started.
    pub const fn from_millis(ms: u64) -> Nanos {
        Nanos(ms * 1_000_000)
    }

    /// Nanoseconds since the station started.
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// Seconds since the station started.
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// Time passed since `earlier`; zero if `earlier` is later.
    pub fn since(self, earlier: Nanos) -> Duration {
        Duration::from_nanos(self.0.saturating_sub(earlier.0))
    }
}

impl Add<Duration> for Nanos {
    type Output = Nanos;

    fn add(self, later: Duration) -> Nanos {
        Nanos(self.0.saturating_add(u64::try_from(later.as_nanos()).unwrap_or(u64::MAX)))
    }
}

impl Sub<Duration> for Nanos {
    type Output = Nanos;

    fn sub(self, earlier: Duration) -> Nanos {
        Nanos(self.0.saturating_sub(u64::try_from(earlier.as_nanos()).unwrap_or(u64::MAX)))
    }
}

impl fmt::Display for Nanos {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.6} s", self.as_secs_f64())
    }
}

/// Milliseconds of settings as a duration.
pub fn millis(ms: u32) -> Duration {
    Duration::from_millis(ms.into())
}
