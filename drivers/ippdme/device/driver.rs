//! The machine as a driver: connections, bytes, time and orders.

use asphera_link::{
    Channel, Command, Driver, Event, Input, Motion, MotionFailure, MotionTrouble, Nanos, Output,
};

use super::{ABORT, BRAKE, Ippdme, Link, line, script};
use crate::wire::Tag;

impl Driver for Ippdme {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn connected(&mut self, now: Nanos) {
        self.framer.reset();
        self.forget();
        self.link = Link::Open;
        self.steps = script::set_up(&self.settings);
        self.next(now);
    }

    fn disconnected(&mut self, _now: Nanos) {
        let bytes = self.framer.reset();
        if bytes > 0 {
            self.events.push(Event::Discarded { bytes });
        }
        self.forget();
        self.link = Link::Closed;
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Bytes(bytes) = input else { return };
        for (at, &byte) in bytes.iter().enumerate() {
            if matches!(self.link, Link::Distrusted | Link::Closed) {
                let bytes = (bytes.len() - at) as u64;
                self.events.push(Event::Discarded { bytes });
                return;
            }
            match self.framer.push(byte) {
                Ok(None) => {}
                Ok(Some(line)) => self.take_line(now, &line),
                Err(error) => {
                    let bytes = self.framer.reset() + 1;
                    self.distrust(bytes, format!("{error}: check address and port of the link"));
                }
            }
        }
    }

    fn timeout(&mut self, now: Nanos) {
        if let Some(halt) = self.halt.take_if(|halt| halt.deadline() <= now) {
            let tag = self.take_event_tag();
            let outcome = halt.timed_out(now, tag, self.answer_time());
            self.halt_outcome(now, outcome);
        }
        if self.halt.is_none() && self.current.as_ref().is_some_and(|one| one.deadline <= now) {
            self.unanswered(now);
        }
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        match &self.halt {
            Some(halt) => Some(halt.deadline()),
            None => self.current.as_ref().map(|current| current.deadline),
        }
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        self.outputs.pop_front().map(Output::Bytes)
    }

    fn poll_event(&mut self) -> Option<Event> {
        self.events.pop()
    }

    fn command(&mut self, now: Nanos, command: Command) {
        match command {
            Command::Start if self.has_ended => {
                self.has_ended = false;
                self.steps.extend(script::set_up(&self.settings));
            }
            Command::Stop if self.link == Link::Online && !self.has_ended => {
                self.steps.extend(script::end(self.was_aborted));
            }
            Command::Start | Command::Stop => {}
        }
        self.next(now);
    }

    fn motion(&mut self, now: Nanos, motion: &Motion) -> Result<(), MotionFailure> {
        let refused = |detail: &str| Err(MotionFailure::new(MotionTrouble::Refused, detail));
        if self.link == Link::Closed {
            let detail = "the machine has not answered on this connection: check its controller";
            return Err(MotionFailure::new(MotionTrouble::Unanswered, detail));
        }
        match motion {
            Motion::Halt => {
                self.halt(now, None);
                Ok(())
            }
            Motion::Move(_) | Motion::Home => {
                refused("a machine with I++ DME runs its program, and no single moves")
            }
            Motion::Run if self.is_running || self.halt.is_some() || !self.is_idle() => {
                refused("the machine is not ready, or runs its program: wait until it stands")
            }
            Motion::Run => {
                self.is_running = true;
                self.was_aborted = false;
                self.steps = script::program(&self.settings);
                self.next(now);
                Ok(())
            }
        }
    }

    fn halt_bytes(&self) -> Option<Vec<u8>> {
        Some(line(Tag::Event(BRAKE), ABORT))
    }
}
