//! The state machine of moves: one command at a time, each reply known by its number, and a halt that goes before all.

use std::collections::VecDeque;
use std::time::Duration;

use asphera_link::{AxisMove, Motion, MotionEvent, MotionFailure, MotionTrouble, Nanos};

use crate::command::{ACCELERATION, Order, Reply, SPEED, axis_number, data};
use crate::reply;
use crate::settings::Settings;
use crate::warning::{self, Warning};

/// Moves of a stage.
#[derive(Debug)]
pub(crate) struct Mover {
    settings: Settings,
    state: State,
    /// Commands of the move that wait for their turn.
    queue: VecDeque<(u8, Order)>,
    /// Number of the next message.
    number: u8,
    /// Commands with a number were sent: a late reply to one may come even after a reconnect.
    is_used: bool,
    /// Speed and acceleration that were set on this connection, by axis.
    set: Vec<[Option<i64>; 2]>,
    /// The newest warning flag of a reply to a question for the position.
    flag: Option<&'static Warning>,
    outputs: VecDeque<Vec<u8>>,
    events: VecDeque<MotionEvent>,
}

#[derive(Clone, Debug, PartialEq)]
enum State {
    /// No move of ours.
    Still,
    /// A command waits for its reply.
    Commanding { number: u8, order: Order, deadline: Nanos },
    /// All commands are accepted: the axes run. A stage that homes has no reference before it stands.
    Running { homes: bool },
    /// A halt waits for its reply. Why, where it is no order.
    Halting { number: u8, deadline: Nanos, attempt: u8, failure: Option<MotionFailure> },
    /// The halt is accepted: the axes run out.
    Stopping { failure: Option<MotionFailure> },
}

impl Mover {
    pub(crate) fn new(settings: &Settings) -> Mover {
        Mover {
            state: State::Still,
            queue: VecDeque::new(),
            number: 0,
            is_used: false,
            set: vec![[None; 2]; settings.axes.len()],
            flag: None,
            outputs: VecDeque::new(),
            events: VecDeque::new(),
            settings: settings.clone(),
        }
    }

    /// Bytes of a halt with a number of its own.
    pub(crate) fn halt_bytes(&self) -> Vec<u8> {
        self.bytes(0, HALT_NUMBER, &Order::Stop)
    }

    pub(crate) fn order(&mut self, now: Nanos, motion: &Motion) -> Result<(), MotionFailure> {
        match motion {
            Motion::Halt => {
                self.halt(now, None);
                Ok(())
            }
            Motion::Run => {
                let detail = "a stage has no program: order moves";
                Err(MotionFailure::new(MotionTrouble::Refused, detail))
            }
            Motion::Home => {
                self.check_still()?;
                // Warnings are no reason not to home: some go away by it, and the stage itself rejects it with the others.
                self.queue = VecDeque::from([(self.settings.axis, Order::Home)]);
                self.next(now);
                Ok(())
            }
            Motion::Move(moves) => {
                self.check_free()?;
                let mut speeds = Vec::new();
                let mut places = Vec::new();
                for one in moves {
                    self.commands(one, &mut speeds, &mut places)?;
                }
                // A reply shows the first warning alone; all are asked for. Speeds come before places: the axes start together.
                let warnings = std::iter::once((0, Order::Warnings));
                self.queue = warnings.chain(speeds).chain(places).collect();
                self.next(now);
                Ok(())
            }
        }
    }

    fn check_still(&self) -> Result<(), MotionFailure> {
        if self.state != State::Still {
            let detail = "the stage still moves: wait until it stands";
            return Err(MotionFailure::new(MotionTrouble::Refused, detail));
        }
        Ok(())
    }

    fn check_free(&self) -> Result<(), MotionFailure> {
        self.check_still()?;
        // The stage clears what it noted of an earlier move when the next one begins.
        let trouble = self.flag.and_then(|flag| Some((flag, flag.trouble()?)));
        match trouble.filter(|(flag, _)| flag.is_bad) {
            Some((flag, trouble)) => Err(flag.failure(trouble)),
            None => Ok(()),
        }
    }

    /// The commands of a move of an axis.
    fn commands(
        &self,
        order: &AxisMove,
        speeds: &mut Vec<(u8, Order)>,
        places: &mut Vec<(u8, Order)>,
    ) -> Result<(), MotionFailure> {
        let axes = &self.settings.axes;
        let refused = |detail| MotionFailure::new(MotionTrouble::Refused, detail);
        let Some(index) = axes.iter().position(|axis| axis.name == order.axis) else {
            let names: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).collect();
            let expected = names.join(", ");
            return Err(refused(format!(
                "expected one of the axes {expected}, found {:?}: name an axis of the stage",
                order.axis
            )));
        };
        let (axis, number) = (&axes[index], axis_number(&self.settings, index));
        let beyond = |what: &str, value: f64| {
            refused(format!(
                "{what} {value} of axis {} is beyond the protocol: plan another",
                axis.name
            ))
        };
        let speed = data(axis, order.speed, SPEED).filter(|&speed| speed > 0);
        let speed = speed.ok_or_else(|| beyond("speed", order.speed))?;
        let acceleration = match order.acceleration {
            None => None,
            Some(value) => {
                // 0 would be an acceleration without limit.
                let data = data(axis, value, ACCELERATION).filter(|&data| data > 0);
                Some(data.ok_or_else(|| beyond("acceleration", value))?)
            }
        };
        let place = data(axis, order.to, 1.0).ok_or_else(|| beyond("place", order.to))?;
        let [old_speed, old_acceleration] = self.set[index];
        if old_speed != Some(speed) {
            speeds.push((number, Order::Speed(speed)));
        }
        if let Some(data) = acceleration.filter(|&data| old_acceleration != Some(data)) {
            speeds.push((number, Order::Acceleration(data)));
        }
        places.push((number, Order::MoveTo(place)));
        Ok(())
    }

    /// Halts every axis: what waits is dropped, and the halt goes first.
    fn halt(&mut self, now: Nanos, failure: Option<MotionFailure>) {
        self.queue.clear();
        self.outputs.clear();
        self.send_halt(now, 1, failure);
    }

    fn send_halt(&mut self, now: Nanos, attempt: u8, failure: Option<MotionFailure>) {
        let number = self.take_number();
        self.outputs.push_back(self.bytes(0, number, &Order::Stop));
        self.state = State::Halting { number, deadline: self.deadline(now), attempt, failure };
    }

    /// Sends the next command, or the axes run.
    fn next(&mut self, now: Nanos) {
        let Some((axis, order)) = self.queue.pop_front() else {
            let homes = matches!(self.state, State::Commanding { order: Order::Home, .. });
            self.state = State::Running { homes };
            return;
        };
        let number = self.take_number();
        self.outputs.push_back(self.bytes(axis, number, &order));
        self.state = State::Commanding { number, order, deadline: self.deadline(now) };
        if let State::Commanding { order: Order::Speed(_) | Order::Acceleration(_), .. } =
            self.state
        {
            // Known once it is accepted; a refused one ends the move.
            self.note(axis);
        }
    }

    fn note(&mut self, axis: u8) {
        let index = (0..self.set.len()).find(|&index| axis_number(&self.settings, index) == axis);
        let Some(index) = index else { return };
        match self.state {
            State::Commanding { order: Order::Speed(data), .. } => self.set[index][0] = Some(data),
            State::Commanding { order: Order::Acceleration(data), .. } => {
                self.set[index][1] = Some(data);
            }
            _ => {}
        }
    }

    /// Takes a reply. Whether it was one to a command of a move.
    pub(crate) fn reply(&mut self, now: Nanos, reply: &Reply<'_>) -> bool {
        match reply.number {
            Some(number) if self.is_used || number == HALT_NUMBER => {
                self.answered(now, number, reply);
                true
            }
            // Questions for the position have none.
            Some(_) => false,
            None => {
                if reply.is_accepted {
                    self.position(now, reply);
                }
                false
            }
        }
    }

    fn answered(&mut self, now: Nanos, number: u8, reply: &Reply<'_>) {
        match self.state.clone() {
            State::Commanding { number: asked, order, .. } if asked == number => {
                if reply.is_accepted {
                    match warning::worst(reply.data).filter(|_| order == Order::Warnings) {
                        None => self.next(now),
                        // Nothing moves yet.
                        Some(failure) => {
                            self.queue.clear();
                            self.state = State::Still;
                            self.events.push_back(MotionEvent::Failed(failure));
                        }
                    }
                    return;
                }
                self.set.iter_mut().for_each(|set| *set = [None; 2]);
                let words = order.words();
                let cure = rejection_cure(reply.data);
                let detail = format!("the stage rejects `{words}` with {}: {cure}", reply.data);
                self.halt(now, Some(MotionFailure::new(MotionTrouble::Refused, detail)));
            }
            State::Halting { number: asked, failure, .. } if asked == number => {
                self.state = State::Stopping { failure };
            }
            // Of a halt or a move that was given up.
            _ => {}
        }
    }

    /// Takes the state of the axes that comes with every position.
    fn position(&mut self, now: Nanos, reply: &Reply<'_>) {
        self.flag = warning::find(reply.warning);
        let trouble = self.flag.and_then(|flag| Some(flag.failure(flag.trouble()?)));
        match &self.state {
            State::Running { homes } => {
                let is_on_the_way = *homes && reply.is_busy;
                let counts = |failure: &MotionFailure| {
                    !(is_on_the_way && failure.kind == MotionTrouble::Unreferenced)
                };
                if let Some(failure) = trouble.filter(counts) {
                    self.halt(now, Some(failure));
                } else if !reply.is_busy {
                    self.state = State::Still;
                    self.events.push_back(MotionEvent::Arrived);
                }
            }
            State::Stopping { failure } if !reply.is_busy => {
                let event = failure.clone().map_or(MotionEvent::Halted, MotionEvent::Failed);
                self.state = State::Still;
                self.events.push_back(event);
            }
            _ => {}
        }
    }

    pub(crate) fn timeout(&mut self, now: Nanos) {
        if self.poll_timeout().is_none_or(|due| now < due) {
            return;
        }
        let timeout_ms = self.settings.timeout_ms;
        match self.state.clone() {
            State::Commanding { order, .. } => {
                self.set.iter_mut().for_each(|set| *set = [None; 2]);
                let words = order.words();
                let detail = format!(
                    "no answer to `{words}` within {timeout_ms} ms: check the cable and the power of the stage"
                );
                self.halt(now, Some(MotionFailure::new(MotionTrouble::Unanswered, detail)));
            }
            State::Halting { attempt, failure, .. } if attempt < HALT_ATTEMPTS => {
                self.send_halt(now, attempt + 1, failure);
            }
            State::Halting { attempt, .. } => {
                let detail =
                    format!("no answer to `stop`, sent {attempt} times: press the emergency stop");
                self.state = State::Still;
                let failure = MotionFailure::new(MotionTrouble::Unanswered, detail);
                self.events.push_back(MotionEvent::Failed(failure));
            }
            State::Still | State::Running { .. } | State::Stopping { .. } => {}
        }
    }

    pub(crate) fn poll_timeout(&self) -> Option<Nanos> {
        match self.state {
            State::Commanding { deadline, .. } | State::Halting { deadline, .. } => Some(deadline),
            State::Still | State::Running { .. } | State::Stopping { .. } => None,
        }
    }

    /// The connection is gone, or new: nothing of before counts.
    pub(crate) fn forget(&mut self) {
        let (is_used, number) = (self.is_used, self.number);
        *self = Mover { is_used, number, ..Mover::new(&self.settings) };
    }

    pub(crate) fn poll_transmit(&mut self) -> Option<Vec<u8>> {
        self.outputs.pop_front()
    }

    pub(crate) fn poll_event(&mut self) -> Option<MotionEvent> {
        self.events.pop_front()
    }

    fn bytes(&self, axis: u8, number: u8, order: &Order) -> Vec<u8> {
        let Settings { address, checksum, .. } = self.settings;
        reply::numbered(address, axis, number, &order.words(), checksum)
    }

    fn take_number(&mut self) -> u8 {
        let number = self.number;
        self.is_used = true;
        self.number = (number + 1) % HALT_NUMBER;
        number
    }

    fn deadline(&self, now: Nanos) -> Nanos {
        now + Duration::from_millis(self.settings.timeout_ms.into())
    }
}

/// The cure of a rejection, by its word.
fn rejection_cure(word: &str) -> &'static str {
    match word {
        "BADDATA" => {
            "the place lies beyond the stage's own limits, or it has no such speed: plan within them"
        }
        "BADAXIS" => "the device has no such axis: correct the settings of the device",
        "STATUSBUSY" => "something else moves the stage: end that",
        "DRIVERDISABLED" | "PARKED" | "INACTIVE" => "make the axis ready with Zaber Launcher",
        _ => "see Zaber's manual",
    }
}

/// Number of the halt that is sent past the state machine; commands count below it.
const HALT_NUMBER: u8 = 99;
/// How often a halt is sent until it is answered.
const HALT_ATTEMPTS: u8 = 5;
