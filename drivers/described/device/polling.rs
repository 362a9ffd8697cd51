//! Asking again and again, and what follows when no answer comes.

use std::time::Duration;

use asphera_link::{FaultKind, Nanos, shown};

use super::{Described, MOST_SILENT, State, millis};
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
            self.next_poll = now + millis(poll.interval_ms);
            self.ask(now, &poll);
        } else {
            self.rest_until_due(now, &poll);
        }
    }

    pub(super) fn ask(&mut self, now: Nanos, poll: &Poll) {
        self.outputs.push_back(poll.ask.clone());
        self.tally.asked += 1;
        self.splitter.clear(true);
        self.passed_before = self.splitter.passed_over();
        self.state = State::Asking { deadline: now + millis(poll.timeout_ms), stranger: None };
    }

    /// Waits for the next due time that has not passed.
    fn rest_until_due(&mut self, now: Nanos, poll: &Poll) {
        let interval_ns = u64::from(poll.interval_ms) * 1_000_000;
        let behind_ns = now.as_nanos().saturating_sub(self.next_poll.as_nanos());
        let missed = behind_ns.div_ceil(interval_ns);
        self.tally.missed += missed;
        self.next_poll = self.next_poll + Duration::from_nanos(missed.saturating_mul(interval_ns));
        self.state = State::Idle { due: self.next_poll };
    }

    /// The question under way has its answer.
    pub(super) fn answered(&mut self, now: Nanos) {
        let Some(poll) = self.settings.poll.clone() else { return };
        self.silent = 0;
        if std::mem::take(&mut self.confirm) {
            self.state = State::Settling { until: now + millis(poll.late_limit_ms) };
        } else if self.errors_due.is_some_and(|due| now >= due) {
            self.begin_or_inquire(now);
        } else {
            self.rest_until_due(now, &poll);
        }
    }

    pub(super) fn unanswered(&mut self, now: Nanos, poll: &Poll, stranger: Option<String>) {
        self.tally.timeouts += 1;
        let came = stranger.map(|frame| format!("; `{frame}` came")).unwrap_or_default();
        let (ask, timeout_ms) = (shown(&poll.ask), poll.timeout_ms);
        let detail = format!(
            "no answer to `{ask}` within {timeout_ms} ms{came}: check cable and power, or increase timeout_ms"
        );
        self.errors_due = None;
        self.settle(now, poll, detail);
    }

    /// Waits for silence after a time-out, or gives the connection up after too many.
    pub(super) fn settle(&mut self, now: Nanos, poll: &Poll, detail: String) {
        self.silent += 1;
        if self.silent >= MOST_SILENT {
            self.abandon(FaultKind::Timeout, detail);
            return;
        }
        self.fault(FaultKind::Timeout, detail);
        self.splitter.clear(false);
        self.state = State::Settling { until: now + millis(poll.late_limit_ms) };
    }
}
