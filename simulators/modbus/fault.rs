//! Ways a device can misbehave.

use std::time::Duration;

/// Event for the answer of one request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// It comes so much later.
    Late(Duration),
    /// It is kept back until the next request comes, and sent right before that one's answer.
    KeptBack,
    /// It never comes.
    Silent,
    /// It is an exception of this code.
    Exception(u8),
    /// It carries the address of another unit.
    WrongUnit(u8),
    /// RTU: its CRC is wrong. TCP: its protocol identifier is not 0.
    Corrupt,
    /// It follows these bytes.
    Noise(Vec<u8>),
    /// The connection is closed instead.
    Close,
}
