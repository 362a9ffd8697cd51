//! The device as a state machine.
//!
//! ```text
//!            connected                    answers, format              Start             answer
//! Closed ──────────────▶ Setup ─────────────────────────────▶ Idle ──────────▶ Starting ───────▶ Streaming
//!                          │                                    ▲                                    │ Stop
//!                          │                                    └──────────── Stopping ◀─────────────┘
//!                          ├─ refused ──────────▶ Refused, until the next Start
//!                          └─ no answer twice ──▶ Abandoned, until the connection is new; also from Streaming,
//!                             when what arrives gives no reading for too long
//! ```
//!
//! Data refer to a format by its counter. Data of a format that did not come, or that gives no readings, are counted, and
//! `SODX` is sent again: its answer is followed by the format (CR, packet protocol).

use std::collections::VecDeque;
use std::fmt::Display;

use asphera_link::{
    Channel, Command as Wish, Driver, Event, Events, FaultKind, Input, Nanos, Output, Reading,
    millis,
};

use super::formats::Formats;
use super::framing::{Framing, Packet};
use super::order::{FULL_SCALE, Order, full_scale_um, words};
use super::settings::PacketSettings;
use super::talk::{State, Talk, Topic};
use crate::decode::DeviceClock;
use crate::error::Error;
use crate::settings::{ATTEMPTS, Trigger};
use crate::wire::packet::{CommandFlags, Data, Format, Kind, Message};

/// Bytes without a reading after which the device cannot be sending what it was set up for.
const MOST_DISCARDED: u64 = 65_536;

/// Why data of a format that did not come give no readings, and the cure.
const UNKNOWN: &str = "it did not come, and is asked for";

/// The stream of measurements.
const MEASUREMENTS: u32 = 1;

/// Driver of a CHRocodile over the packet protocol, TCP port 7891.
///
/// Readings hold the channels of [`PacketSettings::channels`], and for a line the profile of its points. The exposure
/// count becomes [`Reading::count`], the exposure flags [`Reading::flags`], the start time [`Reading::device_time_ns`].
#[derive(Debug)]
pub struct PacketChrocodile {
    settings: PacketSettings,
    channels: Vec<Channel>,
    setup: Vec<Order>,
    wanted: bool,
    state: State,
    talk: Option<Talk>,
    ticket: u16,
    framing: Framing,
    formats: Formats,
    full_scale_um: f64,
    clock: DeviceClock,
    last_data: Nanos,
    /// Bytes passed over since the last reading or start.
    discarded: u64,
    /// Whether it was said why data give no readings, since the last reading.
    troubled: bool,
    outputs: VecDeque<Output>,
    events: Events,
}

impl PacketChrocodile {
    /// A driver with these settings, or what is wrong with them.
    pub fn new(settings: PacketSettings) -> Result<PacketChrocodile, Error> {
        let problems = settings.problems();
        if !problems.is_empty() {
            return Err(Error::Settings(problems));
        }
        Ok(PacketChrocodile {
            channels: settings.channels(),
            setup: Order::setup(&settings),
            settings,
            wanted: false,
            state: State::Closed,
            talk: None,
            ticket: 0,
            framing: Framing::default(),
            formats: Formats::default(),
            full_scale_um: 0.0,
            clock: DeviceClock::default(),
            last_data: Nanos::ZERO,
            discarded: 0,
            troubled: false,
            outputs: VecDeque::new(),
            events: Events::default(),
        })
    }

    fn say(&mut self, now: Nanos, topic: Topic, attempt: u8) {
        let order = match topic {
            Topic::Setup(index) => self.setup[index].clone(),
            Topic::Start => Order::Start,
            Topic::Stop => Order::Stop,
            Topic::Format => Order::Output(self.settings.signals.clone()),
        };
        // 0 is the ticket of updates.
        self.ticket = self.ticket % u16::MAX + 1;
        self.outputs.push_back(Output::Bytes(order.encode(self.ticket)));
        self.talk = Some(Talk {
            topic,
            order,
            ticket: self.ticket,
            attempt,
            deadline: now + millis(self.settings.ready_timeout_ms),
            answered: false,
            format: Err(None),
        });
    }

    /// Goes on until the bytes received tell nothing more.
    fn proceed(&mut self, now: Nanos) {
        while self.state != State::Abandoned
            && let Some(packet) = self.framing.next()
        {
            match packet.kind {
                Kind::Data => self.take_data(now, &packet),
                Kind::Command => match Message::decode(self.framing.body(&packet)) {
                    Some(message) => self.take_message(now, &message),
                    None => self.framing.refuse(&packet),
                },
                Kind::Format => self.take_format(now, &packet),
                Kind::Other(_) => self.framing.refuse(&packet),
            }
        }
        if self.state == State::Abandoned {
            self.framing.abandon();
        }
        if let Some(trouble) = self.framing.take_trouble() {
            self.events.fault(FaultKind::Protocol, format!("bytes that are no packet, {trouble}: check that the port is that of packets, 7891"));
        }
        self.report_discarded();
        if self.takes_data() && self.discarded > MOST_DISCARDED {
            let detail = format!(
                "{} bytes without a sample as set up: check that no other host sets the device up",
                self.discarded
            );
            self.give_up(FaultKind::Protocol, detail);
        }
    }

    /// Whether data that arrive are those that were started.
    fn takes_data(&self) -> bool {
        matches!(self.state, State::Starting | State::Streaming | State::Stopping)
    }

    fn take_data(&mut self, now: Nanos, packet: &Packet) {
        if !self.takes_data() {
            self.framing.refuse(packet);
            return;
        }
        match self.release(now, packet) {
            Ok(()) => (self.discarded, self.troubled, self.last_data) = (0, false, now),
            Err(trouble) => {
                self.framing.refuse(packet);
                if let Some(trouble) = trouble.filter(|_| !self.troubled) {
                    self.events.fault(FaultKind::Protocol, trouble);
                    self.troubled = true;
                }
                if self.troubled && self.talk.is_none() {
                    self.say(now, Topic::Format, 1);
                }
            }
        }
    }

    /// Gives a reading for each sample; else why there is none, or `None` for another stream.
    fn release(&mut self, now: Nanos, packet: &Packet) -> Result<(), Option<String>> {
        let data = Data::decode(self.framing.body(packet)).map_err(|error| error.to_string())?;
        if data.stream != MEASUREMENTS {
            return Err(None);
        }
        let counter = data.counter;
        let trouble = |error: &dyn Display| format!("data of the format {counter}: {error}");
        let known = self.formats.get(counter).ok_or_else(|| trouble(&UNKNOWN))?;
        let plan = known.plan.as_ref().map_err(|error| trouble(error))?;
        let samples = data.split(plan.sample_len).map_err(|error| trouble(&error))?;
        let rate_hz = f64::from(known.format.sample_rate_hz);
        let period_ns = (self.settings.times_samples() && rate_hz > 0.0).then(|| 1e9 / rate_hz);
        let first_ns = data.time_ns();
        for (row, sample) in (0_u32..).zip(samples) {
            let decoded = plan.decode(sample);
            let by_packet = period_ns.map(|period_ns| {
                first_ns.saturating_add((f64::from(row) * period_ns).round() as u64)
            });
            let start_ns = decoded.start_ns.map(|start_ns| self.clock.unwrap(start_ns, now));
            self.events.push(Event::Reading(Reading {
                host: now,
                device_time_ns: start_ns.or(by_packet),
                count: decoded.count,
                values: decoded.values,
                flags: decoded.flags,
            }));
        }
        Ok(())
    }

    fn take_format(&mut self, now: Nanos, packet: &Packet) {
        let format = match Format::decode(self.framing.body(packet)) {
            Ok(format) if format.stream == MEASUREMENTS => format,
            Ok(_) => {
                self.framing.refuse(packet);
                return;
            }
            Err(error) => {
                self.framing.refuse(packet);
                self.events.fault(FaultKind::Protocol, error.to_string());
                return;
            }
        };
        let known = self.formats.insert(format, &self.settings, self.full_scale_um);
        let outcome = known.plan.as_ref().map(|_| ()).map_err(|error| Some(error.to_string()));
        if let Some(talk) = &mut self.talk {
            talk.format = outcome;
            self.conclude(now);
        }
    }

    fn take_message(&mut self, now: Nanos, message: &Message) {
        if message.flags.contains(CommandFlags::UPDATE) {
            // Another host, or a hand at the device, has changed the probe.
            let scale_um = (message.name == FULL_SCALE).then(|| full_scale_um(message)).flatten();
            if let Some(scale_um) = scale_um.filter(|_| self.settings.scale_um.is_none()) {
                self.set_full_scale(scale_um);
            }
            return;
        }
        // Other answers are late ones, of commands that were repeated.
        let is_answer = |talk: &Talk| {
            !talk.answered && (talk.ticket, talk.order.name()) == (message.ticket, message.name)
        };
        let Some(talk) = self.talk.as_mut().filter(|talk| is_answer(talk)) else { return };
        talk.answered = true;
        let (topic, order) = (talk.topic, talk.order.clone());
        self.events.prove_online();
        if message.flags.contains(CommandFlags::ERROR) {
            self.refused(
                topic,
                &order,
                &format!("refused, the answer was {}; see the command reference", words(message)),
            );
            return;
        }
        if message.flags.contains(CommandFlags::WARNING) {
            let detail = format!(
                "{}: done with a warning, {}; see the command reference",
                order.name(),
                words(message)
            );
            self.events.fault(FaultKind::Device, detail);
        }
        if order == Order::AskFullScale {
            match full_scale_um(message) {
                Some(scale_um) => self.set_full_scale(scale_um),
                None => {
                    let detail = format!(
                        "expected the full scale in µm, found {}: set scale_um",
                        words(message)
                    );
                    self.refused(topic, &order, &detail);
                    return;
                }
            }
        }
        self.conclude(now);
    }

    /// Goes on with the next command, where the last one has its answer and, for the signals, their format.
    fn conclude(&mut self, now: Nanos) {
        let Some(talk) = &self.talk else { return };
        let needs_format = matches!(talk.order, Order::Output(_));
        if !talk.answered || (needs_format && talk.format.is_err()) {
            return;
        }
        let topic = talk.topic;
        self.talk = None;
        match topic {
            Topic::Setup(index) if index + 1 < self.setup.len() => {
                self.say(now, Topic::Setup(index + 1), 1);
            }
            Topic::Setup(_) | Topic::Stop => self.state = State::Idle,
            Topic::Start => {
                self.state = State::Streaming;
                (self.last_data, self.discarded, self.troubled) = (now, 0, false);
                self.events.push(Event::Ready);
            }
            Topic::Format => {}
        }
        self.follow_wish(now);
    }

    /// Starts or stops the data where they are not as they are wanted.
    fn follow_wish(&mut self, now: Nanos) {
        if self.talk.is_some() {
            return;
        }
        match self.state {
            State::Idle if self.wanted => {
                self.state = State::Starting;
                self.say(now, Topic::Start, 1);
            }
            State::Streaming if !self.wanted => {
                self.state = State::Stopping;
                self.say(now, Topic::Stop, 1);
            }
            _ => {}
        }
    }

    fn set_full_scale(&mut self, full_scale_um: f64) {
        self.full_scale_um = full_scale_um;
        self.formats.rescale(&self.settings, full_scale_um);
    }

    fn refused(&mut self, topic: Topic, order: &Order, why: &str) {
        let detail = format!("{}: {why}", order.name());
        if topic == Topic::Format {
            // The data go on, and nobody can read them.
            self.give_up(FaultKind::Refused, detail);
            return;
        }
        self.events.fault(FaultKind::Refused, detail);
        (self.talk, self.state) = (None, State::Refused);
    }

    /// The answer, or the format behind it, is overdue.
    fn unanswered(&mut self, now: Nanos, talk: &Talk) {
        if talk.attempt < ATTEMPTS {
            self.say(now, talk.topic, talk.attempt + 1);
            return;
        }
        if let (true, Err(Some(why))) = (talk.answered, &talk.format) {
            let detail = format!("the format that came gives no readings: {why}");
            self.refused(talk.topic, &talk.order, &detail);
            return;
        }
        let what = if talk.answered { "no format after" } else { "no answer to" };
        let (name, ms) = (talk.order.name(), self.settings.ready_timeout_ms);
        let detail = format!(
            "{what} {name} within {ms} ms, asked {ATTEMPTS} times: check cable and power, and that the port is that of packets, 7891"
        );
        self.give_up(FaultKind::Timeout, detail);
    }

    fn give_up(&mut self, kind: FaultKind, detail: String) {
        (self.talk, self.state) = (None, State::Abandoned);
        self.events.reopen(kind, detail);
    }

    fn report_discarded(&mut self) {
        let bytes = self.framing.take_discarded();
        self.discarded += bytes;
        self.events.discarded(bytes);
    }

    /// When a free-running device has been silent for too long.
    fn gap_due(&self) -> Option<Nanos> {
        (self.state == State::Streaming && self.settings.trigger == Trigger::Free)
            .then(|| self.last_data + self.settings.longest_gap())
    }
}

impl Driver for PacketChrocodile {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.framing = Framing::default();
        self.formats.clear();
        self.outputs.clear();
        self.events.clear();
        self.events.restart();
        (self.ticket, self.last_data) = (0, now);
        (self.discarded, self.troubled) = (0, false);
        self.clock = DeviceClock::default();
        self.full_scale_um = self.settings.scale_um.unwrap_or(0.0);
        self.state = State::Setup;
        self.say(now, Topic::Setup(0), 1);
    }

    fn disconnected(&mut self, _now: Nanos) {
        self.framing.abandon();
        self.report_discarded();
        self.outputs.clear();
        (self.talk, self.state) = (None, State::Closed);
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Bytes(bytes) = input else { return };
        if self.state == State::Closed || bytes.is_empty() {
            return;
        }
        self.framing.receive(bytes);
        self.proceed(now);
    }

    fn timeout(&mut self, now: Nanos) {
        if self.gap_due().is_some_and(|due| due <= now) {
            let gap_ms = now.since(self.last_data).as_millis();
            let detail =
                format!("no data for {gap_ms} ms though free-running: check cable and power");
            self.give_up(FaultKind::Timeout, detail);
        }
        if let Some(talk) = self.talk.take_if(|talk| talk.deadline <= now) {
            self.unanswered(now, &talk);
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        let deadline = self.talk.as_ref().map(|talk| talk.deadline);
        [deadline, self.gap_due()].into_iter().flatten().min()
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
            State::Refused if self.wanted => {
                self.state = State::Setup;
                self.say(now, Topic::Setup(0), 1);
            }
            _ => self.follow_wish(now),
        }
    }
}
