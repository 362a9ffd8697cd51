//! The only place that reads a clock.

use std::time::{Duration, Instant, SystemTime};

use asphera_link::Nanos;

/// The host's monotonic clock, from 0 at a start.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
    started_wall_ns: i64,
}

impl Clock {
    /// Starts a clock now.
    #[expect(clippy::disallowed_methods, reason = "this is the clock")]
    pub fn start() -> Clock {
        // A wall clock before 1970 is a host that was never set; its recordings say 1970.
        let wall = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        Clock {
            start: Instant::now(),
            started_wall_ns: i64::try_from(wall.as_nanos()).unwrap_or(i64::MAX),
        }
    }

    /// Time since the start. It never goes back, whatever happens to the wall clock.
    pub fn now(&self) -> Nanos {
        Nanos::ZERO + self.start.elapsed()
    }

    /// Time from the start to `instant`; 0 for one before the start.
    pub fn at(&self, instant: Instant) -> Nanos {
        Nanos::ZERO + instant.saturating_duration_since(self.start)
    }

    /// What the wall clock said at the start, in ns since 1970-01-01T00:00Z.
    pub fn started_wall_ns(&self) -> i64 {
        self.started_wall_ns
    }

    /// The instant of `at`, for a timer.
    pub fn instant(&self, at: Nanos) -> Instant {
        self.start + Duration::from_nanos(at.as_nanos())
    }
}
