//! The halt: `AbortE()`, sent until the machine says that it stands.

use std::time::Duration;

use asphera_link::{MotionEvent, MotionFailure, MotionTrouble, Nanos};

use crate::wire::{Kind, Tag};

/// A halt under way.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Halt {
    pub(super) tag: Tag,
    deadline: Nanos,
    attempt: u8,
    /// Why, where nobody ordered it.
    failure: Option<MotionFailure>,
}

/// What follows an answer to a halt, or its absence.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Outcome {
    /// It goes on.
    Waiting(Halt),
    /// It is to be sent again.
    Again(Halt),
    /// It is over.
    Over(MotionEvent),
}

impl Halt {
    /// A halt that is sent now.
    pub(super) fn sent(
        now: Nanos,
        tag: Tag,
        timeout: Duration,
        failure: Option<MotionFailure>,
    ) -> Halt {
        Halt { tag, deadline: now + timeout, attempt: 1, failure }
    }

    pub(super) fn deadline(&self) -> Nanos {
        self.deadline
    }

    /// Takes an answer to it.
    pub(super) fn answered(self, now: Nanos, kind: &Kind) -> Outcome {
        match kind {
            Kind::Acknowledged => Outcome::Waiting(Halt { deadline: now + RUN_OUT, ..self }),
            Kind::Complete => Outcome::Over(match self.failure {
                None => MotionEvent::Halted,
                Some(failure) => MotionEvent::Failed(failure),
            }),
            // Sent again when its time is over: a server may refuse it before the session began.
            Kind::Error(_) | Kind::Data(_) => Outcome::Waiting(self),
        }
    }

    /// Its time is over.
    pub(super) fn timed_out(self, now: Nanos, tag: Tag, timeout: Duration) -> Outcome {
        if self.attempt < ATTEMPTS {
            let attempt = self.attempt + 1;
            return Outcome::Again(Halt { tag, deadline: now + timeout, attempt, ..self });
        }
        let before = self.failure.map_or(String::new(), |failure| format!("{}; ", failure.detail));
        let detail = format!(
            "{before}no answer to `AbortE()`, sent {ATTEMPTS} times: press the emergency stop"
        );
        Outcome::Over(MotionEvent::Failed(MotionFailure::new(MotionTrouble::Unanswered, detail)))
    }
}

/// How often a halt is sent until it is answered.
const ATTEMPTS: u8 = 5;
/// Time in which a machine that acknowledged a halt comes to rest.
const RUN_OUT: Duration = Duration::from_secs(10);
