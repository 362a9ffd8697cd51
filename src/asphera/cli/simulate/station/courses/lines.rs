//! A part under a line scanner that an axis moves along it.

use asphera_stand::Sight;

use super::super::super::super::output::Failure;
use super::super::super::path::{self, PlaceMm};
use super::{NOTHING_TO_MEASURE, RATE_HZ, Scan, Shown, Simulated, shift_mm, sorted};
use crate::cli::simulate::station::PartArgs;
use crate::config::Config;
use crate::station::{Carriage, Profiler, Scaling};

/// The scan of a configuration's nominal, profile by profile. As many as `[scan] points` says, else as far apart as the points of one.
pub(super) fn scan(
    config: &Config,
    args: &PartArgs,
    profiler: &Profiler,
    mut shown: Shown<'_>,
) -> Result<Scan, Failure> {
    let Carriage::Linear(axis) = &profiler.carriage else {
        return Err("[kinematics]: expected a line scanner on a linear axis, found one over a part that turns, which is not simulated".into());
    };
    let instrument = &shown.of(profiler.stream).instrument;
    let lies = instrument.pitch_mm().zip(instrument.line_range_mm());
    let Some((pitch_mm, range_mm)) = lies else {
        return Err("[kinematics]: expected a line scanner for `across`, found a device that measures points".into());
    };
    let Some([_, half_y_mm]) = config.part.aperture.half_extents_mm() else {
        return Err(NOTHING_TO_MEASURE.into());
    };
    let profiles = config.end.points.unwrap_or((2.0 * half_y_mm / pitch_mm).round() as u64).max(1);
    // From the edge on, so that whole counts of an encoder stay whole.
    let steps = (0..profiles).map(|k| half_y_mm * ((2 * k) as f64 / profiles as f64 - 1.0));
    let along: Vec<f64> =
        steps.map(|y_mm| shown.show(axis, config.part.centre_mm[1] + y_mm)).collect();
    let points = points(profiler.across, pitch_mm);
    let line = Line { across: profiler.across, skew_rad: profiler.skew_rad, along, points };
    let places = path::raster(&config.part, SAMPLES);
    let simulated = Simulated::new(config, args, &places);
    let heights_mm: Vec<f64> =
        places.iter().filter_map(|place| simulated.height_mm(0, *place)).collect();
    let range_mm = sorted([range_mm.0, range_mm.1].map(|end| value_mm(profiler.height, end)));
    let shift_mm = shift_mm(config, Some(range_mm), &heights_mm)?;
    let height = profiler.height;
    let part = config.clone();
    let sight = Sight::new(points, move |trigger, point, across_mm| {
        let k = usize::try_from(trigger).ok()?;
        let place = line.place(k, across_mm)?;
        let index = k * line.points.max(point + 1) + point;
        let height_mm =
            simulated.height_mm(index, place).filter(|_| line.is_inside(&part, place))?;
        Some((height_mm + shift_mm - height.offset_mm) / height.scale)
    });
    shown.see(profiler.stream, sight);
    Ok(Scan {
        played: shown.played(),
        points: profiles,
        rate_hz: args.rate.unwrap_or(RATE_HZ.min(LINES_HZ)),
        part: config.part.nominal.kind(),
        shift_mm,
    })
}

/// Points of a line whose middle lies over the middle of the part.
fn points(across: Scaling, pitch_mm: f64) -> usize {
    let half = (across.offset_mm / (across.scale * pitch_mm)).abs();
    if half > 0.0 { (2.0 * half).round() as usize + 1 } else { ORDINARY_POINTS }
}

fn value_mm(scaling: Scaling, measured_mm: f64) -> f64 {
    measured_mm * scaling.scale + scaling.offset_mm
}

/// Where the lines lie.
struct Line {
    across: Scaling,
    skew_rad: f64,
    /// Of each profile, mm.
    along: Vec<f64>,
    points: usize,
}

impl Line {
    fn place(&self, profile: usize, across_mm: f64) -> Option<PlaceMm> {
        let (sin, cos) = self.skew_rad.sin_cos();
        let u_mm = value_mm(self.across, across_mm);
        Some([u_mm * cos, self.along.get(profile)? + u_mm * sin])
    }

    fn is_inside(&self, config: &Config, [x_mm, y_mm]: PlaceMm) -> bool {
        let [x0_mm, y0_mm] = config.part.centre_mm;
        config.part.aperture.contains(x_mm - x0_mm, y_mm - y0_mm)
    }
}

/// Profiles a second.
const LINES_HZ: f64 = 200.0;
/// Of a scanner whose configuration does not tell how many it has.
const ORDINARY_POINTS: usize = 640;
/// Places of the part that are looked at beforehand.
const SAMPLES: u64 = 10_000;
