//! Whether the count of a companion can be believed.

use std::time::Duration;

use asphera_link::Nanos;

/// Watches how far a companion's counts are from the primary's as both arrive.
///
/// A count of few numbers (240 for a CANopen SYNC) hides the loss of whole cycles. Two devices on one
/// trigger arrive together, give or take buffers, so a distance of half a cycle means one of two things:
/// the host or a buffer was held up, and the distance melts as the backlog drains; or a cycle was lost,
/// and it stays. Until that is known the companion's readings are held, not joined. After an interruption
/// they are held until the new cycle has proved itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Gate {
    /// Counts are believed.
    #[default]
    Open,
    /// Far from the primary since `since`; perhaps only late.
    Lagging {
        /// First reading that was far while no backlog stood in the way; `None` while one does.
        since: Option<Nanos>,
    },
    /// A cycle was chosen after an interruption; it was good since `since`.
    Proving {
        /// First reading of the new cycle that was near.
        since: Option<Nanos>,
    },
}

/// Treatment of a reading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pass {
    /// Join it, and all that are held.
    Release,
    /// Hold it.
    Hold,
    /// The cycle was wrong: what is held, and this reading, cannot be placed.
    Slip,
}

impl Gate {
    /// The link was lost: the next cycle must prove itself.
    pub(crate) fn interrupted(&mut self) {
        *self = Gate::Proving { since: None };
    }

    /// Judges a reading that arrived at `host`, `far` from the primary by half a cycle or more; `None`
    /// where that says nothing: the primary is silent, or a backlog of either is being read.
    pub(crate) fn judge(&mut self, far: Option<bool>, host: Nanos) -> Pass {
        let (next, pass) = match (*self, far) {
            (Gate::Open, Some(true)) => (Gate::Lagging { since: Some(host) }, Pass::Hold),
            (Gate::Open, _) => (Gate::Open, Pass::Release),
            (Gate::Lagging { .. }, Some(false)) => (Gate::Open, Pass::Release),
            (Gate::Lagging { since: Some(since) }, Some(true)) if host.since(since) > PATIENCE => {
                (Gate::Proving { since: None }, Pass::Slip)
            }
            (Gate::Lagging { since }, Some(true)) => {
                (Gate::Lagging { since: since.or(Some(host)) }, Pass::Hold)
            }
            (Gate::Lagging { .. }, None) => (Gate::Lagging { since: None }, Pass::Hold),
            (Gate::Proving { since: Some(since) }, Some(false)) if host.since(since) >= PROOF => {
                (Gate::Open, Pass::Release)
            }
            (Gate::Proving { since }, Some(false)) => {
                (Gate::Proving { since: since.or(Some(host)) }, Pass::Hold)
            }
            (Gate::Proving { .. }, Some(true)) => (Gate::Proving { since: None }, Pass::Slip),
            (held, _) => (held, Pass::Hold),
        };
        *self = next;
        pass
    }
}

/// How long a backlog may take to drain.
const PATIENCE: Duration = Duration::from_millis(500);
/// How long a new cycle is watched before it is believed.
const PROOF: Duration = Duration::from_millis(250);

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(ms: u64) -> Nanos {
        Nanos::from_millis(ms)
    }

    #[test]
    fn backlog_that_drains_loses_nothing() {
        let mut gate = Gate::default();
        assert_eq!(gate.judge(Some(false), ms(0)), Pass::Release);
        assert_eq!(gate.judge(Some(true), ms(200)), Pass::Hold);
        assert_eq!(gate.judge(Some(true), ms(201)), Pass::Hold);
        assert_eq!(gate.judge(Some(false), ms(202)), Pass::Release);
    }

    #[test]
    fn distance_that_stays_is_a_slip() {
        let mut gate = Gate::default();
        assert_eq!(gate.judge(Some(true), ms(0)), Pass::Hold);
        assert_eq!(gate.judge(Some(true), ms(499)), Pass::Hold);
        assert_eq!(gate.judge(Some(true), ms(501)), Pass::Slip);
        assert_eq!(gate, Gate::Proving { since: None });
    }

    #[test]
    fn a_backlog_proves_nothing() {
        let mut gate = Gate::default();
        assert_eq!(gate.judge(Some(true), ms(0)), Pass::Hold);
        assert_eq!(gate.judge(None, ms(400)), Pass::Hold);
        assert_eq!(gate.judge(Some(true), ms(600)), Pass::Hold);
        assert_eq!(gate.judge(Some(true), ms(1101)), Pass::Slip);
    }

    #[test]
    fn new_cycle_is_believed_after_its_proof() {
        let mut gate = Gate::default();
        gate.interrupted();
        assert_eq!(gate.judge(Some(false), ms(0)), Pass::Hold);
        assert_eq!(gate.judge(Some(false), ms(249)), Pass::Hold);
        assert_eq!(gate.judge(Some(false), ms(250)), Pass::Release);
        gate.interrupted();
        assert_eq!(gate.judge(Some(true), ms(300)), Pass::Slip);
    }
}
