//! A part under a measuring machine that runs the program of the station.

use asphera_stand::Touch;

use super::super::super::super::output::Failure;
use super::super::super::path;
use super::{NOTHING_TO_MEASURE, Order, Scan, Shown, Simulated};
use crate::cli::simulate::station::{PartArgs, machine_speed};
use crate::config::Config;
use crate::station::{Axis, Kinematics};

/// The bench of a station with a program. Its machine reads the part as the station expects it: with the ball of `[tip]`, if there is one.
pub(super) fn scan(
    config: &Config,
    args: &PartArgs,
    stream: usize,
    mut shown: Shown<'_>,
) -> Result<Scan, Failure> {
    let Kinematics::Cartesian { x, y, z } = &config.kinematics else {
        return Err("[kinematics]: expected cartesian for a device with a program".into());
    };
    let channels = [x, y, z].map(|axis| axis.source.map(|source| source.channel));
    let is_its_own =
        [x, y, z].into_iter().flat_map(|axis| axis.source).all(|one| one.stream == stream);
    if !is_its_own || ![[0, 1, 2], [1, 0, 2]].map(|order| order.map(Some)).contains(&channels) {
        return Err("[kinematics]: expected x and y of the machine in either order, and z along z, found others, which are not simulated".into());
    }
    let places = path::raster(&config.part, SAMPLES);
    if places.is_empty() {
        return Err(NOTHING_TO_MEASURE.into());
    }
    let without_noise = PartArgs { noise_nm: 0.0, ..args.clone() };
    let simulated = Simulated::new(config, &without_noise, &places);
    let (tip, z, x, y) = (config.tip, z.clone(), x.clone(), y.clone());
    let noise_nm = args.noise_nm / z.scale.abs();
    let height_mm = move |machine_mm: [f64; 2]| {
        let stand = |axis: &Axis| {
            let channel = axis.source.map_or(0, |source| source.channel);
            machine_mm[channel] * axis.scale + axis.offset
        };
        let place = [stand(&x), stand(&y)];
        let height_mm = match &tip {
            Some(tip) => simulated.touched_mm(tip, 0, place),
            None => simulated.height_mm(0, place),
        };
        Some((height_mm? - z.offset) / z.scale)
    };
    shown.touch(stream, Touch::new(height_mm, noise_nm, args.seed, machine_speed(args)?));
    Ok(Scan {
        played: shown.played(),
        points: 0,
        rate_hz: 1.0,
        part: config.part.nominal.kind(),
        shift_mm: 0.0,
        order: Order::Program,
    })
}

/// Places of the part that are looked at beforehand.
const SAMPLES: u64 = 10_000;
