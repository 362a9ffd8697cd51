//! The tables `sync` and `kinematics`: which readings belong together, and what point they make.

use std::f64::consts::TAU;
use std::sync::Arc;
use std::time::Duration;

use asphera_link::Unit;
use asphera_settings::Section;

use super::devices::DeviceConfig;
use super::error_table::ErrorTables;
use super::line;
use super::scan::pair_mm;
use super::time::{self, TimeConfig};
use crate::station::{Axis, Kinematics, Source, SyncSettings, Tilting};

/// Which devices share the trigger.
#[derive(Clone, Debug, PartialEq)]
pub struct SyncConfig {
    /// Devices, the primary first.
    pub devices: Vec<usize>,
    /// How their readings are joined.
    pub settings: SyncSettings,
    /// How they are joined by time; `None` to join them by count.
    pub time: Option<TimeConfig>,
}

pub(super) fn sync(table: &Section<'_>, devices: &[DeviceConfig]) -> Option<SyncConfig> {
    let names: Vec<String> = table.required("devices")?;
    if names.is_empty() {
        table.problem("devices", "at least one device, the primary first", "none");
    }
    let mut found = Vec::new();
    for name in &names {
        match devices.iter().position(|device| device.name == *name) {
            Some(index) if found.contains(&index) => {
                table.problem("devices", "each device once", format!("{name:?} twice"));
            }
            Some(index) => found.push(index),
            None => table.problem(
                "devices",
                format!("devices among {}", list(devices)),
                format!("{name:?}"),
            ),
        }
    }
    let wait = Duration::from_millis(table.within("wait_ms", 2000, 1..=600_000u64));
    let capacity = table.within("capacity", 65_536, 16..=10_000_000usize);
    let paced = table.or("paced", true);
    let devices: Vec<&DeviceConfig> = found.iter().map(|index| &devices[*index]).collect();
    if let Some(longest) = devices.iter().map(|device| device.settings.holds_back()).max()
        && wait <= longest
    {
        let expected = format!(
            "more than {} ms, for which a driver may hold a reading back",
            longest.as_millis()
        );
        table.problem("wait_ms", expected, wait.as_millis());
    }
    let by_time = table.word("by", false, &[("count", false), ("time", true)]);
    let time = if by_time { time::read(table, &devices, wait, paced) } else { None };
    if !by_time {
        time::refuse(table);
        if devices.len() > 1 {
            counts(table, &devices);
        }
    }
    table.finish();
    let settings = SyncSettings { wait, capacity, paced };
    let is_whole = !found.is_empty() && found.len() == names.len() && by_time == time.is_some();
    is_whole.then_some(SyncConfig { devices: found, settings, time })
}

/// Devices that are joined must count every trigger, and the primary's count must not be the shorter: its
/// own losses are told from it.
fn counts(table: &Section<'_>, devices: &[&DeviceConfig]) {
    let mut longest: Option<(u32, &str)> = None;
    for (index, device) in devices.iter().enumerate() {
        match device.settings.count_cycle() {
            Err(why) => {
                table.problem(
                    "devices",
                    "devices that count every trigger",
                    format!("{}: {why}", device.name),
                );
            }
            Ok(cycle) if index == 0 => longest = Some((cycle, &device.name)),
            Ok(cycle) => {
                if let Some((first, name)) = longest.filter(|(first, _)| cycle > *first) {
                    table.problem(
                        "devices",
                        format!("the device with the longest counter first: {}", device.name),
                        format!("{name}, which counts {first} against {cycle}"),
                    );
                }
            }
        }
    }
}

pub(super) fn kinematics(
    table: &Section<'_>,
    sync: Option<&SyncConfig>,
    devices: &[DeviceConfig],
    tables: &ErrorTables<'_>,
) -> Option<Kinematics> {
    #[derive(Clone, Copy)]
    enum Kind {
        Polar,
        Cartesian,
        Line,
        Tilting,
    }
    let kinds = [
        ("polar", Kind::Polar),
        ("cartesian", Kind::Cartesian),
        ("line", Kind::Line),
        ("tilting", Kind::Tilting),
    ];
    let kind = table.required_word("kind", &kinds)?;
    if let Some(sync) = sync.filter(|_| !matches!(kind, Kind::Line)) {
        line::refuse_profiles(table, sync, devices);
    }
    let axis = |name: &str, rotary: bool| {
        let section = table.section(name);
        if !section.is_present() {
            table.problem(name, "a table with device and channel", "nothing");
            return None;
        }
        let errors = tables.read(&section, name, rotary);
        let axis = axis(&section, rotary, sync?, devices);
        if axis.as_ref().is_some_and(|axis| axis.source.is_none()) && errors.is_some() {
            let expected = "no such key, or an axis that moves";
            section.problem("error_table", expected, "an axis that stands still");
        }
        section.finish();
        Some(Axis { errors: errors.map(Arc::new), ..axis? })
    };
    let kinematics = match kind {
        Kind::Polar => {
            let (rotary, radial, probe) =
                (axis("rotary", true), axis("radial", false), axis("probe", false));
            rotary.zip(radial).zip(probe).map(|((rotary, radial), probe)| Kinematics::Polar {
                rotary,
                radial,
                probe,
            })
        }
        Kind::Cartesian => {
            let (x, y, z) = (axis("x", false), axis("y", false), axis("z", false));
            x.zip(y).zip(z).map(|((x, y), z)| Kinematics::Cartesian { x, y, z })
        }
        Kind::Line => line::read(table, sync, devices, &axis).map(Kinematics::Line),
        Kind::Tilting => tilting(table, &axis).map(Box::new).map(Kinematics::Tilting),
    };
    if let Some(axes) = kinematics.as_ref().map(Kinematics::axes) {
        let sources: Vec<Source> = axes.iter().filter_map(|axis| axis.source).collect();
        if (1..sources.len()).any(|index| sources[..index].contains(&sources[index])) {
            table.problem("kind", "a channel of its own for each axis", "one channel for two axes");
        }
    }
    table.finish();
    kinematics
}

/// A tilting probe; `axis` reads the table of an axis by its name, which is rotary or not.
fn tilting(table: &Section<'_>, axis: &dyn Fn(&str, bool) -> Option<Axis>) -> Option<Tilting> {
    let [x, z, probe] = ["x", "z", "probe"].map(|name| axis(name, false));
    let tilt = axis("tilt", true);
    // An axis that the machine has not stands still at 0, and a part that does not turn has none.
    let y = match table.has("y") {
        true => axis("y", false),
        false => Some(Axis { source: None, scale: 1.0, offset: 0.0, errors: None }),
    };
    let rotary = table.has("rotary").then(|| axis("rotary", true));
    let pivot_offset_mm = pair_mm(table, "pivot_offset_mm");
    let rotary = match rotary {
        Some(rotary) => Some(rotary?),
        None => None,
    };
    Some(Tilting { x: x?, y: y?, z: z?, tilt: tilt?, probe: probe?, rotary, pivot_offset_mm })
}

fn axis(
    table: &Section<'_>,
    rotary: bool,
    sync: &SyncConfig,
    devices: &[DeviceConfig],
) -> Option<Axis> {
    let constant_key = if rotary { "constant_rad" } else { "constant_mm" };
    if let Some(offset) = table.get(constant_key) {
        return Some(Axis { source: None, scale: 1.0, offset, errors: None });
    }
    // Read before anything can be wrong, so that they do not seem unknown.
    let offset = table.or(if rotary { "offset_rad" } else { "offset_mm" }, 0.0);
    let reverse = if table.or("reverse", false) { -1.0 } else { 1.0 };
    let device: String = table.required("device")?;
    let index = devices.iter().position(|known| known.name == device);
    let stream = sync.devices.iter().position(|known| Some(*known) == index);
    let Some((stream, index)) = stream.zip(index) else {
        let names: Vec<_> =
            sync.devices.iter().map(|known| devices[*known].name.as_str()).collect();
        table.problem(
            "device",
            format!("one of the synchronized devices {}", names.join(", ")),
            format!("{device:?}"),
        );
        pass_over_scale(table);
        return None;
    };
    let channels = &devices[index].channels;
    let name: String = table.required("channel")?;
    let Some(channel) = channels.iter().position(|known| known.name == name) else {
        let names: Vec<_> = channels.iter().map(|known| known.name.as_str()).collect();
        table.problem(
            "channel",
            format!("one of the channels {} of {device}", names.join(", ")),
            format!("{name:?}"),
        );
        pass_over_scale(table);
        return None;
    };
    let unit = channels[channel].unit;
    let scale = match (unit, rotary) {
        (Unit::Count, true) => TAU / table.required::<f64>("counts_per_turn")?,
        (Unit::Count, false) => table.required::<f64>("mm_per_count")?,
        (Unit::Radian, true) | (Unit::Millimetre, false) => table.or("scale", 1.0),
        _ => {
            let expected =
                if rotary { "a channel in rad or counts" } else { "a channel in mm or counts" };
            table.problem("channel", expected, format!("{name} in {unit}"));
            pass_over_scale(table);
            return None;
        }
    };
    if !scale.is_finite() || scale == 0.0 {
        table.problem("channel", "a scale other than 0", scale);
        return None;
    }
    let source = Some(Source { stream, channel });
    Some(Axis { source, scale: scale * reverse, offset, errors: None })
}

/// Which of these keys a channel has depends on its unit: of an unknown channel none is a mistake.
fn pass_over_scale(table: &Section<'_>) {
    for key in ["scale", "mm_per_count", "counts_per_turn"] {
        table.has(key);
    }
}

fn list(devices: &[DeviceConfig]) -> String {
    devices.iter().map(|device| device.name.as_str()).collect::<Vec<_>>().join(", ")
}
