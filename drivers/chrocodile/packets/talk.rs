//! Where the dialogue with the device stands.

use asphera_link::Nanos;

use super::order::Order;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum State {
    /// No connection.
    Closed,
    /// Commands of the set-up are on their way.
    Setup,
    /// Set up; no data.
    Idle,
    /// `STA` is on its way.
    Starting,
    /// Data arrive when they are triggered.
    Streaming,
    /// `STO` is on its way; data arrive up to its answer.
    Stopping,
    /// The device refused a command; a start tries the set-up again.
    Refused,
    /// The connection is to be opened anew.
    Abandoned,
}

/// A command that waits for its answer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Talk {
    pub(super) topic: Topic,
    pub(super) order: Order,
    pub(super) ticket: u16,
    pub(super) attempt: u8,
    pub(super) deadline: Nanos,
    pub(super) answered: bool,
    /// Whether a format that gives readings came since the command was sent; else why the last one does not.
    pub(super) format: Result<(), Option<String>>,
}

/// What a command is sent for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topic {
    /// The command of this index of the set-up.
    Setup(usize),
    Start,
    Stop,
    /// The format of data that arrive.
    Format,
}
