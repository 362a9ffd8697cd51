//! What each channel shows while a part is scanned.

mod ball;
mod lines;
mod moving;
mod program;
mod side;
mod tilting;

use std::net::SocketAddr;

use asphera_form::Parameter;
use asphera_form::form_error::FormError;
use asphera_geometry::Numbers;
use asphera_measure::Part;
use asphera_stand::{Instrument, Moving, Played, Sight, Touch};
use asphera_transport::Endpoint;

use super::super::super::output::Failure;
use super::super::super::usage::misused;
use super::super::path::{self, PlaceMm};
use super::{PartArgs, instruments};
use crate::config::Config;
use crate::station::{Axis, Kinematics};

/// A scan of a part.
pub(super) struct Scan {
    /// What each device shows.
    pub(super) played: Vec<Played>,
    /// Triggers.
    pub(super) points: u64,
    pub(super) rate_hz: f64,
    /// Kind of the surface.
    pub(super) part: &'static str,
    /// How far the part lies above its nominal place, mm.
    pub(super) shift_mm: f64,
    /// Who says where the machine goes.
    pub(super) order: Order,
}

impl Scan {
    /// Whether a device measures on after the last trigger, so that no silence ends the scan.
    pub(super) fn ends_by_count(&self) -> bool {
        let is_simulated = matches!(self.order, Order::Simulation);
        is_simulated && self.played.iter().any(|played| played.instrument.free_rate_hz().is_some())
    }
}

/// Who says where the machine goes.
pub(super) enum Order {
    /// The simulation: from place to place at each trigger.
    Simulation,
    /// The station's plan.
    Plan(Moving),
    /// The station's program.
    Program,
}

/// The scan of a configuration's nominal, with a smooth form error along z.
///
/// Each place is the one that the devices show: their steps are finite, and the part is met where they say.
pub(super) fn scan(config: &Config, args: &PartArgs) -> Result<Scan, Failure> {
    let mut shown = Shown::new(config, instruments(config)?);
    if let Some(stream) = config.program {
        return program::scan(config, args, stream, shown);
    }
    if args.speed.is_some() {
        return Err(misused(
            "--speed: expected --session or a station with a program, found another station: --rate says how fast it is scanned",
        ));
    }
    let args = &paced(args, &shown)?;
    if let Some(plan) = &config.scan {
        return moving::scan(config, args, plan, shown);
    }
    let height = match &config.kinematics {
        Kinematics::Cartesian { z, .. } => z,
        Kinematics::Polar { probe, .. } => probe,
        Kinematics::Line(profiler) => return lines::scan(config, args, profiler, shown),
        Kinematics::Tilting(tilting) => return tilting::scan(config, args, tilting, shown),
    };
    let places = places(config, args.points, &mut shown)?;
    let heights_mm = heights_mm(config, args, &places)?;
    let shift_mm = shift_mm(config, shown.range_mm(height), &heights_mm)?;
    for height_mm in heights_mm {
        shown.show(height, height_mm + shift_mm);
    }
    Ok(Scan {
        played: shown.played(),
        points: places.len() as u64,
        rate_hz: rate_hz(config, args),
        part: config.part.nominal.kind(),
        shift_mm,
        order: Order::Simulation,
    })
}

/// The arguments with the rate of a device that runs by its own clock, where there is one.
fn paced(args: &PartArgs, shown: &Shown<'_>) -> Result<PartArgs, Failure> {
    let free = shown.played.iter().find_map(|played| played.instrument.free_rate_hz());
    match (args.rate, free) {
        (Some(found), Some(free_hz)) if found != free_hz => Err(misused(format!(
            "--rate: expected none or {free_hz} Hz, of a device that runs by its own clock, found {found} Hz: its settings say how fast it measures"
        ))),
        (rate, free) => Ok(PartArgs { rate: rate.or(free), ..args.clone() }),
    }
}

/// Where the axes say that the machine stands at each trigger.
fn places(config: &Config, points: u64, shown: &mut Shown<'_>) -> Result<Vec<PlaceMm>, Failure> {
    let part = &config.part;
    let places: Vec<PlaceMm> = match &config.kinematics {
        Kinematics::Cartesian { x, y, .. } => {
            let places = match (x.source, y.source) {
                (Some(_), None) => path::line(part, points, 0, y.offset),
                (None, Some(_)) => path::line(part, points, 1, x.offset),
                (Some(_), Some(_)) | (None, None) => path::raster(part, points),
            };
            places
                .into_iter()
                .map(|[x_mm, y_mm]| [shown.show(x, x_mm), shown.show(y, y_mm)])
                .collect()
        }
        Kinematics::Polar { rotary, radial, .. } => {
            let turns = path::spiral(part, points).into_iter();
            let place = |[radius_mm, angle_rad]: [f64; 2]| {
                let (radius_mm, angle_rad) =
                    (shown.show(radial, radius_mm), shown.show(rotary, angle_rad));
                let (sin, cos) = angle_rad.sin_cos();
                [radius_mm * cos, radius_mm * sin]
            };
            turns.map(place).collect()
        }
        // They have scans of their own.
        Kinematics::Line(_) | Kinematics::Tilting(_) => Vec::new(),
    };
    if places.is_empty() {
        return Err(NOTHING_TO_MEASURE.into());
    }
    Ok(places)
}

/// The part with its form error and the noise of the probe.
#[derive(Clone, Debug)]
struct Simulated {
    part: Part,
    form: FormError,
    /// Amount by which the form error is taken.
    share: f64,
    noise_nm: f64,
    noise: Numbers,
}

impl Simulated {
    /// The part of a configuration. `places` tell how high its form error is from peak to valley.
    fn new(config: &Config, args: &PartArgs, places: &[PlaceMm]) -> Simulated {
        let part = config.part.clone();
        let [x0_mm, y0_mm] = part.centre_mm;
        let form = FormError::typical(part.aperture.reach_mm().unwrap_or(1.0));
        let errors = places.iter().map(|[x, y]| form.height_nm(x - x0_mm, y - y0_mm));
        let (lowest, highest) = errors
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), nm| {
                (low.min(nm), high.max(nm))
            });
        let share = if highest > lowest { args.form_nm / (highest - lowest) } else { 0.0 };
        let noise = Numbers::new(args.seed, 0, 0);
        Simulated { part, form, share, noise_nm: args.noise_nm, noise }
    }

    /// Measured height at a place, mm; `None` where the nominal has none.
    fn height_mm(&self, index: usize, place: PlaceMm) -> Option<f64> {
        let noise_nm = self.noise_nm * self.noise.normal(index);
        Some(self.smooth_mm(place)? + MM_PER_NM * noise_nm)
    }

    /// Height at a place without noise, mm.
    fn smooth_mm(&self, [x_mm, y_mm]: PlaceMm) -> Option<f64> {
        let [x0_mm, y0_mm] = self.part.centre_mm;
        let error_nm = self.share * self.form.height_nm(x_mm - x0_mm, y_mm - y0_mm);
        Some(self.part.nominal.height_mm(x_mm, y_mm)? + MM_PER_NM * error_nm)
    }
}

/// Heights of the part at these places, mm.
fn heights_mm(config: &Config, args: &PartArgs, places: &[PlaceMm]) -> Result<Vec<f64>, Failure> {
    let simulated = Simulated::new(config, args, places);
    let height = |(index, &[x_mm, y_mm]): (usize, &PlaceMm)| {
        let read = match &config.tip {
            Some(tip) => simulated.touched_mm(tip, index, [x_mm, y_mm]),
            None => simulated.height_mm(index, [x_mm, y_mm]),
        };
        read.ok_or_else(|| {
            format!("the nominal has no height at ({x_mm:.3}, {y_mm:.3}) mm: narrow its aperture")
                .into()
        })
    };
    places.iter().enumerate().map(height).collect()
}

/// How far the part must lie higher for a probe of this range, from the bottom to the top in mm, to reach all of it; 0 where it does
/// already.
fn shift_mm(
    config: &Config,
    range_mm: Option<[f64; 2]>,
    heights_mm: &[f64],
) -> Result<f64, Failure> {
    let Some([bottom_mm, top_mm]) = range_mm else { return Ok(0.0) };
    let lowest_mm = heights_mm.iter().copied().fold(f64::INFINITY, f64::min);
    let highest_mm = heights_mm.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if lowest_mm >= bottom_mm && highest_mm <= top_mm {
        return Ok(0.0);
    }
    let (span_mm, range_mm) = (highest_mm - lowest_mm, top_mm - bottom_mm);
    if span_mm > range_mm {
        return Err(format!(
            "the part is {span_mm:.3} mm high, and the probe has a range of {range_mm:.3} mm"
        )
        .into());
    }
    if !config.part.free.contains(&Parameter::Tz) {
        return Err(format!("the part reaches from {lowest_mm:.3} to {highest_mm:.3} mm, the probe from {bottom_mm:.3} to {top_mm:.3} mm: set its offset_mm").into());
    }
    Ok(0.5 * (bottom_mm + top_mm) - 0.5 * (lowest_mm + highest_mm))
}

/// Triggers a second. Devices that are joined by time need a slow machine: what they disagree in time counts as a way.
fn rate_hz(config: &Config, args: &PartArgs) -> f64 {
    let slow = || {
        config.sync.time.as_ref()?;
        Some((SPEED_MM_S / path::spacing_mm(&config.part, args.points)?).min(RATE_HZ))
    };
    args.rate.or_else(slow).unwrap_or(RATE_HZ)
}

/// Values that were shown so far.
struct Shown<'a> {
    config: &'a Config,
    played: Vec<Played>,
}

impl Shown<'_> {
    fn new(config: &Config, instruments: Vec<Instrument>) -> Shown<'_> {
        let played = |(instrument, device): (Instrument, &crate::config::DeviceConfig)| Played {
            listen: listen(config, device.link),
            ..Played::still(instrument)
        };
        let played = instruments.into_iter().zip(&config.devices).map(played).collect();
        Shown { config, played }
    }

    /// Lets the channel of an axis show its place, in mm or rad, at one more trigger. The place that is read.
    fn show(&mut self, axis: &Axis, place: f64) -> f64 {
        let Some(source) = axis.source else { return axis.offset };
        let played = &mut self.played[self.config.sync.devices[source.stream]];
        let value = played.instrument.shown(source.channel, (place - axis.offset) / axis.scale);
        played.courses[source.channel].get_or_insert_default().push(value);
        value * axis.scale + axis.offset
    }

    /// Lets the device of a stream see the part.
    fn see(&mut self, stream: usize, sight: Sight) {
        self.played[self.config.sync.devices[stream]].sight = Some(sight);
    }

    /// Lets the device of a stream touch the part.
    fn touch(&mut self, stream: usize, touch: Touch) {
        self.played[self.config.sync.devices[stream]].touch = Some(touch);
    }

    /// Lowest and highest place that an axis can show, mm.
    fn range_mm(&self, axis: &Axis) -> Option<[f64; 2]> {
        let source = axis.source?;
        let range = self.of(source.stream).instrument.range(source.channel)?;
        let is_finite = range.0.is_finite() && range.1.is_finite();
        is_finite.then(|| sorted([range.0, range.1].map(|end| end * axis.scale + axis.offset)))
    }

    /// The device of a stream of the synchronizer.
    fn of(&self, stream: usize) -> &Played {
        &self.played[self.config.sync.devices[stream]]
    }

    fn played(self) -> Vec<Played> {
        self.played
    }
}

/// Where a station listens, on a UDP link.
fn listen(config: &Config, link: usize) -> Option<SocketAddr> {
    match &config.links[link].endpoint {
        Endpoint::Udp { listen, .. } => listen.parse().ok(),
        _ => None,
    }
}

fn sorted([a, b]: [f64; 2]) -> [f64; 2] {
    [a.min(b), a.max(b)]
}

const NOTHING_TO_MEASURE: &str =
    "[nominal.aperture]: expected a region to measure, found none: add shape and size";
const MM_PER_NM: f64 = 1e-6;
/// Of devices that share a trigger.
const RATE_HZ: f64 = 1000.0;
/// Of devices that are joined by time.
const SPEED_MM_S: f64 = 10.0;

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::is_station;
    use super::*;

    /// Every station among the examples has a simulated bench: none of their devices and kinematics is refused.
    #[test]
    fn every_station_of_the_examples_is_played() {
        let args = PartArgs {
            points: 500,
            rate: None,
            form_nm: 100.0,
            noise_nm: 2.0,
            seed: 1,
            speed: None,
        };
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/examples");
        let mut played = 0;
        for entry in std::fs::read_dir(&folder).unwrap() {
            let file = entry.unwrap().path();
            if !is_station(&std::fs::read_to_string(&file).unwrap()) {
                continue;
            }
            let config = Config::load(&file).unwrap();
            let scan = scan(&config, &args);
            let scan = scan.unwrap_or_else(|error| panic!("{}: {error}", file.display()));
            let is_moved = config.scan.is_some() || config.program.is_some();
            assert_eq!(is_moved, !matches!(scan.order, Order::Simulation), "{}", file.display());
            played += 1;
        }
        assert!(played >= 18, "{played}");
    }
}
