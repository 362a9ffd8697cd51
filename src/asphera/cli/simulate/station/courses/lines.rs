//! A part under a line scanner that an axis moves along it, or turns under it.

use asphera_stand::Sight;

use super::super::super::super::output::Failure;
use super::super::super::path::{self, PlaceMm};
use super::side::Side;
use super::{NOTHING_TO_MEASURE, Order, RATE_HZ, Scan, Shown, Simulated, shift_mm, sorted};
use crate::cli::simulate::station::PartArgs;
use crate::config::Config;
use crate::station::{Carriage, ProfileDirection, Profiler, Scaling};

/// The scan of a configuration's nominal, profile by profile: as many as `[scan] points` says, else as far apart as the points of one.
pub(super) fn scan(
    config: &Config,
    args: &PartArgs,
    profiler: &Profiler,
    mut shown: Shown<'_>,
) -> Result<Scan, Failure> {
    let instrument = &shown.of(profiler.stream).instrument;
    let lies = instrument.pitch_mm().zip(instrument.line_range_mm());
    let Some((pitch_mm, range_mm)) = lies else {
        return Err("[kinematics]: expected a line scanner for `across`, found a device that measures points".into());
    };
    let points = instrument.line_points().unwrap_or_else(|| points(profiler.across, pitch_mm));
    let range_mm = sorted([range_mm.0, range_mm.1].map(|end| value_mm(profiler.height, end)));
    let reach_mm = reach_mm(config, profiler)?;
    let stands = stands(config, profiler, reach_mm, pitch_mm);
    let axis = profiler.carriage.axis().clone();
    let stands: Vec<f64> = stands.into_iter().map(|stand| shown.show(&axis, stand)).collect();
    let profiles = stands.len() as u64;
    let track = match profiler.carriage {
        Carriage::Linear(_) => Track::Linear,
        Carriage::Turning { tangential_mm, .. } => Track::Turning { tangential_mm },
    };
    let (across, skew_rad) = (profiler.across, profiler.skew_rad);
    let line = Line { across, skew_rad, track, stands, points };
    let (sight, shift_mm) = match profiler.carriage {
        Carriage::Turning { profile: ProfileDirection::Axial, .. } => {
            let side = Side::new(config, args, range_mm)?;
            (of_side(side, line, profiler.height), 0.0)
        }
        Carriage::Linear(_) | Carriage::Turning { .. } => {
            of_face(config, args, range_mm, line, profiler.height)?
        }
    };
    shown.see(profiler.stream, sight);
    Ok(Scan {
        played: shown.played(),
        points: profiles,
        rate_hz: args.rate.unwrap_or(RATE_HZ.min(LINES_HZ)),
        part: config.part.nominal.kind(),
        shift_mm,
        order: Order::Simulation,
    })
}

/// Farthest way of the part from its middle along the carriage, mm: half its width, or its largest radius.
fn reach_mm(config: &Config, profiler: &Profiler) -> Result<f64, Failure> {
    let aperture = &config.part.aperture;
    let reach_mm = match &profiler.carriage {
        Carriage::Linear(_) => aperture.half_extents_mm().map(|[_, half_y_mm]| half_y_mm),
        Carriage::Turning { profile: ProfileDirection::Radial, .. } => aperture.reach_mm(),
        Carriage::Turning { profile: ProfileDirection::Axial, .. } => {
            Some(Side::radius_mm(&config.part)?)
        }
    };
    reach_mm.ok_or_else(|| NOTHING_TO_MEASURE.into())
}

/// Where the axis stands at each profile, mm or rad: from the edge on, or one turn.
fn stands(config: &Config, profiler: &Profiler, reach_mm: f64, pitch_mm: f64) -> Vec<f64> {
    let profiles =
        |length_mm: f64| config.end.points.unwrap_or((length_mm / pitch_mm).round() as u64).max(1);
    match profiler.carriage {
        Carriage::Linear(_) => {
            let profiles = profiles(2.0 * reach_mm);
            // From the edge on, so that whole counts of an encoder stay whole.
            let share = |k: u64| (2 * k) as f64 / profiles as f64 - 1.0;
            let middle_mm = config.part.centre_mm[1];
            (0..profiles).map(|k| middle_mm + reach_mm * share(k)).collect()
        }
        Carriage::Turning { .. } => {
            let turn_rad = std::f64::consts::TAU;
            let profiles = profiles(turn_rad * reach_mm);
            (0..profiles).map(|k| turn_rad * k as f64 / profiles as f64).collect()
        }
    }
}

/// What is seen of the part's face, with how far it lies higher than its nominal, mm.
fn of_face(
    config: &Config,
    args: &PartArgs,
    range_mm: [f64; 2],
    line: Line,
    height: Scaling,
) -> Result<(Sight, f64), Failure> {
    let places = path::raster(&config.part, SAMPLES);
    let simulated = Simulated::new(config, args, &places);
    let heights_mm: Vec<f64> =
        places.iter().filter_map(|place| simulated.height_mm(0, *place)).collect();
    let shift_mm = shift_mm(config, Some(range_mm), &heights_mm)?;
    let config = config.clone();
    let sight = Sight::new(line.points, move |trigger, point, across_mm| {
        let k = usize::try_from(trigger).ok()?;
        let place = line.place(k, across_mm)?;
        let height_mm = simulated
            .height_mm(line.index(k, point), place)
            .filter(|_| is_inside(&config, place))?;
        Some((height_mm + shift_mm - height.offset_mm) / height.scale)
    });
    Ok((sight, shift_mm))
}

/// What is seen of a part from its side.
fn of_side(side: Side, line: Line, height: Scaling) -> Sight {
    Sight::new(line.points, move |trigger, point, across_mm| {
        let k = usize::try_from(trigger).ok()?;
        let angle_rad = *line.stands.get(k)?;
        let [along_mm, tangential_mm] = line.lies_mm(across_mm);
        let distance_mm =
            side.distance_mm(line.index(k, point), angle_rad, tangential_mm, along_mm)?;
        Some((distance_mm - height.offset_mm) / height.scale)
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

/// How the part passes the lines.
#[derive(Clone, Copy)]
enum Track {
    /// Along y.
    Linear,
    /// It turns, and the laser line passes its axis by so many mm.
    Turning { tangential_mm: f64 },
}

/// Where the lines lie.
struct Line {
    across: Scaling,
    skew_rad: f64,
    track: Track,
    /// Where the axis stands at each profile, mm or rad.
    stands: Vec<f64>,
    points: usize,
}

impl Line {
    /// Place along the laser line and across it, before the axis moved it, mm.
    fn lies_mm(&self, across_mm: f64) -> [f64; 2] {
        let (sin, cos) = self.skew_rad.sin_cos();
        let u_mm = value_mm(self.across, across_mm);
        let beside_mm = match self.track {
            Track::Linear => 0.0,
            Track::Turning { tangential_mm } => tangential_mm,
        };
        [u_mm * cos, beside_mm + u_mm * sin]
    }

    /// Place of a point on the face of the part, mm in the part frame.
    fn place(&self, profile: usize, across_mm: f64) -> Option<PlaceMm> {
        let stand = *self.stands.get(profile)?;
        let [x_mm, y_mm] = self.lies_mm(across_mm);
        Some(match self.track {
            Track::Linear => [x_mm, stand + y_mm],
            Track::Turning { .. } => {
                let (sin, cos) = stand.sin_cos();
                [x_mm * cos - y_mm * sin, x_mm * sin + y_mm * cos]
            }
        })
    }

    /// Number of a point of a profile among those of the scan, for its noise.
    fn index(&self, profile: usize, point: usize) -> usize {
        profile * self.points.max(point + 1) + point
    }
}

fn is_inside(config: &Config, [x_mm, y_mm]: PlaceMm) -> bool {
    let [x0_mm, y0_mm] = config.part.centre_mm;
    config.part.aperture.contains(x_mm - x0_mm, y_mm - y0_mm)
}

/// Profiles a second.
const LINES_HZ: f64 = 200.0;
/// Of a scanner whose configuration does not tell how many it has.
const ORDINARY_POINTS: usize = 640;
/// Places of the part that are looked at beforehand.
const SAMPLES: u64 = 10_000;
