//! The client's side of a connection, without a socket and without a clock.

use std::time::Duration;

use asphera_link::CanFrame;

use super::{Decoder, Item};
use crate::BusError;

/// Time that a server has from the connection to its second `< ok >`.
pub const HANDSHAKE_TIME: Duration = Duration::from_secs(3);

/// One connection to a server, from its greeting on.
///
/// ```text
/// Greeting ─ hi ─▶ Opening ─ ok ─▶ Switching ─ ok ─▶ Open
///      └──────────────┴── error, another element ──▶ Failed
/// ```
#[derive(Clone, Debug)]
pub struct Client {
    bus: String,
    decoder: Decoder,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Greeting,
    Opening,
    Switching,
    Open,
    Failed,
}

/// Event of a connection.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// Bytes to send.
    Send(Vec<u8>),
    /// The bus is open: from now on frames come and go.
    Open,
    /// A frame of the bus.
    Frame(CanFrame),
    /// Trouble on the bus.
    BusError(BusError),
    /// The server refused a command on the open bus, in words for a person.
    Refused(String),
    /// The connection cannot be used, in words for a person.
    Failed(String),
    /// Bytes that are no element of the protocol.
    Discarded {
        /// How many.
        bytes: u64,
    },
}

impl Client {
    /// A new connection that wants the frames of `bus`.
    pub fn new(bus: &str) -> Client {
        Client { bus: bus.to_owned(), decoder: Decoder::new(), state: State::Greeting }
    }

    /// Whether frames come and go.
    pub fn is_open(&self) -> bool {
        self.state == State::Open
    }

    /// Whether the server has still to answer.
    pub fn is_waiting(&self) -> bool {
        matches!(self.state, State::Greeting | State::Opening | State::Switching)
    }

    /// Bytes that wait for the end of their element.
    pub fn pending(&self) -> u64 {
        self.decoder.pending()
    }

    /// Takes bytes off the front of `input` up to the next event, or all of them if none ends in them.
    #[must_use]
    pub fn receive(&mut self, input: &mut &[u8]) -> Option<Event> {
        loop {
            let item = self.decoder.decode(input)?;
            if let Some(event) = self.event(item) {
                return Some(event);
            }
        }
    }

    /// The time of the handshake has run out: why, in words for a person.
    pub fn expire(&mut self) -> String {
        let waited = match self.state {
            State::Greeting => "its greeting < hi >: check that the address is that of socketcand",
            State::Opening => "its answer to < open >: look at its log",
            _ => "its answer to < rawmode >: look at its log",
        };
        self.state = State::Failed;
        let seconds = HANDSHAKE_TIME.as_secs();
        format!("the server did not send within {seconds} s {waited}")
    }

    fn event(&mut self, item: Item) -> Option<Event> {
        match (self.state, item) {
            (State::Failed, _) => None,
            (_, Item::Malformed { bytes }) => Some(Event::Discarded { bytes }),
            (State::Greeting, Item::Greeting) => {
                self.state = State::Opening;
                Some(Event::Send(format!("< open {} >", self.bus).into_bytes()))
            }
            (State::Opening, Item::Done) => {
                self.state = State::Switching;
                Some(Event::Send(b"< rawmode >".to_vec()))
            }
            (State::Switching, Item::Done) => {
                self.state = State::Open;
                Some(Event::Open)
            }
            (State::Open, Item::Frame(frame)) => Some(Event::Frame(frame)),
            (_, Item::BusError(error)) => Some(Event::BusError(error)),
            (State::Open, Item::Refused(words)) => {
                Some(Event::Refused(format!("socketcand refused a command: {words}")))
            }
            (State::Open, _) => None,
            // A bus in its first mode sends no frame that nobody asked for, but nothing forbids it.
            (_, Item::Frame(_)) => None,
            (state, item) => Some(self.fail(state, &item)),
        }
    }

    fn fail(&mut self, state: State, item: &Item) -> Event {
        self.state = State::Failed;
        let bus = &self.bus;
        let found = match item {
            Item::Refused(words) => format!("error {words}"),
            Item::Other(words) => words.clone(),
            Item::Greeting => "hi".to_owned(),
            _ => "ok".to_owned(),
        };
        Event::Failed(match state {
            State::Opening => format!(
                "socketcand does not open bus {bus} (< {found} >): set bus to one that it serves, and look whether that is up"
            ),
            State::Switching => format!(
                "socketcand does not switch bus {bus} to raw mode (< {found} >): update the server"
            ),
            _ => format!(
                "expected the greeting < hi > of socketcand, found < {found} >: check the address"
            ),
        })
    }
}
