//! The table `kinematics` of a line scanner.

use asphera_settings::Section;

use super::devices::DeviceConfig;
use super::motion::SyncConfig;
use crate::station::{Axis, Profiler, Scaling};

/// Reads what is beside the axis `along`: the tables `across` and `height`.
pub(super) fn read(
    table: &Section<'_>,
    sync: Option<&SyncConfig>,
    devices: &[DeviceConfig],
    along: Option<Axis>,
) -> Option<Profiler> {
    let section = table.section("across");
    let device: Option<String> = section.required("device");
    let across = scaling(&section);
    let skew_deg: f64 = section.within("skew_deg", 0.0, -60.0..=60.0);
    let named = device.zip(sync);
    let is_scanner =
        named.is_some_and(|(name, sync)| is_primary_scanner(&section, &name, sync, devices));
    section.finish();
    let section = table.section("height");
    let height = scaling(&section);
    section.finish();
    let (across, height, along) = (across?, height?, along?);
    let skew_rad = skew_deg.to_radians();
    is_scanner.then_some(Profiler { stream: 0, across, height, along, skew_rad })
}

/// A device whose readings have profiles is told apart by its kind of kinematics: no other takes its points.
pub(super) fn refuse_profiles(table: &Section<'_>, sync: &SyncConfig, devices: &[DeviceConfig]) {
    let mut synchronized = sync.devices.iter().map(|index| &devices[*index]);
    if let Some(scanner) = synchronized.find(|device| device.settings.measures_profiles()) {
        let found = format!("another kind, with the line scanner {}", scanner.name);
        table.problem("kind", "\"line\", which uses the points of profiles", found);
    }
}

fn is_primary_scanner(
    section: &Section<'_>,
    name: &str,
    sync: &SyncConfig,
    devices: &[DeviceConfig],
) -> bool {
    let primary = sync.devices.first().map(|index| &devices[*index]);
    match primary {
        Some(primary) if primary.name != name => {
            let expected = format!("{}, the first of the synchronized devices", primary.name);
            section.problem("device", expected, format!("{name:?}"));
            false
        }
        Some(primary) if !primary.settings.measures_profiles() => {
            let expected = "a line scanner, whose readings have profiles";
            section.problem("device", expected, format!("{name:?}, which measures single points"));
            false
        }
        primary => primary.is_some(),
    }
}

fn scaling(section: &Section<'_>) -> Option<Scaling> {
    let scale: f64 = section.or("scale", 1.0);
    let offset_mm: f64 = section.or("offset_mm", 0.0);
    if !scale.is_finite() || scale == 0.0 {
        section.problem("scale", "a scale other than 0", scale);
        return None;
    }
    let direction = if section.or("reverse", false) { -1.0 } else { 1.0 };
    Some(Scaling { scale: scale * direction, offset_mm })
}
