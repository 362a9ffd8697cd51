//! The device as a state machine: what is said, and which frames are believed.

mod errors;
mod polling;

use std::collections::VecDeque;

use asphera_link::{
    Asking, AskingStep, Channel, Command, Driver, Event, Events, FaultKind, Flags, Input, Nanos,
    Output, Problem, millis, shown,
};

use crate::assemble::{Assembled, Assembler, NoReading};
use crate::framing::{Framing, Splitter};
use crate::settings::{Hello, Poll, Refusal, Settings};

/// How often the question of [`Hello`] is asked.
const ATTEMPTS: u8 = 2;

/// A device described by [`Settings`].
///
/// ```text
///         connected             answer                      due
/// Closed ───────────▶ Greeting ────────▶ Listening │ Waiting ⇄ Asking, Inquiring
///    ▲                   │ no answer twice                      │ no answer five times
///    └───────────────────┴──────────────────────────────────────┘
/// ```
///
/// # Devices that are asked
///
/// When to ask, and the silence after a question without an answer, follow [`Asking`].
/// An answer does not say which question it belongs to. After a time-out nothing is asked until the line was
/// silent for [`late_limit_ms`](crate::Poll::late_limit_ms); what comes in that time is dropped. An answer among bytes that
/// nobody understands is flagged, unless a check guards it: noise may look like a number. Without a [`Hello`] the first answer of
/// a connection only proves that the device is there, and the line must be silent for as long after it.
///
/// # Devices with a queue of errors
///
/// The queue is read to its end before the first question, after a question without an answer, and from time to
/// time after an answer. Each error is a fault; readings go on.
///
/// # Devices that send by themselves
///
/// What comes before the first end of a line may be half of one and is dropped, unless lines have a beginning. A line that
/// no check guards is flagged after a silence within it, and after a line that is no reading: half a line and the next
/// one, or noise, may look like a number.
#[derive(Debug)]
pub struct Described {
    settings: Settings,
    channels: Vec<Channel>,
    assembler: Assembler,
    splitter: Splitter,
    state: State,
    asking: Asking,
    wanted: bool,
    /// The next answer is not to be trusted with values.
    confirm: bool,
    /// When the queue of errors is due; `None`: once the line is silent.
    errors_due: Option<Nanos>,
    /// No question was asked on this connection yet.
    unasked: bool,
    /// The last frame was no reading; the first of a run is worth a message.
    muddled: bool,
    in_trouble: bool,
    /// Bytes passed over before the question under way.
    passed_before: u64,
    /// A silence lies within the line that comes.
    is_interrupted: bool,
    /// The newest frame of a device that sends by itself.
    last_frame: Nanos,
    last_receipt: Nanos,
    outputs: VecDeque<Vec<u8>>,
    events: Events,
    tally: Tally,
}

/// What happened since the driver was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Readings given.
    pub readings: u64,
    /// Questions asked.
    pub asked: u64,
    /// Questions without an answer in time.
    pub timeouts: u64,
    /// Due times passed over because another question was under way.
    pub missed: u64,
    /// Frames by which the device said no.
    pub refused: u64,
    /// Errors found in its queue.
    pub errors: u64,
    /// Whole frames that were no reading.
    pub unreadable: u64,
    /// Frames whose check was wrong (lines; records that fail are bytes passed over).
    pub damaged: u64,
    /// Bytes passed over.
    pub discarded_bytes: u64,
}

#[derive(Clone, Debug, PartialEq)]
enum State {
    /// No connection, or none to be trusted.
    Closed,
    /// Asked who is there.
    Greeting { deadline: Nanos, attempt: u8, stranger: Option<String> },
    /// The device sends by itself.
    Listening,
    /// The next question is not due, or the line must be silent first.
    Waiting,
    /// Has asked.
    Asking { stranger: Option<String> },
    /// Has asked for the oldest error; `left` more may be read.
    Inquiring { left: u8, stranger: Option<String> },
}

/// A frame that is no reading.
enum Other {
    /// The device says no.
    Refused(String),
    /// Neither a reading nor wrong.
    Ignored,
    /// Nothing that was described.
    Strange(String),
}

impl Described {
    /// A driver for the device.
    ///
    /// # Errors
    ///
    /// [`Settings::problems`], when there are any.
    pub fn new(settings: Settings) -> Result<Described, Vec<Problem>> {
        let problems = settings.problems();
        if !problems.is_empty() {
            return Err(problems);
        }
        Ok(Described {
            channels: settings.channels(),
            assembler: Assembler::new(&settings),
            splitter: splitter(&settings),
            state: State::Closed,
            asking: Asking::new(settings.poll.as_ref().map(Poll::pace).unwrap_or_default()),
            wanted: false,
            confirm: false,
            errors_due: None,
            unasked: false,
            muddled: false,
            in_trouble: false,
            passed_before: 0,
            is_interrupted: false,
            last_frame: Nanos::ZERO,
            last_receipt: Nanos::ZERO,
            outputs: VecDeque::new(),
            events: Events::default(),
            tally: Tally::default(),
            settings,
        })
    }

    /// What happened since the driver was made.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    fn greet(&mut self, now: Nanos, hello: &Hello, attempt: u8) {
        self.outputs.push_back(hello.ask.clone());
        self.splitter.clear(true);
        let deadline = now + millis(hello.timeout_ms);
        self.state = State::Greeting { deadline, attempt, stranger: None };
    }

    /// The device may measure from now on.
    fn begin(&mut self, now: Nanos) {
        if self.wanted {
            self.outputs.extend(self.settings.on_start.iter().cloned());
        }
        match &self.settings.poll {
            None => self.state = State::Listening,
            Some(_) => {
                self.unasked = true;
                self.begin_or_inquire(now);
            }
        }
    }

    /// Whether what comes is meant for us.
    fn takes_frames(&self) -> bool {
        !matches!(self.state, State::Closed | State::Waiting)
    }

    /// Takes all whole frames.
    fn proceed(&mut self, now: Nanos) {
        while self.takes_frames() {
            let Some(frame) = self.splitter.next() else { break };
            self.frame(now, &frame);
        }
        if !self.takes_frames() {
            // Nothing was asked: what comes is late, or not meant for us.
            self.splitter.clear(false);
            self.asking.disturbed(now);
        }
        self.report_discarded();
    }

    fn frame(&mut self, now: Nanos, frame: &[u8]) {
        self.last_frame = now;
        if let State::Greeting { stranger, .. } = &mut self.state
            && let Some(hello) = &self.settings.hello
        {
            if hello.answer.matches(frame) {
                self.events.prove_online();
                self.events.prove_ready();
                self.begin(now);
                return;
            }
            // A device that sends by itself does so while it is asked, too.
            *stranger = Some(shown(frame));
            self.splitter.pass_over(frame);
            return;
        }
        if matches!(self.state, State::Inquiring { .. }) {
            self.inquiry_frame(now, frame);
            return;
        }
        match self.judge(now, frame) {
            Ok(assembled) => self.read(now, assembled),
            Err(Other::Ignored) => {}
            Err(Other::Refused(detail)) => {
                self.tally.refused += 1;
                self.events.prove_online();
                self.events.fault(FaultKind::Refused, detail);
                self.answered(now);
            }
            Err(Other::Strange(detail)) => {
                self.splitter.pass_over(frame);
                if let State::Asking { stranger } = &mut self.state {
                    *stranger = Some(shown(frame));
                }
                if !std::mem::replace(&mut self.muddled, true) {
                    self.events.fault(FaultKind::Protocol, detail);
                }
            }
        }
    }

    fn judge(&mut self, now: Nanos, frame: &[u8]) -> Result<Assembled, Other> {
        let refused = |refusal: &&Refusal| refusal.pattern.matches(frame);
        if let Some(refusal) = self.settings.refusals.iter().find(refused) {
            let means = &refusal.means;
            let means = if means.is_empty() { "see its manual" } else { means };
            return Err(Other::Refused(format!("the device answers `{}`: {means}", shown(frame))));
        }
        let is_echo = |poll: &Poll| poll.ask.trim_ascii_end() == frame.trim_ascii_end();
        let is_echo = self.settings.poll.as_ref().is_some_and(is_echo);
        if is_echo || self.settings.ignore.iter().any(|pattern| pattern.matches(frame)) {
            return Err(Other::Ignored);
        }
        let body = match self.settings.checksum {
            None => frame,
            Some(checksum) => match checksum.body(frame) {
                Some(body) => body,
                None => {
                    self.tally.damaged += 1;
                    let detail = format!(
                        "checksum of `{}` is wrong: check cable and baud rate",
                        shown(frame)
                    );
                    return Err(Other::Strange(detail));
                }
            },
        };
        let body = &body[self.settings.framing.begin().len().min(body.len())..];
        self.assembler.reading(now, body).map_err(|why| {
            self.tally.unreadable += 1;
            Other::Strange(no_reading(frame, &why))
        })
    }

    fn read(&mut self, now: Nanos, Assembled { mut reading, trouble }: Assembled) {
        self.events.prove_online();
        if self.is_doubtful() {
            reading.flags |= Flags::SUSPECT;
        }
        self.muddled = false;
        let was_in_trouble = std::mem::replace(&mut self.in_trouble, trouble.is_some());
        if let Some(trouble) = trouble.filter(|_| !was_in_trouble) {
            self.events.fault(FaultKind::Device, format!("the device reports {trouble}"));
        }
        if !self.confirm {
            self.tally.readings += 1;
            self.events.push(Event::Reading(reading));
            self.events.prove_ready();
        }
        self.answered(now);
    }

    /// Whether a frame that nothing guards may be noise, or consist of two.
    fn is_doubtful(&mut self) -> bool {
        let is_interrupted = std::mem::take(&mut self.is_interrupted);
        match (&self.settings.poll, &self.settings.framing) {
            _ if self.settings.checksum.is_some() => false,
            (Some(_), _) => self.splitter.passed_over() > self.passed_before,
            (None, Framing::Lines { .. }) => is_interrupted || self.muddled,
            (None, Framing::Records { .. }) => false,
        }
    }

    fn ungreeted(&mut self, now: Nanos, attempt: u8, stranger: Option<String>) {
        let Some(hello) = self.settings.hello.clone() else { return };
        if attempt < ATTEMPTS {
            self.greet(now, &hello, attempt + 1);
            return;
        }
        let ask = shown(&hello.ask);
        let timeout_ms = hello.timeout_ms;
        match stranger {
            Some(frame) => {
                let answer = hello.answer.text();
                let detail = format!(
                    "`{ask}` is answered by `{frame}`, expected `{answer}`: check the baud rate, or connect the right device"
                );
                self.abandon(FaultKind::Protocol, detail);
            }
            None => {
                let detail = format!(
                    "no answer to `{ask}` within {timeout_ms} ms, asked {ATTEMPTS} times: check cable, power, baud rate and the end of commands"
                );
                self.abandon(FaultKind::Timeout, detail);
            }
        }
    }

    fn abandon(&mut self, kind: FaultKind, detail: String) {
        self.outputs.clear();
        self.splitter.clear(false);
        self.asking.stop();
        self.events.reopen(kind, detail);
        self.state = State::Closed;
    }

    fn report_discarded(&mut self) {
        let bytes = self.splitter.take_discarded();
        self.tally.discarded_bytes += bytes;
        self.events.discarded(bytes);
    }

    /// When a device that sends by itself has been silent for too long.
    fn gap_due(&self) -> Option<Nanos> {
        let is_watched = self.settings.gap_ms > 0 && self.events.is_online();
        is_watched.then(|| self.last_frame + millis(self.settings.gap_ms))
    }

    fn silence(&self) -> Option<Nanos> {
        let waits = self.settings.holds_back() && self.state == State::Listening;
        (waits && self.splitter.is_waiting())
            .then(|| self.last_receipt + millis(self.settings.silence_ms))
    }
}

impl Driver for Described {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.splitter = splitter(&self.settings);
        self.events.restart();
        self.asking.stop();
        (self.muddled, self.in_trouble, self.is_interrupted) = (false, false, false);
        (self.errors_due, self.unasked) = (None, false);
        self.last_receipt = now;
        self.outputs.clear();
        self.outputs.extend(self.settings.on_connect.iter().cloned());
        match self.settings.hello.clone() {
            Some(hello) => {
                self.confirm = false;
                self.greet(now, &hello, 1);
            }
            None => {
                self.confirm = self.settings.poll.is_some();
                if self.settings.begins_whole {
                    self.splitter.clear(true);
                }
                self.begin(now);
            }
        }
    }

    fn disconnected(&mut self, now: Nanos) {
        // A record that was held back and is as long as one: nothing can come behind it any more.
        if self.settings.holds_back()
            && self.state == State::Listening
            && let Some(frame) = self.splitter.silence()
        {
            self.frame(now, &frame);
        }
        self.splitter.clear(false);
        self.report_discarded();
        self.outputs.clear();
        self.asking.stop();
        self.state = State::Closed;
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Bytes(bytes) = input else { return };
        if bytes.is_empty() {
            return;
        }
        let is_silent = now.since(self.last_receipt) >= millis(self.settings.silence_ms);
        self.is_interrupted |= is_silent && self.splitter.is_waiting();
        self.last_receipt = now;
        self.splitter.push(bytes);
        self.proceed(now);
    }

    fn timeout(&mut self, now: Nanos) {
        if self.poll_timeout().is_none_or(|due| now < due) {
            return;
        }
        match (self.state.clone(), self.settings.poll.clone()) {
            (State::Greeting { attempt, stranger, .. }, _) => {
                self.ungreeted(now, attempt, stranger);
            }
            (State::Waiting, Some(poll)) => match self.asking.step() {
                AskingStep::Settling { .. } if self.errors_due.is_none() => {
                    self.begin_or_inquire(now);
                }
                AskingStep::Settling { .. } => self.resume(now),
                _ => {
                    self.asking.ask_due(now);
                    self.ask(&poll);
                }
            },
            (State::Asking { stranger }, Some(poll)) => self.unanswered(now, &poll, stranger),
            (State::Inquiring { stranger, .. }, Some(_)) => self.uninquired(now, stranger),
            (State::Listening, _) if self.silence().is_some_and(|due| due <= now) => {
                if let Some(frame) = self.splitter.silence() {
                    self.frame(now, &frame);
                }
            }
            (State::Listening, _) => {
                let gap_ms = now.since(self.last_frame).as_millis();
                let detail =
                    format!("no frame for {gap_ms} ms: check cable and power, or increase gap_ms");
                self.abandon(FaultKind::Timeout, detail);
            }
            _ => {}
        }
        self.report_discarded();
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        match self.state {
            State::Closed => None,
            State::Listening => self.silence().into_iter().chain(self.gap_due()).min(),
            State::Greeting { deadline, .. } => Some(deadline),
            State::Waiting | State::Asking { .. } | State::Inquiring { .. } => self.asking.due(),
        }
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        self.outputs.pop_front().map(Output::Bytes)
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, now: Nanos, command: Command) {
        let wanted = command == Command::Start;
        let is_open = !matches!(self.state, State::Closed | State::Greeting { .. });
        self.wanted = wanted;
        if is_open {
            let words = if wanted { &self.settings.on_start } else { &self.settings.on_stop };
            self.outputs.extend(words.iter().cloned());
            // What was said may be refused: the queue knows after the next answer.
            self.errors_due = self.errors_due.map(|_| now);
        }
    }
}

fn splitter(settings: &Settings) -> Splitter {
    Splitter::new(settings.framing.clone(), settings.checksum, settings.poll.is_some())
}

fn no_reading(frame: &[u8], why: &NoReading) -> String {
    format!("`{}` {why}: check baud rate and settings", shown(frame))
}
