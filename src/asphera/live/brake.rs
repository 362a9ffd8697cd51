//! The brake: a halt that reaches the stage whatever the core waits for.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use asphera_transport::{LinkCommand, LinkRemote};

/// Brake of a station. Clones are the same brake.
///
/// Pressed, it sends the bytes of a halt on each link with axes at once. Until the core has taken notice, nothing else is
/// sent on those links: a move that the core had under way does not follow its halt.
#[derive(Clone, Debug, Default)]
pub(super) struct Brake(Arc<Mutex<State>>);

#[derive(Debug, Default)]
struct State {
    is_pressed: bool,
    halts: Vec<Halt>,
}

/// Halt of the axes on a link.
#[derive(Debug)]
pub(super) struct Halt {
    /// Index of the link.
    pub(super) line: usize,
    pub(super) link: LinkRemote,
    /// Connection that is open.
    pub(super) epoch: u64,
    pub(super) bytes: Vec<u8>,
}

impl Brake {
    /// The halts of the connections that are open.
    pub(super) fn connect(&self, halts: Vec<Halt>) {
        self.state().halts = halts;
    }

    /// Halts every axis, and lets nothing else through.
    pub(super) fn press(&self) {
        let mut state = self.state();
        state.is_pressed = true;
        for Halt { link, epoch, bytes, .. } in &state.halts {
            link.command(LinkCommand::Send { epoch: *epoch, bytes: bytes.clone() });
        }
    }

    /// The core has taken notice.
    pub(super) fn release(&self) {
        self.state().is_pressed = false;
    }

    /// Does this unless the brake holds the line.
    pub(super) fn unless_pressed(&self, line: usize, send: impl FnOnce()) {
        let state = self.state();
        if !(state.is_pressed && state.halts.iter().any(|halt| halt.line == line)) {
            send();
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        // Whoever panicked left numbers and handles that are whole.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
