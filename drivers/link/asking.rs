//! Questions without a number: one at a time, and silence after one without an answer.

use crate::{Nanos, Schedule, millis};

/// Questions without an answer, one after the other, after which the link is opened anew.
const MOST_SILENT: u32 = 5;

/// Times of a device that is asked again and again, in ms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Pace {
    /// Time between two due times.
    pub interval_ms: u32,
    /// How late an answer may come.
    pub timeout_ms: u32,
    /// Silence after which no late answer comes any more.
    pub late_limit_ms: u32,
}

/// Step of a driver whose device does not say which question it answers.
///
/// ```text
///       restart              ask_due            answered, wait
/// Off ──────────▶ Asking │ Idle ─────▶ Asking ────────────────▶ Idle
///  ▲                                     │ unanswered
///  └──────────── five times ─────────────┴──▶ Settling ── silence ─▶ what the driver chooses
/// ```
///
/// After a question without an answer nothing is asked until nothing came for [`Pace::late_limit_ms`]: a late answer would be
/// taken for that of the next question.
#[derive(Clone, Copy, Debug)]
pub struct Asking {
    pace: Pace,
    schedule: Schedule,
    step: AskingStep,
    silent: u32,
}

/// Where the questions stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AskingStep {
    /// Nothing is asked.
    Off,
    /// The next question has a due time.
    Idle {
        /// The due time.
        due: Nanos,
    },
    /// A question waits for its answer.
    Asking {
        /// When it is overdue.
        deadline: Nanos,
    },
    /// Nothing is asked until no late answer can come.
    Settling {
        /// When it was silent for long enough.
        until: Nanos,
    },
}

/// Meaning of a question without an answer for the connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Unanswered {
    /// Silence, then the next question.
    Settle,
    /// The fifth in a row: the link is to be opened anew.
    GiveUp,
}

impl Asking {
    /// Questions at this pace; none is asked yet.
    pub fn new(pace: Pace) -> Asking {
        let schedule = Schedule::new(pace.interval_ms);
        Asking { pace, schedule, step: AskingStep::Off, silent: 0 }
    }

    /// Where the questions stand.
    pub fn step(&self) -> AskingStep {
        self.step
    }

    /// When the step ends by itself.
    pub fn due(&self) -> Option<Nanos> {
        match self.step {
            AskingStep::Off => None,
            AskingStep::Idle { due: at }
            | AskingStep::Asking { deadline: at }
            | AskingStep::Settling { until: at } => Some(at),
        }
    }

    /// Asks nothing any more, and forgets questions without an answer.
    pub fn stop(&mut self) {
        (self.step, self.silent) = (AskingStep::Off, 0);
    }

    /// Begins with a question at once; due times count from now.
    pub fn restart(&mut self, now: Nanos) {
        self.schedule.restart(now);
        self.ask(now, self.pace.timeout_ms);
    }

    /// Asks the question that is due.
    pub fn ask_due(&mut self, now: Nanos) {
        self.schedule.advance();
        self.ask(now, self.pace.timeout_ms);
    }

    /// Asks a question outside the schedule, with a time-out of its own.
    pub fn ask(&mut self, now: Nanos, timeout_ms: u32) {
        self.step = AskingStep::Asking { deadline: now + millis(timeout_ms) };
    }

    /// Takes note of an answer. The driver then chooses what is next.
    pub fn answered(&mut self) {
        self.silent = 0;
    }

    /// Waits for the next due time that has not passed; gives the number of those that have.
    pub fn wait(&mut self, now: Nanos) -> u64 {
        let missed = self.schedule.skip_passed(now);
        self.step = AskingStep::Idle { due: self.schedule.next_due() };
        missed
    }

    /// Waits for silence from now on.
    pub fn settle(&mut self, now: Nanos) {
        self.step = AskingStep::Settling { until: now + millis(self.pace.late_limit_ms) };
    }

    /// Something came that was not asked for: the silence begins anew.
    pub fn disturbed(&mut self, now: Nanos) {
        if matches!(self.step, AskingStep::Settling { .. }) {
            self.settle(now);
        }
    }

    /// The question under way has no answer in time.
    pub fn unanswered(&mut self, now: Nanos) -> Unanswered {
        self.silent += 1;
        if self.silent >= MOST_SILENT {
            self.stop();
            return Unanswered::GiveUp;
        }
        self.settle(now);
        Unanswered::Settle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PACE: Pace = Pace { interval_ms: 100, timeout_ms: 30, late_limit_ms: 250 };

    fn at(ms: u64) -> Nanos {
        Nanos::from_millis(ms)
    }

    #[test]
    fn questions_come_at_their_due_times() {
        let mut asking = Asking::new(PACE);
        assert_eq!(asking.due(), None);
        asking.restart(at(1000));
        assert_eq!(asking.step(), AskingStep::Asking { deadline: at(1030) });
        asking.answered();
        assert_eq!(asking.wait(at(1012)), 0);
        assert_eq!(asking.step(), AskingStep::Idle { due: at(1100) });
        // Late by 3 ms: the next question is due by the schedule all the same.
        asking.ask_due(at(1103));
        assert_eq!(asking.due(), Some(at(1133)));
        asking.answered();
        assert_eq!(asking.wait(at(1120)), 0);
        assert_eq!(asking.due(), Some(at(1200)));
    }

    #[test]
    fn silence_follows_a_question_without_an_answer() {
        let mut asking = Asking::new(PACE);
        asking.restart(at(0));
        assert_eq!(asking.unanswered(at(30)), Unanswered::Settle);
        assert_eq!(asking.step(), AskingStep::Settling { until: at(280) });
        asking.disturbed(at(90));
        assert_eq!(asking.due(), Some(at(340)));
        assert_eq!(asking.wait(at(340)), 3, "100, 200 and 300 ms have passed");
        assert_eq!(asking.due(), Some(at(400)));
        asking.disturbed(at(345));
        assert_eq!(asking.due(), Some(at(400)), "no silence is waited for");
    }

    #[test]
    fn the_fifth_silence_in_a_row_gives_up() {
        let mut asking = Asking::new(PACE);
        asking.restart(at(0));
        let mut now = 0;
        for _ in 0..4 {
            assert_eq!(asking.unanswered(at(now)), Unanswered::Settle);
            now += 1000;
            asking.ask_due(at(now));
        }
        asking.answered();
        for _ in 0..4 {
            assert_eq!(asking.unanswered(at(now)), Unanswered::Settle, "an answer lies between");
        }
        assert_eq!(asking.unanswered(at(now)), Unanswered::GiveUp);
        assert_eq!(asking.step(), AskingStep::Off);
    }
}
