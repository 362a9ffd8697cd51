//! What links and devices delivered and lost.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Bytes and readings of one link and its devices, delivered and lost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinkFigures {
    /// The link.
    pub name: String,
    /// Bytes received (CAN frames of the kernel: 16 bytes each).
    pub received_bytes: u64,
    /// Bytes that belong to no valid frame.
    pub discarded_bytes: u64,
    /// Times it was opened.
    pub opened: u64,
    /// Times it was lost.
    pub closed: u64,
    /// Its devices.
    pub devices: Vec<DeviceFigures>,
}

/// Readings of one device, delivered and lost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DeviceFigures {
    /// The device.
    pub name: String,
    /// Readings.
    pub readings: u64,
    /// Readings with a flag, by flag. A reading with several flags counts once for each.
    pub flagged: BTreeMap<String, u64>,
    /// Triggers skipped, as gaps in the shared count tell: readings lost before they reached the host.
    pub lost: u64,
    /// Readings that found no companion of the same count.
    pub unjoined: u64,
    /// Readings whose trigger could not be told.
    pub ambiguous: u64,
    /// Times a whole cycle of the shared count was found missing.
    pub slips: u64,
    /// Faults by kind.
    pub faults: BTreeMap<String, u64>,
    /// Every channel that makes no coordinate: smallest, mean and largest value.
    pub channels: BTreeMap<String, ChannelFigures>,
}

/// Values of a recorded channel during the measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChannelFigures {
    /// Unit of the values.
    pub unit: String,
    /// Smallest value.
    pub min: f64,
    /// Mean value.
    pub mean: f64,
    /// Largest value.
    pub max: f64,
    /// How many values.
    pub count: u64,
}
