//! Settings of the driver.

use asphera_link::{Channel, Problem, Unit, check_range};

use crate::wire::ADDRESSES;

/// A sensor as it was set up and saved.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Network address, 1 to 127; factory setting 1.
    pub address: u8,
    /// How results are got.
    pub mode: Mode,
    /// Measuring range in mm as on the type plate, 1 to 65535. Another sensor is found out by it.
    pub range_mm: u16,
    /// Serial number; another sensor is found out by it. `None`: any.
    pub serial: Option<u16>,
    /// Time an answer may take, 1 to 60 000 ms.
    pub timeout_ms: u32,
    /// Silence after which no late answer is expected any more, `timeout_ms` to 600 000 ms.
    pub late_limit_ms: u32,
}

/// How results are got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// The sensor sends by itself, once it was told to. After so many ms of silence the link is opened anew; 0: never.
    Stream {
        /// Longest silence in ms, 0 or 10 to 3 600 000.
        silence_ms: u32,
    },
    /// Each result is asked for.
    Poll {
        /// Time from one question to the next, 1 to 3 600 000 ms.
        interval_ms: u32,
    },
}

impl Settings {
    /// Everything that cannot be used. Empty means that [`crate::Riftek::new`] takes the settings.
    pub fn problems(&self) -> Vec<Problem> {
        let mut problems = Vec::new();
        check_range(&mut problems, "address", self.address, *ADDRESSES.start(), *ADDRESSES.end());
        check_range(&mut problems, "range_mm", self.range_mm, 1, u16::MAX);
        check_range(&mut problems, "timeout_ms", self.timeout_ms, 1, 60_000);
        check_range(&mut problems, "late_limit_ms", self.late_limit_ms, self.timeout_ms, 600_000);
        match self.mode {
            Mode::Stream { silence_ms: 0 } => {}
            Mode::Stream { silence_ms } => {
                check_range(&mut problems, "silence_ms", silence_ms, 10, 3_600_000);
            }
            Mode::Poll { interval_ms } => {
                check_range(&mut problems, "interval_ms", interval_ms, 1, 3_600_000);
            }
        }
        problems
    }

    /// Channels of the readings: `distance` in mm from the start of the measuring range.
    pub fn channels(&self) -> Vec<Channel> {
        vec![Channel::new("distance", Unit::Millimetre)]
    }
}
