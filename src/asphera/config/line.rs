//! The table `kinematics` of a line scanner.

use asphera_settings::Section;

use super::devices::DeviceConfig;
use super::motion::SyncConfig;
use crate::station::{Axis, Carriage, ProfileDirection, Profiler, Scaling};

/// Reads the table; `axis` reads that of an axis by its name, which is rotary or not.
pub(super) fn read(
    table: &Section<'_>,
    sync: Option<&SyncConfig>,
    devices: &[DeviceConfig],
    axis: &dyn Fn(&str, bool) -> Option<Axis>,
) -> Option<Profiler> {
    let section = table.section("across");
    let carriage = carriage(table, &section, axis);
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
    let (across, height, carriage) = (across?, height?, carriage?);
    let skew_rad = skew_deg.to_radians();
    is_scanner.then_some(Profiler { stream: 0, across, height, carriage, skew_rad })
}

/// Reads the axis, `along` or `rotary`, and the keys that a rotary one has.
fn carriage(
    table: &Section<'_>,
    across: &Section<'_>,
    axis: &dyn Fn(&str, bool) -> Option<Axis>,
) -> Option<Carriage> {
    if !table.has("rotary") {
        for (section, key) in [(table, "profile"), (across, "tangential_mm")] {
            if section.has(key) {
                let expected = "no such key, or the table rotary in place of along";
                section.problem(key, expected, format!("`{key}`"));
            }
        }
        if !table.has("along") {
            let expected =
                "a table with device and channel, or such a table rotary where the part turns";
            table.problem("along", expected, "nothing");
            return None;
        }
        return axis("along", false).map(Carriage::Linear);
    }
    if table.has("along") {
        table.problem("along", "one axis: along, or rotary where the part turns", "both");
    }
    let words = [("radial", ProfileDirection::Radial), ("axial", ProfileDirection::Axial)];
    let profile = table.required_word("profile", &words);
    let tangential_mm = across.within("tangential_mm", 0.0, -1e4..=1e4);
    let rotary = axis("rotary", true)?;
    Some(Carriage::Turning { rotary, profile: profile?, tangential_mm })
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
