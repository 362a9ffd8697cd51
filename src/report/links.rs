//! What links and devices delivered and lost.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// Bytes and readings of one link and its devices, delivered and lost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinkFigures {
    /// The link.
    pub name: String,
    /// Bytes received (CAN frames of the kernel: 16 bytes each, of CAN FD 72).
    pub received_bytes: u64,
    /// Bytes that belong to no valid frame.
    pub discarded_bytes: u64,
    /// Clock by which its receipts are timed, mapped to the host's monotonic clock: `kernel` where the kernel stamps each frame as it
    /// takes it, `adapter` where an slcan adapter does; absent where the station reads its clock as it reads the bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock: Option<String>,
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
    /// Readings that found no companion of the same count. Joined by time: of the primary, readings without a place; of a
    /// companion, readings of the primary that it could not place.
    pub unjoined: u64,
    /// Readings whose trigger, or joined by time whose time, could not be told.
    pub ambiguous: u64,
    /// Times a whole cycle of the shared count was found missing.
    pub slips: u64,
    /// Faults by kind.
    pub faults: BTreeMap<String, u64>,
    /// Every channel that makes no coordinate: smallest, mean and largest value.
    pub channels: BTreeMap<String, ChannelFigures>,
    /// Its own clock; absent where its readings carry no time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock: Option<ClockFigures>,
}

/// Clock of a device against the host's monotonic clock, which counts from the start of the session.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ClockFigures {
    /// Host time less device time at the newest reading, but for the least delay, s; absent before it is known.
    pub offset_s: Option<f64>,
    /// How much the device's clock gains, in millionths.
    pub drift_ppm: Option<f64>,
    /// Standard uncertainty of the drift.
    pub u_drift_ppm: Option<f64>,
    /// Standard uncertainty of a device time on the host's clock, µs.
    pub u_us: Option<f64>,
    /// Standard deviation of the delays with which readings arrive, µs.
    pub jitter_us: Option<f64>,
    /// Times its counter began again at 0.
    pub wraps: u64,
    /// Times it jumped.
    pub jumps: u64,
    /// Readings with the time of the reading before.
    pub repeated: u64,
}

/// How well places are known that were joined by time. Standard uncertainties along the worst axis, of good points.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaceFigures {
    /// The largest, µm.
    pub largest_um: f64,
    /// Their root mean square, µm.
    pub rms_um: f64,
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
