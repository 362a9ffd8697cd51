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
    /// The cycle was found wrong: its own past tells nothing any more.
    slipped: bool,
    /// The counter started over: its zero is lost for good.
    started_over: bool,
}

/// Data known beside a reading's own count.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Context {
    /// The device was ready before the first trigger, and the counters began with it.
    pub(crate) from_start: bool,
    /// No other device shares the trigger: nothing can be joined wrongly.
    pub(crate) alone: bool,
    /// Progress of another device, once the counters are known to share their zero.
    pub(crate) other: Option<Progress>,
    /// Most triggers a second there have been, 0 while unknown.
    pub(crate) peak_hz: f64,
}

/// Data known of the trigger from another device.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Progress {
    /// Count of its latest reading.
    pub(crate) count: u64,
    /// When that reading arrived.
    pub(crate) host: Nanos,
    /// Triggers a second, 0 while unknown.
    pub(crate) rate_hz: f64,
}

/// Place of a count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Unwrapped {
    /// The count since the first trigger, and how many were skipped since the reading before.
    Known {
        /// From 0.
        count: u64,
        /// Readings lost.
        skipped: u64,
    },
    /// Equal to the number of the reading before: the device repeated itself, or a whole cycle is missing.
    Repeated,
    /// The cycle cannot be told.
    Ambiguous,
}

impl Unwrapper {
    /// The link was lost: the cycle of the next reading must be told anew.
    pub(crate) fn interrupted(&mut self) {
        self.adrift = self.last.is_some();
    }

    /// The cycle was wrong: it must be told anew, from another device.
    pub(crate) fn slipped(&mut self) {
        self.interrupted();
        self.slipped = true;
    }

    /// Count of the latest reading that was known, and when it arrived.
    pub(crate) fn latest(&self) -> Option<(u64, Nanos)> {
        self.last
    }

    /// Takes the next reading's count, which arrived at `host`.
    pub(crate) fn take(&mut self, raw: Count, host: Nanos, context: Context) -> Unwrapped {
        let modulus = u64::from(raw.modulus.max(2));
        let within = u64::from(raw.raw.wrapping_sub(raw.first)) % modulus;
        let nearest = || context.other.and_then(|other| nearest(within, modulus, host, other));
        let (count, first_free) = match self.last {
            None if context.from_start || context.alone => (Some(within), 0),
            None => (nearest(), 0),
            Some((last, at)) => {
                let ahead = (within + modulus - last % modulus) % modulus;
                let most = most_triggers(host.since(at), context.peak_hz);
                // A long counter that went further than the trigger can have gone, and stands near its zero,
                // started over.
                let gone = most.map_or(modulus / 2, |most| most + modulus / 16) < ahead;
                let near_zero = within <= most.unwrap_or(modulus / 2).saturating_add(64);
                if modulus >= LONG && !context.alone && gone && near_zero {
                    self.started_over = true;
                }
                // Half of such a counter passes in no session: it went back.
                self.started_over |= modulus >= ENDLESS && ahead >= modulus / 2;
                let told =
                    context.alone || (!self.slipped && most.is_some_and(|most| most < modulus));
                let count = match ahead {
                    _ if self.started_over => None,
                    // After a slip the count may go back: it had run ahead of the trigger.
                    _ if self.adrift && !told => {
                        nearest().filter(|count| self.slipped || *count > last)
                    }
                    0 if !self.adrift || !context.alone => return Unwrapped::Repeated,
                    0 => Some(last + modulus),
                    ahead => Some(last + ahead),
                };
                (count, last + 1)
            }
        };
        let Some(count) = count else {
            self.adrift = self.last.is_some();
            return Unwrapped::Ambiguous;
        };
        self.adrift = false;
        self.slipped = false;
        self.last = Some((count, host));
        Unwrapped::Known { count, skipped: count.saturating_sub(first_free) }
    }
}

/// Most triggers there can have been in this time, at the highest rate there was; `None` while no rate is
/// known.
pub(crate) fn most_triggers(time: Duration, peak_hz: f64) -> Option<u64> {
    (peak_hz > 0.0).then(|| (1.2 * peak_hz * (time + LATENCY).as_secs_f64() + 8.0) as u64)
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

/// From here on a counter is long: half of it is more than any loss that goes unnoticed.
const LONG: u64 = 4096;
/// From here on a counter does not come round in any session: at 100 kHz it takes an hour and a half.
const ENDLESS: u64 = 1 << 29;
/// How much later than another a device's bytes may reach us: buffers of ports, adapters and the kernel.
pub(crate) const LATENCY: Duration = Duration::from_millis(10);

#[cfg(test)]
mod tests {
    use super::*;

    fn sync(raw: u32) -> Count {
        Count { raw, first: 1, modulus: 240 }
    }

    fn ms(ms: u64) -> Nanos {
        Nanos::from_millis(ms)
    }

    fn at(count: u64, host_ms: u64, rate_hz: f64) -> Context {
        let other = Some(Progress { count, host: ms(host_ms), rate_hz });
        Context { other, peak_hz: rate_hz, ..Context::default() }
    }

    const START: Context = Context { from_start: true, alone: false, other: None, peak_hz: 0.0 };

    #[test]
    fn wraps_and_counts_what_is_lost() {
        let mut unwrapper = Unwrapper::default();
        let mut take = |raw| unwrapper.take(sync(raw), ms(0), START);
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
        unwrapper.take(sync(1), ms(0), START);
        unwrapper.interrupted();
        // 3 s at 1 kHz: trigger 3000 is within cycle 12, at 120, sent as 121.
        assert_eq!(
            unwrapper.take(sync(121), ms(3001), at(3001, 3000, 1000.0)),
            Unwrapped::Known { count: 3000, skipped: 2999 }
        );
        assert_eq!(
            unwrapper.take(sync(122), ms(3002), at(3002, 3001, 1000.0)),
            Unwrapped::Known { count: 3001, skipped: 0 }
        );
    }

    #[test]
    fn without_a_good_reference_the_cycle_is_ambiguous() {
        let mut unwrapper = Unwrapper::default();
        unwrapper.take(sync(1), ms(0), START);
        unwrapper.interrupted();
        assert_eq!(unwrapper.take(sync(5), ms(3000), Context::default()), Unwrapped::Ambiguous);
        // At 100 kHz 10 ms of doubt are 1000 triggers, more than a cycle.
        let fast = at(300_000, 3000, 100_000.0);
        assert_eq!(unwrapper.take(sync(5), ms(3000), fast), Unwrapped::Ambiguous);
        // A known count is never followed by a smaller one.
        assert_eq!(unwrapper.take(sync(1), ms(3000), at(1, 3000, 1000.0)), Unwrapped::Ambiguous);
    }

    #[test]
    fn a_device_that_was_ready_before_the_scan_is_in_the_first_cycle_however_far_the_other_is() {
        let mut unwrapper = Unwrapper::default();
        assert_eq!(
            unwrapper.take(sync(1), ms(10), Context { from_start: true, ..at(50_000, 10, 0.0) }),
            Unwrapped::Known { count: 0, skipped: 0 }
        );
        // One that was not, while nothing is known of the rate, is nowhere.
        let mut unwrapper = Unwrapper::default();
        assert_eq!(unwrapper.take(sync(1), ms(10), at(50_000, 10, 0.0)), Unwrapped::Ambiguous);
    }

    #[test]
    fn a_short_interruption_needs_no_other_device() {
        let probe = |raw| Count { raw, first: 0, modulus: 65_536 };
        let mut unwrapper = Unwrapper::default();
        unwrapper.take(probe(60_000), ms(0), START);
        unwrapper.interrupted();
        // 8 s at 4 kHz are 32,000 triggers: less than a cycle, wherever the other device is.
        let context = Context { peak_hz: 4000.0, ..Context::default() };
        assert_eq!(
            unwrapper.take(probe(26_464), ms(8000), context),
            Unwrapped::Known { count: 92_000, skipped: 31_999 }
        );
        // 20 s are more than one.
        unwrapper.interrupted();
        assert_eq!(unwrapper.take(probe(1), ms(28_000), context), Unwrapped::Ambiguous);
        // A device alone goes on within its cycle: it has nobody to be joined with.
        let alone = Context { alone: true, ..context };
        assert!(matches!(unwrapper.take(probe(1), ms(28_000), alone), Unwrapped::Known { .. }));
    }

    #[test]
    fn a_long_counter_that_went_back_has_started_over() {
        let probe = |raw| Count { raw, first: 0, modulus: 65_536 };
        let mut unwrapper = Unwrapper::default();
        unwrapper.take(probe(5_000), ms(0), START);
        assert_eq!(unwrapper.take(probe(3), ms(1), START), Unwrapped::Ambiguous);
        // Its zero is lost: without a reference nothing of it is known any more.
        assert_eq!(unwrapper.take(probe(4), ms(2), START), Unwrapped::Ambiguous);
    }

    #[test]
    fn a_counter_that_does_not_come_round_started_over_when_it_goes_back() {
        let scanner = |raw| Count { raw, first: 0, modulus: 1 << 31 };
        let alone = Context { alone: true, ..START };
        let mut unwrapper = Unwrapper::default();
        let mut take = |raw| unwrapper.take(scanner(raw), ms(0), alone);
        assert_eq!(take(9_000), Unwrapped::Known { count: 9_000, skipped: 9_000 });
        assert_eq!(take(9_010), Unwrapped::Known { count: 9_010, skipped: 9 });
        assert_eq!(take(0), Unwrapped::Ambiguous);
        assert_eq!(take(1), Unwrapped::Ambiguous, "its places have another zero");
    }

    #[test]
    fn joining_a_running_scan_takes_the_cycle_of_the_other() {
        let mut unwrapper = Unwrapper::default();
        assert_eq!(
            unwrapper.take(sync(41), ms(10), at(1000, 10, 1000.0)),
            Unwrapped::Known { count: 1000, skipped: 1000 }
        );
    }
}
