//! The device as a state machine: when to ask, whom to believe.

use std::collections::VecDeque;
use std::time::Duration;

use asphera_link::{
    Channel, Command, Driver, Event, Events, FaultKind, Input, Nanos, Output, Problem, Schedule,
    millis,
};
use tokio_modbus::ExceptionCode;

use crate::call::{Answer, Caller};
use crate::map::Block;
use crate::reading::{Assembler, Image};
use crate::screen::{OutOfStep, Question, Screen};
use crate::settings::{Settings, Transport};

/// A Modbus device read through its register map.
///
/// It polls from [`Driver::connected`] on, whether measuring was started or not, so that a scan's
/// preparation sees live values; each poll reads all blocks of the map, one request at a time, and
/// gives one reading. [`Command`]s change nothing.
///
/// # Schedule
///
/// Polls are due at fixed times, [`Settings::poll_interval_ms`] apart from the connection on. A due
/// time that passes while another poll is under way is counted as missed and never made up for.
///
/// # Late answers
///
/// - **Modbus TCP**: an answer with another transaction or unit than asked for is passed over.
///   Transaction ids go on over reconnects. A time-out ends the connection ([`Event::Reopen`]).
/// - **Modbus RTU** has no transaction ids: after a time-out nothing is asked until the late answer
///   came and was dropped, or the line was silent for [`Settings::late_limit_ms`]. After such a
///   silence, and after [`Driver::connected`], the first answer only proves that the device is
///   there: its values are not used, and the line must then be silent for as long again.
///   A device that for ever answers each request with the answer to the one before cannot be found
///   out unless its blocks differ in length or function.
///
/// # Refusals
///
/// An exception is a valid answer: the device is there. The fields of the refused block are missing
/// and the reading is flagged as a device error; when all channels are refused there is no reading.
/// Exceptions 10 and 11 come from a gateway and prove nothing about the device.
pub struct Modbus {
    settings: Settings,
    requests: Vec<Block>,
    assembler: Assembler,
    caller: Caller,
    screen: Screen,
    state: State,
    schedule: Schedule,
    /// RTU: the next answer is not to be trusted with values.
    confirm: bool,
    alarmed: bool,
    last_device_time_ns: Option<u64>,
    transmits: VecDeque<Vec<u8>>,
    events: Events,
    tally: Tally,
}

/// What happened since the driver was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Requests sent.
    pub requests: u64,
    /// Answers accepted, exceptions among them.
    pub answers: u64,
    /// Readings given.
    pub readings: u64,
    /// Polls that showed the device time of the reading before and gave none.
    pub repeated: u64,
    /// Answers that only proved the device is there.
    pub confirmed: u64,
    /// Due times passed over because another poll was under way.
    pub missed: u64,
    /// Requests without an answer in time.
    pub timeouts: u64,
    /// Answers that came after their time-out and were dropped (RTU).
    pub late: u64,
    /// Exceptions.
    pub refused: u64,
    /// Bytes passed over.
    pub discarded_bytes: u64,
}

enum State {
    /// Not connected, or not to be trusted until connected anew.
    Closed,
    /// Waits for the next poll.
    Idle { due: Nanos },
    /// Has sent a request.
    Asking { question: Question, deadline: Nanos, image: Image },
    /// Has got an answer and waits before the next request of the same poll.
    Pausing { until: Nanos, image: Image },
    /// RTU: waits for the line to be out of debt. `question` is the one still unanswered.
    Settling { question: Option<Question>, until: Nanos, silence: Duration },
}

impl Modbus {
    /// A driver for the device.
    ///
    /// # Errors
    ///
    /// [`Settings::problems`], when there are any.
    pub fn new(settings: Settings) -> Result<Modbus, Vec<Problem>> {
        let problems = settings.problems();
        let Some(map) = settings.map.resolve().filter(|_| problems.is_empty()) else {
            return Err(problems);
        };
        let requests = settings.requests();
        Ok(Modbus {
            assembler: Assembler::new(&map, &requests),
            requests,
            caller: Caller::new(settings.transport, settings.unit_id),
            screen: Screen::new(settings.transport),
            state: State::Closed,
            schedule: Schedule::new(settings.poll_interval_ms),
            confirm: false,
            alarmed: false,
            last_device_time_ns: None,
            transmits: VecDeque::new(),
            events: Events::default(),
            tally: Tally::default(),
            settings,
        })
    }

    /// The requests of one poll, in order.
    pub fn requests(&self) -> &[Block] {
        &self.requests
    }

    /// What happened since the driver was made.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    fn ask(&mut self, now: Nanos, image: Image) -> State {
        let (bytes, question) = self.caller.ask(self.requests[image.len()]);
        self.screen.forget_stranger();
        self.transmits.push_back(bytes);
        self.tally.requests += 1;
        State::Asking { question, deadline: now + millis(self.settings.timeout_ms), image }
    }

    /// Waits for the next due time that has not passed, at least the pause.
    fn idle(&mut self, now: Nanos) -> State {
        self.tally.missed += self.schedule.skip_passed(now);
        let quiet = now + millis(self.settings.pause_between_requests_ms);
        State::Idle { due: self.schedule.next_due().max(quiet) }
    }

    /// Takes the frame that answers the request for block `image.len()`.
    fn answered(&mut self, now: Nanos, frame: Vec<u8>, mut image: Image) -> State {
        let block = self.requests[image.len()];
        self.tally.answers += 1;
        let words = match self.caller.answer(frame) {
            Ok(Answer::Words(words)) => {
                self.events.prove_online();
                Some(words)
            }
            Ok(Answer::Refused(exception)) => {
                self.tally.refused += 1;
                if !is_gateway(exception) {
                    self.events.prove_online();
                }
                let (unit_id, code) = (self.settings.unit_id, u8::from(exception));
                let text = exception_text(code);
                let detail = format!(
                    "unit {unit_id} refused to read {block}: {text} (exception {code}); check unit_id and the map of registers"
                );
                self.events.fault(FaultKind::Refused, detail);
                None
            }
            Err(error) => {
                let unit_id = self.settings.unit_id;
                let detail = format!(
                    "answer of unit {unit_id} is not one to read {block}: {error}; check that no other client uses the line"
                );
                self.events.fault(FaultKind::Protocol, detail);
                None
            }
        };
        if std::mem::take(&mut self.confirm) {
            self.tally.confirmed += 1;
            let silence = self.settings.late_limit();
            return State::Settling { question: None, until: now + silence, silence };
        }
        image.push(words);
        if image.len() == self.requests.len() {
            self.finish(now, &image);
            return self.idle(now);
        }
        match self.settings.pause_between_requests_ms {
            0 => self.ask(now, image),
            pause_ms => State::Pausing { until: now + millis(pause_ms), image },
        }
    }

    /// All blocks of a poll are answered.
    fn finish(&mut self, now: Nanos, image: &Image) {
        let alarm = self.assembler.alarm(image).map(str::to_owned);
        let was_alarmed = std::mem::replace(&mut self.alarmed, alarm.is_some());
        if let Some(name) = alarm.filter(|_| !was_alarmed) {
            let unit_id = self.settings.unit_id;
            self.events.fault(
                FaultKind::Device,
                format!("unit {unit_id} reports `{name}`: see its manual"),
            );
        }
        let Some(reading) = self.assembler.reading(now, image) else {
            return;
        };
        let time_ns = reading.device_time_ns;
        let repeated = time_ns.is_some() && time_ns == self.last_device_time_ns;
        if repeated && self.settings.skip_repeated {
            self.tally.repeated += 1;
            return;
        }
        self.last_device_time_ns = time_ns.or(self.last_device_time_ns);
        self.tally.readings += 1;
        self.events.push(Event::Reading(reading));
        self.events.prove_ready();
    }

    fn timed_out(&mut self, now: Nanos, question: Question, image: &Image) -> State {
        self.tally.timeouts += 1;
        self.caller.reset();
        let (block, unit_id) = (self.requests[image.len()], self.settings.unit_id);
        let timeout_ms = self.settings.timeout_ms;
        let stranger = self.screen.stranger(&question);
        let stranger = stranger.map(|unit| format!("; unit {unit} answered")).unwrap_or_default();
        let detail = format!(
            "no answer of unit {unit_id} to read {block} within {timeout_ms} ms{stranger}: check unit_id, cable and power"
        );
        match self.settings.transport {
            Transport::Tcp => self.lose(FaultKind::Timeout, detail),
            Transport::Rtu => {
                self.events.fault(FaultKind::Timeout, detail);
                let silence = self.settings.late_limit();
                State::Settling { question: Some(question), until: now + silence, silence }
            }
        }
    }

    /// Gives up the connection.
    fn lose(&mut self, kind: FaultKind, detail: String) -> State {
        self.caller.reset();
        self.screen.clear();
        self.transmits.clear();
        self.events.reopen(kind, detail);
        State::Closed
    }

    /// Judges the received bytes in the given state. Gives the next state and whether there may be
    /// more to judge.
    fn judge(&mut self, now: Nanos, state: State) -> Result<(State, bool), OutOfStep> {
        match state {
            State::Closed => {
                self.screen.clear();
                Ok((State::Closed, false))
            }
            State::Idle { .. } | State::Pausing { .. } => {
                self.screen.take(None)?;
                Ok((state, false))
            }
            State::Asking { question, deadline, image } => {
                match self.screen.take(Some(&question))? {
                    Some(frame) => Ok((self.answered(now, frame, image), true)),
                    None => Ok((State::Asking { question, deadline, image }, false)),
                }
            }
            State::Settling { question, silence, .. } => {
                let Some(late) = self.screen.take(question.as_ref())? else {
                    return Ok((
                        State::Settling { question, until: now + silence, silence },
                        false,
                    ));
                };
                self.tally.late += 1;
                self.screen.pass_over(late.len());
                Ok((self.idle(now), true))
            }
        }
    }

    fn report_discarded(&mut self) {
        let bytes = self.screen.take_passed_over();
        self.tally.discarded_bytes += bytes;
        self.events.discarded(bytes);
    }
}

impl Driver for Modbus {
    fn channels(&self) -> &[Channel] {
        self.assembler.channels()
    }

    fn connected(&mut self, now: Nanos) {
        self.caller.reset();
        self.screen = Screen::new(self.settings.transport);
        self.transmits.clear();
        self.confirm = self.settings.transport == Transport::Rtu;
        self.events.restart();
        self.alarmed = false;
        self.last_device_time_ns = None;
        self.schedule.restart(now);
        self.state = self.ask(now, Image::new());
    }

    fn disconnected(&mut self, _: Nanos) {
        self.caller.reset();
        self.screen.clear();
        self.report_discarded();
        self.transmits.clear();
        self.state = State::Closed;
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Bytes(bytes) = input else {
            return;
        };
        if bytes.is_empty() {
            return;
        }
        self.screen.push(bytes);
        let mut state = std::mem::replace(&mut self.state, State::Closed);
        self.state = loop {
            match self.judge(now, state) {
                Ok((next, true)) => state = next,
                Ok((next, false)) => break next,
                Err(OutOfStep { protocol, len }) => {
                    let detail = format!(
                        "no Modbus TCP frame where one must begin, protocol {protocol}, length {len}: check framing, and address and port of the link"
                    );
                    break self.lose(FaultKind::Protocol, detail);
                }
            }
        };
        self.report_discarded();
    }

    fn timeout(&mut self, now: Nanos) {
        if self.poll_timeout().is_none_or(|due| now < due) {
            return;
        }
        self.state = match std::mem::replace(&mut self.state, State::Closed) {
            State::Closed => State::Closed,
            State::Idle { .. } => {
                self.schedule.advance();
                self.ask(now, Image::new())
            }
            State::Pausing { image, .. } => self.ask(now, image),
            State::Asking { question, image, .. } => self.timed_out(now, question, &image),
            State::Settling { question, .. } => {
                self.screen.clear();
                self.confirm = question.is_some();
                self.idle(now)
            }
        };
        self.report_discarded();
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        match self.state {
            State::Closed => None,
            State::Idle { due } => Some(due),
            State::Asking { deadline, .. } => Some(deadline),
            State::Pausing { until, .. } | State::Settling { until, .. } => Some(until),
        }
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        self.transmits.pop_front().map(Output::Bytes)
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, _: Nanos, _: Command) {}
}

/// Whether a gateway answered in place of the device.
fn is_gateway(exception: ExceptionCode) -> bool {
    matches!(exception, ExceptionCode::GatewayPathUnavailable | ExceptionCode::GatewayTargetDevice)
}

/// Names of the exception codes: V1.1b3, section 7.
fn exception_text(code: u8) -> &'static str {
    match code {
        1 => "illegal function",
        2 => "illegal data address",
        3 => "illegal data value",
        4 => "server device failure",
        5 => "acknowledge",
        6 => "server device busy",
        8 => "memory parity error",
        10 => "gateway path unavailable",
        11 => "gateway target device failed to respond",
        _ => "unknown exception",
    }
}
