//! From a configuration to the core of a station.

use asphera_link::Problem;
use thiserror::Error;

use super::bench::{Bench, BenchSettings};
use super::line::Line;
use crate::config::Config;

/// A driver refused its settings.
#[derive(Debug, Error)]
#[error("device {device} cannot be set up: {reason}")]
pub struct AssembleError {
    /// The device.
    pub device: String,
    /// Words of its driver.
    pub reason: String,
}

/// Puts the core of a station together. A replay does the same from the configuration in the recording.
///
/// # Errors
///
/// When a driver refuses settings that passed the check of the configuration.
pub fn assemble(config: &Config) -> Result<Bench, AssembleError> {
    let mut places = vec![(0, 0); config.devices.len()];
    let mut lines = Vec::new();
    for (line, link) in config.links.iter().enumerate() {
        let mut devices = Vec::new();
        for (index, device) in
            config.devices.iter().enumerate().filter(|(_, device)| device.link == line)
        {
            places[index] = (line, devices.len());
            let driver = device.settings.driver().map_err(|problems| AssembleError {
                device: device.name.clone(),
                reason: problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("; "),
            })?;
            devices.push((device.name.clone(), driver));
        }
        lines.push(Line::new(link.name.clone(), link.framing, devices));
    }
    Ok(Bench::new(BenchSettings {
        lines,
        streams: config.sync.devices.iter().map(|device| places[*device]).collect(),
        sync: config.sync.settings.clone(),
        kinematics: config.kinematics.clone(),
        calibration: config.calibration.clone(),
        end: config.end,
    }))
}
