//! The only place that reads a clock.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant, SystemTime};

use asphera_link::Nanos;
use nix::time::{ClockId, clock_gettime};

/// The host's clock, from 0 at a start. It never goes back, whatever happens to the wall clock.
///
/// `Instant` stands still while the computer is suspended, and so do the timers. The devices go on meanwhile. Therefore
/// [`Clock::catch_up`] adds such times; clones of a clock catch up together.
#[derive(Clone, Debug)]
pub struct Clock {
    start: Instant,
    /// Latest time of the clock that counts suspended times as well, at `start`; `None` if the system has none.
    started_boot: Option<Duration>,
    started_wall_ns: i64,
    suspended_ns: Arc<AtomicU64>,
}

impl Clock {
    /// Starts a clock now.
    #[expect(clippy::disallowed_methods, reason = "this is the clock")]
    pub fn start() -> Clock {
        // A wall clock before 1970 is a host that was never set; its recordings say 1970.
        let wall = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        // In this order, here and in `catch_up`: what passes between two readings makes a suspended time shorter, never longer.
        let start = Instant::now();
        Clock {
            start,
            started_boot: boot_time(),
            started_wall_ns: i64::try_from(wall.as_nanos()).unwrap_or(i64::MAX),
            suspended_ns: Arc::default(),
        }
    }

    /// Time since the start, suspended times included as far as the clock caught up.
    pub fn now(&self) -> Nanos {
        self.at(self.start + self.start.elapsed())
    }

    /// Time from the start to `instant`; 0 for one before the start.
    pub fn at(&self, instant: Instant) -> Nanos {
        Nanos::ZERO + instant.saturating_duration_since(self.start) + self.suspended()
    }

    /// What the wall clock said at the start, in ns since 1970-01-01T00:00Z.
    pub fn started_wall_ns(&self) -> i64 {
        self.started_wall_ns
    }

    /// The instant of `at`, for a timer; the start for a time that passed while the computer was suspended.
    pub fn instant(&self, at: Nanos) -> Instant {
        self.start + Duration::from_nanos(at.as_nanos()).saturating_sub(self.suspended())
    }

    /// Adds the time for which the computer was suspended since the last call, and gives it; 0 if it was not.
    pub fn catch_up(&self) -> Duration {
        let Some((started, boot)) = self.started_boot.zip(boot_time()) else {
            return Duration::ZERO;
        };
        let known = self.suspended();
        let new = newly_suspended(boot.saturating_sub(started), self.start.elapsed(), known);
        let total = u64::try_from((known + new).as_nanos()).unwrap_or(u64::MAX);
        self.suspended_ns.store(total, Ordering::Relaxed);
        new
    }

    fn suspended(&self) -> Duration {
        Duration::from_nanos(self.suspended_ns.load(Ordering::Relaxed))
    }
}

/// Suspended time that is not known yet, of the times since the start with and without suspended times.
fn newly_suspended(with: Duration, without: Duration, known: Duration) -> Duration {
    let new = with.saturating_sub(without).saturating_sub(known);
    if new >= SUSPENDED { new } else { Duration::ZERO }
}

/// Time since the system started, suspended times included.
fn boot_time() -> Option<Duration> {
    clock_gettime(ClockId::CLOCK_BOOTTIME).ok().map(Duration::from)
}

/// No computer suspends and resumes in less; clocks that are compared differ by less.
const SUSPENDED: Duration = Duration::from_millis(50);

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn a_suspended_time_is_counted_once() {
        assert_eq!(newly_suspended(ms(1000), ms(1000), ms(0)), ms(0));
        assert_eq!(newly_suspended(ms(5000), ms(1000), ms(0)), ms(4000));
        assert_eq!(newly_suspended(ms(5500), ms(1500), ms(4000)), ms(0));
        assert_eq!(newly_suspended(ms(9500), ms(2500), ms(4000)), ms(3000));
        // A clock that lags by how it is read.
        assert_eq!(newly_suspended(ms(999), ms(1000), ms(0)), ms(0));
        assert_eq!(newly_suspended(ms(1049), ms(1000), ms(0)), ms(0));
    }

    #[test]
    fn timers_and_times_agree_after_a_suspended_time() {
        let clock = Clock::start();
        assert_eq!(clock.catch_up(), ms(0));
        let copy = clock.clone();
        let read = clock.start + ms(200);
        assert_eq!(clock.at(read), Nanos::from_millis(200));
        clock.suspended_ns.store(3_600_000_000_000, Ordering::Relaxed);
        let late = copy.at(read);
        assert_eq!(late, Nanos::from_millis(3_600_200));
        assert_eq!(copy.instant(late), read);
        // What was due meanwhile is due at once.
        assert_eq!(copy.instant(Nanos::from_millis(5000)), clock.start);
        assert!(copy.now() >= Nanos::from_millis(3_600_000));
    }
}
