//! From cyclic trigger counts to counts that never repeat.

use std::time::Duration;

use asphera_link::{Count, Nanos};

/// Follows the cyclic count of one device and gives the count since the first trigger, from 0.
///
/// A count of modulus m says where a reading is within a cycle, not in which cycle. On an unbroken link
/// the next reading's cycle is the nearest ahead. The first reading of a device that was ready before the
/// scan began is in the first cycle. After a link was lost, and for the first reading of a device that
/// joins a running scan, the cycle is told from the progress of another device on the same trigger, if
/// that is known to a quarter of a cycle; if not, the count is *ambiguous*.
#[derive(Clone, Debug, Default)]
pub(crate) struct Unwrapper {
    last: Option<(u64, Nanos)>,
    /// The cycle is unknown since the link was lost.
    adrift: bool,
}

/// What is known of the trigger from another device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    /// Count of its latest reading.
    pub(crate) count: u64,
    /// When that reading arrived.
    pub(crate) host: Nanos,
    /// Triggers a second, 0 while unknown.
    pub(crate) rate_hz: f64,
}

/// What a count turned out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unwrapped {
    /// The count since the first trigger, and how many were skipped since the reading before.
    Known {
        /// From 0.
        count: u64,
        /// Readings lost.
        skipped: u64,
    },
    /// The same number as the reading before: the device repeated itself, or a whole cycle is missing.
    Repeated,
    /// The cycle cannot be told.
    Ambiguous,
}

impl Unwrapper {
    /// The link was lost: the cycle of the next reading must be told anew.
    pub(crate) fn interrupted(&mut self) {
        self.adrift = self.last.is_some();
    }

    /// Count of the latest reading that was known, and when it arrived.
    pub(crate) fn latest(&self) -> Option<(u64, Nanos)> {
        self.last
    }

    /// Takes the next reading's count, which arrived at `host`. `from_start`: the device was ready before
    /// the first trigger.
    pub(crate) fn take(
        &mut self,
        raw: Count,
        host: Nanos,
        from_start: bool,
        other: Option<Progress>,
    ) -> Unwrapped {
        let modulus = u64::from(raw.modulus.max(2));
        let within = u64::from(raw.raw.wrapping_sub(raw.first)) % modulus;
        let nearest = || other.and_then(|other| nearest(within, modulus, host, other));
        let (count, first_free) = match self.last {
            None if from_start || other.is_none() => (Some(within), 0),
            None => (nearest(), 0),
            Some((last, _)) if self.adrift => (nearest().filter(|count| *count > last), last + 1),
            Some((last, _)) => match (within + modulus - last % modulus) % modulus {
                0 => return Unwrapped::Repeated,
                ahead => (Some(last + ahead), last + 1),
            },
        };
        let Some(count) = count else {
            self.adrift = self.last.is_some();
            return Unwrapped::Ambiguous;
        };
        self.adrift = false;
        self.last = Some((count, host));
        Unwrapped::Known { count, skipped: count - first_free }
    }
}

/// Whether, at this rate, host times tell counts well enough to choose a cycle.
pub(crate) fn tells_cycle(rate_hz: f64, modulus: u32) -> bool {
    rate_hz > 0.0 && rate_hz * LATENCY.as_secs_f64() <= f64::from(modulus) / 4.0
}

/// The count congruent to `within` that is nearest to where the other device must be by now, if the
/// doubt about that is at most a quarter of a cycle.
fn nearest(within: u64, modulus: u64, host: Nanos, other: Progress) -> Option<u64> {
    let silent = host.since(other.host);
    let doubt = other.rate_hz * (LATENCY + silent).as_secs_f64();
    // Without a rate nothing is known of the doubt.
    if other.rate_hz <= 0.0 || doubt > modulus as f64 / 4.0 {
        return None;
    }
    let expected = other.count + (other.rate_hz * silent.as_secs_f64()).round() as u64;
    let above = expected + (within + modulus - expected % modulus) % modulus;
    match above.checked_sub(modulus) {
        Some(below) if expected - below < above - expected => Some(below),
        _ => Some(above),
    }
}

/// How much later than another a device's bytes may reach us: buffers of ports, adapters and the kernel.
const LATENCY: Duration = Duration::from_millis(10);

#[cfg(test)]
mod tests {
    use super::*;

    fn sync(raw: u32) -> Count {
        Count { raw, first: 1, modulus: 240 }
    }

    fn ms(ms: u64) -> Nanos {
        Nanos::from_millis(ms)
    }

    fn at(count: u64, host_ms: u64, rate_hz: f64) -> Option<Progress> {
        Some(Progress { count, host: ms(host_ms), rate_hz })
    }

    #[test]
    fn wraps_and_counts_what_is_lost() {
        let mut unwrapper = Unwrapper::default();
        let mut take = |raw| unwrapper.take(sync(raw), ms(0), true, None);
        assert_eq!(take(1), Unwrapped::Known { count: 0, skipped: 0 });
        assert_eq!(take(2), Unwrapped::Known { count: 1, skipped: 0 });
        assert_eq!(take(2), Unwrapped::Repeated);
        assert_eq!(take(240), Unwrapped::Known { count: 239, skipped: 237 });
        assert_eq!(take(1), Unwrapped::Known { count: 240, skipped: 0 });
        assert_eq!(take(3), Unwrapped::Known { count: 242, skipped: 1 });
    }

    #[test]
    fn cycle_after_an_interruption_comes_from_the_other_device() {
        let mut unwrapper = Unwrapper::default();
        unwrapper.take(sync(1), ms(0), true, None);
        unwrapper.interrupted();
        // 3 s at 1 kHz: trigger 3000 is within cycle 12, at 120, sent as 121.
        assert_eq!(
            unwrapper.take(sync(121), ms(3001), false, at(3001, 3000, 1000.0)),
            Unwrapped::Known { count: 3000, skipped: 2999 }
        );
        assert_eq!(
            unwrapper.take(sync(122), ms(3002), false, at(3002, 3001, 1000.0)),
            Unwrapped::Known { count: 3001, skipped: 0 }
        );
    }

    #[test]
    fn without_a_good_reference_the_cycle_is_ambiguous() {
        let mut unwrapper = Unwrapper::default();
        unwrapper.take(sync(1), ms(0), true, None);
        unwrapper.interrupted();
        assert_eq!(unwrapper.take(sync(5), ms(3000), false, None), Unwrapped::Ambiguous);
        // At 100 kHz 10 ms of doubt are 1000 triggers, more than a cycle.
        let fast = at(300_000, 3000, 100_000.0);
        assert_eq!(unwrapper.take(sync(5), ms(3000), false, fast), Unwrapped::Ambiguous);
        // A known count is never followed by a smaller one.
        assert_eq!(unwrapper.take(sync(1), ms(0), false, at(0, 0, 1.0)), Unwrapped::Ambiguous);
    }

    #[test]
    fn a_device_that_was_ready_before_the_scan_is_in_the_first_cycle_however_far_the_other_is() {
        let mut unwrapper = Unwrapper::default();
        assert_eq!(
            unwrapper.take(sync(1), ms(10), true, at(50_000, 10, 0.0)),
            Unwrapped::Known { count: 0, skipped: 0 }
        );
        // One that was not, while nothing is known of the rate, is nowhere.
        let mut unwrapper = Unwrapper::default();
        assert_eq!(
            unwrapper.take(sync(1), ms(10), false, at(50_000, 10, 0.0)),
            Unwrapped::Ambiguous
        );
    }

    #[test]
    fn joining_a_running_scan_takes_the_cycle_of_the_other() {
        let mut unwrapper = Unwrapper::default();
        assert_eq!(
            unwrapper.take(sync(41), ms(10), false, at(1000, 10, 1000.0)),
            Unwrapped::Known { count: 1000, skipped: 1000 }
        );
    }
}
