//! Due times of a device that is asked again and again.

use std::time::Duration;

use crate::{Nanos, millis};

/// Due times at a fixed interval. One that passes while something else is under way is counted and never made up for.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    interval: Duration,
    next: Nanos,
}

impl Schedule {
    /// A schedule that begins with [`restart`](Schedule::restart). The interval is at least 1 ms.
    pub fn new(interval_ms: u32) -> Schedule {
        Schedule { interval: millis(interval_ms.max(1)), next: Nanos::ZERO }
    }

    /// Makes the next due time one interval after `now`.
    pub fn restart(&mut self, now: Nanos) {
        self.next = now + self.interval;
    }

    /// Goes from the due time that has come to the one after it.
    pub fn advance(&mut self) {
        self.next = self.next + self.interval;
    }

    /// Passes over the due times before `now`, and gives their number.
    pub fn skip_passed(&mut self, now: Nanos) -> u64 {
        let interval_ns = u64::try_from(self.interval.as_nanos()).unwrap_or(u64::MAX);
        let behind_ns = now.as_nanos().saturating_sub(self.next.as_nanos());
        let passed = behind_ns.div_ceil(interval_ns);
        self.next = self.next + Duration::from_nanos(passed.saturating_mul(interval_ns));
        passed
    }

    /// The next due time.
    pub fn next_due(&self) -> Nanos {
        self.next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn due_times_stay_on_their_grid() {
        let mut schedule = Schedule::new(100);
        schedule.restart(Nanos::from_millis(7));
        schedule.advance();
        assert_eq!(schedule.next_due(), Nanos::from_millis(207));
        assert_eq!(
            schedule.skip_passed(Nanos::from_millis(207)),
            0,
            "it is due, and has not passed"
        );
        assert_eq!(schedule.skip_passed(Nanos::from_millis(451)), 3);
        assert_eq!(schedule.next_due(), Nanos::from_millis(507));
        assert_eq!(schedule.skip_passed(Nanos::from_millis(500)), 0);
    }

    #[test]
    fn an_interval_of_zero_is_one_millisecond() {
        let mut schedule = Schedule::new(0);
        schedule.restart(Nanos::ZERO);
        assert_eq!(schedule.skip_passed(Nanos::from_millis(11)), 10);
        assert_eq!(schedule.next_due(), Nanos::from_millis(11));
    }
}
