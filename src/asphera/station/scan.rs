//! The scanner: it drives the axes of a station over a plan, once someone armed it.
//!
//! ```text
//!             arm                devices ready            pieces done           decided: measure
//! Disarmed ─────────▶ Armed ───────────────────▶ Moving ─────────────▶ Settling ─▶ Deciding ──▶ Moving
//!     ▲                 │ ▲ └── home ─▶ Homing ──┤   ▲ dwell             │             │ decided: end
//!     └── stop, trouble ┴────────────────────────┴───┘                   └─────────────┴──────▶ Ended
//! ```
//!
//! Like the rest of the core it has no clock and no task: the same happenings give the same orders. Whatever is not as it must be halts
//! every axis, and nothing moves until someone arms it again.

mod gate;
mod pieces;
mod plan;
mod program;
mod region;
mod scanner;
#[cfg(test)]
mod tests;
mod watch;

use std::collections::{BTreeSet, VecDeque};

use asphera_link::{Motion, MotionEvent, MotionFailure, MotionTrouble, Nanos, Reading};
use asphera_plan::{Piece, Spacing};
use asphera_report::ScanFigures;

pub use self::plan::{AdaptivePlan, ScanAxis, ScanDecision, ScanPlan, Stroke};
pub(super) use self::program::ProgramScanner;
pub(crate) use self::region::plan_aperture;
pub use self::scanner::{ArmError, Order, Scanner};
use super::kinematics::Point;
use gate::Gate;
use pieces::Runs;
use watch::Watch;

/// Scanner of a station that drives axes over a plan.
#[derive(Debug)]
pub(super) struct PlanScanner {
    plan: ScanPlan,
    /// Device of each axis: (line, device on that line).
    devices: [(usize, usize); 2],
    /// Lines whose loss disarms: those of the axes and of the primary.
    lines: BTreeSet<usize>,
    state: State,
    /// Pieces that are not measured yet, that of the run under way first.
    pieces: VecDeque<(Piece, Spacing)>,
    runs: Runs,
    watch: Watch,
    gate: Gate,
    orders: VecDeque<Order>,
    /// Lines on which a halt is due as soon as they open.
    halt_when_open: BTreeSet<usize>,
    /// Whether the axes have found home, where they are to.
    is_homed: bool,
    /// When the first move began.
    began: Option<Nanos>,
    pass: u32,
    pieces_of_pass: usize,
}

/// State of the scanner.
#[derive(Clone, Debug, PartialEq)]
enum State {
    /// Nothing moves. Why, where it was armed before.
    Disarmed { why: Option<String> },
    /// Waits for the devices.
    Armed,
    /// Axes find home. So many devices have not found it yet.
    Homing { by: Nanos, devices: usize },
    /// Axes run to the end of a run. So many devices have not arrived yet.
    Moving { by: Nanos, devices: usize },
    /// Stands at a place that is measured.
    Dwelling { until: Nanos },
    /// Stands until the last points are joined.
    Settling { until: Nanos },
    /// Stands until it is decided what follows.
    Deciding,
    /// The scan is over.
    Ended { why: &'static str },
}

impl PlanScanner {
    /// A disarmed scanner; `streams` are the synchronized devices, as (line, device on that line), the primary first.
    pub(super) fn new(plan: ScanPlan, streams: &[(usize, usize)]) -> PlanScanner {
        let device = |axis: &ScanAxis| streams.get(axis.stream).copied().unwrap_or_default();
        let devices = [device(&plan.axes[0]), device(&plan.axes[1])];
        let primary = streams.first().map(|(line, _)| *line);
        PlanScanner {
            lines: devices.iter().map(|(line, _)| *line).chain(primary).collect(),
            devices,
            state: State::Disarmed { why: None },
            pieces: plan.pieces.iter().copied().collect(),
            pieces_of_pass: plan.pieces.len(),
            runs: Runs::default(),
            watch: Watch::new(&plan),
            gate: Gate::new(plan.point_spacing_mm),
            orders: VecDeque::new(),
            halt_when_open: BTreeSet::new(),
            is_homed: plan.home_within.is_none(),
            began: None,
            pass: 1,
            plan,
        }
    }
}

impl Scanner for PlanScanner {
    fn arm(&mut self, now: Nanos) -> Result<(), ArmError> {
        match self.state {
            State::Disarmed { .. } => {
                self.state = State::Armed;
                self.watch.begin(now);
                Ok(())
            }
            State::Ended { .. } => Err(ArmError::Ended),
            _ => Err(ArmError::Armed),
        }
    }

    fn stop(&mut self, now: Nanos) {
        self.halt();
        if self.is_active() {
            self.disarm(now, "stopped by hand".to_owned());
        }
    }

    fn session_ends(&mut self, now: Nanos) {
        if self.is_active() {
            self.trouble(now, "the session ended".to_owned());
        }
    }

    fn decide(&mut self, now: Nanos, decision: &ScanDecision) {
        match decision {
            ScanDecision::End(ending) if self.is_active() => {
                self.halt();
                self.gate.end(now);
                self.state = State::Ended { why: plan::ending_words(*ending) };
            }
            ScanDecision::Measure(strokes) if self.state == State::Deciding => {
                self.pieces = strokes.iter().map(Stroke::piece).collect();
                self.pieces_of_pass = self.pieces.len();
                self.pass += 1;
                self.next(now);
            }
            ScanDecision::End(_) | ScanDecision::Measure(_) => {}
        }
    }

    fn wants_decision(&self) -> bool {
        self.state == State::Deciding
    }

    fn ends_on_certain_fail(&self) -> bool {
        self.plan.adaptive.is_some() && self.is_active() && self.began.is_some()
    }

    fn place_mm(&self) -> Option<[f64; 2]> {
        self.watch.places().map(|axes| self.plan.place_mm(axes))
    }

    fn spent_s(&self, now: Nanos) -> f64 {
        self.began.map_or(0.0, |began| now.since(began).as_secs_f64())
    }

    fn is_ended(&self) -> bool {
        matches!(self.state, State::Ended { .. })
    }

    fn reading(&mut self, now: Nanos, stream: usize, reading: &Reading) {
        self.watch.reading(stream, reading, &self.plan);
        if !self.is_active() {
            return;
        }
        let run = match self.state {
            State::Moving { .. } => self.runs.current(),
            _ => None,
        };
        if let Some(why) = self.watch.strayed(run, &self.plan) {
            self.trouble(now, why);
        }
    }

    fn interrupted(&mut self, now: Nanos, line: usize, name: &str) {
        if !self.lines.contains(&line) {
            return;
        }
        self.watch.forget(line, &self.devices);
        if self.devices.iter().any(|(of, _)| *of == line) {
            self.is_homed = self.plan.home_within.is_none();
        }
        if self.is_active() {
            let cure = "check its cable and power, then arm the scan again";
            self.trouble(now, format!("the link {name} was lost: {cure}"));
            // What is ordered now may not reach it any more.
            if self.devices.iter().any(|(of, _)| *of == line) {
                self.halt_when_open.insert(line);
            }
        }
    }

    fn opened(&mut self, line: usize) {
        if self.halt_when_open.remove(&line) {
            let devices = self.halted_devices().into_iter().filter(|(of, _)| *of == line);
            self.orders.extend(devices.map(|device| Order { device, motion: Motion::Halt }));
        }
    }

    fn motion(&mut self, now: Nanos, event: &MotionEvent) {
        match (event, &mut self.state) {
            (MotionEvent::Arrived, State::Moving { devices, .. }) => {
                *devices = devices.saturating_sub(1);
                if *devices == 0 {
                    self.arrived(now);
                }
            }
            (MotionEvent::Arrived, State::Homing { devices, .. }) => {
                *devices = devices.saturating_sub(1);
                if *devices == 0 {
                    self.is_homed = true;
                    self.watch.rehomed(now);
                    self.state = State::Armed;
                }
            }
            (MotionEvent::Failed(failure), _) => self.failed(now, failure),
            (MotionEvent::Arrived | MotionEvent::Halted, _) => {}
        }
    }

    fn failed(&mut self, now: Nanos, failure: &MotionFailure) {
        if failure.kind == MotionTrouble::Unreferenced {
            self.is_homed = self.plan.home_within.is_none();
        }
        if self.is_active() {
            self.trouble(now, format!("{}; then arm the scan again", failure.detail));
        } else if let State::Disarmed { why: Some(why) } = &mut self.state
            && !why.contains(&failure.detail)
        {
            // As a halt that nobody answers.
            *why = format!("{why}; {}", failure.detail);
        }
    }

    fn advance(&mut self, now: Nanos, is_ready: bool) {
        if self.state != State::Armed || !is_ready || !self.watch.is_known() {
            return;
        }
        self.began.get_or_insert(now);
        match self.plan.home_within.filter(|_| !self.is_homed) {
            Some(within) => self.home(now + within),
            None => {
                self.watch.stand();
                self.next(now);
            }
        }
    }

    fn timeout(&mut self, now: Nanos) {
        if let Some(why) = self.watch.silent(now, &self.plan).filter(|_| self.is_watching()) {
            self.trouble(now, why);
            return;
        }
        match self.state {
            State::Moving { by, .. } if by <= now => {
                let why = "the axes have not arrived in time: look whether something blocks them, then arm the scan again";
                self.trouble(now, why.to_owned());
            }
            State::Homing { by, .. } if by <= now => {
                let why = "the axes have not found home in time: look at their switches, or set home_within_s, then arm the scan again";
                self.trouble(now, why.to_owned());
            }
            State::Dwelling { until } if until <= now => {
                self.gate.end(now);
                self.run_on(now);
            }
            State::Settling { until } if until <= now => {
                self.state = match &self.plan.adaptive {
                    Some(_) => State::Deciding,
                    None => State::Ended { why: "the plan is measured" },
                };
            }
            _ => {}
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        let watch = self.watch.poll_timeout(&self.plan).filter(|_| self.is_watching());
        let own = match self.state {
            State::Moving { by, .. } | State::Homing { by, .. } => Some(by),
            State::Dwelling { until } | State::Settling { until } => Some(until),
            _ => None,
        };
        watch.into_iter().chain(own).min()
    }

    fn poll_order(&mut self) -> Option<Order> {
        self.orders.pop_front()
    }

    fn judge(&mut self, point: &mut Point) {
        self.gate.judge(point);
        if self.plan.points_max.is_some_and(|most| self.gate.taken() >= most) && self.is_active() {
            self.halt();
            self.gate.end(self.watch.newest());
            self.state = State::Ended { why: "points_max is reached" };
        }
    }

    fn figures(&self, now: Nanos) -> ScanFigures {
        let (state, text) = match &self.state {
            State::Disarmed { why: None } => {
                ("disarmed", "nothing moves until the scan is armed".to_owned())
            }
            State::Disarmed { why: Some(why) } => ("disarmed", why.clone()),
            State::Armed => ("armed", "waits for the devices".to_owned()),
            State::Homing { .. } => ("moving", "the axes find home".to_owned()),
            State::Moving { .. } => ("moving", self.runs.text()),
            State::Dwelling { .. } => ("moving", "measures at rest".to_owned()),
            State::Settling { .. } | State::Deciding => {
                ("deciding", "decides what to measure next".to_owned())
            }
            State::Ended { why } => ("ended", (*why).to_owned()),
        };
        let total = self.pieces_of_pass;
        ScanFigures {
            state: state.to_owned(),
            text,
            place_mm: self.place_mm(),
            next_mm: self.runs.current().map(|run| self.plan.place_mm(run.to)),
            pass: self.pass,
            pieces: total as u64,
            pieces_done: total.saturating_sub(self.pieces.len()) as u64,
            points: self.gate.taken(),
            spent_s: self.spent_s(now),
            time_limit_s: self.plan.time_limit.map(|limit| limit.as_secs_f64()),
        }
    }

    fn unhalted(&mut self, device: (usize, usize)) {
        self.halt_when_open.insert(device.0);
    }
}

impl PlanScanner {
    fn is_active(&self) -> bool {
        !matches!(self.state, State::Disarmed { .. } | State::Ended { .. })
    }

    /// Silence counts while axes may move, or points are wanted.
    fn is_watching(&self) -> bool {
        self.is_active() && self.state != State::Armed
    }

    /// Lets every device with axes find home.
    fn home(&mut self, by: Nanos) {
        let devices = self.halted_devices();
        self.state = State::Homing { by, devices: devices.len() };
        self.orders
            .extend(devices.into_iter().map(|device| Order { device, motion: Motion::Home }));
    }

    /// Begins the next piece, or the pass is over.
    fn next(&mut self, now: Nanos) {
        if self.plan.time_limit.is_some_and(|limit| self.spent_s(now) >= limit.as_secs_f64()) {
            self.state = State::Ended { why: "the time is spent" };
            return;
        }
        let Some((&(piece, spacing), axes)) = self.pieces.front().zip(self.watch.places()) else {
            self.state = State::Settling { until: now + SETTLE };
            return;
        };
        match self.runs.begin(piece, spacing, &self.plan.limits, axes) {
            Ok(()) => self.run(now),
            Err(error) => self.trouble(now, format!("[scan.plan] {error}")),
        }
    }

    /// Orders the run that is next.
    fn run(&mut self, now: Nanos) {
        let Some(run) = self.runs.current().copied() else {
            self.pieces.pop_front();
            self.next(now);
            return;
        };
        let moves = self.plan.moves(&run);
        let mut orders: Vec<Order> = Vec::new();
        for (axis, one) in moves {
            let device = self.devices[axis];
            match orders.iter_mut().find(|order| order.device == device) {
                Some(Order { motion: Motion::Move(moves), .. }) => moves.push(one),
                _ => orders.push(Order { device, motion: Motion::Move(vec![one]) }),
            }
        }
        if Runs::measures_on_the_way(&run) {
            self.gate.begin(now);
        }
        if orders.is_empty() {
            self.arrived(now);
            return;
        }
        self.state = State::Moving { by: now + pieces::patience(&run), devices: orders.len() };
        self.orders.extend(orders);
    }

    /// Every axis stands where it was sent.
    fn arrived(&mut self, now: Nanos) {
        let Some(run) = self.runs.current().copied() else { return };
        if let Some(why) = self.watch.missed(&run, &self.plan) {
            self.trouble(now, why);
            return;
        }
        self.watch.stand();
        self.gate.end(now);
        if Runs::measures_at_its_end(&run) {
            self.gate.begin(now);
            self.state = State::Dwelling { until: now + self.plan.dwell };
            return;
        }
        self.run_on(now);
    }

    fn run_on(&mut self, now: Nanos) {
        self.runs.done();
        self.run(now);
    }

    fn trouble(&mut self, now: Nanos, why: String) {
        self.halt();
        self.disarm(now, why);
    }

    fn disarm(&mut self, now: Nanos, why: String) {
        self.gate.end(now);
        self.runs = Runs::default();
        self.state = State::Disarmed { why: Some(why) };
    }

    /// Halts the devices of all axes, before anything else that was ordered.
    fn halt(&mut self) {
        self.orders.clear();
        let devices = self.halted_devices();
        self.orders
            .extend(devices.into_iter().map(|device| Order { device, motion: Motion::Halt }));
    }

    fn halted_devices(&self) -> BTreeSet<(usize, usize)> {
        self.devices.into_iter().collect()
    }
}

/// Time in which the last points of a pass are joined.
const SETTLE: std::time::Duration = std::time::Duration::from_millis(300);
