//! The state machine of one drive.

mod answer;
mod motion;
mod steps;

use std::collections::VecDeque;
use std::time::Duration;

use asphera_link::{
    CanFrame, Channel, Command, Driver, Event, Events, FaultKind, Flags, Input, Motion,
    MotionFailure, MotionTrouble, Nanos, Output, Problem, Reading, Values,
};

use crate::wire::{
    Cob, Emergency, NmtCommand, NmtRequest, NmtState, NodeId, PowerState, Statusword, control,
    decode_tpdo,
};
use crate::{Reference, Settings};
use steps::{InFlight, Step};

/// Driver of one drive on a bus that it may share with others.
///
/// ```text
/// connected ─▶ Setup ─▶ Rest ─ order ─▶ Preparing ─▶ Running ─▶ Rest       arrived
///       ▲       │ ▲       ▲                  │ trouble, halt │
///     Waiting ◀─┘ └ lost  └──── stands ──── Halting ◀────────┘             halted, failed
/// ```
///
/// - One SDO is in flight at a time. A halt goes before everything: what waits is dropped, and the controlword of the
///   quick stop is sent at once, again and again until the drive stands.
/// - [`Event::Online`] comes when the node has told its profile (and vendor), [`Event::Ready`] with the first statusword and
///   position after [`Command::Start`].
/// - [`Event::Reopen`] never comes: the bus belongs to others too. The node alone is set up anew.
/// - A drive that has not been homed refuses to move. Whether it has is read from the drive, in homing mode with the power
///   off; a restart, or a loss of the node, forgets it.
pub struct Cia402 {
    settings: Settings,
    node: NodeId,
    channels: Vec<Channel>,
    job: Job,
    /// Steps of the job that wait for their turn.
    steps: VecDeque<Step>,
    in_flight: Option<InFlight>,
    /// When the next step may go.
    resume: Option<Nanos>,
    is_configured: bool,
    is_wanted: bool,
    /// Whether the first TPDO since the start has come.
    is_measuring: bool,
    is_homed: bool,
    /// Whether the node has an error of its own.
    error: bool,
    is_length_said: bool,
    status: Statusword,
    /// Last position, and since when it has not changed.
    still: Option<(i32, Nanos)>,
    alive_until: Option<Nanos>,
    tpdo_until: Option<Nanos>,
    pause: Duration,
    transmit: VecDeque<CanFrame>,
    events: Events,
}

/// Work of the driver.
#[derive(Clone, Debug, PartialEq)]
enum Job {
    /// The link is closed.
    Closed,
    /// The node is set up.
    Setup,
    /// The last set-up failed.
    Waiting { until: Nanos },
    /// Nothing moves by order.
    Rest,
    /// The drive is taken to where it starts.
    Preparing(Order),
    /// The drive moves.
    Running(Order),
    /// Home is found: the start bit is taken back.
    Concluding,
    /// The drive is told to stop. Why, where it is no order.
    Halting { failure: Option<MotionFailure>, attempt: u8 },
}

/// Order that moves the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    Move,
    Home,
}

const FIRST_PAUSE: Duration = Duration::from_secs(1);
const LONGEST_PAUSE: Duration = Duration::from_secs(8);
/// How often a halt is sent until the drive stands.
const HALT_ATTEMPTS: u8 = 5;
/// A drive in quick stop whose position stays for so long stands, whatever its bits say.
const STILL: Duration = Duration::from_millis(200);
/// A position may be late by as much beside its period.
const TPDO_GRACE: Duration = Duration::from_secs(1);

impl Cia402 {
    /// The driver of a drive. Fails with all that is wrong with the settings.
    pub fn new(settings: Settings) -> Result<Cia402, Vec<Problem>> {
        let problems = settings.problems();
        let Some(node) = settings.node().filter(|_| problems.is_empty()) else {
            return Err(problems);
        };
        Ok(Cia402 {
            node,
            channels: settings.channels(),
            settings,
            job: Job::Closed,
            steps: VecDeque::new(),
            in_flight: None,
            resume: None,
            is_configured: false,
            is_wanted: false,
            is_measuring: false,
            is_homed: false,
            error: false,
            is_length_said: false,
            status: Statusword::default(),
            still: None,
            alive_until: None,
            tpdo_until: None,
            pause: FIRST_PAUSE,
            transmit: VecDeque::new(),
            events: Events::default(),
        })
    }

    fn begin_setup(&mut self, now: Nanos) {
        self.send_nmt(NmtCommand::EnterPreOperational);
        self.is_configured = false;
        self.is_measuring = false;
        self.is_length_said = false;
        (self.alive_until, self.tpdo_until, self.still) = (None, None, None);
        self.begin(now, Job::Setup, steps::setup(&self.settings, self.node));
    }

    /// Begins a job with its steps.
    fn begin(&mut self, now: Nanos, job: Job, steps: Vec<Step>) {
        self.job = job;
        self.steps = steps.into();
        (self.in_flight, self.resume) = (None, None);
        self.go_on(now);
    }

    /// The set-up is over: the node measures where that is wanted.
    fn configured(&mut self, now: Nanos) {
        self.job = Job::Rest;
        self.is_configured = true;
        self.pause = FIRST_PAUSE;
        self.alive_until = Some(now + self.heartbeat_timeout());
        if self.is_wanted {
            self.start(now);
        }
    }

    fn start(&mut self, now: Nanos) {
        self.send_nmt(NmtCommand::Start);
        self.is_measuring = false;
        self.tpdo_until = Some(now + self.tpdo_timeout());
    }

    /// The node cannot be set up now.
    fn give_up(&mut self, now: Nanos, kind: FaultKind, detail: String) {
        self.events.fault(kind, detail);
        self.steps.clear();
        (self.in_flight, self.resume) = (None, None);
        self.job = Job::Waiting { until: now + self.pause };
        self.pause = (2 * self.pause).min(LONGEST_PAUSE);
    }

    /// The node was set up and is no longer what it was. It stops by itself only if it is made so: a quick stop goes out
    /// first of all.
    fn lose(&mut self, now: Nanos, kind: FaultKind, detail: String) {
        self.is_homed = self.settings.reference == Reference::Absolute;
        self.is_configured = false;
        if matches!(self.job, Job::Preparing(_) | Job::Running(_) | Job::Concluding) {
            let trouble = match kind {
                FaultKind::Timeout => MotionTrouble::Unanswered,
                _ => MotionTrouble::Device,
            };
            return self.halt(now, Some(MotionFailure::new(trouble, detail)));
        }
        if matches!(self.job, Job::Halting { .. }) {
            // It goes on until it is answered or given up; then the node is set up.
            return;
        }
        self.events.fault(kind, detail);
        self.begin_setup(now);
    }

    fn on_heartbeat(&mut self, now: Nanos, data: &[u8]) {
        let Ok(state) = NmtState::decode(self.node, data) else { return self.discard(data) };
        if self.alive_until.is_some() {
            self.alive_until = Some(now + self.heartbeat_timeout());
        }
        match state {
            NmtState::BootUp if !self.is_configured && !self.events.is_online() => {
                self.begin_setup(now);
            }
            NmtState::BootUp => {
                let detail = format!(
                    "node {} restarted, and is set up anew: check its power, and home it again",
                    self.node
                );
                self.lose(now, FaultKind::Device, detail);
            }
            NmtState::PreOperational | NmtState::Stopped if self.is_measuring => {
                let detail = format!(
                    "node {} is {state}, though it was started: check that no other master controls it",
                    self.node
                );
                self.lose(now, FaultKind::Device, detail);
            }
            _ => {}
        }
    }

    fn on_emergency(&mut self, data: &[u8]) {
        let Ok(emergency) = Emergency::decode(self.node, data) else { return self.discard(data) };
        self.error = !emergency.is_all_clear();
        if self.error {
            let detail = format!("node {}: {emergency}; see its manual", self.node);
            self.events.fault(FaultKind::Device, detail);
        }
    }

    fn on_tpdo(&mut self, now: Nanos, data: &[u8]) {
        let Some((status, position)) = decode_tpdo(data) else {
            if !std::mem::replace(&mut self.is_length_said, true) {
                let detail = format!(
                    "TPDO1 of node {} has {} bytes, its mapping 6: see its manual, or start it anew",
                    self.node,
                    data.len()
                );
                self.events.fault(FaultKind::Protocol, detail);
            }
            return self.discard(data);
        };
        if !self.is_configured || self.tpdo_until.is_none() {
            return self.discard(data);
        }
        self.tpdo_until = Some(now + self.tpdo_timeout());
        self.alive_until = Some(now + self.heartbeat_timeout());
        if !std::mem::replace(&mut self.is_measuring, true) {
            self.events.push(Event::Ready);
        }
        self.status = status;
        if self.still.is_none_or(|(last, _)| last != position) {
            self.still = Some((position, now));
        }
        let is_bad = self.error || !self.is_homed || status.state() == Some(PowerState::Fault);
        let mut flags = Flags::empty();
        flags.set(Flags::DEVICE_ERROR, is_bad);
        let mut values = Values::new();
        values.push(Some(f64::from(position) * self.settings.step.in_channel().1));
        let reading = Reading { host: now, device_time_ns: None, count: None, values, flags };
        self.events.push(Event::Reading(reading));
        self.follow(now, status);
    }

    fn send_nmt(&mut self, command: NmtCommand) {
        self.transmit.push_back(NmtRequest::to(self.node, command).encode());
    }

    fn discard(&mut self, data: &[u8]) {
        self.events.push(Event::Discarded { bytes: data.len() as u64 });
    }

    fn heartbeat_timeout(&self) -> Duration {
        2 * Duration::from_millis(self.settings.heartbeat_ms.into())
    }

    fn tpdo_timeout(&self) -> Duration {
        2 * Duration::from_millis(self.settings.period_ms.into()) + TPDO_GRACE
    }
}

impl Driver for Cia402 {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.transmit.clear();
        self.events.restart();
        self.error = false;
        self.is_homed = self.settings.reference == Reference::Absolute;
        self.pause = FIRST_PAUSE;
        self.begin_setup(now);
    }

    fn disconnected(&mut self, _now: Nanos) {
        self.transmit.clear();
        self.steps.clear();
        (self.in_flight, self.resume) = (None, None);
        (self.alive_until, self.tpdo_until) = (None, None);
        (self.is_configured, self.is_measuring) = (false, false);
        self.job = Job::Closed;
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        if self.job == Job::Closed {
            return;
        }
        let frame = match input {
            Input::Frame(frame) => frame,
            Input::Bytes(bytes) | Input::Second(bytes) => return self.discard(bytes),
        };
        match Cob::from_frame(frame) {
            Some(Cob::Tpdo1(node)) if node == self.node => self.on_tpdo(now, frame.data()),
            Some(Cob::Heartbeat(node)) if node == self.node => self.on_heartbeat(now, frame.data()),
            Some(Cob::SdoResponse(node)) if node == self.node => self.on_sdo(now, frame.data()),
            Some(Cob::Emergency(node)) if node == self.node => self.on_emergency(frame.data()),
            _ => {}
        }
    }

    fn timeout(&mut self, now: Nanos) {
        if self.alive_until.is_some_and(|until| until <= now) {
            self.alive_until = None;
            let detail = format!(
                "no heartbeat of node {} within {} ms: check its power, the cable and both ends of the bus",
                self.node,
                self.heartbeat_timeout().as_millis()
            );
            return self.lose(now, FaultKind::Timeout, detail);
        }
        if self.tpdo_until.is_some_and(|until| until <= now) {
            self.tpdo_until = None;
            let detail = format!(
                "no position of node {} within {} ms: check the load of the bus, and that no other master controls it",
                self.node,
                self.tpdo_timeout().as_millis()
            );
            return self.lose(now, FaultKind::Timeout, detail);
        }
        match self.job {
            Job::Waiting { until } if until <= now => self.begin_setup(now),
            _ => self.step_timeout(now),
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        let waiting = match self.job {
            Job::Waiting { until } => Some(until),
            _ => None,
        };
        let in_flight = self.in_flight.as_ref().map(|request| request.until);
        [waiting, in_flight, self.resume, self.alive_until, self.tpdo_until]
            .into_iter()
            .flatten()
            .min()
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        self.transmit.pop_front().map(Output::Frame)
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, now: Nanos, command: Command) {
        self.is_wanted = command == Command::Start;
        match command {
            Command::Start if self.is_measuring => self.events.push(Event::Ready),
            Command::Start if self.is_configured => self.start(now),
            Command::Stop if self.is_configured => {
                self.send_nmt(NmtCommand::EnterPreOperational);
                self.is_measuring = false;
                self.tpdo_until = None;
            }
            _ => {}
        }
    }

    fn motion(&mut self, now: Nanos, motion: &Motion) -> Result<(), MotionFailure> {
        if self.job == Job::Closed {
            return Err(self.unanswered());
        }
        match motion {
            Motion::Halt => {
                self.halt(now, None);
                Ok(())
            }
            Motion::Run => {
                let detail = "a drive has no program: order moves";
                Err(MotionFailure::new(MotionTrouble::Refused, detail))
            }
            Motion::Home => self.order_home(now),
            Motion::Move(moves) => self.order_move(now, moves),
        }
    }

    fn halt_frames(&self) -> Vec<CanFrame> {
        vec![steps::controlword(self.node, control::QUICK_STOP)]
    }
}
