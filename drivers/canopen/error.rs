//! Why bytes are not what they should be.

use thiserror::Error;

use crate::Cob;

/// Why a CAN frame is not the CANopen object it should be.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum WireError {
    /// A node number that does not exist.
    #[error("node {0} does not exist, expected 1 to 127")]
    Node(u8),
    /// Data of the wrong size.
    #[error("{cob} has {found} bytes, expected {expected}")]
    Length {
        /// The object.
        cob: Cob,
        /// What it should have.
        expected: usize,
        /// What it has.
        found: usize,
    },
    /// A number without meaning where one with a meaning should be.
    #[error("{cob} says {found:#04x}, which means nothing there")]
    Value {
        /// The object.
        cob: Cob,
        /// The number.
        found: u8,
    },
}
