//! The state machine of one node.

mod cycle;
mod listening;
mod setup;

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::time::Duration;

use asphera_link::{
    CanFrame, Channel, Command, Count, Driver, Event, Events, Fault, FaultKind, Flags, Input,
    Nanos, Output, Problem, Reading, Values,
};

use crate::wire::{
    AbortCode, AreaState, Cob, Emergency, NmtCommand, NmtRequest, NmtState, NodeId, Position,
    SdoRequest, SdoResponse, TpdoLayout, object,
};
use crate::{Kind, Settings, Transmission};
use cycle::Cycle;
use setup::{Learned, Progress, Setup};

/// Driver of one node on a bus it may share with others.
///
/// ```text
///            ┌──────────── silent, refused ──────────┐
///            ▼                                       │
/// connected ─▶ Setup ──▶ Configured ──▶ Starting ──▶ Running
///   Waiting ──▲  │  ▲     Start │ ▲       answer, heartbeat or position: Ready
///      ▲         │  │           └─┼── Stop ───────────┘
///      └─ fails ─┘  └─ boot-up, heartbeat lost, no longer operational
/// ```
///
/// - A node is taken into pre-operational, never reset: a reset would drop what another tool has set
///   and what is not yet stored, and everything the driver depends on it writes anyway.
/// - [`Event::Online`] comes when the node has told its profile (and vendor), [`Event::Ready`] when
///   it is operational on [`Command::Start`], and again after each restart of the node. Nothing in
///   CANopen confirms a start, and the next heartbeat may be a second away; so the node is asked for its
///   error register right after. Frames to a node keep their order: one that answers has had its start.
///   Should it have refused it, its heartbeats say so, which is a fault: the second one, for the first may
///   have waited on the bus since before the start, where all answers and positions overtake it.
/// - [`Event::Reopen`] never comes. A bus is shared: closing it would take the other nodes down for
///   the trouble of one. The node alone is set up anew instead, with a pause of 1 s, doubled up to
///   8 s, between attempts that fail.
/// - A lost heartbeat, a restart or a node that leaves operational by itself is a fault; so is each
///   emergency. Until the emergency "error reset" with an empty error register, or a restart,
///   readings carry [`Flags::DEVICE_ERROR`].
/// - With [`Settings::listen_only`] nothing is ever sent: the first valid frame of the node is [`Event::Online`], and it is
///   [`Event::Ready`] once it is operational. Its heartbeat may be off, so silence is no fault.
/// - With SYNC, a reading has the count of the SYNC it answers. One that answers none has no count and
///   [`Flags::DELAYED`]; the first after missing ones has [`Flags::TRIGGER_LOST`].
/// - A position that comes after the next SYNC, or whose own SYNC was lost together with the position
///   before, would be given the count of a wrong SYNC, and no frame can show it. Set
///   [`Settings::sync_window_us`] below the period of SYNC to have such positions flagged.
pub struct Cia406 {
    settings: Settings,
    node: NodeId,
    layout: TpdoLayout,
    channels: Vec<Channel>,
    state: State,
    /// Whether the station wants readings.
    wanted: bool,
    /// Whether the node has an error of its own.
    error: bool,
    /// Whether a frame of another length than mapped was told since the last setup.
    length_told: bool,
    /// Answers to the question after a start that may still come.
    start_answers: u8,
    /// When the node counts as lost; only once its heartbeat is set.
    alive_until: Option<Nanos>,
    /// Pause before the next attempt to set the node up.
    pause: Duration,
    transmit: VecDeque<CanFrame>,
    events: Events,
}

enum State {
    /// The link is closed.
    Closed,
    /// A request is in flight.
    Setup { setup: Setup, until: Nanos, tries: u8 },
    /// The last setup failed.
    Waiting { until: Nanos },
    /// Set up, pre-operational.
    Configured { learned: Learned },
    /// Told to start, not yet seen to have.
    Starting { learned: Learned, cycle: Cycle, until: Nanos, tries: u8 },
    /// Operational. `heard`: a heartbeat came since.
    Running { learned: Learned, cycle: Cycle, heard: bool },
    /// Another master has set the node up. `measures`: it is operational. `stopped`: its readings are no longer wanted.
    Listening { learned: Learned, cycle: Cycle, measures: bool, stopped: bool },
}

/// How often a request is sent before the node counts as silent.
const TRIES: u8 = 3;
const FIRST_PAUSE: Duration = Duration::from_secs(1);
const LONGEST_PAUSE: Duration = Duration::from_secs(8);

impl Cia406 {
    /// The driver of a node. Fails with all that is wrong with the settings.
    pub fn new(settings: Settings) -> Result<Cia406, Vec<Problem>> {
        let problems = settings.problems();
        let Some(node) = settings.node().filter(|_| problems.is_empty()) else {
            return Err(problems);
        };
        Ok(Cia406 {
            node,
            layout: settings.layout(),
            channels: settings.channels(),
            settings,
            state: State::Closed,
            wanted: false,
            error: false,
            length_told: false,
            start_answers: 0,
            alive_until: None,
            pause: FIRST_PAUSE,
            transmit: VecDeque::new(),
            events: Events::default(),
        })
    }

    fn begin_setup(&mut self, now: Nanos) {
        self.start_answers = 0;
        self.tell_nmt(NmtCommand::EnterPreOperational);
        self.alive_until = None;
        self.length_told = false;
        self.ask(now, Setup::new(self.node, &self.settings));
    }

    fn ask(&mut self, now: Nanos, setup: Setup) {
        self.transmit.push_back(setup.request(&self.settings).encode(self.node));
        self.state = State::Setup { setup, until: now + self.sdo_timeout(), tries: 1 };
    }

    /// The node cannot be set up now.
    fn give_up(&mut self, now: Nanos, fault: Fault) {
        self.events.push(Event::Fault(fault));
        self.state = State::Waiting { until: now + self.pause };
        self.pause = (2 * self.pause).min(LONGEST_PAUSE);
    }

    /// The node was set up and is no longer what it was.
    fn lose(&mut self, now: Nanos, kind: FaultKind, detail: String) {
        self.end_cycle();
        self.events.fault(kind, detail);
        self.begin_setup(now);
    }

    fn end_cycle(&mut self) {
        if let State::Starting { cycle, .. }
        | State::Running { cycle, .. }
        | State::Listening { cycle, .. } = &mut self.state
        {
            cycle.end(&mut self.events);
        }
    }

    fn configured(&mut self, now: Nanos, learned: Learned) {
        self.error = learned.error;
        self.pause = FIRST_PAUSE;
        self.alive_until = Some(now + self.heartbeat_timeout());
        self.state = State::Configured { learned };
        if self.wanted {
            self.start(now, learned, TRIES);
        }
    }

    fn start(&mut self, now: Nanos, learned: Learned, tries: u8) {
        self.tell_nmt(NmtCommand::Start);
        self.transmit.push_back(SdoRequest::Upload(object::ERROR_REGISTER).encode(self.node));
        self.start_answers = self.start_answers.saturating_add(1);
        let until = now + self.heartbeat_timeout();
        self.state = State::Starting { learned, cycle: self.cycle(), until, tries };
    }

    fn cycle(&self) -> Cycle {
        let every = match self.settings.transmission {
            Transmission::Sync { every } => every,
            Transmission::EventTimer { .. } => 1,
        };
        let window = self.settings.sync_window_us.map(|us| Duration::from_micros(us.into()));
        Cycle::new(self.node, self.settings.sync_counter_overflow, every, window)
    }

    /// The node is operational: its heartbeat says so, an answer after its start, or a position, which no
    /// other state sends.
    fn running(&mut self) {
        let state = std::mem::replace(&mut self.state, State::Closed);
        self.state = match state {
            State::Starting { learned, mut cycle, .. } => {
                cycle.begin();
                self.events.push(Event::Ready);
                State::Running { learned, cycle, heard: false }
            }
            other => other,
        };
    }

    fn on_sdo(&mut self, now: Nanos, data: &[u8]) {
        let State::Setup { setup, .. } = &self.state else {
            return self.on_start_answer(data);
        };
        let asked = setup.request(&self.settings);
        let answer = match SdoResponse::decode(self.node, data) {
            Ok(response) if response.address() == asked.address() => response,
            // Not ours: a late answer to an earlier request, or to another master.
            _ => return self.discard(data),
        };
        let answer = match (answer, asked) {
            (SdoResponse::Uploaded(_, value), SdoRequest::Upload(_)) => Ok(value.number()),
            (SdoResponse::Downloaded(_), SdoRequest::Download(..)) => Ok(0),
            (SdoResponse::Aborted(_, code), _) => Err(code),
            (SdoResponse::Segmented(address), SdoRequest::Upload(_)) => {
                let abort = SdoRequest::Abort(address, AbortCode::UNSUPPORTED_ACCESS);
                self.transmit.push_back(abort.encode(self.node));
                let detail = format!(
                    "node {} has more than four bytes at {address}: see its manual",
                    self.node
                );
                return self.give_up(now, Fault { kind: FaultKind::Protocol, detail });
            }
            _ => return self.discard(data),
        };
        let mut setup = setup.clone();
        let progress = setup.answered(&self.settings, answer);
        if setup.is_identified() {
            self.events.prove_online();
        }
        match progress {
            Progress::Next(told) => {
                self.events.extend(told.map(Event::Fault));
                self.ask(now, setup);
            }
            Progress::Done(learned) => self.configured(now, learned),
            Progress::Failed(fault) => self.give_up(now, fault),
        }
    }

    /// An answer outside of the set-up: to the question after a start, or to somebody else.
    fn on_start_answer(&mut self, data: &[u8]) {
        let asked = self.start_answers > 0
            && SdoResponse::decode(self.node, data)
                .is_ok_and(|response| response.address() == object::ERROR_REGISTER);
        if !asked {
            return self.discard(data);
        }
        self.start_answers -= 1;
        self.running();
    }

    fn on_heartbeat(&mut self, now: Nanos, data: &[u8]) {
        let Ok(said) = NmtState::decode(self.node, data) else {
            return self.discard(data);
        };
        if self.alive_until.is_some() {
            self.alive_until = Some(now + self.heartbeat_timeout());
        }
        let first = match &mut self.state {
            State::Running { heard, .. } => !std::mem::replace(heard, true),
            _ => false,
        };
        match (said, &self.state) {
            (NmtState::BootUp, State::Setup { setup, .. }) if !setup.is_identified() => {
                self.begin_setup(now);
            }
            (NmtState::BootUp, State::Waiting { .. }) => self.begin_setup(now),
            (NmtState::BootUp, _) => {
                let detail =
                    format!("node {} restarted, and is set up anew: check its power", self.node);
                self.lose(now, FaultKind::Device, detail);
            }
            (NmtState::Operational, State::Starting { .. }) => self.running(),
            // Stop was lost, or somebody else started it.
            (NmtState::Operational, State::Configured { .. }) => {
                self.tell_nmt(NmtCommand::EnterPreOperational);
            }
            // It may be from before the start: heartbeats yield to answers and positions on the bus.
            (NmtState::PreOperational, State::Running { .. }) if first => {}
            (NmtState::PreOperational | NmtState::Stopped, State::Running { .. }) => {
                let detail = format!(
                    "node {} is {said}, though it was started: check that no other master controls it",
                    self.node
                );
                self.lose(now, FaultKind::Device, detail);
            }
            _ => {}
        }
    }

    fn on_emergency(&mut self, data: &[u8]) {
        let Ok(emergency) = Emergency::decode(self.node, data) else {
            return self.discard(data);
        };
        self.error = !emergency.is_all_clear();
        if self.error {
            self.events.fault(
                FaultKind::Device,
                format!("node {}: {emergency}; see its manual", self.node),
            );
        }
    }

    fn on_position(&mut self, now: Nanos, data: &[u8]) {
        let Some(position) = self.layout.decode(data) else {
            self.tell_length(data.len());
            return self.discard(data);
        };
        self.running();
        // A position is a sign of life too: on a busy bus a heartbeat may wait behind hundreds of them.
        if self.alive_until.is_some() {
            self.alive_until = Some(now + self.heartbeat_timeout());
        }
        let State::Running { learned, cycle, .. } = &mut self.state else {
            return self.discard(data);
        };
        let learned = *learned;
        let (count, mut flags) = match self.settings.transmission {
            Transmission::Sync { .. } => cycle.position(now, &mut self.events),
            Transmission::EventTimer { .. } => (None, Flags::empty()),
        };
        if data.len() != self.layout.byte_len() {
            self.tell_length(data.len());
        }
        flags.set(Flags::DEVICE_ERROR, self.error);
        flags.set(Flags::OUT_OF_RANGE, position.area_state.is_some_and(AreaState::is_outside));
        let reading = self.reading(now, position, learned, count, flags);
        self.events.push(Event::Reading(reading));
    }

    fn reading(
        &self,
        host: Nanos,
        position: Position,
        learned: Learned,
        count: Option<Count>,
        flags: Flags,
    ) -> Reading {
        let counts = self.settings.position.counts(position.position) as f64;
        let value = match self.settings.kind {
            // Divided, not multiplied by 1e-6: the result is then the double nearest to the product.
            Kind::Linear { .. } => counts * learned.step_nm / 1e6,
            Kind::Rotary { counts_per_turn } => counts / f64::from(counts_per_turn) * TAU,
            Kind::Counts => counts,
        };
        let mut values = Values::new();
        values.push(Some(value));
        if self.layout.velocity {
            let velocity = position.velocity.map(f64::from);
            values.push(velocity.map(|steps| steps * learned.velocity_step_mm_s));
        }
        if self.layout.area_state {
            values.push(position.area_state.map(|state| state.0.into()));
        }
        Reading { host, device_time_ns: None, count, values, flags }
    }

    fn tell_length(&mut self, found: usize) {
        if !self.length_told {
            self.length_told = true;
            let detail = format!(
                "TPDO1 of node {} has {found} bytes, its mapping {}: see its manual, or start it anew",
                self.node,
                self.layout.byte_len()
            );
            self.events.fault(FaultKind::Protocol, detail);
        }
    }

    fn tell_nmt(&mut self, command: NmtCommand) {
        self.transmit.push_back(NmtRequest::to(self.node, command).encode());
    }

    fn discard(&mut self, data: &[u8]) {
        self.events.push(Event::Discarded { bytes: data.len() as u64 });
    }

    fn sdo_timeout(&self) -> Duration {
        Duration::from_millis(self.settings.sdo_timeout_ms.into())
    }

    /// CiA 301 asks only that a consumer waits longer than the producer's time.
    fn heartbeat_timeout(&self) -> Duration {
        2 * Duration::from_millis(self.settings.heartbeat_ms.into())
    }
}

impl Driver for Cia406 {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.transmit.clear();
        self.events.restart();
        self.error = false;
        self.pause = FIRST_PAUSE;
        if self.settings.listen_only {
            return self.begin_listening(false);
        }
        self.begin_setup(now);
    }

    fn disconnected(&mut self, _now: Nanos) {
        self.end_cycle();
        self.transmit.clear();
        self.alive_until = None;
        self.state = State::Closed;
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        if matches!(self.state, State::Closed) {
            return;
        }
        let frame = match input {
            Input::Frame(frame) => frame,
            Input::Bytes(bytes) | Input::Second(bytes) => return self.discard(bytes),
        };
        if matches!(self.state, State::Listening { .. }) {
            return self.overhear(now, frame);
        }
        match Cob::from_frame(frame) {
            Some(Cob::Sync) => {
                if let State::Starting { cycle, .. } | State::Running { cycle, .. } =
                    &mut self.state
                    && matches!(self.settings.transmission, Transmission::Sync { .. })
                {
                    cycle.sync(now, frame.data(), &mut self.events);
                }
            }
            Some(Cob::Tpdo1(node)) if node == self.node => self.on_position(now, frame.data()),
            Some(Cob::Heartbeat(node)) if node == self.node => {
                self.on_heartbeat(now, frame.data());
            }
            Some(Cob::SdoResponse(node)) if node == self.node => self.on_sdo(now, frame.data()),
            Some(Cob::Emergency(node)) if node == self.node => self.on_emergency(frame.data()),
            _ => {}
        }
    }

    fn timeout(&mut self, now: Nanos) {
        if self.alive_until.is_some_and(|until| until <= now) {
            let detail = format!(
                "no heartbeat of node {} within {} ms: check its power, the cable and both ends of the bus",
                self.node,
                self.heartbeat_timeout().as_millis()
            );
            return self.lose(now, FaultKind::Timeout, detail);
        }
        let sdo_timeout = self.sdo_timeout();
        match &mut self.state {
            State::Setup { setup, until, tries } if *until <= now => {
                let asked = setup.request(&self.settings);
                if *tries < TRIES {
                    *tries += 1;
                    *until = now + sdo_timeout;
                    self.transmit.push_back(asked.encode(self.node));
                } else {
                    let abort = SdoRequest::Abort(asked.address(), AbortCode::TIMED_OUT);
                    self.transmit.push_back(abort.encode(self.node));
                    let detail = format!(
                        "node {} did not answer for {} within {TRIES} times {} ms: check node number, bit rate, cable and power",
                        self.node,
                        asked.address(),
                        self.settings.sdo_timeout_ms
                    );
                    self.give_up(now, Fault { kind: FaultKind::Timeout, detail });
                }
            }
            State::Waiting { until } if *until <= now => self.begin_setup(now),
            State::Starting { learned, until, tries, .. } if *until <= now => {
                let (learned, tries) = (*learned, *tries - 1);
                if tries > 0 {
                    self.start(now, learned, tries);
                } else {
                    let detail = format!(
                        "node {} did not become operational: check that no other master controls it",
                        self.node
                    );
                    self.lose(now, FaultKind::Timeout, detail);
                }
            }
            _ => {}
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        let own = match &self.state {
            State::Setup { until, .. }
            | State::Waiting { until }
            | State::Starting { until, .. } => Some(*until),
            State::Closed
            | State::Configured { .. }
            | State::Running { .. }
            | State::Listening { .. } => None,
        };
        own.into_iter().chain(self.alive_until).min()
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        self.transmit.pop_front().map(Output::Frame)
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, now: Nanos, command: Command) {
        self.wanted = command == Command::Start;
        match (command, &self.state) {
            (Command::Start, State::Configured { learned }) => {
                let learned = *learned;
                self.start(now, learned, TRIES);
            }
            (Command::Start, State::Running { .. } | State::Listening { measures: true, .. }) => {
                self.events.push(Event::Ready);
            }
            (Command::Start, State::Listening { stopped: true, .. }) => self.begin_listening(false),
            (Command::Stop, State::Listening { .. }) => {
                self.end_cycle();
                self.begin_listening(true);
            }
            (Command::Stop, State::Starting { learned, .. } | State::Running { learned, .. }) => {
                let learned = *learned;
                self.end_cycle();
                self.tell_nmt(NmtCommand::EnterPreOperational);
                self.state = State::Configured { learned };
            }
            _ => {}
        }
    }
}
