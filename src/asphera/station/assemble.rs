//! From a configuration to the core of a station.

use std::f64::consts::TAU;

use asphera_clocks::{Coordinate, TimeSettings};
use asphera_link::Problem;
use thiserror::Error;

use super::bench::{Bench, BenchSettings};
use super::joiner::JoinSettings;
use super::kinematics::Source;
use super::line::Line;
use super::thermal::Thermal;
use crate::config::{Config, SyncConfig};

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
        lines.push(Line::new(link.name.clone(), link.framing.clone(), devices));
    }
    Ok(Bench::new(BenchSettings {
        lines,
        streams: config.sync.devices.iter().map(|device| places[*device]).collect(),
        join: join(config),
        kinematics: config.kinematics.clone(),
        calibration: config.calibration.clone(),
        thermal: config.thermal.clone().map(|settings| Thermal::new(settings, places)),
        tip: config.tip,
        end: config.end,
        scan: config.scan.clone(),
        program: config.program,
    }))
}

/// How readings are joined.
fn join(config: &Config) -> JoinSettings {
    let SyncConfig { devices, settings, time } = &config.sync;
    let Some(time) = time else {
        let clocks = devices.iter().map(|device| config.devices[*device].settings.clock());
        return JoinSettings::Count { settings: settings.clone(), clocks: clocks.collect() };
    };
    let axes = config.kinematics.axes().into_iter();
    let coordinates = axes.filter_map(|axis| {
        let Source { stream, channel } = axis.source?;
        let turn = if Some(&axis) == time.turning.as_ref() { TAU / axis.scale.abs() } else { 0.0 };
        Some(Coordinate { stream, channel, turn })
    });
    JoinSettings::Time {
        u_limit_mm: time.u_limit_mm,
        settings: TimeSettings {
            wait: settings.wait,
            capacity: settings.capacity,
            gap: time.gap,
            devices: time.devices.clone(),
            coordinates: coordinates.collect(),
        },
    }
}
