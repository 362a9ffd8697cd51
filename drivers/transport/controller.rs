//! Times of frames by the clock of the CAN controller that stamps them.

use asphera_link::{LeastDelay, Nanos};
use tokio::time::Instant;

/// The clock of a controller on one connection, laid on the host's.
///
/// The kernel takes a frame after the controller did, by the time of an interrupt: that is the delay which [`LeastDelay`] takes out.
pub(crate) struct ControllerClock {
    opened: Instant,
    /// Time of the frame before: times do not go back.
    latest: Instant,
    delay: LeastDelay,
    has_stamped: bool,
    /// Frames in a row without a stamp, before the first with one.
    unstamped: u8,
}

/// Time of a frame.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Taken {
    pub(crate) at: Instant,
    /// Whether the controller's clock jumped since the frame before.
    pub(crate) has_jumped: bool,
}

/// The controller stamps no frames.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct NoStamps;

impl ControllerClock {
    /// The clock of a connection that was opened then.
    pub(crate) fn new(opened: Instant) -> ControllerClock {
        let delay = LeastDelay::default();
        ControllerClock { opened, latest: opened, delay, has_stamped: false, unstamped: 0 }
    }

    /// When the controller took a frame that the kernel took at `by_kernel`. A frame without a stamp among others, as one of another program on
    /// this host, has the time of the kernel.
    pub(crate) fn at(
        &mut self,
        stamp_ns: Option<i64>,
        by_kernel: Instant,
    ) -> Result<Taken, NoStamps> {
        let (at, has_jumped) = match stamp_ns {
            Some(stamp_ns) => {
                self.has_stamped = true;
                let since = by_kernel.saturating_duration_since(self.opened);
                let read = Nanos::from_nanos(u64::try_from(since.as_nanos()).unwrap_or(u64::MAX));
                let stamped = self.delay.take(stamp_ns, read);
                let waited = read.since(stamped.at);
                (by_kernel.checked_sub(waited).unwrap_or(by_kernel), stamped.has_jumped)
            }
            None => {
                self.unstamped += u8::from(!self.has_stamped);
                if self.unstamped >= PROOF && !self.has_stamped {
                    return Err(NoStamps);
                }
                (by_kernel, false)
            }
        };
        self.latest = self.latest.max(at);
        Ok(Taken { at: self.latest, has_jumped })
    }
}

/// Frames that show whether a controller stamps: some may be of other programs on this host.
const PROOF: u8 = 10;

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    const US: Duration = Duration::from_micros(1);

    /// Interrupts late by 20 to 720 µs: times are right to the least delay.
    #[test]
    fn late_interrupts_are_taken_out() {
        let opened = Instant::now();
        let mut clock = ControllerClock::new(opened);
        for (place, late_us) in [20, 720, 300, 20, 90].into_iter().enumerate() {
            let bus = opened + 1000 * (place as u32 + 1) * US;
            let stamp_ns = 77_000_000_000 + (bus - opened).as_nanos() as i64;
            let taken = clock.at(Some(stamp_ns), bus + late_us * US).unwrap();
            let off = taken.at - (bus + 20 * US);
            assert!(off < 2 * US && !taken.has_jumped, "{place}: {off:?}");
        }
    }

    /// A frame of another program has the time of the kernel; one that the controller took before it is not earlier.
    #[test]
    fn times_do_not_go_back() {
        let opened = Instant::now();
        let mut clock = ControllerClock::new(opened);
        clock.at(Some(0), opened + 20 * US).unwrap();
        let other = clock.at(None, opened + 2000 * US).unwrap();
        let late = clock.at(Some(1_900_000), opened + 2010 * US).unwrap();
        assert_eq!((other.at, late.at), (opened + 2000 * US, opened + 2000 * US));
    }

    #[test]
    fn a_controller_without_stamps_is_refused() {
        let opened = Instant::now();
        let mut clock = ControllerClock::new(opened);
        for _ in 1..PROOF {
            assert_eq!(
                clock.at(None, opened + US),
                Ok(Taken { at: opened + US, has_jumped: false })
            );
        }
        assert_eq!(clock.at(None, opened + US), Err(NoStamps));
    }

    #[test]
    fn frames_of_other_programs_have_no_stamp() {
        let opened = Instant::now();
        let mut clock = ControllerClock::new(opened);
        clock.at(Some(5), opened + US).unwrap();
        for _ in 0..2 * PROOF {
            assert!(clock.at(None, opened + 2 * US).is_ok());
        }
    }

    #[test]
    fn a_controller_that_began_anew_is_said() {
        let opened = Instant::now();
        let mut clock = ControllerClock::new(opened);
        clock.at(Some(9_000_000_000), opened + US).unwrap();
        assert_eq!(
            clock.at(Some(0), opened + 2 * US),
            Ok(Taken { at: opened + 2 * US, has_jumped: true })
        );
    }
}
