//! The controller as a state machine.
//!
//! ```text
//!         connected            answers           Start                    answers
//! Closed ───────────▶ Setup ───────────▶ Idle ─────────▶ Starting ─────────────────▶ Streaming
//!                                         ▲               ▲    │ refused               │   │ Stop
//!                                         │               │    ▼                       │   ▼
//!                                         │               └─ Waiting ◀── it stopped ───┘ Stopping
//!                                         └────────────────────────────────────────────────┘
//! ```
//!
//! One question at a time. An answer that does not come, or that nobody asked for, ends the connection.

mod stream;

use std::collections::VecDeque;
use std::time::Duration;

use asphera_link::{
    Channel, Command as Wish, Driver, Event, Events, FaultKind, Input, Nanos, Output, Problem,
    millis,
};

use crate::Settings;
use crate::wire::{Answer, ErrorCodes, Layout, Request, Series, Unit};
use stream::Stream;

/// How many numbers the count of readings has: the trigger count without its highest bit.
pub(crate) const COUNTS: u32 = 1 << 31;

/// A controller of the series LJ-X8000 or LJ-V7000 with one head.
#[derive(Debug)]
pub struct Profiler {
    settings: Settings,
    channels: Vec<Channel>,
    state: State,
    wanted: bool,
    talk: Option<Talk>,
    /// Bytes of an answer that has not come whole.
    answers: Vec<u8>,
    stream: Stream,
    /// Errors that the controller had when it was asked last.
    errors: ErrorCodes,
    next_watch: Nanos,
    last_profile: Nanos,
    outputs: VecDeque<Output>,
    events: Events,
    tally: Tally,
}

/// What happened since the driver was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Readings given.
    pub readings: u64,
    /// Points of these readings, with and without a height.
    pub points: u64,
    /// Points without a height.
    pub empty_points: u64,
    /// Triggers missing between readings.
    pub missing: u64,
    /// Times the count of triggers began anew.
    pub restarts: u64,
    /// Profiles with a wrong sum.
    pub damaged: u64,
    /// Times the controller stopped the stream by itself.
    pub stops: u64,
    /// Batches that ended.
    pub batches: u64,
    /// Bytes passed over.
    pub discarded_bytes: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Closed,
    Setup,
    Idle,
    Starting,
    Streaming,
    Stopping,
    /// It refused, or stopped: it is asked again then.
    Waiting(Nanos),
    /// A new connection was asked for.
    Abandoned,
}

/// Question without an answer yet.
#[derive(Clone, Copy, Debug)]
struct Talk {
    request: Request,
    deadline: Nanos,
}

impl Profiler {
    /// A driver for the controller.
    ///
    /// # Errors
    ///
    /// [`Settings::problems`], when there are any.
    pub fn new(settings: Settings) -> Result<Profiler, Vec<Problem>> {
        let problems = settings.problems();
        if !problems.is_empty() {
            return Err(problems);
        }
        Ok(Profiler {
            channels: settings.channels(),
            settings,
            state: State::Closed,
            wanted: false,
            talk: None,
            answers: Vec::new(),
            stream: Stream::default(),
            errors: ErrorCodes::default(),
            next_watch: Nanos::ZERO,
            last_profile: Nanos::ZERO,
            outputs: VecDeque::new(),
            events: Events::default(),
            tally: Tally::default(),
        })
    }

    /// What happened since the driver was made.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    fn ask(&mut self, now: Nanos, request: Request) {
        self.outputs.push_back(Output::Bytes(request.encode(self.settings.series)));
        self.talk = Some(Talk { request, deadline: now + millis(self.settings.answer_ms) });
    }

    fn take_answers(&mut self, now: Nanos, bytes: &[u8]) {
        self.answers.extend_from_slice(bytes);
        let answers = std::mem::take(&mut self.answers);
        let mut rest = &answers[..];
        while self.state != State::Abandoned {
            match Answer::decode(rest) {
                Ok(Some((answer, len))) => {
                    rest = &rest[len..];
                    self.take_answer(now, &answer);
                }
                Ok(None) => {
                    self.answers = rest.to_vec();
                    return;
                }
                Err(error) => self.give_up(FaultKind::Protocol, error.to_string()),
            }
        }
        self.discard(rest.len());
    }

    fn take_answer(&mut self, now: Nanos, answer: &Answer<'_>) {
        let Answer { command, error, content } = *answer;
        let Some(Talk { request, .. }) =
            self.talk.take_if(|talk| talk.request.command() == command)
        else {
            let expected = self.talk.map_or("nothing was asked", |talk| talk.request.name());
            let detail = format!(
                "an answer to command {command:02X}h with error {error:02X}h, expected: {expected}; check series"
            );
            self.give_up(FaultKind::Protocol, detail);
            return;
        };
        // Where nothing streamed, the controller may refuse to stop it.
        let may_refuse = self.state == State::Setup && request == Request::Stop;
        let refused = (error != 0 && !may_refuse)
            .then(|| format!("{} refused with error {error:02X}h", request.name()));
        match refused {
            Some(detail) => self.refused(now, request, detail),
            None => self.go_on(now, request, content),
        }
        self.follow_wish(now);
    }

    /// A request was carried out: what follows from it.
    fn go_on(&mut self, now: Nanos, request: Request, content: &[u8]) {
        match request {
            Request::Stop if self.state == State::Setup => match self.settings.series {
                Series::LjX8000 => self.ask(now, Request::Units),
                Series::LjV7000 => self.known(),
            },
            Request::Units => {
                self.check_serial(&Unit::decode_all(content));
                if self.state != State::Abandoned {
                    self.ask(now, Request::Errors);
                }
            }
            Request::Errors => {
                self.note_errors(ErrorCodes::decode(content));
                self.next_watch = now + millis(self.settings.watch());
                if self.state == State::Setup {
                    self.known();
                }
            }
            Request::Prepare => match Layout::decode(content) {
                Ok(layout) => {
                    self.stream.prepare(layout);
                    let next = if layout.unit_10nm == 0 { Request::Profile } else { self.start() };
                    self.ask(now, next);
                }
                Err(error) => self.refused(now, request, error.to_string()),
            },
            Request::Profile => match Layout::unit_of_profile(content) {
                Some(unit_10nm @ 1..) => {
                    self.stream.set_unit(unit_10nm);
                    let start = self.start();
                    self.ask(now, start);
                }
                _ => {
                    let detail = "the controller gives no unit of the heights, neither with the stream nor with a profile";
                    self.refused(now, request, detail.to_owned());
                }
            },
            Request::Start { .. } if self.settings.batch => self.ask(now, Request::StartMeasure),
            Request::Start { .. } | Request::StartMeasure => self.started(now),
            Request::StopMeasure => self.ask(now, Request::Stop),
            Request::Stop => self.stopped(),
        }
    }

    /// The controller is the right one, as far as that can be found.
    fn known(&mut self) {
        self.state = State::Idle;
        self.events.prove_online();
    }

    /// The request that starts the stream; what arrives from now on belongs to it.
    fn start(&mut self) -> Request {
        Request::Start { code: self.stream.open() }
    }

    fn started(&mut self, now: Nanos) {
        // It may have stopped again before it said that it started.
        if self.state == State::Starting {
            self.state = State::Streaming;
            (self.last_profile, self.next_watch) = (now, now + millis(self.settings.watch()));
            self.events.push(Event::Ready);
        }
    }

    fn stopped(&mut self) {
        self.state = State::Idle;
        let bytes = self.stream.end();
        self.discard(bytes);
    }

    /// A request was refused.
    fn refused(&mut self, now: Nanos, request: Request, detail: String) {
        self.events.fault(FaultKind::Refused, detail);
        match request {
            Request::Units if self.settings.serial.is_some() => {
                let detail = "the controller does not tell its serial number: check that it is the right one, and take serial away";
                self.give_up(FaultKind::Refused, detail.to_owned());
            }
            Request::Units => self.ask(now, Request::Errors),
            Request::Errors if self.state == State::Setup => self.known(),
            Request::Errors => self.next_watch = now + millis(self.settings.watch()),
            Request::StopMeasure => self.ask(now, Request::Stop),
            Request::Stop => self.stopped(),
            // A batch that runs already has profiles, too.
            Request::StartMeasure => self.started(now),
            Request::Prepare | Request::Profile | Request::Start { .. } => self.wait(now),
        }
    }

    /// The stream is not there: it is asked for again a little later.
    fn wait(&mut self, now: Nanos) {
        let bytes = self.stream.close();
        self.discard(bytes);
        self.state = State::Waiting(now + RESTART);
    }

    fn check_serial(&mut self, units: &[Unit]) {
        let Some(expected) = &self.settings.serial else { return };
        let found = units.first().map_or("", |unit| unit.serial.as_str());
        if found != expected {
            let detail = format!(
                "the controller has the serial number {found:?}, expected {expected:?}: check address and serial"
            );
            self.give_up(FaultKind::Refused, detail);
        }
    }

    /// Reports errors that the controller did not have before.
    fn note_errors(&mut self, errors: ErrorCodes) {
        let is_new = |code: &&u16| !self.errors.0.contains(code);
        let new: Vec<String> =
            errors.0.iter().filter(is_new).map(|code| format!("{code:04X}h")).collect();
        if !new.is_empty() {
            let shown = new[..new.len().min(CODES)].join(", ");
            let more = if new.len() > CODES { ", …" } else { "" };
            let detail = format!("the controller reports the error {shown}{more}: see its manual");
            self.events.fault(FaultKind::Device, detail);
        }
        self.errors = errors;
    }

    /// Starts or stops the stream where it is not as it is wanted.
    fn follow_wish(&mut self, now: Nanos) {
        if self.talk.is_some() {
            return;
        }
        match self.state {
            State::Idle if self.wanted => {
                self.state = State::Starting;
                self.ask(now, Request::Prepare);
            }
            State::Waiting(_) if !self.wanted => self.state = State::Idle,
            State::Waiting(due) if due <= now => {
                self.state = State::Starting;
                self.ask(now, Request::Prepare);
            }
            State::Streaming if !self.wanted => {
                self.state = State::Stopping;
                self.stream.expect_stop();
                let ends = self.settings.batch;
                self.ask(now, if ends { Request::StopMeasure } else { Request::Stop });
            }
            _ => {}
        }
    }

    fn give_up(&mut self, kind: FaultKind, detail: String) {
        (self.talk, self.state) = (None, State::Abandoned);
        self.outputs.clear();
        let bytes = self.stream.close();
        self.discard(bytes);
        self.events.reopen(kind, detail);
    }

    fn discard(&mut self, bytes: usize) {
        self.tally.discarded_bytes += bytes as u64;
        self.events.discarded(bytes as u64);
    }

    /// When the stream has been silent for too long.
    fn silent_at(&self) -> Option<Nanos> {
        let watched = self.state == State::Streaming && self.settings.silence_ms > 0;
        watched.then(|| self.last_profile + millis(self.settings.silence_ms))
    }

    /// When something is to be asked.
    fn ask_at(&self) -> Option<Nanos> {
        match self.state {
            _ if self.talk.is_some() => None,
            State::Waiting(due) => Some(due),
            State::Streaming if self.settings.watch() > 0 => Some(self.next_watch),
            _ => None,
        }
    }
}

impl Driver for Profiler {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.answers.clear();
        self.stream = Stream::default();
        self.outputs.clear();
        self.events.clear();
        self.errors = ErrorCodes::default();
        self.events.restart();
        self.state = State::Setup;
        // Whoever was connected before may have left a stream.
        self.ask(now, Request::Stop);
    }

    fn disconnected(&mut self, _: Nanos) {
        let bytes = self.stream.close() + self.answers.len();
        self.answers.clear();
        self.discard(bytes);
        self.outputs.clear();
        (self.talk, self.state) = (None, State::Closed);
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        match (self.state, input) {
            (_, Input::Frame(_)) => {}
            (State::Closed | State::Abandoned, Input::Bytes(bytes) | Input::Second(bytes)) => {
                self.discard(bytes.len());
            }
            (_, Input::Bytes(bytes)) => self.take_answers(now, bytes),
            (_, Input::Second(bytes)) => self.take_stream(now, bytes),
        }
    }

    fn timeout(&mut self, now: Nanos) {
        if let Some(talk) = self.talk.take_if(|talk| talk.deadline <= now) {
            let ms = self.settings.answer_ms;
            let detail = format!(
                "no answer to {} within {ms} ms: check cable, power, and that no other program is connected",
                talk.request.name()
            );
            self.give_up(FaultKind::Timeout, detail);
            return;
        }
        if self.silent_at().is_some_and(|due| due <= now) {
            let silence = now.since(self.last_profile).as_millis();
            let detail = format!(
                "no profile for {silence} ms: check laser, trigger and encoder, or increase silence_ms"
            );
            self.give_up(FaultKind::Timeout, detail);
            return;
        }
        let is_due = self.ask_at().is_some_and(|due| due <= now);
        if is_due && self.state == State::Streaming {
            self.ask(now, Request::Errors);
        } else if is_due {
            self.follow_wish(now);
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        let deadline = self.talk.map(|talk| talk.deadline);
        [deadline, self.silent_at(), self.ask_at()].into_iter().flatten().min()
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, now: Nanos, command: Wish) {
        self.wanted = command == Wish::Start;
        match self.state {
            State::Streaming if self.wanted => self.events.push(Event::Ready),
            State::Closed | State::Abandoned => {}
            _ => self.follow_wish(now),
        }
    }
}

/// Time after which a stream that was refused, or has stopped, is asked for again.
const RESTART: Duration = Duration::from_millis(250);

/// Most codes of errors that a message lists.
const CODES: usize = 8;
