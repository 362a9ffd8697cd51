//! The core of a station: what links received goes in, points come out.
//!
//! Everything here follows from the inputs and their times alone. Live, the inputs come from ports and a
//! clock; in a replay they come from a recording. The code and the results are the same.

use std::collections::VecDeque;
use std::time::Duration;

use asphera_link::{Command, Motion, Nanos};
use asphera_measure::{Systematic, Tip};
use asphera_report::{LinkFigures, PlaceFigures, ThermalFigures};

use super::hold_up::Patience;
use super::joiner::{JoinSettings, Joiner};
use super::kinematics::{Kinematics, Point};
use super::line::{Effect, Line};
use super::places::{Places, clock_figures};
use super::scan::{ArmError, PlanScanner, ProgramScanner, ScanDecision, ScanPlan, Scanner};
use super::synchronizer::Record;
use super::systematic::{Sides, systematic};
use super::thermal::Thermal;
use crate::calibration::CalibrationFile;

/// How a station is put together.
pub struct BenchSettings {
    /// Links with their devices.
    pub lines: Vec<Line>,
    /// Devices read at the same trigger, the primary first: (line, device on that line).
    pub streams: Vec<(usize, usize)>,
    /// How their readings are joined.
    pub join: JoinSettings,
    /// How a joined record becomes a point.
    pub kinematics: Kinematics,
    /// Errors of the machine, which are taken out of its points.
    pub calibration: Option<CalibrationFile>,
    /// Thermal expansion, which is taken out after that.
    pub thermal: Option<Thermal>,
    /// The ball at the end of a stylus; points are its centres then.
    pub tip: Option<Tip>,
    /// When the scan is over.
    pub end: EndSettings,
    /// Plan by which the station drives the scan; `None`: something else does.
    pub scan: Option<ScanPlan>,
    /// Device whose program the station runs, as its place among `streams`.
    pub program: Option<usize>,
}

/// When a scan is over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EndSettings {
    /// After this many triggers.
    pub points: Option<u64>,
    /// After this long without a reading of the primary device.
    pub idle: Option<Duration>,
    /// After this long without a first one, counted from when every device would answer a trigger; before that, from when the
    /// links of all of them had opened. Counts while a session is measured; that of a recording has its end in it.
    pub first: Option<Duration>,
    /// After this long, counted from the start, while a link with a device of the trigger has not opened.
    pub open: Option<Duration>,
}

/// Event for a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Happening<'a> {
    /// A link opened.
    Opened {
        /// The connection's epoch.
        epoch: u64,
    },
    /// A link received bytes.
    Received(&'a [u8]),
    /// A link was lost.
    Closed(&'a str),
    /// A link could not be opened.
    OpenFailed(&'a str),
}

/// Action that a station wants with a link.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// Send bytes on a connection.
    Send {
        /// Which link.
        line: usize,
        /// Which connection of it.
        epoch: u64,
        /// What.
        bytes: Vec<u8>,
    },
    /// A valid frame arrived.
    Confirm {
        /// Which link.
        line: usize,
    },
    /// Close a connection and open a new one.
    Reopen {
        /// Which link.
        line: usize,
        /// Which connection of it.
        epoch: u64,
    },
}

/// Order to the scanner of a station.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ScanOrder {
    /// Move from now on.
    Arm,
    /// Halt every axis, and move no more.
    Halt,
    /// Do what was decided after a pass.
    Decide(ScanDecision),
}

/// Why a scan ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// All triggers were read.
    Complete,
    /// No reading came for too long.
    Idle,
}

impl Ended {
    /// As recordings and reports write it.
    pub const fn word(self) -> &'static str {
        match self {
            Ended::Complete => "complete",
            Ended::Idle => "idle",
        }
    }
}

/// The core of a station.
pub struct Bench {
    lines: Vec<Line>,
    streams: Vec<(usize, usize)>,
    joiner: Joiner,
    places: Places,
    kinematics: Kinematics,
    calibration: Option<CalibrationFile>,
    thermal: Option<Thermal>,
    tip: Option<Tip>,
    /// Sides of the centre on which the radial axis stood so far.
    sides: Sides,
    end: EndSettings,
    scanner: Option<Box<dyn Scanner>>,
    now: Nanos,
    /// The primary waits to be started until its companions are ready, and no longer than this.
    primary_held: Option<Nanos>,
    patience: Patience,
    /// How long the computer was suspended since the first reading of the primary.
    suspended: Duration,
    last_primary: Option<Nanos>,
    /// When the devices were told to start.
    started: Option<Nanos>,
    /// Since when every device of the trigger would answer one.
    ready_since: Option<Nanos>,
    /// Since when, all links with such a device having been open, one of them has not been ready.
    open_since: Option<Nanos>,
    records: u64,
    joined: Vec<Record>,
    effects: Vec<Effect>,
    actions: VecDeque<Action>,
    points: Vec<Point>,
}

impl Bench {
    /// Puts a station together. Nothing happens until its links open.
    pub fn new(settings: BenchSettings) -> Bench {
        Bench {
            places: Places::new(&settings.join),
            joiner: Joiner::new(settings.streams.len(), settings.join),
            scanner: scanner(settings.scan, settings.program, &settings.streams),
            lines: settings.lines,
            streams: settings.streams,
            kinematics: settings.kinematics,
            calibration: settings.calibration,
            thermal: settings.thermal,
            tip: settings.tip,
            sides: Sides::default(),
            end: settings.end,
            now: Nanos::ZERO,
            primary_held: None,
            patience: Patience::default(),
            suspended: Duration::ZERO,
            last_primary: None,
            started: None,
            ready_since: None,
            open_since: None,
            records: 0,
            joined: Vec::new(),
            effects: Vec::new(),
            actions: VecDeque::new(),
            points: Vec::new(),
        }
    }

    /// Something happened on `line` at `now`. What was due before is done first, at the time it was due.
    pub fn happened(&mut self, now: Nanos, line: usize, what: Happening<'_>) {
        self.advance(now);
        let target = &mut self.lines[line];
        match what {
            Happening::Opened { epoch } => target.opened(now, epoch, &mut self.effects),
            Happening::Received(bytes) => {
                let is_backlog = target.is_backlog(bytes.len());
                for (stream, (of, _)) in self.streams.iter().enumerate() {
                    if *of == line {
                        self.joiner.backlogged(stream, is_backlog);
                    }
                }
                target.received(now, bytes, &mut self.effects);
            }
            Happening::Closed(reason) => {
                target.closed(now, reason.to_owned(), &mut self.effects);
            }
            Happening::OpenFailed(reason) => target.open_failed(reason.to_owned()),
        }
        if matches!(what, Happening::Opened { .. })
            && let Some(scanner) = &mut self.scanner
        {
            scanner.opened(line);
        }
        self.settle(line);
        self.drive();
    }

    /// Arms the scan, or halts and disarms it, or takes what is decided after a pass.
    ///
    /// # Errors
    ///
    /// When it cannot be armed; a station without a plan has nothing to arm.
    pub fn scan(&mut self, now: Nanos, order: &ScanOrder) -> Result<(), ArmError> {
        self.advance(now);
        let Some(scanner) = &mut self.scanner else { return Err(ArmError::NoPlan) };
        let result = match order {
            ScanOrder::Arm => scanner.arm(now),
            ScanOrder::Halt => {
                scanner.stop(now);
                Ok(())
            }
            ScanOrder::Decide(decision) => {
                scanner.decide(now, decision);
                Ok(())
            }
        };
        self.drive();
        result
    }

    /// The scanner, where the station drives the scan.
    pub fn scanner(&self) -> Option<&dyn Scanner> {
        self.scanner.as_deref()
    }

    /// Open connections of links with axes, and the bytes that halt these; none where something else drives the scan.
    pub fn halts(&self) -> Vec<(usize, u64, Vec<u8>)> {
        let lines = self.lines.iter().enumerate().filter(|_| self.scanner.is_some());
        lines
            .filter_map(|(at, line)| line.halt_bytes().map(|(epoch, bytes)| (at, epoch, bytes)))
            .collect()
    }

    /// Gives the orders of the scanner to the drivers.
    fn drive(&mut self) {
        let is_ready = self.is_ready();
        if let Some(scanner) = &mut self.scanner {
            scanner.advance(self.now, is_ready);
        }
        while let Some(order) = self.scanner.as_mut().and_then(|scanner| scanner.poll_order()) {
            let (line, device) = order.device;
            let result =
                self.lines[line].motion(self.now, device, &order.motion, &mut self.effects);
            if let (Err(failure), Some(scanner)) = (result, &mut self.scanner) {
                match order.motion {
                    Motion::Halt => scanner.unhalted(order.device),
                    Motion::Move(_) | Motion::Home | Motion::Run => {
                        scanner.failed(self.now, &failure);
                    }
                }
            }
            self.settle(line);
        }
    }

    /// Tells every device to start or stop measuring.
    ///
    /// The primary is started last, when its companions are ready: its first reading then finds them so,
    /// whichever link is read first, and what they send from then on is known to be of the first cycle of
    /// their counts. A companion that is not there holds it back for 5 s at most, and so does a temperature that is not known.
    pub fn command(&mut self, now: Nanos, command: Command) {
        self.advance(now);
        self.started = (command == Command::Start).then_some(now);
        let held = command == Command::Start && !self.companions_ready();
        self.primary_held = held.then(|| now + COMPANIONS_WAIT);
        let primary = self.streams.first().copied().filter(|_| held);
        if let Some(scanner) = self.scanner.as_mut().filter(|_| command == Command::Stop) {
            scanner.session_ends(now);
            self.drive();
        }
        for line in 0..self.lines.len() {
            let except = primary.and_then(|(of, device)| (of == line).then_some(device));
            self.lines[line].command(now, command, except, &mut self.effects);
            self.settle(line);
        }
    }

    /// Lets time pass: does everything that is due by `now`, each at the time it was due.
    pub fn advance(&mut self, now: Nanos) {
        while let Some(due) = self.poll_timeout().filter(|due| *due <= now) {
            // A driver may ask for a time that has passed; time still never goes back.
            let due = due.max(self.now);
            self.now = due;
            self.patience.passed(due);
            if self.joiner.poll_timeout().is_some_and(|wanted| wanted <= due) {
                self.joiner.timeout(due, &mut self.joined);
                self.emit();
            }
            if self.primary_held.is_some_and(|until| until <= due) {
                self.start_primary();
            }
            for line in 0..self.lines.len() {
                if self.lines[line].poll_timeout().is_some_and(|wanted| wanted <= due) {
                    self.lines[line].timeout(due, &mut self.effects);
                    self.settle(line);
                }
            }
            if let Some(scanner) = &mut self.scanner
                && scanner.poll_timeout().is_some_and(|wanted| wanted <= due)
            {
                scanner.timeout(due);
            }
            self.drive();
        }
        self.now = self.now.max(now);
        self.patience.passed(self.now);
    }

    /// The host was held up until `until`, and whatever came meanwhile may still lie unread. So what was due is
    /// put off until there was time to read it: a heartbeat that waits in a buffer was not missed. Comes before
    /// anything that happened after it. `suspended` is how long of that the computer was suspended.
    pub fn held_up(&mut self, until: Nanos, suspended: Duration) {
        if self.last_primary.is_some() {
            self.suspended += suspended;
        }
        self.patience.held_up(self.now, until);
        self.joiner.held_up(self.patience.put_off(until));
    }

    /// The time of the latest happening, or of what was done since.
    pub fn now(&self) -> Nanos {
        self.now
    }

    /// When [`Bench::advance`] is to be called at the latest.
    pub fn poll_timeout(&self) -> Option<Nanos> {
        let lines = self.lines.iter().filter_map(Line::poll_timeout);
        let scan = self.scanner.as_ref().and_then(|scanner| scanner.poll_timeout());
        let due =
            lines.chain(self.joiner.poll_timeout()).chain(self.primary_held).chain(scan).min();
        due.map(|due| self.patience.put_off(due))
    }

    /// The next thing to be done with a link.
    pub fn poll_action(&mut self) -> Option<Action> {
        self.actions.pop_front()
    }

    /// The points made since the last call, in the order of their triggers.
    pub fn take_points(&mut self) -> Vec<Point> {
        std::mem::take(&mut self.points)
    }

    /// Whether, at `now`, the scan is over.
    pub fn ended(&self, now: Nanos) -> Option<Ended> {
        let seen = self.records + self.joiner.lost();
        if self.scanner.as_ref().is_some_and(|scanner| scanner.is_ended()) {
            return Some(Ended::Complete);
        }
        if self.end.points.is_some_and(|points| seen >= points && self.joiner.pending() == 0) {
            return Some(Ended::Complete);
        }
        self.idle_at().is_some_and(|due| due <= now).then_some(Ended::Idle)
    }

    /// When the scan will be over if no more readings come.
    pub fn idle_at(&self) -> Option<Nanos> {
        if self.waits_for_orders() {
            return None;
        }
        Some(self.patience.put_off(self.last_primary? + self.end.idle?))
    }

    /// When a scan whose first trigger does not come will be given up; `None` once it came. A device that becomes ready begins
    /// the wait anew.
    pub fn first_by(&self) -> Option<Nanos> {
        let by = match self.ready_since.or(self.open_since) {
            _ if self.last_primary.is_some() => return None,
            _ if self.waits_for_orders() && self.is_ready() => return None,
            Some(since) => since + self.end.first?,
            None => self.started? + self.end.open?,
        };
        Some(self.patience.put_off(by))
    }

    /// Whether silence is no end: the devices measure when they are ordered to.
    fn waits_for_orders(&self) -> bool {
        self.scanner.as_ref().is_some_and(|scanner| scanner.keeps_session())
    }

    /// No more readings will come: gives up what still waits.
    pub fn flush(&mut self) {
        self.joiner.flush(self.now, &mut self.joined);
        self.emit();
    }

    /// Whether every device of the trigger is set up and would answer one.
    pub fn is_ready(&self) -> bool {
        self.streams.iter().all(|(line, device)| self.lines[*line].is_ready(*device))
    }

    /// Names of the links with a device of the trigger that have never opened.
    pub fn unopened(&self) -> impl Iterator<Item = &str> {
        let of_trigger = |line: usize| self.streams.iter().any(|(of, _)| *of == line);
        let lines = self.lines.iter().enumerate().filter(move |(line, _)| of_trigger(*line));
        lines.filter(|(_, line)| line.traffic().opened == 0).map(|(_, line)| line.name())
    }

    /// Names of the links with a device of the trigger that would not answer one.
    pub fn unready(&self) -> impl Iterator<Item = &str> {
        let ready = |line: usize| {
            let mut of_line = self.streams.iter().filter(move |(of, _)| *of == line);
            of_line.all(|(line, device)| self.lines[*line].is_ready(*device))
        };
        let lines = self.lines.iter().enumerate();
        lines.filter(move |(line, _)| !ready(*line)).map(|(_, line)| line.name())
    }

    /// The links.
    pub fn lines(&self) -> &[Line] {
        &self.lines
    }

    /// Triggers seen whose readings still wait for others.
    pub fn pending(&self) -> usize {
        self.joiner.pending()
    }

    /// Triggers seen or known to be lost.
    fn seen(&self) -> u64 {
        self.records + self.lost()
    }

    /// Triggers the scan should have had and that were neither seen nor known to be lost.
    pub fn missing(&self) -> u64 {
        self.end.points.map_or(0, |points| points.saturating_sub(self.seen()))
    }

    /// How the axes make points.
    pub fn kinematics(&self) -> &Kinematics {
        &self.kinematics
    }

    /// The calibration of the machine, if there is one.
    pub fn calibration(&self) -> Option<&CalibrationFile> {
        self.calibration.as_ref()
    }

    /// The primary's first count, if the counters had not been reset before the scan.
    pub fn unreset(&self) -> Option<u64> {
        self.joiner.unreset()
    }

    /// When the latest reading of the primary arrived.
    pub fn last_primary(&self) -> Option<Nanos> {
        self.last_primary
    }

    /// How long the computer was suspended since the first reading of the primary.
    pub fn suspended(&self) -> Duration {
        self.suspended
    }

    /// Triggers the primary device skipped.
    pub fn lost(&self) -> u64 {
        self.joiner.lost()
    }

    /// Triggers the devices of a link skipped.
    pub fn lost_on(&self, line: &Line) -> u64 {
        self.streams
            .iter()
            .zip(self.joiner.counts())
            .filter(|((of, _), _)| self.lines[*of].name() == line.name())
            .map(|(_, counts)| counts.lost)
            .sum()
    }

    /// Bytes and readings of every link and device, delivered and lost.
    pub fn figures(&self) -> Vec<LinkFigures> {
        let coordinates = self.coordinates();
        let mut figures: Vec<LinkFigures> = self
            .lines
            .iter()
            .enumerate()
            .map(|(line, link)| {
                let of_line = coordinates.iter().filter(|(at, ..)| *at == line);
                let of_line: Vec<_> =
                    of_line.map(|(_, device, channel)| (*device, *channel)).collect();
                link.figures(&of_line)
            })
            .collect();
        for ((line, device), counts) in self.streams.iter().zip(self.joiner.counts()) {
            let figures = &mut figures[*line].devices[*device];
            figures.lost = counts.lost;
            figures.unjoined = counts.unjoined;
            figures.ambiguous = counts.ambiguous + counts.repeated;
            figures.slips = counts.slips;
        }
        for ((line, device), clock) in self.streams.iter().zip(self.joiner.clocks()) {
            figures[*line].devices[*device].clock = clock.map(clock_figures);
        }
        figures
    }

    /// (line, device, channel) of every coordinate.
    fn coordinates(&self) -> Vec<(usize, usize, usize)> {
        self.kinematics
            .axes()
            .into_iter()
            .filter_map(|axis| axis.source)
            .map(|source| {
                let (line, device) = self.streams[source.stream];
                (line, device, source.channel)
            })
            .collect()
    }

    /// Does what a line wants.
    fn settle(&mut self, line: usize) {
        let mut effects = std::mem::take(&mut self.effects);
        for effect in effects.drain(..) {
            match effect {
                Effect::Send { epoch, bytes } => {
                    self.actions.push_back(Action::Send { line, epoch, bytes });
                }
                Effect::Confirm => self.actions.push_back(Action::Confirm { line }),
                Effect::Reopen { epoch } => self.actions.push_back(Action::Reopen { line, epoch }),
                Effect::Reading { device, reading } => {
                    if let Some(thermal) = &mut self.thermal {
                        thermal.take(line, device, &reading);
                    }
                    if let Some(stream) = self.stream(line, device) {
                        if stream == 0 {
                            self.last_primary = Some(reading.host);
                        }
                        if let Some(scanner) = &mut self.scanner {
                            scanner.reading(self.now, stream, &reading);
                        }
                        self.joiner.take(stream, reading, &mut self.joined);
                    }
                }
                Effect::Ready { device } => {
                    if let Some(stream) = self.stream(line, device) {
                        self.joiner.ready(stream, self.now);
                    }
                }
                Effect::Motion { event } => {
                    if let Some(scanner) = &mut self.scanner {
                        scanner.motion(self.now, &event);
                    }
                }
                Effect::Interrupted { device } => {
                    if let Some(scanner) = &mut self.scanner {
                        scanner.interrupted(self.now, line, self.lines[line].name());
                    }
                    if let Some(stream) = self.stream(line, device) {
                        self.joiner.interrupted(stream);
                    }
                }
            }
        }
        self.effects = effects;
        self.emit();
        self.ready_since = self.is_ready().then(|| self.ready_since.unwrap_or(self.now));
        // A driver that opens its link again for want of an answer does not begin the wait anew.
        let is_open = || self.streams.iter().all(|(line, _)| self.lines[*line].is_open());
        if self.ready_since.is_some() || self.open_since.is_none() && is_open() {
            self.open_since = Some(self.now);
        }
        if self.primary_held.is_some() && self.companions_ready() {
            self.start_primary();
        }
    }

    /// Whether the primary may start: its companions are ready, and temperatures are known.
    fn companions_ready(&self) -> bool {
        self.thermal.as_ref().is_none_or(Thermal::is_ready)
            && self.streams.iter().skip(1).all(|(line, device)| self.lines[*line].is_ready(*device))
    }

    /// Starts the device that was left out when all were told to.
    fn start_primary(&mut self) {
        self.primary_held = None;
        let Some((line, device)) = self.streams.first().copied() else { return };
        self.lines[line].command_device(self.now, device, Command::Start, &mut self.effects);
        self.settle(line);
    }

    fn stream(&self, line: usize, device: usize) -> Option<usize> {
        self.streams.iter().position(|stream| *stream == (line, device))
    }

    fn emit(&mut self) {
        self.records += self.joined.len() as u64;
        for record in self.joined.drain(..) {
            let correction = self.calibration.as_ref().map(CalibrationFile::correction);
            let first = self.points.len();
            self.kinematics.note_side(&record, &mut self.sides);
            self.kinematics.points(&record, correction, &mut self.points);
            if let Some(tip) = &self.tip {
                let up = self.kinematics.up(&record);
                for point in &mut self.points[first..] {
                    point.position_mm = tip.centre_mm(point.position_mm, up);
                }
            }
            if let Some(thermal) = &mut self.thermal {
                self.points[first..].iter_mut().for_each(|point| thermal.apply(point));
            }
            self.points[first..].iter_mut().for_each(|point| self.places.judge(point));
            if let Some(scanner) = &mut self.scanner {
                self.points[first..].iter_mut().for_each(|point| scanner.judge(point));
            }
        }
    }

    /// Thermal expansion that was taken out of good points; `None` where there is no table of it, or no good point.
    pub fn thermal(&self) -> Option<ThermalFigures> {
        self.thermal.as_ref().and_then(Thermal::figures)
    }

    /// Errors that all points have together, as far as their uncertainties are known.
    pub fn systematic(&self) -> Vec<Systematic> {
        let calibration = self.calibration.as_ref();
        systematic(&self.kinematics, self.sides, calibration, self.thermal().as_ref())
    }

    /// How well places are known that were joined by time; `None` where they were joined by count, or none is good.
    pub fn places(&self) -> Option<PlaceFigures> {
        self.places.figures()
    }
}

/// The scanner of a station that drives the scan by a plan, or has a device run its program.
fn scanner(
    plan: Option<ScanPlan>,
    program: Option<usize>,
    streams: &[(usize, usize)],
) -> Option<Box<dyn Scanner>> {
    if let Some(plan) = plan {
        return Some(Box::new(PlanScanner::new(plan, streams)));
    }
    let device = *streams.get(program?)?;
    Some(Box::new(ProgramScanner::new(device)))
}

/// How long the primary waits for a companion: opening and setting up a node takes well below a second.
const COMPANIONS_WAIT: Duration = Duration::from_secs(5);

#[cfg(test)]
mod tests;
