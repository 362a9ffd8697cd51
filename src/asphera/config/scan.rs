//! The table `scan.plan`: the scan that the station drives.

use std::f64::consts::PI;
use std::time::Duration;

use asphera_measure::{Part, design_spacing};
use asphera_plan::{
    Aperture, Axis as Limit, Goal, Limits, Machine, Path, Piece, PlanError, Spacing, Way,
    axis_runs, lay,
};
use asphera_settings::Section;

use super::devices::DeviceConfig;
use super::motion::SyncConfig;
use crate::station::{AdaptivePlan, Axis, Kinematics, ScanAxis, ScanPlan, plan_aperture};

/// All that a plan is checked against.
pub(super) struct Station<'a> {
    pub(super) sync: &'a SyncConfig,
    pub(super) kinematics: &'a Kinematics,
    pub(super) devices: &'a [DeviceConfig],
    pub(super) part: &'a Part,
}

/// Reads the table; `None` where it is absent, or cannot be used, which it says. Without a station it is only known.
pub(super) fn read(scan: &Section<'_>, station: Option<&Station<'_>>) -> Option<ScanPlan> {
    let table = scan.section("plan");
    if !table.is_present() {
        return None;
    }
    if scan.has("points") {
        let expected = "no such key beside [scan.plan]: the plan says when the scan is over";
        scan.problem("points", expected, "`points`");
    }
    let keys = Keys::read(&table);
    let Some(station) = station else {
        // What is wrong elsewhere is said there.
        for axis in ["x", "y", "r", "c"] {
            table.has(axis);
        }
        return None;
    };
    let axes = axes(&table, station);
    table.finish();
    let (axes, machine) = axes?;
    if keys.home_within.is_some() {
        check_homing(&table, station, &axes);
    }
    plan(&table, keys, station, axes, machine)
}

/// Whether the devices of all axes find home on order.
fn check_homing(table: &Section<'_>, station: &Station<'_>, axes: &[ScanAxis; 2]) {
    let device = |axis: &ScanAxis| &station.devices[station.sync.devices[axis.stream]];
    if let Some(other) = axes.iter().map(device).find(|device| !device.settings.homes()) {
        let expected = "false, or axes of devices that home: zaber, or cia402 with homing = { … }";
        table.problem("home", expected, format!("true, with {}", other.name));
    }
}

/// The device whose program the station runs, as its place among those of `sync`; `None`: none has one.
pub(super) fn program(scan: &Section<'_>, station: &Station<'_>) -> Option<usize> {
    let runs_program = |device: &usize| station.devices[*device].settings.runs_program();
    let mut with_program =
        (0..).zip(&station.sync.devices).filter(|(_, device)| runs_program(device));
    let (stream, device) = with_program.next()?;
    let name = &station.devices[*device].name;
    if with_program.next().is_some() {
        let expected = "no second device with a program in [sync] devices";
        scan.problem("plan", expected, format!("another beside {name}"));
    }
    for key in ["plan", "points"] {
        if scan.has(key) {
            let expected = format!("no such key: the program of {name} says what is measured");
            scan.problem(key, expected, format!("`{key}`"));
        }
    }
    Some(stream)
}

/// Path of a pitch in mm, one way or not, and a way about the centre.
type PathOf = fn(f64, bool, Way) -> Path;

/// Keys that are numbers and words.
struct Keys {
    path: Option<PathOf>,
    one_way: bool,
    way: Way,
    spacing_mm: Option<f64>,
    epsilon: Option<f64>,
    margin_mm: f64,
    centre_mm: [f64; 2],
    scan_speed_mm_s: f64,
    dwell: Duration,
    point_spacing_mm: Option<f64>,
    home_within: Option<Duration>,
    watchdog: Duration,
    time_limit: Option<Duration>,
    points_max: Option<u64>,
    adaptive: bool,
    coverage: f64,
    u_max_nm: Option<f64>,
    finest_mm: Option<f64>,
    batch_places: usize,
}

impl Keys {
    fn read(table: &Section<'_>) -> Keys {
        let paths: [(&str, PathOf); 4] = [
            ("raster", |pitch_mm, one_way, _| Path::Raster { pitch_mm, one_way }),
            ("spiral", |pitch_mm, _, way| Path::Spiral { pitch_mm, way }),
            ("rings", |pitch_mm, _, way| Path::Rings { pitch_mm, way }),
            ("meridians", |pitch_mm, _, _| Path::Meridians { pitch_mm }),
        ];
        let optional = |key: &str, range: std::ops::RangeInclusive<f64>| {
            // One outside the range is said, and nothing is planned with it.
            let given = table.has(key).then(|| table.within(key, f64::NAN, range.clone()));
            given.filter(|number| !number.is_nan())
        };
        let seconds = |key: &str, default: f64, range| {
            Duration::from_secs_f64(table.within(key, default, range))
        };
        let adaptive = table.or("adaptive", false);
        for key in ["coverage", "u_max_nm", "finest_mm", "batch_places"] {
            if !adaptive && table.has(key) {
                table.problem(key, "no such key, or adaptive = true", format!("`{key}`"));
            }
        }
        let homes = table.or("home", false);
        let home_within = seconds("home_within_s", 60.0, 1.0..=3600.0);
        Keys {
            path: table.required_word("path", &paths),
            one_way: table.or("one_way", false),
            way: if table.or("inward", false) { Way::In } else { Way::Out },
            spacing_mm: optional("spacing_mm", 1e-6..=1e6),
            epsilon: optional("from_epsilon", 1e-6..=1.0),
            margin_mm: table.within("margin_mm", 0.0, 0.0..=1e6),
            centre_mm: pair_mm(table, "centre_mm"),
            scan_speed_mm_s: table.within("scan_speed_mm_s", 5.0, 1e-6..=1e6),
            dwell: Duration::from_millis(table.within("dwell_ms", 50, 1..=60_000u64)),
            point_spacing_mm: optional("point_spacing_mm", 0.0..=1e6),
            home_within: homes.then_some(home_within),
            watchdog: Duration::from_millis(table.within("watchdog_ms", 500, 20..=60_000u64)),
            time_limit: table.has("time_limit_s").then(|| seconds("time_limit_s", 1.0, 0.1..=1e7)),
            points_max: table
                .has("points_max")
                .then(|| table.within("points_max", 1, 1..=10_000_000_000)),
            adaptive,
            coverage: table.within("coverage", 0.99, 0.01..=1.0),
            u_max_nm: optional("u_max_nm", 1e-6..=1e9),
            finest_mm: optional("finest_mm", 1e-6..=1e6),
            batch_places: table.within("batch_places", 2000, 1..=100_000usize),
        }
    }
}

/// Two numbers in mm; 0 without the key, or where it has something else, which is a problem.
pub(super) fn pair_mm(table: &Section<'_>, key: &str) -> [f64; 2] {
    let numbers: Vec<f64> = table.or(key, vec![0.0, 0.0]);
    match numbers[..] {
        [x, y] if x.is_finite() && y.is_finite() => [x, y],
        _ => {
            table.problem(key, "two numbers in mm", format!("{numbers:?}"));
            [0.0; 2]
        }
    }
}

/// The axes that are driven, x and y or r and c, with the limits of the machine.
fn axes(table: &Section<'_>, station: &Station<'_>) -> Option<([ScanAxis; 2], Machine)> {
    match station.kinematics {
        Kinematics::Cartesian { x, y, .. } => {
            let [x, y] =
                [("x", x), ("y", y)].map(|(name, axis)| driven(table, station, name, axis, false));
            let ((x, x_limit), (y, y_limit)) = x.zip(y)?;
            Some(([x, y], Machine::Cartesian { x: x_limit, y: y_limit }))
        }
        Kinematics::Polar { rotary, radial, .. } => {
            let r = driven(table, station, "r", radial, false);
            let c = driven(table, station, "c", rotary, true);
            let ((r, r_limit), (c, c_limit)) = r.zip(c)?;
            Some(([r, c], Machine::Polar { r: r_limit, c: c_limit }))
        }
        Kinematics::Line(_) | Kinematics::Tilting(_) => {
            let expected = "no such table, or [kinematics] kind = \"cartesian\" or \"polar\"";
            let is_line = matches!(station.kinematics, Kinematics::Line(_));
            let found = if is_line { "kind = \"line\"" } else { "kind = \"tilting\"" };
            table.problem("path", expected, found);
            None
        }
    }
}

/// An axis and its limits; the keys of a rotary one are in degrees.
fn driven(
    table: &Section<'_>,
    station: &Station<'_>,
    name: &str,
    axis: &Axis,
    is_rotary: bool,
) -> Option<(ScanAxis, Limit)> {
    let limits = table.section(name);
    let (travel, speed, acceleration) = match is_rotary {
        false => ("travel_mm", "speed_mm_s", "acceleration_mm_s2"),
        true => ("travel_deg", "speed_deg_s", "acceleration_deg_s2"),
    };
    let unit = if is_rotary { PI / 180.0 } else { 1.0 };
    let ends = limits.range(travel);
    let (usual_speed, usual_acceleration) = if is_rotary { (360.0, 3600.0) } else { (20.0, 200.0) };
    let limit = Limit {
        low: ends.map_or(f64::NEG_INFINITY, |(low, _)| low * unit),
        high: ends.map_or(f64::INFINITY, |(_, high)| high * unit),
        speed: limits.within(speed, usual_speed, 1e-6..=1e6) * unit,
        acceleration: limits.within(acceleration, usual_acceleration, 1e-6..=1e9) * unit,
    };
    let tolerance = match is_rotary {
        false => limits.within("tolerance_mm", 0.05, 1e-6..=1e3),
        true => limits.within("tolerance_deg", 0.1, 1e-6..=90.0) * unit,
    };
    if ends.is_none() && !is_rotary {
        let expected = "two numbers [low, high]: the axis is moved nowhere else";
        limits.problem(travel, expected, "nothing");
        return None;
    }
    limits.finish();
    let Some(source) = axis.source else {
        let expected =
            format!("an axis that moves: [kinematics] gives {name} from a device with axes");
        table.problem(name, expected, "a constant");
        return None;
    };
    let device = &station.devices[station.sync.devices[source.stream]];
    if !device.settings.moves_axes() {
        let expected =
            format!("{name} in [kinematics] from a device whose driver moves axes, as zaber");
        table.problem(name, expected, format!("{}, which is only read", device.name));
        return None;
    }
    let scan_axis = ScanAxis {
        name: device.channels[source.channel].name.clone(),
        stream: source.stream,
        channel: source.channel,
        scale: axis.scale,
        offset: axis.offset,
        tolerance,
    };
    Some((scan_axis, limit))
}

fn plan(
    table: &Section<'_>,
    keys: Keys,
    station: &Station<'_>,
    axes: [ScanAxis; 2],
    machine: Machine,
) -> Option<ScanPlan> {
    let Some(aperture) = plan_aperture(&station.part.aperture) else {
        let expected =
            "a nominal with [aperture] circle, rectangle or annulus: the region of the path";
        table.problem("path", expected, "none");
        return None;
    };
    let spacing_mm = spacing(table, &keys, station.part)?;
    let path = keys.path?(spacing_mm, keys.one_way, keys.way);
    let limits = Limits {
        machine,
        scan_speed_mm_s: keys.scan_speed_mm_s,
        dwell_s: keys.dwell.as_secs_f64(),
    };
    let adaptive = keys.adaptive.then(|| AdaptivePlan {
        goal: Goal {
            coverage: keys.coverage,
            u_max: keys.u_max_nm,
            budget_s: keys.time_limit.map(|limit| limit.as_secs_f64()),
            batch_places: keys.batch_places,
            finest_mm: keys.finest_mm.unwrap_or(spacing_mm / FINEST),
        },
        aperture,
        centre_mm: keys.centre_mm,
        spacing_mm,
    });
    if keys.adaptive && matches!(path, Path::Raster { .. }) && keys.margin_mm > 0.0 {
        let expected = "0 with adaptive = true: places on the border are measured anyway";
        table.problem("margin_mm", expected, keys.margin_mm);
    }
    let region = aperture.widened(keys.margin_mm);
    let pieces = bounded(&region, spacing_mm).and_then(|()| match &adaptive {
        Some(adaptive) if matches!(path, Path::Raster { .. }) => adaptive.first_pass(),
        _ => laid(&path, &region, keys.centre_mm, spacing_mm),
    });
    let pieces = pieces.and_then(|pieces| {
        axis_runs(&pieces, &limits, [0.0; 2])?;
        Ok(pieces)
    });
    let pieces = pieces.map_err(|error| said(table, &error)).ok()?;
    Some(ScanPlan {
        axes,
        limits,
        pieces,
        dwell: keys.dwell,
        point_spacing_mm: keys.point_spacing_mm.unwrap_or(spacing_mm / DENSER),
        home_within: keys.home_within,
        watchdog: keys.watchdog,
        time_limit: keys.time_limit,
        points_max: keys.points_max,
        adaptive,
    })
}

/// The spacing in mm that is given, or that the nominal needs, whichever is smaller.
fn spacing(table: &Section<'_>, keys: &Keys, part: &Part) -> Option<f64> {
    let needed = keys.epsilon.map(|epsilon| design_spacing(part, epsilon));
    match (keys.spacing_mm, needed) {
        (_, Some(Err(why))) => {
            table.problem(
                "from_epsilon",
                "a nominal whose local feature size is known, or spacing_mm",
                why,
            );
            None
        }
        (given, Some(Ok(needed))) if needed.spacing_mm.is_finite() => {
            Some(given.map_or(needed.spacing_mm, |mm| mm.min(needed.spacing_mm)))
        }
        (Some(given), _) => Some(given),
        (None, Some(Ok(_))) => {
            table.problem(
                "spacing_mm",
                "a number in mm: the nominal is plane, any spacing suits it",
                "nothing",
            );
            None
        }
        (None, None) => {
            table.problem("spacing_mm", "spacing_mm or from_epsilon", "nothing");
            None
        }
    }
}

/// Fails where a region has too many places, before any is laid.
fn bounded(region: &Aperture, spacing_mm: f64) -> Result<(), PlanError> {
    let places = (2.0 * region.reach_mm() / spacing_mm).powi(2);
    if places <= MOST_PLACES {
        return Ok(());
    }
    Err(PlanError {
        key: "spacing_mm",
        expected: format!("at most {MOST_PLACES} places"),
        found: format!("about {places:.0} with {spacing_mm} mm"),
        cure: "give a larger spacing".to_owned(),
    })
}

/// The pieces of a path.
fn laid(
    path: &Path,
    aperture: &Aperture,
    centre_mm: [f64; 2],
    spacing_mm: f64,
) -> Result<Vec<(Piece, Spacing)>, PlanError> {
    let pieces = lay(path, aperture, centre_mm)?;
    Ok(pieces.into_iter().map(|piece| (piece, Spacing::AtMost { mm: spacing_mm })).collect())
}

/// A mistake of the plan under the key it is of.
fn said(table: &Section<'_>, error: &PlanError) {
    let PlanError { key, expected, found, cure } = error;
    let of_axis = |axis: &str, end: &str| {
        let unit = if axis == "c" { "deg" } else { "mm" };
        format!("{axis}.{end}_{unit}")
    };
    let key = match key.split_once('.') {
        Some((axis, "travel")) => of_axis(axis, "travel"),
        _ if *key == "spacing" => "spacing_mm".to_owned(),
        _ => (*key).to_owned(),
    };
    table.problem(&key, format!("{expected}: {cure}"), found);
}

/// Without `point_spacing_mm` points are denser than lines by so much.
const DENSER: f64 = 10.0;
/// Without `finest_mm` the spacing of later passes falls to so small a part.
const FINEST: f64 = 16.0;
/// Most places of a plan.
const MOST_PLACES: f64 = 1e6;
