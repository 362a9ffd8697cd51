//! Reading the queue of errors to its end.

use asphera_link::{FaultKind, Nanos, millis, shown};

use super::{Described, State};
use crate::settings::ErrorQueue;

/// Most errors read at one time; a queue that never ends must not stop the readings.
const MOST_ERRORS: u8 = 32;

impl Described {
    /// Asks for the oldest error.
    pub(super) fn inquire(&mut self, now: Nanos, errors: &ErrorQueue) {
        self.ask_error(now, errors, MOST_ERRORS);
    }

    fn ask_error(&mut self, now: Nanos, errors: &ErrorQueue, left: u8) {
        self.outputs.push_back(errors.ask.clone());
        self.splitter.clear(true);
        self.asking.ask(now, errors.timeout_ms);
        self.state = State::Inquiring { left, stranger: None };
    }

    /// Takes a frame while an answer of the queue is awaited.
    pub(super) fn inquiry_frame(&mut self, now: Nanos, frame: &[u8]) {
        let Some(errors) = self.settings.errors.clone() else { return };
        let State::Inquiring { left, stranger } = &mut self.state else { return };
        if errors.none.matches(frame) {
            self.inquired(now, &errors);
            return;
        }
        if !errors.entry.matches(frame) {
            *stranger = Some(shown(frame));
            self.splitter.pass_over(frame);
            return;
        }
        let left = *left - 1;
        self.tally.errors += 1;
        self.events.fault(
            FaultKind::Device,
            format!("the device reports the error `{}`: see its manual", shown(frame)),
        );
        if left > 0 {
            self.ask_error(now, &errors, left);
            return;
        }
        let detail =
            format!("the queue holds more than {MOST_ERRORS} errors: switch the device off and on");
        self.events.fault(FaultKind::Device, detail);
        self.inquired(now, &errors);
    }

    /// The queue was read; the questions go on.
    fn inquired(&mut self, now: Nanos, errors: &ErrorQueue) {
        self.errors_due = Some(now + millis(errors.interval_ms));
        self.resume(now);
    }

    /// The queue gave no answer in time.
    pub(super) fn uninquired(&mut self, now: Nanos, stranger: Option<String>) {
        let Some(errors) = self.settings.errors.clone() else { return };
        let came = stranger.map(|frame| format!("; `{frame}` came")).unwrap_or_default();
        let (ask, timeout_ms) = (shown(&errors.ask), errors.timeout_ms);
        // A device without a queue must not be asked for it in a circle: readings first.
        self.errors_due = Some(now + millis(errors.interval_ms));
        let cure = "if the device has no queue of errors, do not ask for it";
        let detail = format!("no answer to `{ask}` within {timeout_ms} ms{came}; {cure}");
        self.settle(now, detail);
    }
}
