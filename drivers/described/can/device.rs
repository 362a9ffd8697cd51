//! The device on the bus as a state machine.

use std::collections::VecDeque;

use asphera_link::{
    Asking, AskingStep, CanFrame, Channel, Command, Driver, Event, Events, FaultKind, Input, Nanos,
    Output, Problem, Unanswered, millis,
};

use super::{CanPoll, CanSettings};
use crate::assemble::{Assembled, Assembler};
use crate::field::{Field, Place};
use crate::framing::Framing;
use crate::number::{ByteOrder, Form};
use crate::settings::{Layout, Settings};

/// A device on a CAN bus, described by [`CanSettings`].
///
/// ```text
///         connected
/// Closed ───────────▶ Listening │ Polling
///    ▲                                │
///    └─────── no answer five times ───┘
/// ```
///
/// A device that is polled is asked by the rules of [`Asking`].
/// CAN checks each frame, so that a frame of the right identifier, kind and length is believed. An answer does not say
/// which question it belongs to: after a time-out nothing is asked until no frame came for
/// [`late_limit_ms`](CanPoll::late_limit_ms). The first answer of a connection may belong to a question of the one before;
/// it proves that the device is there, and gives no reading.
#[derive(Debug)]
pub struct CanGauge {
    settings: CanSettings,
    channels: Vec<Channel>,
    assembler: Assembler,
    state: State,
    asking: Asking,
    wanted: bool,
    /// The next answer is not to be trusted with values.
    confirm: bool,
    /// The last frame was no reading; the first of a run is worth a message.
    muddled: bool,
    in_trouble: bool,
    last_frame: Nanos,
    outputs: VecDeque<CanFrame>,
    events: Events,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    /// No connection, or none to be trusted.
    Closed,
    /// The device sends by itself.
    Listening,
    /// The device is asked.
    Polling,
}

impl CanGauge {
    /// A driver for the device.
    ///
    /// # Errors
    ///
    /// [`CanSettings::problems`], when there are any.
    pub fn new(settings: CanSettings) -> Result<CanGauge, Vec<Problem>> {
        let problems = settings.problems();
        if !problems.is_empty() {
            return Err(problems);
        }
        Ok(CanGauge {
            channels: settings.channels(),
            assembler: assembler(&settings),
            state: State::Closed,
            asking: Asking::new(settings.poll.map(|poll| poll.pace()).unwrap_or_default()),
            wanted: false,
            confirm: false,
            muddled: false,
            in_trouble: false,
            last_frame: Nanos::ZERO,
            outputs: VecDeque::new(),
            events: Events::default(),
            settings,
        })
    }

    /// Why a frame of the device's identifier is no reading.
    fn unreadable(&self, frame: &CanFrame) -> Option<String> {
        let found = frame.data().len();
        let needed = self.settings.needed_bytes();
        if frame.fd().is_some() != self.settings.fd {
            let (found, cure) = match self.settings.fd {
                true => ("a classic frame", "fd = false"),
                false => ("a CAN FD frame", "fd = true"),
            };
            return Some(format!("{frame:?} is {found}: set {cure}, or check the device"));
        }
        match self.settings.length {
            Some(length) if found != length => Some(format!(
                "{frame:?} has {found} bytes, expected {length}: check identifier and length"
            )),
            _ if found < needed => Some(format!(
                "{frame:?} has {found} bytes, the fields need {needed}: check identifier and fields"
            )),
            _ => None,
        }
    }

    /// Takes a frame of the device.
    fn frame(&mut self, now: Nanos, frame: &CanFrame) {
        if let Some(detail) = self.unreadable(frame) {
            self.discard(frame);
            if !std::mem::replace(&mut self.muddled, true) {
                self.events.fault(FaultKind::Protocol, detail);
            }
            return;
        }
        let is_awaited = match self.state {
            State::Closed => false,
            State::Listening => true,
            State::Polling => matches!(self.asking.step(), AskingStep::Asking { .. }),
        };
        if !is_awaited {
            // Nothing was asked: what comes is late, or not meant for us.
            self.discard(frame);
            self.asking.disturbed(now);
            return;
        }
        // Fields lie one behind the other, as numbers of eight bytes.
        let numbers = self.settings.fields.iter().map(|field| field.signal.read(frame.data()));
        let body: Vec<u8> =
            numbers.flat_map(|number| number.unwrap_or(f64::NAN).to_be_bytes()).collect();
        match self.assembler.reading(now, &body) {
            Ok(assembled) => self.read(now, assembled),
            // Each channel of a frame that is long enough holds a number.
            Err(_) => self.discard(frame),
        }
    }

    fn read(&mut self, now: Nanos, Assembled { reading, trouble }: Assembled) {
        self.last_frame = now;
        self.muddled = false;
        self.events.prove_online();
        let was_in_trouble = std::mem::replace(&mut self.in_trouble, trouble.is_some());
        if let Some(trouble) = trouble.filter(|_| !was_in_trouble) {
            self.events.fault(FaultKind::Device, format!("the device reports {trouble}"));
        }
        if !self.confirm {
            self.events.push(Event::Reading(reading));
            self.events.prove_ready();
        }
        if self.state == State::Polling {
            self.asking.answered();
            match std::mem::take(&mut self.confirm) {
                true => self.asking.settle(now),
                false => {
                    self.asking.wait(now);
                }
            }
        }
    }

    fn unanswered(&mut self, now: Nanos, poll: &CanPoll) {
        let detail = format!(
            "no answer to {:?} within {} ms: check power, wiring and identifiers, or increase timeout_ms",
            poll.ask, poll.timeout_ms
        );
        match self.asking.unanswered(now) {
            Unanswered::GiveUp => self.abandon(detail),
            Unanswered::Settle => self.events.fault(FaultKind::Timeout, detail),
        }
    }

    fn abandon(&mut self, detail: String) {
        self.outputs.clear();
        self.asking.stop();
        self.state = State::Closed;
        self.events.reopen(FaultKind::Timeout, detail);
    }

    fn discard(&mut self, frame: &CanFrame) {
        self.events.discarded(frame.data().len() as u64);
    }

    /// When a device that sends by itself has been silent for too long.
    fn gap_due(&self) -> Option<Nanos> {
        let is_watched = self.settings.gap_ms > 0 && self.events.is_online();
        is_watched.then(|| self.last_frame + millis(self.settings.gap_ms))
    }
}

impl Driver for CanGauge {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.events.restart();
        self.asking.stop();
        (self.muddled, self.in_trouble) = (false, false);
        self.outputs.clear();
        self.outputs.extend(self.settings.on_connect.iter().copied());
        if self.wanted {
            self.outputs.extend(self.settings.on_start.iter().copied());
        }
        self.confirm = self.settings.poll.is_some();
        match self.settings.poll {
            None => self.state = State::Listening,
            Some(poll) => {
                self.outputs.push_back(poll.ask);
                self.asking.restart(now);
                self.state = State::Polling;
            }
        }
    }

    fn disconnected(&mut self, _: Nanos) {
        self.outputs.clear();
        self.asking.stop();
        self.state = State::Closed;
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Frame(frame) = input else { return };
        if !frame.is_remote() && self.settings.is_own(frame.id()) {
            self.frame(now, frame);
        }
    }

    fn timeout(&mut self, now: Nanos) {
        if self.poll_timeout().is_none_or(|due| now < due) {
            return;
        }
        match (self.state, self.settings.poll) {
            (State::Polling, Some(poll)) => match self.asking.step() {
                AskingStep::Off => {}
                AskingStep::Idle { .. } => {
                    self.outputs.push_back(poll.ask);
                    self.asking.ask_due(now);
                }
                AskingStep::Settling { .. } => {
                    self.outputs.push_back(poll.ask);
                    self.asking.restart(now);
                }
                AskingStep::Asking { .. } => self.unanswered(now, &poll),
            },
            (State::Listening, _) => {
                let gap_ms = now.since(self.last_frame).as_millis();
                self.abandon(format!(
                    "no frame for {gap_ms} ms: check cable and power, or increase gap_ms"
                ));
            }
            _ => {}
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        match self.state {
            State::Closed => None,
            State::Listening => self.gap_due(),
            State::Polling => self.asking.due(),
        }
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        self.outputs.pop_front().map(Output::Frame)
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, _: Nanos, command: Command) {
        self.wanted = command == Command::Start;
        if self.state != State::Closed {
            let frames = match command {
                Command::Start => &self.settings.on_start,
                Command::Stop => &self.settings.on_stop,
            };
            self.outputs.extend(frames.iter().copied());
        }
    }

    fn reads_fd(&self) -> bool {
        self.settings.fd
    }
}

/// Fields as numbers of eight bytes, one behind the other: their meaning is that of any record.
fn assembler(settings: &CanSettings) -> Assembler {
    const WIDTH: usize = 8;
    let field = |(index, meaning): (usize, &Field)| Field {
        place: Place::At(WIDTH * index),
        form: Form::Double(ByteOrder::Big),
        ..meaning.clone()
    };
    let meanings = settings.fields.iter().map(|field| &field.meaning);
    let fields: Vec<Field> = meanings.enumerate().map(field).collect();
    let length = WIDTH * fields.len();
    Assembler::new(&Settings {
        framing: Framing::Records { begin: Vec::new(), length },
        layout: Layout::Bytes,
        fields,
        ..Settings::default()
    })
}
