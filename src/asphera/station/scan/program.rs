//! The scanner of a machine that runs a program of its own: a coordinate measuring machine.
//!
//! ```text
//!             arm              device ready           program complete
//! Disarmed ─────────▶ Armed ────────────────▶ Running ────────────────▶ Settling ─▶ Ended
//!                       │                        │
//!                       └───── stop, trouble ────┴──▶ Broken off
//! ```
//!
//! A program that broke off is not begun again in the same session: its first points would be measured twice.

use std::collections::VecDeque;

use asphera_link::{Motion, MotionEvent, MotionFailure, Nanos};
use asphera_report::ScanFigures;

use super::scanner::{ArmError, Order, Scanner};
use super::{Point, SETTLE};

/// Scanner of a station whose device runs a program.
#[derive(Debug)]
pub(in crate::station) struct ProgramScanner {
    /// (line, device on that line).
    device: (usize, usize),
    state: State,
    orders: VecDeque<Order>,
    /// A halt is due as soon as the link opens.
    halts_when_open: bool,
    /// When the program began.
    began: Option<Nanos>,
    /// Good points so far.
    points: u64,
}

#[derive(Clone, Debug, PartialEq)]
enum State {
    /// Nothing moves yet.
    Disarmed,
    /// Waits for the device.
    Armed,
    /// The program runs.
    Running,
    /// Stands until the last points are joined.
    Settling { until: Nanos },
    /// The program is complete.
    Ended,
    /// The program broke off, or was never begun.
    BrokenOff { why: String },
}

impl ProgramScanner {
    /// A disarmed scanner of the device at (line, device on that line).
    pub(in crate::station) fn new(device: (usize, usize)) -> ProgramScanner {
        ProgramScanner {
            device,
            state: State::Disarmed,
            orders: VecDeque::new(),
            halts_when_open: false,
            began: None,
            points: 0,
        }
    }

    fn is_active(&self) -> bool {
        matches!(self.state, State::Armed | State::Running | State::Settling { .. })
    }

    /// Halts the device, before anything else that was ordered.
    fn halt(&mut self) {
        self.orders.clear();
        self.orders.push_back(Order { device: self.device, motion: Motion::Halt });
    }

    fn trouble(&mut self, why: String) {
        self.halt();
        self.state = State::BrokenOff { why };
    }
}

impl Scanner for ProgramScanner {
    fn arm(&mut self, _now: Nanos) -> Result<(), ArmError> {
        match self.state {
            State::Disarmed => {
                self.state = State::Armed;
                Ok(())
            }
            State::Armed | State::Running | State::Settling { .. } => Err(ArmError::Armed),
            State::Ended => Err(ArmError::Ended),
            State::BrokenOff { .. } => Err(ArmError::BrokenOff),
        }
    }

    fn stop(&mut self, _now: Nanos) {
        self.halt();
        if self.is_active() {
            self.state = State::BrokenOff { why: "stopped by hand".to_owned() };
        }
    }

    fn session_ends(&mut self, _now: Nanos) {
        if self.is_active() {
            self.trouble("the session ended".to_owned());
        }
    }

    fn keeps_session(&self) -> bool {
        !matches!(self.state, State::Ended | State::BrokenOff { .. })
    }

    fn spent_s(&self, now: Nanos) -> f64 {
        self.began.map_or(0.0, |began| now.since(began).as_secs_f64())
    }

    fn is_ended(&self) -> bool {
        self.state == State::Ended
    }

    fn interrupted(&mut self, _now: Nanos, line: usize, name: &str) {
        if line == self.device.0 && self.is_active() {
            self.trouble(format!("the link {name} was lost: check its cable and the machine"));
            // What is ordered now may not reach it any more.
            self.halts_when_open = true;
        }
    }

    fn opened(&mut self, line: usize) {
        if line == self.device.0 && std::mem::take(&mut self.halts_when_open) {
            self.orders.push_back(Order { device: self.device, motion: Motion::Halt });
        }
    }

    fn motion(&mut self, now: Nanos, event: &MotionEvent) {
        match event {
            MotionEvent::Arrived if self.state == State::Running => {
                self.state = State::Settling { until: now + SETTLE };
            }
            MotionEvent::Failed(failure) => self.failed(now, failure),
            MotionEvent::Arrived | MotionEvent::Halted => {}
        }
    }

    fn failed(&mut self, _now: Nanos, failure: &MotionFailure) {
        if self.is_active() {
            self.trouble(failure.detail.clone());
        } else if let State::BrokenOff { why } = &mut self.state
            && !why.contains(&failure.detail)
        {
            // As a halt that nobody answers.
            *why = format!("{why}; {}", failure.detail);
        }
    }

    fn advance(&mut self, now: Nanos, is_ready: bool) {
        if self.state == State::Armed && is_ready {
            self.began = Some(now);
            self.state = State::Running;
            self.orders.push_back(Order { device: self.device, motion: Motion::Run });
        }
    }

    fn timeout(&mut self, now: Nanos) {
        if matches!(self.state, State::Settling { until } if until <= now) {
            self.state = State::Ended;
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        match self.state {
            State::Settling { until } => Some(until),
            _ => None,
        }
    }

    fn poll_order(&mut self) -> Option<Order> {
        self.orders.pop_front()
    }

    fn judge(&mut self, point: &mut Point) {
        self.points += u64::from(point.is_good());
    }

    fn figures(&self, now: Nanos) -> ScanFigures {
        let (state, text) = match &self.state {
            State::Disarmed => ("disarmed", "nothing moves until the scan is armed"),
            State::Armed => ("armed", "waits for the machine"),
            State::Running => ("moving", "the machine runs its program"),
            State::Settling { .. } => ("moving", "the last points are joined"),
            State::Ended => ("ended", "the program is complete"),
            State::BrokenOff { why } => ("disarmed", why.as_str()),
        };
        ScanFigures {
            state: state.to_owned(),
            text: text.to_owned(),
            place_mm: None,
            next_mm: None,
            pass: 1,
            pieces: 1,
            pieces_done: u64::from(matches!(self.state, State::Settling { .. } | State::Ended)),
            points: self.points,
            spent_s: self.spent_s(now),
            time_limit_s: None,
        }
    }

    fn unhalted(&mut self, _device: (usize, usize)) {
        self.halts_when_open = true;
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use asphera_link::MotionTrouble;

    use super::*;

    const DEVICE: (usize, usize) = (2, 0);

    type Trouble<'a> = &'a dyn Fn(&mut ProgramScanner);

    fn at(ms: u64) -> Nanos {
        Nanos::from_millis(ms)
    }

    fn orders(scanner: &mut ProgramScanner) -> Vec<Motion> {
        std::iter::from_fn(|| scanner.poll_order()).map(|order| order.motion).collect()
    }

    fn running() -> ProgramScanner {
        let mut scanner = ProgramScanner::new(DEVICE);
        scanner.advance(at(0), true);
        assert_eq!(orders(&mut scanner), [], "nothing moves before it is armed");
        scanner.arm(at(10)).unwrap();
        scanner.advance(at(20), false);
        assert_eq!(orders(&mut scanner), [], "nothing moves before the machine is ready");
        scanner.advance(at(30), true);
        scanner.advance(at(40), true);
        assert_eq!(orders(&mut scanner), [Motion::Run], "once");
        scanner
    }

    fn text(scanner: &ProgramScanner) -> String {
        let figures = scanner.figures(at(100));
        format!("{}: {}", figures.state, figures.text)
    }

    #[test]
    fn a_program_runs_once_and_ends() {
        let mut scanner = running();
        assert!(scanner.keeps_session());
        assert_eq!(scanner.arm(at(50)), Err(ArmError::Armed));
        scanner.motion(at(60), &MotionEvent::Arrived);
        assert!(!scanner.is_ended());
        let due = scanner.poll_timeout().unwrap();
        assert_eq!(due, at(60) + SETTLE);
        scanner.timeout(due);
        assert!(scanner.is_ended() && !scanner.keeps_session());
        assert_eq!(scanner.arm(due), Err(ArmError::Ended));
        assert_eq!(text(&scanner), "ended: the program is complete");
        assert!((scanner.spent_s(at(1030)) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn trouble_halts_and_the_program_is_not_begun_again() {
        let failure = MotionFailure::new(MotionTrouble::Limit, "beyond its volume");
        let troubles: [(Trouble<'_>, &str); 4] = [
            (&|one| one.motion(at(50), &MotionEvent::Failed(failure.clone())), "beyond its volume"),
            (&|one| one.stop(at(50)), "stopped by hand"),
            (&|one| one.session_ends(at(50)), "the session ended"),
            (
                &|one| one.interrupted(at(50), 2, "cmm"),
                "the link cmm was lost: check its cable and the machine",
            ),
        ];
        for (trouble, why) in troubles {
            let mut scanner = running();
            trouble(&mut scanner);
            assert_eq!(orders(&mut scanner), [Motion::Halt], "{why}");
            assert_eq!(text(&scanner), format!("disarmed: {why}"));
            assert_eq!(scanner.arm(at(60)), Err(ArmError::BrokenOff));
            assert!(!scanner.keeps_session() && !scanner.is_ended());
            scanner.motion(at(70), &MotionEvent::Arrived);
            assert_eq!(scanner.poll_timeout(), None);
        }
    }

    #[test]
    fn a_machine_whose_link_was_lost_is_halted_when_it_opens() {
        let mut scanner = running();
        scanner.interrupted(at(50), 1, "other");
        assert_eq!(orders(&mut scanner), []);
        scanner.interrupted(at(50), 2, "cmm");
        orders(&mut scanner);
        scanner.opened(1);
        assert_eq!(orders(&mut scanner), []);
        scanner.opened(2);
        assert_eq!(orders(&mut scanner), [Motion::Halt]);
        scanner.opened(2);
        assert_eq!(orders(&mut scanner), []);
        // A stop halts whatever the state.
        scanner.stop(at(60) + Duration::from_secs(1));
        assert_eq!(orders(&mut scanner), [Motion::Halt]);
    }
}
