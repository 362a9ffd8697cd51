//! Axes with a drive: Zaber stages that obey, and CANopen drives that obey or are pushed.

use std::sync::Arc;

use asphera_cia402::{self as cia402, Reference, Step};
use asphera_sim_cia402::{Drive, DriveSettings, SharedDrives};
use asphera_sim_zaber::{AxisSettings, SharedStage, Stage};
use asphera_zaber::{self as zaber, Microstep};

use crate::moving::Moving;
use crate::played::{Kind, Played};

/// Why a drive by these settings is not simulated; `None` where it is.
pub(crate) fn refusal(settings: &cia402::Settings) -> Option<String> {
    let is_known = |method| [METHOD_SWITCH, 35, 37].contains(&method);
    match settings.homing.as_ref().map(|homing| homing.method) {
        Some(method) if !is_known(method) => {
            return Some(format!("it homes by method {method}: 17, 35 and 37 are simulated"));
        }
        _ => {}
    }
    let scales = [settings.velocity_scale, settings.acceleration_scale];
    (scales != [1.0; 2]).then(|| {
        "its speeds have units of their own: velocity_scale = 1 and acceleration_scale = 1 are simulated".to_owned()
    })
}

/// Length of a position count in the unit of the channel.
fn step(settings: &cia402::Settings) -> f64 {
    match settings.step {
        Step::Nanometres(nm) => nm * 1e-6,
        Step::CountsPerTurn(counts) => std::f64::consts::TAU / counts,
    }
}

/// The value that is read where this one is sent.
pub(crate) fn shown(settings: &cia402::Settings, value: f64) -> f64 {
    (value / step(settings)).round() * step(settings)
}

/// The axes of a stand.
#[derive(Clone)]
pub(crate) struct Axes {
    stages: Vec<StageAxes>,
    drives: Vec<Arc<DriveAxes>>,
}

/// A stage that obeys, as a number among the devices.
#[derive(Clone)]
struct StageAxes {
    device: usize,
    stage: SharedStage,
    /// Number of the axis of its first channel, from 0.
    first: usize,
}

/// The drives of one bus.
pub(crate) struct DriveAxes {
    link: usize,
    drives: SharedDrives,
    counting: Vec<Counting>,
}

/// How a drive counts, with its number among the devices.
#[derive(Clone, Copy)]
struct Counting {
    device: usize,
    /// Position at the start of its travel.
    at_switch: i32,
    /// Length of a count in the unit of the channel.
    step: f64,
}

impl Axes {
    /// The axes of these devices, which obey where the station moves them. Fails with what a device cannot do, in words.
    pub(crate) fn new(played: &[Played], moving: Option<&Moving>) -> Result<Axes, String> {
        let mut axes = Axes { stages: Vec::new(), drives: Vec::new() };
        let mut buses: Vec<(usize, Vec<Drive>, Vec<Counting>)> = Vec::new();
        for (device, one) in played.iter().enumerate() {
            let (name, link) = (&one.instrument.name, one.instrument.link);
            match (&one.instrument.kind, moving) {
                (Kind::Stage(settings, _), Some(moving)) => {
                    let (stage, first) = stage(settings, device, moving)
                        .ok_or_else(|| short_stage(name, settings))?;
                    axes.stages.push(StageAxes { device, stage, first });
                }
                (Kind::Drive(settings), _) => {
                    let travel = moving.and_then(|moving| moving.travel(device, 0));
                    let (drive, at_switch) = drive(settings, travel).ok_or_else(|| format!("device {name}: its axis does not run as far as [scan.plan] lets it: a drive that is homed by a switch counts from its home offset on. Set the travel, or offset_mm of [kinematics]"))?;
                    let counting = Counting { device, at_switch, step: step(settings) };
                    match buses.iter_mut().find(|(known, ..)| *known == link) {
                        Some((_, drives, all)) => {
                            drives.push(drive);
                            all.push(counting);
                        }
                        None => buses.push((link, vec![drive], vec![counting])),
                    }
                }
                _ => {}
            }
        }
        axes.drives = buses
            .into_iter()
            .map(|(link, drives, counting)| {
                Arc::new(DriveAxes { link, drives: SharedDrives::new(drives), counting })
            })
            .collect();
        Ok(axes)
    }

    /// Values of the channels of each device that obeys, in their units, with its number.
    pub(crate) fn values(&self) -> Vec<(usize, Vec<f64>)> {
        let of_stage = |axes: &StageAxes| {
            (axes.device, axes.stage.places_mm().into_iter().skip(axes.first).collect())
        };
        let of_drives = |axes: &Arc<DriveAxes>| {
            let places = axes.drives.places();
            let value = |(counting, place): (&Counting, f64)| {
                (counting.device, vec![(place + f64::from(counting.at_switch)) * counting.step])
            };
            axes.counting.iter().zip(places).map(value).collect::<Vec<_>>()
        };
        let stages = self.stages.iter().map(of_stage);
        stages.chain(self.drives.iter().flat_map(of_drives)).collect()
    }

    /// The stage of a device, where it obeys.
    pub(crate) fn stage(&self, device: usize) -> Option<&SharedStage> {
        self.stages.iter().find(|axes| axes.device == device).map(|axes| &axes.stage)
    }

    /// The drives of a bus, where it has some.
    pub(crate) fn drives(&self, link: usize) -> Option<&Arc<DriveAxes>> {
        self.drives.iter().find(|axes| axes.link == link)
    }
}

impl DriveAxes {
    /// The drives themselves.
    pub(crate) fn drives(&self) -> &SharedDrives {
        &self.drives
    }

    /// Pushes each drive to the value that its channel is to show.
    pub(crate) fn push(&self, value: impl Fn(usize) -> f64) {
        for (index, counting) in self.counting.iter().enumerate() {
            let counts = (value(counting.device) / counting.step).round();
            self.drives.push(index, counts - f64::from(counting.at_switch));
        }
    }
}

/// Why a stage by these settings does not obey, in words.
fn short_stage(name: &str, settings: &zaber::Settings) -> String {
    match settings.checksum {
        true => format!(
            "device {name}: a simulated stage that moves has no checksums: set checksum = false"
        ),
        false => format!(
            "device {name}: its axes do not run as far as [scan.plan] lets them: a Zaber stage counts from 0 on. Set the travel, or offset_mm of [kinematics]"
        ),
    }
}

/// A stage with the travel of its axes, and the number of the first axis. `None` where an axis would have to run below 0, or where it is to
/// have checksums.
fn stage(
    settings: &zaber::Settings,
    device: usize,
    moving: &Moving,
) -> Option<(SharedStage, usize)> {
    if settings.checksum {
        return None;
    }
    let first = usize::from(settings.axis).saturating_sub(1);
    let axis = |(channel, axis): (usize, &zaber::Axis)| {
        let step = match axis.microstep {
            Microstep::Micrometres(um) => um * 1e-3,
            Microstep::Degrees(deg) => deg.to_radians(),
        };
        let [low, high] = moving.travel(device, channel).unwrap_or([0.0, 0.0]);
        // What turns without end begins anywhere.
        let low = if matches!(axis.microstep, Microstep::Degrees(_)) { low.max(0.0) } else { low };
        let fits = low >= 0.0 && high / step < f64::from(i32::MAX);
        // A stage counts in µm and mm; of one that turns these stand for rad.
        let (microstep_um, travel_mm) = (step * 1e3, high);
        fits.then_some(AxisSettings { microstep_um, travel_mm, at_mm: low })
    };
    let axes: Vec<AxisSettings> =
        settings.axes.iter().enumerate().map(axis).collect::<Option<_>>()?;
    // Axes of the controller that the station does not read.
    let others = axes.first().map(|axis| AxisSettings { travel_mm: 0.0, at_mm: 0.0, ..*axis })?;
    let all: Vec<AxisSettings> = std::iter::repeat_n(others, first).chain(axes).collect();
    Some((SharedStage::new(Stage::new(settings.address, &all)), first))
}

/// A drive that knows its place, with its position at the start of its travel. `None` where its travel has too many counts.
fn drive(settings: &cia402::Settings, travel: Option<[f64; 2]>) -> Option<(Drive, i32)> {
    let counts = |value: f64| {
        let counts = value / step(settings);
        (counts.abs() < f64::from(i32::MAX / 2)).then_some(counts)
    };
    let (low, high) = match travel {
        Some([low, high]) => (counts(low)?.floor() as i32, counts(high)?.ceil() as i32),
        None => (0, 0),
    };
    let home = match &settings.homing {
        Some(homing) => counts(homing.offset)?.round() as i32,
        None => low,
    };
    let by_switch = settings.homing.as_ref().is_some_and(|homing| homing.method == METHOD_SWITCH);
    // A switch lies at the start of the travel; without one home is where the drive stands.
    let at_switch = if by_switch { home } else { low };
    if low < at_switch {
        return None;
    }
    let length = high - at_switch;
    let at = match settings.homing {
        Some(_) if !by_switch => (home - low).clamp(0, length),
        _ => length / 3,
    };
    let node_id = settings.node_id;
    let drive = DriveSettings { node_id, travel: length, at, acceleration: ACCELERATION };
    let drive = Drive::new(drive).ok()?;
    let drive = settings.vendor_id.map_or(drive.clone(), |vendor| drive.with_vendor(vendor));
    let is_known = settings.reference == Reference::Absolute || travel.is_none() || !by_switch;
    Some((if is_known { drive.absolute(at_switch) } else { drive }, at_switch))
}

/// Homing to the negative limit switch.
const METHOD_SWITCH: i8 = 17;
/// Of a drive, unless it is set anew, counts/s².
const ACCELERATION: u32 = 1_000_000;
