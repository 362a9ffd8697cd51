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

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use asphera_transport::{Backoff, Endpoint, Link, LinkSettings};
    use tokio::io::AsyncReadExt as _;
    use tokio::net::TcpListener;
    use tokio::sync::mpsc;

    use super::*;

    /// The core takes no event at all; the halt is there, and nothing after it until the core took notice.
    #[tokio::test]
    async fn a_pressed_brake_sends_its_halt_and_nothing_else() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let backoff =
            Backoff::try_new(Duration::from_millis(5), Duration::from_millis(20), 1).unwrap();
        let (events, _never_taken) = mpsc::channel(1);
        let settings = LinkSettings { index: 0, endpoint: Endpoint::Tcp { address }, backoff };
        let link = Link::spawn(settings, events);
        let (mut peer, _) = listener.accept().await.unwrap();
        let brake = Brake::default();
        let halt = Halt { line: 4, link: link.remote(), epoch: 1, bytes: b"halt".to_vec() };
        brake.connect(vec![halt]);
        let send = |bytes: &[u8]| {
            let command = LinkCommand::Send { epoch: 1, bytes: bytes.to_vec() };
            brake.unless_pressed(4, || link.command(command));
        };
        send(b"move");
        brake.press();
        send(b"move");
        let mut others = 0;
        brake.unless_pressed(5, || others += 1);
        assert_eq!(others, 1, "links without axes go on");
        brake.release();
        send(b"next");
        let mut got = [0; 12];
        peer.read_exact(&mut got).await.unwrap();
        assert_eq!(&got, b"movehaltnext");
    }
}
