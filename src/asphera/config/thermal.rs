//! `[thermal]`: expansion of the part and of the scales of the machine.

use std::time::Duration;

use asphera_link::Unit;
use asphera_settings::Section;

use super::devices::DeviceConfig;
use crate::station::{Expansion, Temperature, ThermalSettings};

/// Reads the table; `None` where it is absent or cannot be used. Of devices that cannot be used none is asked for.
pub(super) fn read(
    table: &Section<'_>,
    devices: Option<&Vec<DeviceConfig>>,
) -> Option<ThermalSettings> {
    if !table.is_present() {
        return None;
    }
    let devices = devices?;
    let stale_s = table.within("stale_s", 60.0, 0.1..=86_400.0);
    let range_degc = match table.has("range_degc") {
        true => table.range("range_degc")?,
        false => USUAL_DEGC,
    };
    let read = |key: &str| {
        let section = table.section(key);
        section.is_present().then(|| {
            let body = body(&section, devices, range_degc);
            section.finish();
            body
        })
    };
    let (part, scales) = (read("part"), read("scales"));
    if part.is_none() && scales.is_none() {
        table.problem(
            "part",
            "a table part or scales with a temperature and a coefficient",
            "nothing",
        );
    }
    table.finish();
    // A table that cannot be used is a problem already.
    let is_whole = part != Some(None) && scales != Some(None);
    is_whole.then(|| ThermalSettings {
        part: part.flatten(),
        scales: scales.flatten(),
        stale: Duration::from_secs_f64(stale_s),
        range_degc,
        starts_with_angle: false,
    })
}

/// Temperatures in °C of rooms where things are measured: what else a thermometer says is its failure.
const USUAL_DEGC: (f64, f64) = (10.0, 40.0);

fn body(
    table: &Section<'_>,
    devices: &[DeviceConfig],
    range_degc: (f64, f64),
) -> Option<Expansion> {
    let number = |key: &str, low: f64, high: f64| -> Option<f64> {
        let value: f64 = table.required(key)?;
        if (low..=high).contains(&value) {
            return Some(value);
        }
        table.problem(key, format!("{low} to {high}"), value);
        None
    };
    let per_k = number("expansion_um_per_m_k", -50.0, 1000.0);
    let u_per_k = number("u_expansion_um_per_m_k", 0.0, 1000.0);
    let u_k = number("u_k", 0.0, 100.0);
    let temperature = if table.has("constant_degc") {
        number("constant_degc", range_degc.0, range_degc.1).map(Temperature::Constant)
    } else {
        channel(table, devices)
    };
    Some(Expansion {
        temperature: temperature?,
        per_k: per_k? * PER_UM_PER_M,
        u_per_k: u_per_k? * PER_UM_PER_M,
        u_k: u_k?,
    })
}

const PER_UM_PER_M: f64 = 1e-6;

/// The channel of a thermometer, which may be any device of the station.
fn channel(table: &Section<'_>, devices: &[DeviceConfig]) -> Option<Temperature> {
    let name: Option<String> = table.required("device");
    let channel: Option<String> = table.required("channel");
    let (name, channel) = (name?, channel?);
    let Some(device) = devices.iter().position(|device| device.name == name) else {
        let names: Vec<&str> = devices.iter().map(|device| device.name.as_str()).collect();
        let expected = format!("one of the devices {}, or constant_degc", names.join(", "));
        table.problem("device", expected, format!("{name:?}"));
        return None;
    };
    let channels = &devices[device].channels;
    let known = channels.iter().position(|known| known.name == channel);
    let found = known.filter(|known| channels[*known].unit == Unit::DegreeCelsius);
    if found.is_none() {
        let warm = channels.iter().filter(|known| known.unit == Unit::DegreeCelsius);
        let names: Vec<&str> = warm.map(|known| known.name.as_str()).collect();
        let expected = match &names[..] {
            [] => format!("a device with a channel in degC, which {name} has not"),
            names => format!("one of the channels in degC {} of {name}", names.join(", ")),
        };
        table.problem("channel", expected, format!("{channel:?}"));
    }
    found.map(|channel| Temperature::Channel { device, channel })
}
