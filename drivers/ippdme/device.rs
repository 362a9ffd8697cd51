//! The client as a state machine.
//!
//! ```text
//!         connected                     Motion::Run                    last command complete
//! Closed ──────────▶ setting up ─▶ Ready ───────────▶ running commands ───────────────────▶ Ready
//!                                   ▲                   │ Motion::Halt, no answer
//!                                   └──── halting ◀─────┘
//! ```

mod driver;
mod halt;
mod points;
mod script;

use std::collections::VecDeque;
use std::time::Duration;

use asphera_link::{
    Channel, Event, Events, FaultKind, MotionEvent, MotionFailure, MotionTrouble, Nanos, Problem,
    shown,
};

use crate::settings::{Settings, is_measuring};
use crate::wire::{Answer, Data, Framer, Kind, ServerError, Severity, Tag};
use halt::{Halt, Outcome};
use points::Points;
use script::{Part, Step};

/// A coordinate measuring machine.
///
/// One command is under way at a time. Each answer belongs to it by its tag, or to a halt; any other ends the connection.
#[derive(Debug)]
pub struct Ippdme {
    settings: Settings,
    channels: Vec<Channel>,
    points: Points,
    framer: Framer,
    link: Link,
    /// Number of the next tag.
    next_tag: u32,
    /// Number of the next tag of a halt.
    next_event: u16,
    /// Commands that wait for their turn.
    steps: VecDeque<Step>,
    current: Option<Transaction>,
    /// Tag of a command that was given up: its end may still come.
    given_up: Option<Tag>,
    is_running: bool,
    was_aborted: bool,
    has_ended: bool,
    halt: Option<Halt>,
    outputs: VecDeque<Vec<u8>>,
    events: Events,
}

/// State of the connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Link {
    Closed,
    /// Nothing valid came yet.
    Open,
    /// The server answered.
    Online,
    /// What came cannot be trusted: all else counts as discarded.
    Distrusted,
}

/// Command under way.
#[derive(Clone, Debug, PartialEq)]
struct Transaction {
    tag: Tag,
    step: Step,
    deadline: Nanos,
    is_acknowledged: bool,
    points: u64,
    /// The worst error that the server reported.
    error: Option<ServerError>,
}

impl Ippdme {
    /// A driver for the machine.
    ///
    /// # Errors
    ///
    /// [`Settings::problems`], when there are any.
    pub fn new(settings: Settings) -> Result<Ippdme, Vec<Problem>> {
        let problems = settings.problems();
        if !problems.is_empty() {
            return Err(problems);
        }
        Ok(Ippdme {
            channels: settings.channels(),
            points: Points::new(&settings),
            framer: Framer::default(),
            link: Link::Closed,
            next_tag: 1,
            next_event: 1,
            steps: VecDeque::new(),
            current: None,
            given_up: None,
            is_running: false,
            was_aborted: false,
            has_ended: false,
            halt: None,
            outputs: VecDeque::new(),
            events: Events::default(),
            settings,
        })
    }

    /// Whether the session is set up and no command is under way.
    fn is_idle(&self) -> bool {
        self.link == Link::Online && self.current.is_none() && self.steps.is_empty()
    }

    fn forget(&mut self) {
        self.steps.clear();
        self.outputs.clear();
        (self.current, self.given_up, self.halt) = (None, None, None);
        (self.is_running, self.was_aborted, self.has_ended) = (false, false, false);
    }

    /// Sends the next command, if it is its turn.
    fn next(&mut self, now: Nanos) {
        if self.current.is_some() || self.halt.is_some() || self.link == Link::Distrusted {
            return;
        }
        let Some(step) = self.steps.pop_front() else { return };
        let tag = Tag::Number(self.next_tag);
        self.next_tag = self.next_tag % MOST_TAG + 1;
        self.outputs.push_back(line(tag, &step.text));
        let deadline = now + self.answer_time();
        let is_acknowledged = false;
        self.current =
            Some(Transaction { tag, step, deadline, is_acknowledged, points: 0, error: None });
    }

    fn take_line(&mut self, now: Nanos, line: &[u8]) {
        let bytes = line.len() as u64 + 2;
        let Some(answer) = Answer::parse(line) else {
            let detail = format!(
                "a line that is no answer of I++ DME, `{}`: check address and port of the link",
                shown(line)
            );
            self.distrust(bytes, detail);
            return;
        };
        let is_halt = |halt: &Halt| halt.tag == answer.tag;
        if self.halt.as_ref().is_some_and(is_halt) {
            self.confirm();
            if let Some(halt) = self.halt.take() {
                let outcome = halt.answered(now, &answer.kind);
                self.halt_outcome(now, outcome);
            }
        } else if self.current.as_ref().is_some_and(|current| current.tag == answer.tag) {
            self.confirm();
            self.answered(now, answer, bytes);
        } else if answer.tag == Tag::UNASKED {
            self.confirm();
            if let Kind::Error(error) = answer.kind {
                self.unasked_error(&error);
            }
        } else if !self.is_expected(&answer) {
            let tag = answer.tag;
            let detail = format!(
                "an answer with tag {tag}, which no command under way has: increase silence_s, or check that no other program uses this connection"
            );
            self.distrust(bytes, detail);
        }
    }

    /// Answers that come late and mean nothing any more: to earlier halts, and the end of a command that was given up.
    fn is_expected(&self, answer: &Answer) -> bool {
        match answer.tag {
            _ if matches!(answer.kind, Kind::Data(_)) => false,
            Tag::Event(number) => number == BRAKE || number < self.next_event,
            Tag::Number(_) => {
                self.given_up == Some(answer.tag) && answer.kind != Kind::Acknowledged
            }
        }
    }

    fn confirm(&mut self) {
        if self.link == Link::Open {
            self.link = Link::Online;
            self.events.push(Event::Online);
        }
    }

    /// Nothing more of this connection is used.
    fn distrust(&mut self, bytes: u64, detail: String) {
        self.events.push(Event::Discarded { bytes });
        self.reopen(FaultKind::Protocol, detail);
    }

    fn reopen(&mut self, kind: FaultKind, detail: String) {
        self.steps.clear();
        self.current = None;
        self.link = Link::Distrusted;
        self.events.reopen(kind, detail);
    }

    /// Takes an answer to the command under way.
    fn answered(&mut self, now: Nanos, answer: Answer, bytes: u64) {
        let silence = Duration::from_secs(self.settings.silence_s.into());
        let Some(current) = &mut self.current else { return };
        current.deadline = now + silence;
        match answer.kind {
            Kind::Acknowledged => current.is_acknowledged = true,
            Kind::Complete => self.complete(now),
            Kind::Data(data) => self.data(now, &data, bytes),
            Kind::Error(error) => {
                // `%` follows; a server that leaves it out is not waited for long.
                current.deadline = now + Duration::from_millis(self.settings.timeout_ms.into());
                let worst = current.error.as_ref().map_or(Severity::Info, |worst| worst.severity);
                if current.error.is_none() || error.severity > worst {
                    current.error = Some(error.clone());
                }
                let (kind, detail) = described(&current.step, &error);
                // A halt of ours breaks off the command: that is no fault.
                if !(error.is_abort() && self.halt.is_some()) {
                    self.events.fault(kind, detail);
                }
            }
        }
    }

    fn data(&mut self, now: Nanos, data: &Data, bytes: u64) {
        let Some(current) = &mut self.current else { return };
        let method = current.step.name().to_owned();
        if current.step.part != Part::Program || !is_measuring(&method) {
            return;
        }
        match self.points.readings(now, &method, data) {
            Ok(readings) => {
                current.points += readings.len() as u64;
                self.events.extend(readings.into_iter().map(Event::Reading));
            }
            Err(why) => {
                self.events.push(Event::Discarded { bytes });
                let cure = "the machine answers otherwise than it was asked; see its manual";
                self.events.fault(FaultKind::Protocol, format!("{why}: {cure}"));
            }
        }
    }

    /// The command under way is complete.
    fn complete(&mut self, now: Nanos) {
        let Some(done) = self.current.take() else { return };
        let error = done.error.filter(|error| error.severity >= Severity::Error);
        match (done.step.part, error) {
            (Part::SetUp, Some(error)) => {
                let (kind, detail) = described(&done.step, &error);
                self.reopen(kind, detail);
                return;
            }
            (Part::SetUp, None) if self.steps.is_empty() => self.events.push(Event::Ready),
            (Part::Program, Some(error)) if error.is_missed_point() => {
                self.steps.push_front(Step::clear());
            }
            (Part::Program, Some(error)) => {
                let (_, detail) = described(&done.step, &error);
                self.fail(&error, detail);
            }
            (Part::Program, None) => {
                if done.points == 0 && is_measuring(done.step.name()) {
                    let detail = format!(
                        "`{}` gave no point: see the machine's manual",
                        short(&done.step.text)
                    );
                    self.events.fault(FaultKind::Protocol, detail);
                }
                let is_last = !self.steps.iter().any(|step| step.part == Part::Program);
                if is_last && self.is_running && self.halt.is_none() {
                    self.is_running = false;
                    self.events.push(Event::Motion(MotionEvent::Arrived));
                }
            }
            (Part::End, _) => self.has_ended = self.steps.is_empty(),
            (Part::SetUp, None) => {}
        }
        self.next(now);
    }

    /// The program broke off: the machine stands.
    fn fail(&mut self, error: &ServerError, detail: String) {
        self.steps.retain(|step| step.part != Part::Program);
        self.was_aborted = true;
        // A halt says so itself.
        if std::mem::take(&mut self.is_running) && self.halt.is_none() {
            let failure = MotionFailure::new(trouble(error), detail);
            self.events.push(Event::Motion(MotionEvent::Failed(failure)));
        }
    }

    fn unasked_error(&mut self, error: &ServerError) {
        let ServerError { number, severity, text, .. } = error;
        let (severity, text) = (severity.digit(), short(text));
        let detail = format!(
            "the machine reports error {number:04} of severity {severity}, {text}: {}",
            error.cure()
        );
        self.events.fault(FaultKind::Device, detail.clone());
        if error.severity >= Severity::Error {
            self.fail(error, detail);
        }
    }

    fn halt(&mut self, now: Nanos, failure: Option<MotionFailure>) {
        self.steps.retain(|step| step.part != Part::Program);
        self.is_running = false;
        self.was_aborted = true;
        let tag = self.take_event_tag();
        // It goes before everything that waits.
        self.outputs.clear();
        self.outputs.push_back(line(tag, ABORT));
        self.halt = Some(Halt::sent(now, tag, self.answer_time(), failure));
    }

    fn halt_outcome(&mut self, now: Nanos, outcome: Outcome) {
        match outcome {
            Outcome::Waiting(halt) => self.halt = Some(halt),
            Outcome::Again(halt) => {
                self.outputs.push_back(line(halt.tag, ABORT));
                self.halt = Some(halt);
            }
            Outcome::Over(event) => {
                // The command it broke off is over too, whether its end came or not.
                if let Some(current) =
                    self.current.take_if(|current| current.step.part == Part::Program)
                {
                    self.given_up = Some(current.tag);
                }
                self.events.push(Event::Motion(event));
                self.next(now);
            }
        }
    }

    fn take_event_tag(&mut self) -> Tag {
        let tag = Tag::Event(self.next_event);
        self.next_event = self.next_event % (BRAKE - 1) + 1;
        tag
    }

    fn answer_time(&self) -> Duration {
        Duration::from_millis(self.settings.timeout_ms.into())
    }

    /// The command under way has had no answer in time.
    fn unanswered(&mut self, now: Nanos) {
        let Some(current) = &self.current else { return };
        if current.error.is_some() {
            self.given_up = Some(current.tag);
            self.complete(now);
            return;
        }
        let after = match current.is_acknowledged {
            true => format!("{} s", self.settings.silence_s),
            false => format!("{} ms", self.settings.timeout_ms),
        };
        let cure = "check the machine and its controller";
        let command = short(&current.step.text);
        let detail = format!("no answer to `{command}` for {after}: {cure}");
        if current.step.part == Part::Program {
            self.given_up = Some(current.tag);
            self.current = None;
            let failure = MotionFailure::new(MotionTrouble::Unanswered, detail);
            self.halt(now, Some(failure));
        } else {
            self.reopen(FaultKind::Timeout, detail);
        }
    }
}

/// A line to the server.
fn line(tag: Tag, text: &str) -> Vec<u8> {
    format!("{tag} {text}\r\n").into_bytes()
}

/// Kind and sentence of an error of a command.
fn described(step: &Step, error: &ServerError) -> (FaultKind, String) {
    let kind = match step.part {
        Part::Program => FaultKind::Device,
        Part::SetUp | Part::End => FaultKind::Refused,
    };
    let ServerError { number, severity, .. } = error;
    let (command, text, cure) = (short(&step.text), short(&error.text), error.cure());
    let detail = format!(
        "the machine reports error {number:04} of severity {} to `{command}`, {text}: {cure}",
        severity.digit()
    );
    (kind, detail)
}

/// A text as a message shows it.
fn short(text: &str) -> String {
    const LONGEST: usize = 120;
    let mut short: String = text.chars().take(LONGEST).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}

/// Kind of the failure of a program.
fn trouble(error: &ServerError) -> MotionTrouble {
    match error.number {
        6 | 500 => MotionTrouble::Interrupted,
        501..=510 => MotionTrouble::Refused,
        1008 | 2500 => MotionTrouble::Limit,
        1005 | 2501 | 2502 => MotionTrouble::Unreferenced,
        1001 | 2001 | 2504 => MotionTrouble::Stalled,
        _ => MotionTrouble::Device,
    }
}

/// The command that halts the machine.
const ABORT: &str = "AbortE()";
/// Largest tag; the next is 1 again.
const MOST_TAG: u32 = 99_999;
/// Tag of the halt that is sent past the state machine; others count below it.
const BRAKE: u16 = 9999;
