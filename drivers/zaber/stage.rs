//! The driver: positions by the state machine of described devices, moves beside it on the same line.

use asphera_described::Described;
use asphera_link::{
    Channel, Command, Driver, Event, Input, Motion, MotionFailure, MotionTrouble, Nanos, Output,
};

use crate::command::Reply;
use crate::mover::Mover;
use crate::settings::Settings;

/// A stage on its line.
///
/// Replies to moves have numbers of messages, those to questions for the position have none. Each whole line is given to the
/// one or the other.
#[derive(Debug)]
pub(crate) struct Stage {
    positions: Described,
    mover: Mover,
    address: u8,
    is_checked: bool,
    /// Begin of a line whose end has not come.
    line: Vec<u8>,
    is_open: bool,
    is_online: bool,
}

impl Stage {
    pub(crate) fn new(positions: Described, settings: &Settings) -> Stage {
        Stage {
            positions,
            mover: Mover::new(settings),
            address: settings.address,
            is_checked: settings.checksum,
            line: Vec::new(),
            is_open: false,
            is_online: false,
        }
    }

    /// Gives the line so far to the one it is for.
    fn take_line(&mut self, now: Nanos) {
        let line = std::mem::take(&mut self.line);
        let text = line.trim_ascii_end();
        let reply = Reply::parse(text, self.address, self.is_checked);
        let is_of_move = reply.is_some_and(|reply| self.mover.reply(now, &reply));
        if !is_of_move {
            self.positions.receive(now, Input::Bytes(&line));
        }
    }
}

impl Driver for Stage {
    fn channels(&self) -> &[Channel] {
        self.positions.channels()
    }

    fn connected(&mut self, now: Nanos) {
        self.line.clear();
        self.mover.forget();
        (self.is_open, self.is_online) = (true, false);
        self.positions.connected(now);
    }

    fn disconnected(&mut self, now: Nanos) {
        // Half a line counts as discarded.
        let line = std::mem::take(&mut self.line);
        self.positions.receive(now, Input::Bytes(&line));
        self.mover.forget();
        (self.is_open, self.is_online) = (false, false);
        self.positions.disconnected(now);
    }

    fn receive(&mut self, now: Nanos, input: Input<'_>) {
        let Input::Bytes(bytes) = input else { return };
        for &byte in bytes {
            self.line.push(byte);
            if matches!(byte, b'\n' | b'\r') || self.line.len() >= LONGEST {
                self.take_line(now);
            }
        }
    }

    fn timeout(&mut self, now: Nanos) {
        self.mover.timeout(now);
        self.positions.timeout(now);
    }

    fn poll_timeout(&self) -> Option<Nanos> {
        self.mover.poll_timeout().into_iter().chain(self.positions.poll_timeout()).min()
    }

    fn poll_transmit(&mut self) -> Option<Output> {
        let of_move = self.mover.poll_transmit().map(Output::Bytes);
        of_move.or_else(|| self.positions.poll_transmit())
    }

    fn poll_event(&mut self) -> Option<Event> {
        let event = self.positions.poll_event();
        self.is_online |= matches!(event, Some(Event::Online));
        event.or_else(|| self.mover.poll_event().map(Event::Motion))
    }

    fn command(&mut self, now: Nanos, command: Command) {
        self.positions.command(now, command);
    }

    fn motion(&mut self, now: Nanos, motion: &Motion) -> Result<(), MotionFailure> {
        // A halt may always be tried.
        if !self.is_open || !self.is_online && *motion != Motion::Halt {
            let detail = "the stage has not answered on this connection: check the cable and the power of the stage";
            return Err(MotionFailure::new(MotionTrouble::Unanswered, detail));
        }
        self.mover.order(now, motion)
    }

    fn halt_bytes(&self) -> Option<Vec<u8>> {
        Some(self.mover.halt_bytes())
    }
}

/// Most bytes of a line that are waited for.
const LONGEST: usize = 256;
