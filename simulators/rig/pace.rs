//! How fast the triggers come.

use std::time::Duration;

use tokio::time::{Instant, sleep_until};

/// How fast a scan goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// So many times the rate of the scene, 0.001 to 1000.
    Times(f64),
    /// As fast as the links take the data.
    Max,
}

/// The rhythm of the triggers. This file is the one place of the rig that reads the clock.
///
/// Triggers are due at `start + k / rate`, whatever time each took, so the rate does not drift; the
/// timer's resolution of a millisecond gathers them in small batches. A machine that was held up
/// for longer than [`PATIENCE`], because a host did not read, goes on from there and does not race.
#[derive(Debug)]
pub(crate) struct Pace {
    /// `None` at the highest speed: nothing is waited for.
    rate_hz: Option<f64>,
    origin: Instant,
    /// The trigger that is due at `origin`.
    first: u64,
}

impl Pace {
    /// The rhythm of triggers at `rate_hz` times the speed, beginning now with trigger 0.
    pub(crate) fn new(speed: Speed, rate_hz: f64) -> Pace {
        let rate_hz = match speed {
            Speed::Times(times) => Some(rate_hz * times),
            Speed::Max => None,
        };
        Pace { rate_hz, origin: Instant::now(), first: 0 }
    }

    /// Waits until trigger `k` is due. To be asked for each trigger in turn.
    pub(crate) async fn due(&mut self, k: u64) {
        let Some(rate_hz) = self.rate_hz else { return };
        let due = self.origin + Duration::from_secs_f64((k - self.first) as f64 / rate_hz);
        let now = Instant::now();
        if due > now {
            sleep_until(due).await;
        } else if now - due > PATIENCE {
            (self.origin, self.first) = (now, k);
        }
    }
}

/// A moment to come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Deadline(Instant);

impl Deadline {
    pub(crate) fn after(duration: Duration) -> Deadline {
        Deadline(Instant::now() + duration)
    }

    pub(crate) fn is_past(self) -> bool {
        Instant::now() > self.0
    }
}

/// Tells a host that has left from one that is about to arm again.
#[derive(Debug, Default)]
pub(crate) struct Absence(Option<Instant>);

impl Absence {
    /// Whether what is told has been true for longer than a host takes to set a device up.
    pub(crate) fn is_long(&mut self, absent: bool) -> bool {
        if !absent {
            self.0 = None;
            return false;
        }
        self.0.get_or_insert_with(Instant::now).elapsed() > ABSENT
    }
}

/// Both devices disarmed for so long: the host wants no more of the scan.
const ABSENT: Duration = Duration::from_millis(100);

/// How far behind a machine may be and still catch up: the hiccups of a busy computer.
const PATIENCE: Duration = Duration::from_millis(100);

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn triggers_keep_their_rate_without_drift() {
        let start = Instant::now();
        let mut pace = Pace::new(Speed::Times(3.0), 1000.0);
        for k in 0..30_000 {
            pace.due(k).await;
        }
        pace.due(30_000).await;
        let elapsed = start.elapsed();
        assert!((10_000..=10_001).contains(&elapsed.as_millis()), "{elapsed:?}");
    }

    #[tokio::test(start_paused = true)]
    async fn a_machine_that_was_held_up_does_not_race() {
        let mut pace = Pace::new(Speed::Times(1.0), 1000.0);
        pace.due(500).await;
        tokio::time::advance(Duration::from_secs(5)).await;
        let held_up = Instant::now();
        pace.due(501).await;
        pace.due(1501).await;
        let elapsed = held_up.elapsed();
        assert!((1_000..=1_001).contains(&elapsed.as_millis()), "{elapsed:?}");
    }

    #[tokio::test(start_paused = true)]
    async fn a_short_delay_is_made_up_for() {
        let start = Instant::now();
        let mut pace = Pace::new(Speed::Times(1.0), 1000.0);
        pace.due(10).await;
        tokio::time::advance(Duration::from_millis(80)).await;
        pace.due(11).await;
        pace.due(200).await;
        assert!((200..=201).contains(&start.elapsed().as_millis()));
    }

    #[tokio::test(start_paused = true)]
    async fn the_highest_speed_waits_for_nothing() {
        let start = Instant::now();
        let mut pace = Pace::new(Speed::Max, 100.0);
        for k in 0..1_000_000 {
            pace.due(k).await;
        }
        assert_eq!(start.elapsed(), Duration::ZERO);
    }
}
