//! Asking again and again, and what follows when no answer comes.

use asphera_link::{FaultKind, Nanos, Unanswered, shown};

use super::{Described, State};
use crate::settings::Poll;

impl Described {
    pub(super) fn begin_or_inquire(&mut self, now: Nanos) {
        match self.settings.errors.clone() {
            Some(errors) => self.inquire(now, &errors),
            None => self.resume(now),
        }
    }

    /// Asks at once if nothing was asked yet, else when the next question is due.
    pub(super) fn resume(&mut self, now: Nanos) {
        let Some(poll) = self.settings.poll.clone() else { return };
        if std::mem::take(&mut self.unasked) {
            self.asking.restart(now);
            self.ask(&poll);
        } else {
            self.wait(now);
        }
    }

    /// Sends the question that is under way now.
    pub(super) fn ask(&mut self, poll: &Poll) {
        self.outputs.push_back(poll.ask.clone());
        self.tally.asked += 1;
        self.splitter.clear(true);
        self.passed_before = self.splitter.passed_over();
        self.state = State::Asking { stranger: None };
    }

    fn wait(&mut self, now: Nanos) {
        self.tally.missed += self.asking.wait(now);
        self.state = State::Waiting;
    }

    /// The question under way has its answer.
    pub(super) fn answered(&mut self, now: Nanos) {
        if self.settings.poll.is_none() {
            return;
        }
        self.asking.answered();
        if std::mem::take(&mut self.confirm) {
            self.asking.settle(now);
            self.state = State::Waiting;
        } else if self.errors_due.is_some_and(|due| now >= due) {
            self.begin_or_inquire(now);
        } else {
            self.wait(now);
        }
    }

    pub(super) fn unanswered(&mut self, now: Nanos, poll: &Poll, stranger: Option<String>) {
        let came = stranger.map(|frame| format!("; `{frame}` came")).unwrap_or_default();
        let (ask, timeout_ms) = (shown(&poll.ask), poll.timeout_ms);
        let detail = format!(
            "no answer to `{ask}` within {timeout_ms} ms{came}: check cable and power, or increase timeout_ms"
        );
        self.errors_due = None;
        self.settle(now, detail);
    }

    /// Waits for silence after a time-out, or gives the connection up after too many.
    pub(super) fn settle(&mut self, now: Nanos, detail: String) {
        self.tally.timeouts += 1;
        match self.asking.unanswered(now) {
            Unanswered::GiveUp => self.abandon(FaultKind::Timeout, detail),
            Unanswered::Settle => {
                self.events.fault(FaultKind::Timeout, detail);
                self.splitter.clear(false);
                self.state = State::Waiting;
            }
        }
    }
}
