//! A part under a probe that tilts with its slope.

use asphera_form::Parameter;

use super::super::super::super::output::Failure;
use super::super::super::path::{self, PlaceMm};
use super::{MM_PER_NM, NOTHING_TO_MEASURE, Order, Scan, Shown, Simulated, rate_hz, sorted};
use crate::cli::simulate::station::PartArgs;
use crate::config::Config;
use crate::station::{Axis, Tilting};

/// The scan of a configuration's nominal: the beam lies along the normal as far as the axes let it, and the pivot follows the part.
///
/// Each place is the one that the devices show: their steps are finite, and the beam meets the part where they say.
pub(super) fn scan(
    config: &Config,
    args: &PartArgs,
    tilting: &Tilting,
    mut shown: Shown<'_>,
) -> Result<Scan, Failure> {
    if config.tip.is_some() {
        return Err("[tip]: expected no ball on a probe that tilts, found one, which is not simulated: remove [tip]".into());
    }
    let targets = targets(config, args.points, tilting);
    if targets.is_empty() {
        return Err(NOTHING_TO_MEASURE.into());
    }
    let places: Vec<PlaceMm> = targets.iter().map(|target| target.place()).collect();
    let simulated = Simulated::new(config, args, &places);
    let range_mm = shown.range_mm(&tilting.probe);
    let shift_mm = shift_mm(config, tilting, range_mm, &simulated, &places)?;
    let bench = Bench { tilting, simulated, shift_mm, range_mm };
    for (index, target) in targets.iter().enumerate() {
        bench.measure(index, *target, &mut shown)?;
    }
    Ok(Scan {
        played: shown.played(),
        points: targets.len() as u64,
        rate_hz: rate_hz(config, args),
        part: config.part.nominal.kind(),
        shift_mm,
        order: Order::Simulation,
    })
}

/// Place where the beam is to meet the part, before the part turned by an angle.
#[derive(Clone, Copy)]
struct Target {
    at_mm: PlaceMm,
    angle_rad: f64,
}

impl Target {
    /// The place in the part frame.
    fn place(self) -> PlaceMm {
        turned(self.at_mm, self.angle_rad)
    }
}

/// A spiral where the part turns, else a raster.
fn targets(config: &Config, points: u64, tilting: &Tilting) -> Vec<Target> {
    let part = &config.part;
    match tilting.rotary {
        Some(_) => {
            let turns = path::spiral(part, points).into_iter();
            turns.map(|[x_mm, angle_rad]| Target { at_mm: [x_mm, 0.0], angle_rad }).collect()
        }
        None => {
            let places = path::raster(part, points).into_iter();
            places.map(|at_mm| Target { at_mm, angle_rad: 0.0 }).collect()
        }
    }
}

/// How far the part must lie higher, mm, where the pivot has no height of its own.
fn shift_mm(
    config: &Config,
    tilting: &Tilting,
    range_mm: Option<[f64; 2]>,
    simulated: &Simulated,
    places: &[PlaceMm],
) -> Result<f64, Failure> {
    let Some(range_mm) = range_mm.filter(|_| tilting.z.source.is_none()) else { return Ok(0.0) };
    if !config.part.free.contains(&Parameter::Tz) {
        return Ok(0.0);
    }
    let heights: Vec<f64> = places.iter().filter_map(|place| simulated.smooth_mm(*place)).collect();
    let at_zero_mm = range_mm.map(|d_mm| d_mm + tilting.z.offset);
    super::shift_mm(config, Some(at_zero_mm), &heights)
}

/// The probe over the part.
struct Bench<'a> {
    tilting: &'a Tilting,
    simulated: Simulated,
    shift_mm: f64,
    /// What the probe can read along its beam, mm.
    range_mm: Option<[f64; 2]>,
}

impl Bench<'_> {
    /// Lets all axes show one more point.
    fn measure(&self, index: usize, target: Target, shown: &mut Shown<'_>) -> Result<(), Failure> {
        let Tilting { x, y, z, tilt, probe, rotary, pivot_offset_mm: [a, b] } = self.tilting;
        let at_mm = [target.at_mm[0], target.at_mm[1]];
        let nowhere = || -> Failure {
            let [x_mm, y_mm] = target.place();
            format!("the nominal has no height at ({x_mm:.3}, {y_mm:.3}) mm: narrow its aperture")
                .into()
        };
        let angle_rad = rotary.as_ref().map_or(0.0, |axis| shown.show(axis, target.angle_rad));
        let height =
            |at: PlaceMm| Some(self.simulated.smooth_mm(turned(at, angle_rad))? + self.shift_mm);
        let slope = slope(&height, at_mm).ok_or_else(nowhere)?;
        // The upward normal of z(x) is (−z′, 1).
        let tilt_rad = shown.show(tilt, (-slope).atan());
        let (sin, cos) = tilt_rad.sin_cos();
        let middle_mm = self.range_mm.map_or(0.0, |[low, high]| 0.5 * (low + high));
        let beam = |d_mm: f64| [a * cos + d_mm * sin, *b, d_mm * cos - a * sin];
        let [reach_x, reach_y, reach_z] = beam(middle_mm);
        let above_mm = height(at_mm).ok_or_else(nowhere)?;
        let pivot_mm = [
            shown.show(x, at_mm[0] - reach_x),
            shown.show(y, at_mm[1] - reach_y),
            shown.show(z, above_mm - reach_z),
        ];
        let mut d_mm = middle_mm;
        for _ in 0..STEPS {
            let [dx, dy, dz] = beam(d_mm);
            let at = [pivot_mm[0] + dx, pivot_mm[1] + dy];
            let gap_mm = pivot_mm[2] + dz - height(at).ok_or_else(nowhere)?;
            d_mm -= gap_mm / (cos - slope * sin);
        }
        let noise_mm = MM_PER_NM * self.simulated.noise_nm * self.simulated.noise.normal(index);
        self.show(probe, d_mm + noise_mm, shown)
    }

    fn show(&self, probe: &Axis, d_mm: f64, shown: &mut Shown<'_>) -> Result<(), Failure> {
        if let Some([low, high]) =
            self.range_mm.map(sorted).filter(|[low, high]| !(*low..=*high).contains(&d_mm))
        {
            return Err(format!("the probe would have to read {d_mm:.3} mm along its beam, and reads {low:.3} to {high:.3} mm: let z move, or set offset_mm of z").into());
        }
        shown.show(probe, d_mm);
        Ok(())
    }
}

/// Slope of the part along x, by central differences.
fn slope(height: &impl Fn(PlaceMm) -> Option<f64>, [x_mm, y_mm]: PlaceMm) -> Option<f64> {
    let ahead = height([x_mm + STEP_MM, y_mm])?;
    Some((ahead - height([x_mm - STEP_MM, y_mm])?) / (2.0 * STEP_MM))
}

/// A place after a turn of the part.
fn turned([x_mm, y_mm]: PlaceMm, angle_rad: f64) -> PlaceMm {
    let (sin, cos) = angle_rad.sin_cos();
    [x_mm * cos - y_mm * sin, x_mm * sin + y_mm * cos]
}

/// Steps to where the beam meets the part: each leaves the curvature of the part times the square of what was left.
const STEPS: usize = 12;
/// Half a step of the differences, mm.
const STEP_MM: f64 = 1e-4;
