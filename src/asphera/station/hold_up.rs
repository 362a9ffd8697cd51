//! What becomes of deadlines when the host itself was held up.

use std::time::Duration;

use asphera_link::Nanos;

/// Puts deadlines off after the host was held up.
///
/// A process that did not run for a while finds its timers due and its bytes unread, all at once. What was
/// due says nothing then: the heartbeat that was to come may lie in a buffer. So nothing that is due is done
/// before the links had [`GRACE`] to be read. A host that is held up again and again puts it off again, but
/// not for ever: once it ran for [`LONGEST`] between hold-ups in a row, deadlines hold as they are, or a scan on an
/// overloaded host would never end. How long the hold-ups themselves were does not count: in them nothing could be read.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Patience(Option<Spell>);

/// Hold-ups in a row.
#[derive(Clone, Copy, Debug)]
struct Spell {
    /// End of the latest hold-up.
    held_up_until: Nanos,
    /// How long the host ran between them.
    ran: Duration,
    /// Deadlines are put off to here.
    until: Nanos,
}

impl Patience {
    /// The host was held up from one time to another.
    pub(crate) fn held_up(&mut self, from: Nanos, to: Nanos) {
        let ran =
            self.0.map_or(Duration::ZERO, |spell| spell.ran + from.since(spell.held_up_until));
        if ran < LONGEST {
            self.0 = Some(Spell { held_up_until: to, ran, until: to + GRACE });
        }
    }

    /// When something that is due is to be done.
    pub(crate) fn put_off(&self, due: Nanos) -> Nanos {
        self.0.map_or(due, |spell| due.max(spell.until))
    }

    /// What is due by this time is being done.
    pub(crate) fn passed(&mut self, now: Nanos) {
        self.0 = self.0.filter(|spell| now < spell.until);
    }
}

/// How long links may take to be read once the host runs again.
const GRACE: Duration = Duration::from_millis(250);
/// How long a host may run between hold-ups that put deadlines off.
const LONGEST: Duration = Duration::from_secs(10);

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Nanos {
        Nanos::from_millis(ms)
    }

    #[test]
    fn what_was_due_waits_until_the_links_were_read() {
        let mut patience = Patience::default();
        assert_eq!(patience.put_off(ms(1000)), ms(1000));
        patience.held_up(ms(900), ms(1500));
        assert_eq!(patience.put_off(ms(1000)), ms(1750));
        assert_eq!(patience.put_off(ms(2000)), ms(2000));
        patience.passed(ms(1749));
        assert_eq!(patience.put_off(ms(1000)), ms(1750));
        patience.passed(ms(1750));
        assert_eq!(patience.put_off(ms(1000)), ms(1000));
    }

    #[test]
    fn a_host_that_is_held_up_for_ever_still_keeps_deadlines() {
        let mut patience = Patience::default();
        for at in (0..60_000).step_by(300) {
            patience.held_up(ms(at), ms(at + 100));
        }
        assert!(patience.put_off(ms(0)) <= ms(15_500), "{patience:?}");
    }

    /// A saturated host waits a little for its pipeline all the time, and at times for long.
    #[test]
    fn a_long_hold_up_among_short_ones_puts_deadlines_off() {
        let mut patience = Patience::default();
        for at in (0..9_000).step_by(300) {
            patience.held_up(ms(at), ms(at + 150));
        }
        patience.held_up(ms(9_000), ms(20_000));
        assert_eq!(patience.put_off(ms(9_200)), ms(20_250));
    }
}
