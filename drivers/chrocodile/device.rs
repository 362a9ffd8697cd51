//! The device as a state machine.
//!
//! ```text
//!            connected                       ready              Start          ready
//! Closed ──────────────▶ Talking(Setup) ─────────────▶ Idle ──────────▶ Talking ─────▶ Streaming
//!                              │                         ▲                                │ Stop
//!                              │                         └──────────── Talking ◀──────────┘
//!                              ├─ refused twice ────▶ Refused, until the next Start
//!                              └─ no answer twice ──▶ Abandoned, until the connection is new; also
//!                                 from Streaming, when what arrives is no telegram for too long
//! ```
//!
//! Set-up stops the data first (`STO`), so that no telegram of another format can follow it; chooses
//! binary and the signals, then rate, averaging and trigger mode, and asks for the full scale last,
//! because the probe's is meant that is in use then. The data are started alone (`STA`), when a scan
//! is wanted: both commands concern this connection only (Command Reference, STA and STO).

use std::collections::VecDeque;
use std::ops::Range;

use asphera_link::{
    Channel, Command as Wish, Driver, Event, Events, FaultKind, Flags, Input, Nanos, Output,
    Reading, millis,
};

use crate::decode::{Decoded, DeviceClock, Plan};
use crate::error::Error;
use crate::framing::{Found, Framing};
use crate::settings::{ATTEMPTS, Settings, Trigger};
use crate::wire::{Command, Layout, NOT_VALID};
use crate::words::{is_full_scale, shortened};

/// Bytes without a telegram among them after which the device cannot be sending what it was set up for:
/// it may have restarted. More than any disturbance that passes.
const MOST_DISCARDED: u64 = 16_384;

/// Driver of a CHRocodile 2 and its relatives over the dollar protocol.
///
/// The same bytes run over a serial port and over TCP port 7890. Readings hold the channels of
/// [`Settings::channels`]; the exposure count becomes [`Reading::count`], the exposure flags
/// [`Reading::flags`], and the start time [`Reading::device_time_ns`].
#[derive(Debug)]
pub struct Chrocodile {
    settings: Settings,
    channels: Vec<Channel>,
    layout: Layout,
    setup: Vec<Command>,
    wanted: bool,
    state: State,
    framing: Framing,
    plan: Option<Plan>,
    clock: DeviceClock,
    last_receipt: Nanos,
    /// Bytes passed over since the last telegram or start.
    discarded: u64,
    /// When a silence is due, while bytes wait for confirmation.
    silence_due: Option<Nanos>,
    outputs: VecDeque<Output>,
    events: Events,
}

#[derive(Clone, Debug, PartialEq)]
enum State {
    /// No connection.
    Closed,
    /// A command was sent.
    Talking(Talk),
    /// Set up; no data.
    Idle,
    /// Data arrive when they are triggered.
    Streaming,
    /// The device refused a command; a start tries the set-up again.
    Refused,
    /// The connection is to be opened anew.
    Abandoned,
}

/// A command that waits for its answer.
#[derive(Clone, Debug, PartialEq)]
struct Talk {
    topic: Topic,
    command: Command,
    echo: Vec<u8>,
    attempt: u8,
    deadline: Nanos,
    echoed: bool,
}

/// What a command is sent for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Topic {
    /// The command of this index of the set-up.
    Setup(usize),
    Start,
    /// The only one during which telegrams may stand before the echo.
    Stop,
}

impl Chrocodile {
    /// A driver with these settings, or what is wrong with them.
    pub fn new(settings: Settings) -> Result<Chrocodile, Error> {
        let problems = settings.problems();
        if !problems.is_empty() {
            return Err(Error::Settings(problems));
        }
        let layout = Layout::new(settings.sync, &settings.signals)
            .expect("settings without problems have known signals only");
        Ok(Chrocodile {
            channels: settings.channels(),
            framing: Framing::new(&layout, settings.averaging, settings.sample_rate_hz),
            layout,
            setup: setup(&settings),
            settings,
            wanted: false,
            state: State::Closed,
            plan: None,
            clock: DeviceClock::default(),
            last_receipt: Nanos::ZERO,
            discarded: 0,
            silence_due: None,
            outputs: VecDeque::new(),
            events: Events::default(),
        })
    }

    fn say(&mut self, now: Nanos, topic: Topic, attempt: u8) {
        let command = match topic {
            Topic::Setup(index) => self.setup[index].clone(),
            Topic::Start => Command::Start,
            Topic::Stop => Command::Stop,
        };
        self.outputs.push_back(Output::Bytes(command.encode()));
        let echo = command.text().into_bytes();
        let deadline = now + millis(self.settings.ready_timeout_ms);
        self.state =
            State::Talking(Talk { topic, command, echo, attempt, deadline, echoed: false });
    }

    /// Goes on until the bytes received tell nothing more.
    fn proceed(&mut self, now: Nanos) {
        loop {
            match &mut self.state {
                State::Closed | State::Idle | State::Refused | State::Abandoned => {
                    self.framing.discard_all();
                    break;
                }
                State::Streaming => match self.framing.next(None) {
                    Found::Telegram { at, arrival, suspect } => self.release(at, arrival, suspect),
                    Found::Echo | Found::Nothing => break,
                },
                State::Talking(talk) if talk.echoed => match self.framing.take_answer() {
                    None => break,
                    Some(Ok(text)) => {
                        let talk = talk.clone();
                        self.answered(now, talk, &text);
                    }
                    Some(Err(_)) => {
                        let detail = format!(
                            "the answer to {} does not end: check the baud rate",
                            talk.command.text()
                        );
                        self.give_up(FaultKind::Protocol, detail);
                    }
                },
                State::Talking(talk) if talk.topic == Topic::Stop => {
                    match self.framing.next(Some(&talk.echo)) {
                        Found::Telegram { at, arrival, suspect } => {
                            self.release(at, arrival, suspect);
                        }
                        Found::Echo => talk.echoed = true,
                        Found::Nothing => break,
                    }
                }
                State::Talking(talk) => {
                    if !self.framing.skip_to_echo(&talk.echo) {
                        break;
                    }
                    talk.echoed = true;
                }
            }
        }
        self.report_discarded();
        if self.state == State::Streaming && self.discarded > MOST_DISCARDED {
            let detail = format!(
                "{} bytes without a telegram as set up: check cable and baud rate",
                self.discarded
            );
            self.give_up(FaultKind::Protocol, detail);
        }
        self.silence_due = (self.is_streaming() && self.framing.is_waiting())
            .then(|| self.last_receipt + millis(self.settings.silence_ms));
    }

    fn answered(&mut self, now: Nanos, talk: Talk, text: &str) {
        self.report_discarded();
        self.events.prove_online();
        let is_accepted = match talk.command {
            Command::AskFullScale => match full_scale(text) {
                Some(full_scale_um) => {
                    self.set_full_scale(full_scale_um);
                    true
                }
                None => false,
            },
            _ => text.is_empty(),
        };
        if !is_accepted {
            self.refused(now, &talk, text);
            return;
        }
        match talk.topic {
            Topic::Setup(index) if index + 1 < self.setup.len() => {
                self.say(now, Topic::Setup(index + 1), 1);
                return;
            }
            Topic::Setup(_) | Topic::Stop => self.state = State::Idle,
            Topic::Start => {
                self.state = State::Streaming;
                self.framing.begin();
                self.last_receipt = now;
                self.discarded = 0;
                self.events.push(Event::Ready);
            }
        }
        self.follow_wish(now);
    }

    /// Starts or stops the data where they are not as they are wanted.
    fn follow_wish(&mut self, now: Nanos) {
        match self.state {
            State::Idle if self.wanted => self.say(now, Topic::Start, 1),
            State::Streaming if !self.wanted => self.say(now, Topic::Stop, 1),
            _ => {}
        }
    }

    fn set_full_scale(&mut self, full_scale_um: f64) {
        self.plan = Some(Plan::new(&self.layout, full_scale_um, self.settings.intensity_min));
    }

    /// A command damaged on the way is refused as well, hence the second attempt.
    fn refused(&mut self, now: Nanos, talk: &Talk, text: &str) {
        if talk.attempt < ATTEMPTS {
            self.say(now, talk.topic, talk.attempt + 1);
            return;
        }
        // Signs that no device means to send take several each when they are written.
        let written = format!("{text:?}");
        let message = shortened(&written);
        let reason = if text.contains(NOT_VALID) { "the value is not accepted" } else { "refused" };
        let cure = "see the command reference for what this device can do";
        let detail = format!("{}: {reason}, the answer was {message}; {cure}", talk.command.text());
        self.events.fault(FaultKind::Refused, detail);
        self.state = State::Refused;
    }

    fn unanswered(&mut self, now: Nanos, talk: &Talk) {
        if talk.attempt < ATTEMPTS {
            self.say(now, talk.topic, talk.attempt + 1);
            return;
        }
        let what = if talk.echoed { "answer" } else { "echo" };
        let detail = format!(
            "no {what} to {} within {} ms, asked {ATTEMPTS} times: check cable, power, baud rate and protocol",
            talk.command.text(),
            self.settings.ready_timeout_ms
        );
        self.give_up(FaultKind::Timeout, detail);
    }

    fn give_up(&mut self, kind: FaultKind, detail: String) {
        self.state = State::Abandoned;
        self.events.reopen(kind, detail);
    }

    fn release(&mut self, at: Range<usize>, arrival: Nanos, suspect: bool) {
        self.report_discarded();
        self.discarded = 0;
        let plan = self.plan.as_ref().expect("the set-up ends with a known full scale");
        let decoded = plan.decode(self.framing.bytes(at));
        let mut flags = decoded.flags;
        flags.set(Flags::SUSPECT, suspect);
        let device_time_ns = decoded.start_ns.map(|start_ns| {
            if suspect {
                self.clock.peek(start_ns, arrival)
            } else {
                self.clock.unwrap(start_ns, arrival)
            }
        });
        let Decoded { count, values, .. } = decoded;
        let reading = Reading { host: arrival, device_time_ns, count, values, flags };
        self.events.push(Event::Reading(reading));
    }

    fn report_discarded(&mut self) {
        let bytes = self.framing.take_discarded();
        self.discarded += bytes;
        self.events.discarded(bytes);
    }

    fn is_streaming(&self) -> bool {
        match &self.state {
            State::Streaming => true,
            State::Talking(talk) => talk.topic == Topic::Stop && !talk.echoed,
            State::Closed | State::Idle | State::Refused | State::Abandoned => false,
        }
    }

    /// When a free-running device has been silent for too long.
    fn gap_due(&self) -> Option<Nanos> {
        (self.state == State::Streaming && self.settings.trigger == Trigger::Free)
            .then(|| self.last_receipt + self.settings.longest_gap())
    }
}

impl Driver for Chrocodile {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.framing.reset();
        self.outputs.clear();
        self.events.clear();
        self.events.restart();
        self.plan = None;
        self.clock = DeviceClock::default();
        self.last_receipt = now;
        self.silence_due = None;
        if let Some(full_scale_um) = self.settings.scale_um {
            self.set_full_scale(full_scale_um);
        }
        self.say(now, Topic::Setup(0), 1);
    }

    fn disconnected(&mut self, _now: Nanos) {
        self.framing.abandon();
        self.report_discarded();
        self.framing.reset();
        self.outputs.clear();
        self.silence_due = None;
        self.state = State::Closed;
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Bytes(bytes) = input else { return };
        if self.state == State::Closed || bytes.is_empty() {
            return;
        }
        self.framing.receive(now, bytes);
        self.last_receipt = now;
        self.proceed(now);
    }

    fn timeout(&mut self, now: Nanos) {
        if self.silence_due.is_some_and(|due| due <= now) {
            self.framing.silence();
            self.proceed(now);
            // A telegram that is still incomplete waits for bytes, not for another silence.
            self.silence_due = None;
        }
        if self.gap_due().is_some_and(|due| due <= now) {
            let gap_ms = now.since(self.last_receipt).as_millis();
            let detail =
                format!("no data for {gap_ms} ms though free-running: check cable and power");
            self.give_up(FaultKind::Timeout, detail);
        }
        if let State::Talking(talk) = &self.state
            && talk.deadline <= now
        {
            let talk = talk.clone();
            self.unanswered(now, &talk);
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        let deadline = match &self.state {
            State::Talking(talk) => Some(talk.deadline),
            _ => None,
        };
        [deadline, self.silence_due, self.gap_due()].into_iter().flatten().min()
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
            State::Refused if self.wanted => self.say(now, Topic::Setup(0), 1),
            _ => self.follow_wish(now),
        }
    }
}

/// The commands of the set-up, in order.
fn setup(settings: &Settings) -> Vec<Command> {
    let mut commands = vec![
        Command::Stop,
        Command::Binary,
        Command::Output(settings.signals.clone()),
        Command::SampleRate(settings.sample_rate_hz),
        Command::Averaging(settings.averaging),
        match settings.trigger {
            Trigger::Free => Command::FreeRun,
            Trigger::Each => Command::TriggerEach,
        },
    ];
    if settings.scale_um.is_none() {
        commands.push(Command::AskFullScale);
    }
    commands
}

/// The full scale in µm that an answer to `SCA ?` names: its last word.
fn full_scale(text: &str) -> Option<f64> {
    text.split_whitespace().next_back()?.parse().ok().filter(is_full_scale)
}
