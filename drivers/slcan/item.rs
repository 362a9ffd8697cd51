//! What a line says.

use asphera_link::CanFrame;
use bitflags::bitflags;

use crate::Command;

/// What one line, or one BEL, says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    /// A frame, classic or CAN FD, with the adapter's time in ms (0 to 59999, then 0 again) where the line carries one.
    Frame(CanFrame, Option<u16>),
    /// An empty line: the last command was done.
    Ok,
    /// BEL: the last command was refused.
    Error,
    /// `z` or `Z`: a frame was sent, while auto-poll is on.
    TransmitAck {
        /// Whether it had a 29-bit identifier (`Z`).
        extended: bool,
    },
    /// `Vhhss`: versions of hardware and software, each of two characters.
    Version {
        /// Hardware, as sent.
        hardware: [u8; 2],
        /// Software, as sent.
        software: [u8; 2],
    },
    /// `Nxxxx`: the four characters of the serial number.
    SerialNumber([u8; 4]),
    /// `Fxx`: what the adapter's CAN controller complains of.
    Status(AdapterStatus),
    /// A command for an adapter. A host sees one where two hosts share a null-modem.
    Command(Command),
    /// Bytes that are no line.
    Malformed {
        /// How many, with the CR if a CR ended them.
        bytes: u64,
    },
}

bitflags! {
    /// Answer to the `F` command (EasySYNC ES_000005; the bits of the SJA1000 behind it).
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct AdapterStatus: u8 {
        /// The receive queue is full: frames from the bus were lost.
        const RECEIVE_FULL = 1;
        /// The transmit queue is full.
        const TRANSMIT_FULL = 1 << 1;
        /// Error warning (EI).
        const ERROR_WARNING = 1 << 2;
        /// Data overrun (DOI): frames from the bus were lost.
        const DATA_OVERRUN = 1 << 3;
        /// Not used by Lawicel; kept as sent.
        const RESERVED = 1 << 4;
        /// Error passive (EPI).
        const ERROR_PASSIVE = 1 << 5;
        /// Arbitration lost (ALI).
        const ARBITRATION_LOST = 1 << 6;
        /// Bus error (BEI).
        const BUS_ERROR = 1 << 7;
    }
}
