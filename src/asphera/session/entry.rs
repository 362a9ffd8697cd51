//! What a recording holds, entry by entry.

use std::time::Duration;

use asphera_link::{Command, Nanos};
use serde::Serialize;
use serde::de::IgnoredAny;

use super::PointCloud;
use crate::station::ScanOrder;

/// One thing that happened at one time.
///
/// The order of the entries of a session is the order in which the station handled them, over all
/// links. A replay that follows it gives the drivers the same calls.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// When it was handled.
    pub at: Nanos,
    /// What it was.
    pub what: What,
}

/// Event. `link` is an index into [`super::Header::links`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum What {
    /// A link was opened.
    Opened {
        /// Which.
        link: usize,
    },
    /// A link received bytes, in one read. A CAN frame is its record of 16 bytes, or 72 of CAN FD
    /// ([`asphera_link::CanFrame::to_record`]); a read of one of two connections is its
    /// [`asphera_link::Connection::chunk`].
    Received {
        /// Which.
        link: usize,
        /// Exactly what was read; at most 16 MiB.
        bytes: Vec<u8>,
    },
    /// A link sent bytes, or a CAN frame as its record.
    Sent {
        /// Which.
        link: usize,
        /// Exactly what was written; at most 16 MiB.
        bytes: Vec<u8>,
    },
    /// A link was closed.
    Closed {
        /// Which.
        link: usize,
        /// Why, in words.
        reason: String,
    },
    /// The station started or stopped the measurement.
    Command(Command),
    /// The scan that the station drives was armed, halted, or decided.
    Scan(ScanOrder),
    /// The host was held up: what the links delivered meanwhile was read late, and no deadline that passed
    /// meanwhile was kept or missed by a device.
    HeldUp {
        /// Until when.
        until: Nanos,
        /// How long of that the computer was suspended.
        suspended: Duration,
    },
    /// Points that were made of what was received.
    Points(PointCloud),
    /// The measurement ended; only [`super::Recorder::finish`] writes it.
    Finish {
        /// Why, in words.
        reason: String,
    },
    /// The results, after the end; only [`super::Recorder::finish`] writes it.
    Results(ResultsJson),
}

impl What {
    /// The link it happened on; `None` for what concerns the session.
    pub fn link(&self) -> Option<usize> {
        match *self {
            What::Opened { link }
            | What::Received { link, .. }
            | What::Sent { link, .. }
            | What::Closed { link, .. } => Some(link),
            What::Command(_)
            | What::Scan(_)
            | What::HeldUp { .. }
            | What::Points(_)
            | What::Finish { .. }
            | What::Results(_) => None,
        }
    }
}

/// Results as JSON text. The text is kept as it is, so that a replay can be compared bit by bit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ResultsJson(String);

impl ResultsJson {
    /// Takes a text that is valid JSON.
    pub fn new(text: impl Into<String>) -> Result<ResultsJson, serde_json::Error> {
        let text = text.into();
        serde_json::from_str::<IgnoredAny>(&text)?;
        Ok(ResultsJson(text))
    }

    /// Writes a value as JSON.
    pub fn encode<T: Serialize + ?Sized>(value: &T) -> Result<ResultsJson, serde_json::Error> {
        serde_json::to_string(value).map(ResultsJson)
    }

    /// The text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}
