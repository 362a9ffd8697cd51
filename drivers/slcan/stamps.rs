//! The clock of an adapter that stamps its frames, against that of the host.

use asphera_link::{LeastDelay, Nanos, Stamped};

use crate::TIMESTAMP_MODULUS_MS;

/// The time of each frame on the host's clock, by the stamps of an adapter (`Z1`).
///
/// A stamp counts ms from 0 to 59999, then starts again (EasySYNC ES_000005, section 4.1.5). Of the times it may mean, the one nearest to
/// the host's clock counts, so a silence of any length is unwound, but for delays above half a minute. [`LeastDelay`] lays it on the host's.
#[derive(Clone, Copy, Debug, Default)]
pub struct StampClock {
    last: Option<Last>,
    delay: LeastDelay,
}

/// The frame before.
#[derive(Clone, Copy, Debug)]
struct Last {
    stamp_ms: u16,
    /// Its stamp without wraps, ms.
    unwound_ms: i64,
    read: Nanos,
}

impl StampClock {
    /// The time of a frame with this stamp, below [`TIMESTAMP_MODULUS_MS`], that was read now. Reads do not go back in time.
    pub fn take(&mut self, stamp_ms: u16, read: Nanos) -> Stamped {
        let unwound_ms = self.last.map_or(i64::from(stamp_ms), |last| {
            let passed_ns = read.as_nanos().cast_signed() - last.read.as_nanos().cast_signed();
            last.unwound_ms + nearest(stamp_ms, last.stamp_ms, passed_ns / NS_PER_MS)
        });
        self.last = Some(Last { stamp_ms, unwound_ms, read });
        self.delay.take(unwound_ms * NS_PER_MS, read)
    }
}

/// ms from one stamp to the next, of all that it may mean the nearest to what passed.
fn nearest(stamp_ms: u16, before_ms: u16, passed_ms: i64) -> i64 {
    let turn = i64::from(TIMESTAMP_MODULUS_MS);
    let step = i64::from(stamp_ms) - i64::from(before_ms);
    step + (passed_ms - step + turn / 2).div_euclid(turn) * turn
}

const NS_PER_MS: i64 = 1_000_000;

#[cfg(test)]
mod tests {
    use asphera_link::CanFrame;
    use proptest::prelude::*;

    use super::*;
    use crate::{Decoder, Item, Timestamps};

    fn ms(ms: u64) -> Nanos {
        Nanos::from_millis(ms)
    }

    /// Frames read late have the times at which they came on the bus, once one was read without delay.
    #[test]
    fn delays_are_taken_out() {
        let mut clock = StampClock::default();
        let mut at = |stamp, read| clock.take(stamp, ms(read)).at.as_nanos() as f64 / 1e6;
        assert_eq!(at(100, 1000), 1000.0);
        // Two more were held in a buffer, and come at once.
        assert!((at(110, 1030) - 1010.0).abs() < 0.01);
        assert!((at(120, 1030) - 1020.0).abs() < 0.01);
        // One with less delay than ever: from here on all are earlier.
        assert_eq!(at(200, 1095), 1095.0);
        assert!((at(210, 1130) - 1105.0).abs() < 0.01);
    }

    /// 0xEA5F is the last ms (EasySYNC ES_000005, section 4.1.5): then 0 comes, and a silence of many turns is unwound.
    #[test]
    fn the_minute_is_unwound() {
        let mut decoder = Decoder::expecting(Timestamps::Always);
        let mut clock = StampClock::default();
        let mut take = |line: &str, read: u64| {
            let mut bytes = line.as_bytes();
            let Some(Item::Frame(frame, Some(stamp))) = decoder.decode(&mut bytes) else {
                panic!("{line}")
            };
            assert_eq!(frame, CanFrame::data_frame(frame.id(), &[0x11]).expect("one byte"));
            clock.take(stamp, ms(read))
        };
        assert_eq!(take("t123111EA5F\r", 5_000).at, ms(5_000));
        assert_eq!(take("t1231110000\r", 5_001).at, ms(5_001));
        let late = take("t1231110002\r", 5_010);
        assert!(!late.has_jumped && late.at.since(ms(5_003)).as_micros() < 10);
        // 3 minutes and 1 s later, read 4 ms late.
        let late = take("t12311103EA\r", 186_007);
        assert!(!late.has_jumped, "{late:?}");
        assert_eq!(
            late.at,
            ms(186_003) + std::time::Duration::from_millis(4),
            "a slow quartz may do that"
        );
    }

    /// An adapter that was restarted counts from 0: its frame has the time of its read, and the next ones go on from there.
    #[test]
    fn a_jump_begins_anew() {
        let mut clock = StampClock::default();
        clock.take(30_000, ms(1000));
        let jumped = clock.take(5, ms(1010));
        assert_eq!(jumped, Stamped { at: ms(1010), has_jumped: true });
        let next = clock.take(15, ms(1025));
        assert!(!next.has_jumped && next.at.since(ms(1020)).as_micros() < 10, "{next:?}");
    }

    /// Stamps out of order by some ms are no turn of a minute.
    #[test]
    fn stamps_may_be_out_of_order() {
        let mut clock = StampClock::default();
        clock.take(0, ms(1000));
        let before = clock.take(59_999, ms(1001));
        assert!(!before.has_jumped && before.at.as_nanos() <= ms(1000).as_nanos());
    }

    proptest! {
        /// Whatever the delays, below a second, and a drift of 100 millionths: no time is after its read, none is before the frame came
        /// by more than a step and the least delay so far allows, and none after it by more than that delay.
        #[test]
        fn times_lie_between_the_bus_and_the_read(
            start in 0u64..60_000,
            drift in -100i64..=100,
            steps in proptest::collection::vec((0u64..2000, 0u64..300), 1..200),
        ) {
            let mut clock = StampClock::default();
            let (mut bus_us, mut read_us, mut least_us) = (0_u64, 0_u64, u64::MAX);
            for (wait_ms, delay_ms) in steps {
                bus_us += 1000 * wait_ms;
                read_us = read_us.max(bus_us + 1000 * delay_ms);
                let own_us = bus_us as i64 + bus_us as i64 * drift / 1_000_000;
                let stamp = (start + own_us as u64 / 1000) % 60_000;
                let read = Nanos::from_nanos(1000 * read_us);
                let stamped = clock.take(stamp as u16, read);
                least_us = least_us.min(read_us - bus_us);
                prop_assert!(!stamped.has_jumped && stamped.at <= read);
                let at_us = (stamped.at.as_nanos() / 1000) as i64;
                // Over 400 s the drift is 40 ms, which the least delay may be old.
                let drifted_us = 400_000_000 * 300 / 1_000_000;
                prop_assert!(at_us >= bus_us as i64 - 2000 - drifted_us);
                prop_assert!(at_us <= (bus_us + least_us) as i64 + 2000 + drifted_us);
            }
        }
    }
}
