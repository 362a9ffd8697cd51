//! The thermometer: two slow temperatures in two input registers.

use std::f64::consts::TAU;

use asphera_link::{Nanos, Unit};
use asphera_modbus::{Field, Function, Kind, Map};
use asphera_sim_modbus::Device;

use crate::noise::uniform;
use crate::scene::Thermal;

/// Worth of a unit of the registers, °C.
pub(crate) const STEP_DEGC: f64 = 0.01;
/// Names of the fields, in the order of their registers from 0.
pub(crate) const FIELDS: [&str; 2] = ["air", "part"];

/// A device whose registers follow the time of the request.
pub(crate) fn device(thermal: Thermal, seed: u64) -> Device {
    let fields = FIELDS.iter().zip(0..).map(|(name, address)| Field {
        scale: STEP_DEGC,
        ..Field::channel(*name, Function::ReadInput, address, Kind::I16, Unit::DegreeCelsius)
    });
    let map = Map { name: "thermometer".to_owned(), fields: fields.collect(), blocks: Vec::new() };
    let device = Device::new(thermal.unit_id, map);
    device.animate(move |now, image| {
        for (name, value) in FIELDS.into_iter().zip(temperatures_degc(&thermal, seed, now)) {
            image.set(name, value).expect("the map has both fields, and a scene's range fits them");
        }
    });
    device
}

/// Air and part at a time: the part follows at a third of the amplitude, an eighth of the period
/// later. The seed sets the phase.
fn temperatures_degc(thermal: &Thermal, seed: u64, now: Nanos) -> [f64; 2] {
    let periods = now.as_nanos() as f64 * 1e-9 / thermal.period_s + uniform(seed, PHASE);
    let at = |share: f64, lag: f64| {
        thermal.mean_degc + share * thermal.amplitude_degc * (TAU * (periods - lag)).sin()
    };
    [at(1.0, 0.0), at(1.0 / 3.0, 0.125)]
}

/// Place in the stream of the seed, far from those of the triggers.
const PHASE: u64 = 1 << 63;

#[cfg(test)]
mod tests {
    use super::*;

    const THERMAL: Thermal =
        Thermal { unit_id: 1, mean_degc: 20.0, amplitude_degc: 0.3, period_s: 8.0 };

    #[test]
    fn temperatures_stay_within_their_amplitudes_and_repeat_after_a_period() {
        let at = |ms| temperatures_degc(&THERMAL, 5, Nanos::from_millis(ms));
        let swings: Vec<[f64; 2]> =
            (0..800).map(|i| at(10 * i).map(|value| value - 20.0)).collect();
        let largest = |i: usize| swings.iter().map(|swing| swing[i].abs()).fold(0.0, f64::max);
        assert!((largest(0) - 0.3).abs() < 1e-4 && (largest(1) - 0.1).abs() < 1e-4);
        assert!((at(8_000)[0] - at(0)[0]).abs() < 1e-12);
        assert!((at(1_000)[1] - 20.0 - (at(0)[0] - 20.0) / 3.0).abs() < 1e-12);
    }
}
