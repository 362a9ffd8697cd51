//! A part on axes that the station moves.

use asphera_plan::{Axis as Limit, Machine};
use asphera_stand::Moving;

use super::super::super::super::output::Failure;
use super::super::super::path;
use super::{NOTHING_TO_MEASURE, Order, Scan, Shown, Simulated, heights_mm, shift_mm};
use crate::cli::simulate::station::PartArgs;
use crate::config::Config;
use crate::station::{Axis, Kinematics, ScanPlan};

/// The bench of a station with a plan: its stages and drives obey, and the probe meets the part where they stand.
pub(super) fn scan(
    config: &Config,
    args: &PartArgs,
    plan: &ScanPlan,
    shown: Shown<'_>,
) -> Result<Scan, Failure> {
    let (Kinematics::Cartesian { z: height, .. } | Kinematics::Polar { probe: height, .. }) =
        &config.kinematics
    else {
        // A plan has no others.
        return Err("[kinematics]: expected cartesian or polar beside [scan.plan]".into());
    };
    let Some(source) = height.source else {
        return Err("[kinematics]: expected a probe that measures, found a constant height".into());
    };
    let places = path::raster(&config.part, SAMPLES);
    if places.is_empty() {
        return Err(NOTHING_TO_MEASURE.into());
    }
    let simulated = Simulated::new(config, args, &places);
    let range_mm = shown.range_mm(height);
    let shift_mm = shift_mm(config, range_mm, &heights_mm(config, args, &places)?)?;
    // Beside the part the probe shows what is beyond its range.
    let beside_mm = range_mm.map_or(BESIDE_MM, |[low_mm, high_mm]| 2.0 * high_mm - low_mm);
    let travels = travels(config, plan, &shown);
    let places =
        Places { kinematics: config.kinematics.clone(), devices: config.sync.devices.clone() };
    let (probe, channel) = (config.sync.devices[source.stream], source.channel);
    let (tip, height) = (config.tip, height.clone());
    let follow = move |reading: u64, values: &mut [Vec<f64>]| {
        let index = usize::try_from(reading).unwrap_or(usize::MAX);
        let place = places.place_mm(values);
        let height_mm = match &tip {
            Some(tip) => simulated.touched_mm(tip, index, place),
            None => simulated.height_mm(index, place),
        };
        let z_mm = height_mm.map_or(beside_mm, |height_mm| height_mm + shift_mm);
        values[probe][channel] = (z_mm - height.offset) / height.scale;
    };
    Ok(Scan {
        played: shown.played(),
        points: args.points,
        rate_hz: args.rate.unwrap_or(READINGS_HZ),
        part: config.part.nominal.kind(),
        shift_mm,
        order: Order::Plan(Moving::new(travels, follow)),
    })
}

/// Where values of channels say that the machine stands.
struct Places {
    kinematics: Kinematics,
    /// Of each stream the number of its device.
    devices: Vec<usize>,
}

impl Places {
    fn place_mm(&self, values: &[Vec<f64>]) -> [f64; 2] {
        let stand = |axis: &Axis| match axis.source {
            Some(source) => {
                values[self.devices[source.stream]][source.channel] * axis.scale + axis.offset
            }
            None => axis.offset,
        };
        match &self.kinematics {
            Kinematics::Cartesian { x, y, .. } => [stand(x), stand(y)],
            Kinematics::Polar { rotary, radial, .. } => {
                let ((sin, cos), radius_mm) = (stand(rotary).sin_cos(), stand(radial));
                [radius_mm * cos, radius_mm * sin]
            }
            // A plan has no others.
            Kinematics::Line(_) | Kinematics::Tilting(_) => [f64::NAN; 2],
        }
    }
}

/// Travel of each device and channel that the plan moves, in the unit of the channel.
fn travels(config: &Config, plan: &ScanPlan, shown: &Shown<'_>) -> Vec<Vec<Option<[f64; 2]>>> {
    let mut travels: Vec<Vec<Option<[f64; 2]>>> =
        shown.played.iter().map(|played| vec![None; played.courses.len()]).collect();
    let limits = match plan.limits.machine {
        Machine::Cartesian { x, y } => [x, y],
        Machine::Polar { r, c } => [r, c],
    };
    for (axis, Limit { low, high, .. }) in plan.axes.iter().zip(limits) {
        // An axis without end has turns enough.
        let ends = [low.max(-ENDLESS), high.min(ENDLESS)];
        let travel = super::sorted(ends.map(|end| (end - axis.offset) / axis.scale));
        travels[config.sync.devices[axis.stream]][axis.channel] = Some(travel);
    }
    travels
}

/// Of the probe, while the station moves the axes.
const READINGS_HZ: f64 = 500.0;
/// Height that no part has.
const BESIDE_MM: f64 = 99.0;
/// Travel of an axis that turns without end, rad.
const ENDLESS: f64 = 6283.0;
/// Places of the part that are looked at beforehand.
const SAMPLES: u64 = 10_000;
