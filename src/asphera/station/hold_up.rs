//! What becomes of deadlines when the host itself was held up.

use std::time::Duration;

use asphera_link::Nanos;

/// Puts deadlines off after the host was held up.
///
/// A process that did not run for a while finds its timers due and its bytes unread, all at once. What was
/// due says nothing then: the heartbeat that was to come may lie in a buffer. So nothing that is due is done
/// before the links had [`GRACE`] to be read. A host that is held up again and again puts it off again, but
/// not for ever: after [`LONGEST`] deadlines hold as they are, or a scan on an overloaded host would never end.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Patience(Option<Spell>);

#[derive(Clone, Copy, Debug)]
struct Spell {
    /// End of the first of several hold-ups.
    since: Nanos,
    until: Nanos,
}

impl Patience {
    /// The host was held up until now.
    pub(crate) fn held_up(&mut self, now: Nanos) {
        let since = self.0.map_or(now, |spell| spell.since);
        if now.since(since) < LONGEST {
            self.0 = Some(Spell { since, until: now + GRACE });
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
/// How long hold-ups in a row may put a deadline off.
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
        patience.held_up(ms(1500));
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
            patience.held_up(ms(at));
        }
        assert!(patience.put_off(ms(0)) <= ms(10_250), "{patience:?}");
    }
}
