//! A Modbus device whose registers follow the scan.

use std::sync::Arc;

use asphera_modbus::{Field, Kind, Map, Role, Settings};
use asphera_sim_modbus::{Device, Image, serve};
use tokio::net::TcpListener;
use tokio::time::Instant;

use crate::port::serve_hosts;
use crate::showing::Showing;

/// The device by its settings, which have no problems; `None` where there is no such map.
pub(crate) fn device(settings: &Settings, device: usize, showing: Arc<Showing>) -> Option<Device> {
    let map = settings.map.resolve()?;
    let registers = Device::new(settings.unit_id, map.clone());
    registers.animate(move |now, image| {
        let clock_s = now.as_nanos() as f64 * 1e-9;
        fill(image, &map, &showing.now(device), (showing.trigger(), clock_s));
    });
    Some(registers)
}

/// Sets every field to what it has to say. A value that its register cannot hold leaves the one before.
fn fill(image: &mut Image, map: &Map, values: &[f64], (trigger, clock_s): (u64, f64)) {
    let mut values = values.iter().copied();
    for field in &map.fields {
        let value = match &field.role {
            Role::Channel => values.next().unwrap_or(0.0),
            Role::Quality { good, .. } => {
                field.offset + field.scale * f64::from(good.first().copied().unwrap_or(0))
            }
            Role::Alarm => 0.0,
            Role::DeviceTimeSeconds => clock_s.floor(),
            Role::DeviceTimeMicros => micros(map, field, clock_s),
            Role::Count { first, modulus } => {
                (u64::from(*first) + trigger % u64::from((*modulus).max(1))) as f64
            }
        };
        if let Err(error) = image.set(&field.name, value) {
            tracing::debug!(%error, "a register holds no such value");
        }
    }
}

/// Microseconds within the second, where another field has the seconds; in the unit of the field.
fn micros(map: &Map, field: &Field, clock_s: f64) -> f64 {
    let has_seconds = map.fields.iter().any(|field| field.role == Role::DeviceTimeSeconds);
    let largest = match field.kind {
        Kind::U16 | Kind::I16 => 1e-6 * f64::from(u16::MAX),
        _ => 1e-6 * f64::from(u32::MAX),
    };
    if has_seconds { clock_s.fract() } else { clock_s.rem_euclid(largest) }
}

/// The value that is read where this one is sent.
pub(crate) fn shown(settings: &Settings, channel: usize, value: f64) -> f64 {
    let Some(map) = settings.map.resolve() else { return value };
    let mut channels = map.fields.iter().filter(|field| field.role == Role::Channel);
    let Some(field) = channels.nth(channel) else { return value };
    let words = asphera_modbus::encode_field(field, value).ok();
    words.map_or(value, |words| asphera_modbus::decode_field(field, &words))
}

/// The range that the map says a channel has.
pub(crate) fn range(settings: &Settings, channel: usize) -> Option<(f64, f64)> {
    let map = settings.map.resolve()?;
    map.fields.iter().filter(|field| field.role == Role::Channel).nth(channel)?.valid_range
}

/// Answers any number of hosts.
pub(crate) async fn answer(port: TcpListener, device: Device, settings: Settings) {
    let start = Instant::now();
    serve_hosts(port, |stream| serve(stream, device.clone(), settings.transport, start)).await;
}
