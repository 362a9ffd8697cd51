//! Answers to requests, and the next request.

use asphera_link::{Event, FaultKind, MotionEvent, MotionFailure, MotionTrouble, Nanos};

use super::steps::{AGAIN, Goal, InFlight, Step, Use, control_step};
use super::{Cia402, HALT_ATTEMPTS, Job, Order, STILL};
use crate::wire::{AbortCode, PowerState, SdoRequest, SdoResponse, Statusword, control, object};

/// How often a request is sent before the node counts as silent.
const TRIES: u8 = 3;

impl Cia402 {
    /// Sends the next step, or the job is at its end.
    pub(super) fn go_on(&mut self, now: Nanos) {
        let Some(mut step) = self.steps.pop_front() else { return self.steps_done(now) };
        if let Step::Until { by, .. } = &mut step {
            let timeout = std::time::Duration::from_millis(self.settings.state_timeout_ms.into());
            by.get_or_insert(now + timeout);
        }
        let request = step.request();
        self.transmit.push_back(request.encode(self.node));
        let until = now + self.sdo_timeout();
        self.in_flight = Some(InFlight { request, step, until, tries: 1 });
    }

    fn steps_done(&mut self, now: Nanos) {
        match self.job.clone() {
            Job::Setup => self.configured(now),
            Job::Preparing(order) => self.job = Job::Running(order),
            Job::Concluding => {
                self.job = Job::Rest;
                self.events.push(Event::Motion(MotionEvent::Arrived));
            }
            Job::Halting { failure, .. } => {
                let event = failure.map_or(MotionEvent::Halted, MotionEvent::Failed);
                self.events.push(Event::Motion(event));
                self.halted(now);
            }
            Job::Closed | Job::Waiting { .. } | Job::Rest | Job::Running(_) => {}
        }
    }

    pub(super) fn on_sdo(&mut self, now: Nanos, data: &[u8]) {
        let Some(InFlight { request, step, .. }) = self.in_flight.clone() else {
            return self.discard(data);
        };
        let answer = match (SdoResponse::decode(self.node, data), request) {
            // Not ours: a late answer to an earlier request, or to another master.
            (Ok(response), _) if response.address() != request.address() => {
                return self.discard(data);
            }
            (Ok(SdoResponse::Uploaded(_, value)), SdoRequest::Upload(_)) => Ok(value.number()),
            (Ok(SdoResponse::Downloaded(_)), SdoRequest::Download(..)) => Ok(0),
            (Ok(SdoResponse::Aborted(_, code)), _) => Err(code),
            _ => return self.discard(data),
        };
        self.in_flight = None;
        match answer {
            Ok(value) => self.answered(now, step, value),
            Err(code) => self.refused(now, step, code),
        }
    }

    fn answered(&mut self, now: Nanos, step: Step, value: u32) {
        match step {
            Step::Write { .. } => self.go_on(now),
            Step::Read(_, what) => self.learned(now, what, value),
            Step::Until { goal, by } => {
                let is_late = by.is_some_and(|by| by <= now);
                self.judged(now, goal, value, is_late, step);
            }
        }
    }

    /// Takes a value of the set-up.
    fn learned(&mut self, now: Nanos, what: Use, value: u32) {
        let node = self.node;
        match what {
            Use::Profile if value as u16 != object::PROFILE_402 => {
                let detail = format!(
                    "node {node} follows profile {} (device type {value:08X}h), expected 402: set node_id, or connect a drive",
                    value as u16
                );
                return self.give_up(now, FaultKind::Refused, detail);
            }
            Use::Vendor(vendor) if value != vendor => {
                let detail = format!(
                    "node {node} has vendor {value:X}h, expected {vendor:X}h: set vendor_id, or connect the right node"
                );
                return self.give_up(now, FaultKind::Refused, detail);
            }
            Use::Profile | Use::Vendor(_) => {}
            Use::ErrorRegister => {
                self.events.prove_online();
                self.error = value != 0;
                if self.error {
                    let detail =
                        format!("node {node} has error register {value:02X}h: see its manual");
                    self.events.fault(FaultKind::Device, detail);
                }
            }
            Use::Modes => {
                let needed = match self.settings.homing {
                    Some(_) => object::HAS_PROFILE_POSITION | object::HAS_HOMING,
                    None => object::HAS_PROFILE_POSITION,
                };
                if value & needed != needed {
                    let detail = format!(
                        "node {node} has modes {value:08X}h, expected profile position and, for [homing], homing: connect a drive that has them"
                    );
                    return self.give_up(now, FaultKind::Refused, detail);
                }
            }
            Use::PowerOff => {
                // Nobody changes the mode of a drive that may be moving by another's order.
                let state = Statusword(value as u16).state();
                if matches!(state, Some(PowerState::OperationEnabled | PowerState::QuickStopActive))
                {
                    self.steps.clear();
                }
            }
            Use::Attained => {
                let status = Statusword(value as u16);
                self.is_homed = status.is_acknowledged() && !status.has_mode_error();
            }
        }
        self.go_on(now);
    }

    /// Takes a value that a job waits for.
    fn judged(&mut self, now: Nanos, goal: Goal, value: u32, is_late: bool, step: Step) {
        let status = Statusword(value as u16);
        let is_reached = match goal {
            Goal::Mode(mode) | Goal::ModeForQuestion(mode) => value as u8 == mode,
            Goal::Enabled => status.state() == Some(PowerState::OperationEnabled),
            Goal::Acknowledged => status.is_acknowledged(),
            Goal::Standing => self.stands(now, status),
        };
        if is_reached {
            return self.go_on(now);
        }
        if is_late {
            return self.missed(now, goal, status, value);
        }
        self.steps.push_front(step);
        let next =
            status.state().and_then(PowerState::next_control).filter(|_| goal == Goal::Enabled);
        match next {
            Some(word) => {
                self.steps.push_front(control_step(word));
                if word == control::FAULT_RESET {
                    // The drive takes the rising edge alone.
                    self.steps.push_front(control_step(control::DISABLE_VOLTAGE));
                }
                self.go_on(now);
            }
            None => self.resume = Some(now + AGAIN),
        }
    }

    fn stands(&self, now: Nanos, status: Statusword) -> bool {
        match status.state() {
            Some(PowerState::QuickStopActive) => {
                let is_still = self.still.is_some_and(|(_, since)| now.since(since) >= STILL);
                status.is_target_reached() || is_still && self.is_measuring
            }
            Some(PowerState::OperationEnabled | PowerState::FaultReactionActive) | None => false,
            Some(_) => true,
        }
    }

    /// The time for a goal has run out.
    fn missed(&mut self, now: Nanos, goal: Goal, status: Statusword, value: u32) {
        let ms = self.settings.state_timeout_ms;
        let failure = |detail| Some(MotionFailure::new(MotionTrouble::Device, detail));
        match goal {
            // It is only asked: whether the drive is homed stays unknown.
            Goal::ModeForQuestion(_) => {
                self.steps.clear();
                self.go_on(now);
            }
            Goal::Mode(mode) => {
                let mode_now = value as u8;
                let detail = format!(
                    "the drive stays in mode {mode_now} for {ms} ms, expected {mode}: see its manual, and that no other master controls it"
                );
                self.halt(now, failure(detail));
            }
            Goal::Enabled => {
                let detail = format!(
                    "the drive is in state {status} after {ms} ms, expected operation enabled: check its supply, its enable input and its fault"
                );
                self.halt(now, failure(detail));
            }
            Goal::Acknowledged => {
                let detail = format!(
                    "the drive did not take its target within {ms} ms ({status}): see whether it lies within its limits"
                );
                self.halt(now, failure(detail));
            }
            Goal::Standing => self.halt_again(now),
        }
    }

    fn refused(&mut self, now: Nanos, step: Step, code: AbortCode) {
        let address = step.request().address();
        if let Step::Write { is_optional: true, .. } | Step::Read(_, Use::Modes) = step {
            return self.go_on(now);
        }
        if let Step::Read(_, Use::ErrorRegister) = step
            && code.is_absent()
        {
            return self.learned(now, Use::ErrorRegister, 0);
        }
        let verb = match step {
            Step::Write { value, .. } => format!("writing {:X}h to", value.number()),
            _ => "reading".to_owned(),
        };
        let detail = format!("node {} refused {verb} {address}: {code}; see its manual", self.node);
        match self.job {
            Job::Setup => self.give_up(now, FaultKind::Refused, detail),
            Job::Halting { .. } => self.halt_again(now),
            _ => self.halt(now, Some(MotionFailure::new(MotionTrouble::Refused, detail))),
        }
    }

    /// What was due in the job.
    pub(super) fn step_timeout(&mut self, now: Nanos) {
        if self.resume.is_some_and(|at| at <= now) {
            self.resume = None;
            return self.go_on(now);
        }
        let timeout = self.sdo_timeout();
        let Some(waiting) = self.in_flight.as_mut().filter(|waiting| waiting.until <= now) else {
            return;
        };
        let address = waiting.request.address();
        let is_setup = self.job == Job::Setup;
        // A question may be asked again. A controlword is an edge: it is not.
        let may_repeat = is_setup || matches!(waiting.request, SdoRequest::Upload(_));
        if may_repeat && waiting.tries < TRIES {
            waiting.tries += 1;
            waiting.until = now + timeout;
            let frame = waiting.request.encode(self.node);
            self.transmit.push_back(frame);
            return;
        }
        let tries = waiting.tries;
        self.in_flight = None;
        let detail = format!(
            "node {} did not answer for {address} within {tries} times {} ms: check node number, bit rate, cable and power",
            self.node, self.settings.sdo_timeout_ms
        );
        match self.job {
            Job::Setup => {
                let abort = SdoRequest::Abort(address, AbortCode::TIMED_OUT);
                self.transmit.push_back(abort.encode(self.node));
                self.give_up(now, FaultKind::Timeout, detail);
            }
            Job::Halting { .. } => self.halt_again(now),
            _ => self.halt(now, Some(MotionFailure::new(MotionTrouble::Unanswered, detail))),
        }
    }

    fn sdo_timeout(&self) -> std::time::Duration {
        std::time::Duration::from_millis(self.settings.sdo_timeout_ms.into())
    }

    fn halt_again(&mut self, now: Nanos) {
        let Job::Halting { failure, attempt } = self.job.clone() else { return };
        if attempt < HALT_ATTEMPTS {
            return self.send_halt(now, failure, attempt + 1);
        }
        let why = failure.map(|failure| format!("{}; ", failure.detail)).unwrap_or_default();
        let detail = format!(
            "{why}the drive does not stand after a quick stop, sent {attempt} times: press the emergency stop"
        );
        let failure = MotionFailure::new(MotionTrouble::Unanswered, detail);
        self.events.push(Event::Motion(MotionEvent::Failed(failure)));
        self.halted(now);
    }

    /// The halt is over: a node that was lost meanwhile is set up.
    fn halted(&mut self, now: Nanos) {
        self.steps.clear();
        (self.in_flight, self.resume) = (None, None);
        self.job = Job::Rest;
        if !self.is_configured {
            self.begin_setup(now);
        }
    }

    /// Takes the statusword that comes with every position.
    pub(super) fn follow(&mut self, now: Nanos, status: Statusword) {
        let Job::Running(order) = self.job else { return };
        let failure = |trouble, detail: String| Some(MotionFailure::new(trouble, detail));
        match status.state() {
            Some(PowerState::OperationEnabled) => {}
            Some(PowerState::Fault | PowerState::FaultReactionActive) => {
                let detail = format!(
                    "the drive has a fault ({status}): its emergency says which; see its manual"
                );
                return self.halt(now, failure(MotionTrouble::Device, detail));
            }
            _ => {
                let detail = format!(
                    "the drive left operation enabled ({status}): look who stopped it, or opened its enable input"
                );
                return self.halt(now, failure(MotionTrouble::Interrupted, detail));
            }
        }
        match order {
            Order::Home if status.has_mode_error() => {
                let detail = "the drive reports a homing error: check its switches, and [homing] method and speeds";
                self.halt(now, failure(MotionTrouble::Device, detail.to_owned()));
            }
            Order::Home if status.is_acknowledged() && status.is_target_reached() => {
                self.is_homed = true;
                self.begin(now, Job::Concluding, vec![control_step(control::ENABLE_OPERATION)]);
            }
            Order::Home => {}
            Order::Move if status.has_mode_error() => {
                let detail = "the axis does not follow its motor (following error): look whether something blocks it, or move slower";
                self.halt(now, failure(MotionTrouble::Stalled, detail.to_owned()));
            }
            Order::Move if status.is_limited() => {
                let detail = "the axis ran into a limit of the drive: move it away from there, and compare the travel in [scan.plan] with the drive's limits";
                self.halt(now, failure(MotionTrouble::Limit, detail.to_owned()));
            }
            Order::Move if status.is_target_reached() && !status.is_acknowledged() => {
                self.job = Job::Rest;
                self.events.push(Event::Motion(MotionEvent::Arrived));
            }
            Order::Move => {}
        }
    }
}
