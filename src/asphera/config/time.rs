//! The keys of `[sync]` with which readings are joined by time.

use std::time::Duration;

use asphera_clocks::Timekeeping;
use asphera_settings::Section;

use super::devices::DeviceConfig;
use crate::station::Axis;

/// How readings are joined by time.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeConfig {
    /// Longest time between two readings of a companion that is interpolated.
    pub gap: Duration,
    /// Largest standard uncertainty of a good point along an axis by the joining, mm.
    pub u_limit_mm: f64,
    /// Noise of the heights that the primary measures, mm; `None` where it is not stated.
    pub noise_mm: Option<f64>,
    /// Times of each device, the primary first.
    pub devices: Vec<Timekeeping>,
    /// The axis that turns, if there is one.
    pub turning: Option<Axis>,
}

/// Reads the keys; `wait` and `paced` are those beside them.
pub(super) fn read(
    table: &Section<'_>,
    devices: &[&DeviceConfig],
    wait: Duration,
    paced: bool,
) -> Option<TimeConfig> {
    let gap = milliseconds(table.within("gap_limit_ms", 100.0, 0.01..=60_000.0));
    let u_limit_um: f64 = table.within("u_limit_um", 100.0, 1e-6..=1e6);
    let noise_nm: Option<f64> =
        table.has("noise_nm").then(|| table.within("noise_nm", 1.0, 1e-3..=1e9));
    if !paced {
        let expected = "true: times tell nothing of devices that go only as fast as their host";
        table.problem("paced", expected, false);
    }
    if wait <= gap {
        let expected = "more than gap_limit_ms: a reading waits for the next one of its companion";
        table.problem("wait_ms", expected, wait.as_millis());
    }
    for (name, _) in table.sections("clock") {
        if !devices.iter().any(|device| device.name == name) {
            let names: Vec<_> = devices.iter().map(|device| device.name.as_str()).collect();
            let expected = format!("tables of the synchronized devices {}", names.join(", "));
            table.problem("clock", expected, format!("{name:?}"));
        }
    }
    let clocks = table.section("clock");
    let each = devices.iter().map(|device| clock(&clocks.section(&device.name), device));
    let devices: Vec<Option<Timekeeping>> = each.collect();
    let devices = devices.into_iter().collect::<Option<_>>()?;
    let noise_mm = noise_nm.map(|noise_nm| noise_nm * 1e-6);
    Some(TimeConfig { gap, u_limit_mm: u_limit_um * 1e-3, noise_mm, devices, turning: None })
}

/// None of these keys means anything where readings are joined by count.
pub(super) fn refuse(table: &Section<'_>) {
    for key in ["gap_limit_ms", "u_limit_um", "noise_nm", "clock"] {
        if table.has(key) {
            table.problem(key, "no such key, or by = \"time\"", format!("`{key}`"));
        }
    }
}

fn clock(table: &Section<'_>, device: &DeviceConfig) -> Option<Timekeeping> {
    let own = device.settings.clock();
    let by_device = table.word("from", own.is_some(), &[("device", true), ("host", false)]);
    if by_device && own.is_none() {
        let expected = "\"host\", or settings with which its readings carry a time";
        table.problem("from", expected, format!("\"device\", of {}", device.name));
    }
    let delay = milliseconds(table.within("delay_ms", 0.0, 0.0..=10_000.0));
    let u_ms: Option<f64> = table.required("u_ms");
    if let Some(u_ms) = u_ms.filter(|u_ms| !(0.0..=10_000.0).contains(u_ms)) {
        table.problem("u_ms", "0 to 10000", u_ms);
        return None;
    }
    table.finish();
    Some(Timekeeping { clock: own.filter(|_| by_device), delay, u: milliseconds(u_ms?) })
}

fn milliseconds(ms: f64) -> Duration {
    Duration::from_secs_f64(ms * 1e-3)
}
