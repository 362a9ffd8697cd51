//! A clock that stamps what is read later, laid on the clock of who reads it.

use crate::Nanos;

/// The time of each thing read on the reader's clock, by the stamps of another clock.
///
/// What is read comes late, never early. So the least delay so far is that of the way itself, and all others are later by what they waited:
///
/// ```text
/// offset = min (read − stamp)      at = stamp + offset, at most the time of its read
/// ```
///
/// The offset may grow by 200 millionths of the time that passes, for a quartz that goes slow. A delay that changes by more than a second at
/// once is a jump of the stamping clock, as after its restart: this one has the time of its read, and the offset begins anew. O(1) a stamp.
#[derive(Clone, Copy, Debug, Default)]
pub struct LeastDelay {
    last: Option<Last>,
}

/// What was read before.
#[derive(Clone, Copy, Debug)]
struct Last {
    read: Nanos,
    /// Time of the reader less stamp, ns.
    offset_ns: i64,
}

/// Time of something that was stamped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stamped {
    /// Time on the reader's clock, at most that of the read.
    pub at: Nanos,
    /// Whether the stamping clock jumped since the stamp before.
    pub has_jumped: bool,
}

impl LeastDelay {
    /// The time of what was stamped `stamp_ns` and is read now. The stamping clock has any zero and does not wrap. Reads do not go back in time.
    pub fn take(&mut self, stamp_ns: i64, read: Nanos) -> Stamped {
        let read_ns = signed(read);
        let found_ns = read_ns.saturating_sub(stamp_ns);
        let allowed = self.last.map(|last| {
            let passed_ns = read_ns - signed(last.read);
            (last.offset_ns, last.offset_ns.saturating_add(passed_ns / SLOW_PARTS))
        });
        let begin = |has_jumped| (found_ns, Stamped { at: read, has_jumped });
        let (offset_ns, stamped) = match allowed {
            None => begin(false),
            Some((before_ns, _)) if found_ns.saturating_sub(before_ns).unsigned_abs() > JUMP_NS => {
                begin(true)
            }
            Some((_, most_ns)) => {
                let offset_ns = found_ns.min(most_ns);
                let at_ns = u64::try_from(stamp_ns.saturating_add(offset_ns)).unwrap_or(0);
                let at = Nanos::from_nanos(at_ns).min(read);
                (offset_ns, Stamped { at, has_jumped: false })
            }
        };
        self.last = Some(Last { read, offset_ns });
        stamped
    }
}

fn signed(at: Nanos) -> i64 {
    at.as_nanos().cast_signed()
}

/// 1/5000: 200 millionths.
const SLOW_PARTS: i64 = 5000;
const JUMP_NS: u64 = 1_000_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    fn us(us: u64) -> Nanos {
        Nanos::from_nanos(1000 * us)
    }

    /// A controller whose clock has run for a day stamps frames that are read up to 300 µs later.
    #[test]
    fn waits_are_taken_out() {
        let mut clock = LeastDelay::default();
        let day_ns = 86_400_000_000_000;
        let mut at = |stamp_us: i64, read_us| clock.take(day_ns + 1000 * stamp_us, us(read_us)).at;
        assert_eq!(at(0, 1050), us(1050));
        assert_eq!(at(1000, 2020), us(2020), "less delay than ever");
        assert!(at(2000, 3320).since(us(3020)).as_nanos() < 1000);
        assert!(at(3000, 4020).since(us(4020)).as_nanos() < 1000);
    }

    /// A clock set back by a restart has no say for one stamp.
    #[test]
    fn a_jump_begins_anew() {
        let mut clock = LeastDelay::default();
        clock.take(5_000_000_000, us(1000));
        assert_eq!(clock.take(7000, us(1500)), Stamped { at: us(1500), has_jumped: true });
        let next = clock.take(507_000, us(2300));
        assert!(!next.has_jumped && next.at.since(us(2000)).as_nanos() < 1000, "{next:?}");
    }

    /// Stamps of any kind, and no panic.
    #[test]
    fn absurd_stamps_give_no_later_time() {
        let mut clock = LeastDelay::default();
        for stamp_ns in [i64::MAX, i64::MIN, 0, -1, i64::MAX, i64::MIN + 1, 5] {
            assert!(clock.take(stamp_ns, us(10)).at <= us(10));
        }
    }
}
