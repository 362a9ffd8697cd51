//! What a bench says of a driver and of its device.

use std::time::Duration;

use asphera_link::{Connection, Driver, Flags, Motion, Nanos, Output};

use crate::Fault;

/// A driver, its device, and what each fault must look like.
pub trait Bench {
    /// Head of the column.
    fn name(&self) -> &'static str;

    /// Makes the driver.
    fn driver(&self) -> Box<dyn Driver>;

    /// Makes the device, switched on.
    fn device(&self, model: Model) -> Box<dyn Device>;

    /// Appearance of a fault.
    fn expects(&self, fault: Fault) -> Expectation;

    /// Time after the fault within which good readings come again.
    fn recovery(&self) -> Duration {
        Duration::from_secs(5)
    }

    /// Delay of a late answer.
    fn lateness(&self) -> Duration {
        Duration::from_millis(120)
    }

    /// Order without which the device gives no readings: a program.
    fn order(&self) -> Option<Motion> {
        None
    }

    /// Move that a stalling stage is sent.
    fn movement(&self) -> Option<Motion> {
        None
    }

    /// Whether the connection ends with a restart of the device.
    fn restart_closes(&self) -> bool {
        false
    }

    /// Whether frames come whole, as datagrams.
    fn has_datagrams(&self) -> bool {
        false
    }

    /// Whether frames are those of CAN.
    fn is_can(&self) -> bool {
        false
    }

    /// Whether frames end with line ends, which no driver counts.
    fn has_line_ends(&self) -> bool {
        false
    }

    /// Bytes of good frames that a driver may take without a reading: those which prove the device, a connection and a time-out.
    fn proof_bytes(&self) -> u64 {
        0
    }
}

/// Device on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// The one that was configured.
    Right,
    /// Another one.
    Stranger,
}

/// State of a device, or of what it measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// All is well.
    Good,
    /// The part lies outside the range.
    OutOfRange,
    /// The detector is saturated.
    Saturated,
    /// The motor turns and the stage does not.
    Stalled,
    /// A limit switch is hit.
    Limit,
}

/// A device in virtual time.
pub trait Device {
    /// The link was opened.
    fn opened(&mut self) {}

    /// Takes what the host sent; gives its answers.
    fn receive(&mut self, now: Nanos, parcel: &Output) -> Vec<Sent>;

    /// Time between two frames that it sends by itself; `None`: it sends only when asked.
    fn period(&self) -> Option<Duration> {
        None
    }

    /// Frames that it sends by itself, once a period.
    fn tick(&mut self, _now: Nanos) -> Vec<Sent> {
        Vec::new()
    }

    /// Starts anew, as after power-on; gives what it sends then.
    fn restart(&mut self) -> Vec<Sent> {
        Vec::new()
    }

    /// Takes a state.
    fn condition(&mut self, _condition: Condition) {}

    /// Whether bytes of the host make something move.
    fn is_motion(&self, _parcel: &Output) -> bool {
        false
    }
}

/// A frame of a device.
#[derive(Clone, Debug, PartialEq)]
pub struct Sent {
    /// Its bytes, or the CAN frame.
    pub parcel: Output,
    /// Whether it is a measurement.
    pub is_measurement: bool,
    /// Values of the one good reading that it may become.
    pub values: Option<Vec<Option<f64>>>,
    /// Connection on which it comes.
    pub connection: Connection,
}

impl Sent {
    /// An answer that is no measurement.
    pub fn answer(bytes: impl Into<Vec<u8>>) -> Sent {
        Sent::carrying(Output::Bytes(bytes.into()), false, None)
    }

    /// A measurement with the values of its reading.
    pub fn good(bytes: impl Into<Vec<u8>>, values: Vec<Option<f64>>) -> Sent {
        Sent::carrying(Output::Bytes(bytes.into()), true, Some(values))
    }

    /// A measurement that must be flagged.
    pub fn bad(bytes: impl Into<Vec<u8>>) -> Sent {
        Sent::carrying(Output::Bytes(bytes.into()), true, None)
    }

    /// A parcel on the first connection.
    pub fn carrying(
        parcel: Output,
        is_measurement: bool,
        values: Option<Vec<Option<f64>>>,
    ) -> Sent {
        Sent { parcel, is_measurement, values, connection: Connection::First }
    }

    /// The same on the second connection.
    #[must_use]
    pub fn on_second(self) -> Sent {
        Sent { connection: Connection::Second, ..self }
    }
}

/// Appearance of a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expectation {
    /// It cannot occur with this driver: why.
    Absent(&'static str),
    /// These marks and no other. None: readings go on.
    Marks(&'static [Mark]),
}

/// Sign of a fault that a person or a program can see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mark {
    /// Readings with these flags, and none with others.
    Flagged(Flags),
    /// Bytes counted as discarded.
    Discarded,
    /// A fault whose text has these words.
    Fault(&'static str),
    /// A new connection is asked for, with these words.
    Reopened(&'static str),
    /// A move broke off, with these words.
    Halted(&'static str),
}
