//! The machine of a plan, as the command line gives it.

use asphera_plan::{Axis, Limits, Machine, PlanError};
use clap::{Args, ValueEnum};
use serde::Serialize;

/// The machine, its axes and the scan.
#[derive(Args, Clone, Debug)]
pub(super) struct MachineArgs {
    /// Two stages x and y, or a turning table c about 0,0 with a stage r.
    #[arg(long, value_enum, default_value_t = Kind::Cartesian)]
    machine: Kind,
    /// Travel, speed and acceleration of an axis x, y or r in mm, or c in degrees, each per s and s²; -inf and inf where an axis has no end.
    /// Without it 20 mm/s, 200 mm/s², 360 °/s, 3600 °/s² and no ends. May be given for each axis.
    #[arg(
        long = "axis",
        value_name = "AXIS=LOW,HIGH,SPEED,ACCELERATION",
        value_parser = axis,
        allow_hyphen_values = true
    )]
    axes: Vec<NamedAxis>,
    /// Speed along a path in mm/s, as far as the axes allow it.
    #[arg(long, value_name = "MM/S", default_value_t = 5.0, value_parser = speed)]
    scan_speed: f64,
    /// Time at each place where the machine stops for a point, in s.
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = distance)]
    dwell: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Kind {
    /// Stages x and y.
    Cartesian,
    /// A table and a stage.
    Polar,
}

/// An axis by its name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NamedAxis {
    name: char,
    numbers: [f64; 4],
}

/// The limits of an axis as they were used.
#[derive(Serialize)]
pub(super) struct AxisFigures {
    axis: &'static str,
    unit: &'static str,
    /// Absent where there is no end.
    low: Option<f64>,
    high: Option<f64>,
    speed_per_s: f64,
    acceleration_per_s2: f64,
}

impl MachineArgs {
    pub(super) fn is_polar(&self) -> bool {
        self.machine == Kind::Polar
    }

    pub(super) fn scan_speed_mm_s(&self) -> f64 {
        self.scan_speed
    }

    /// The limits of a plan.
    pub(super) fn limits(&self) -> Result<Limits, PlanError> {
        if let Some(other) = self.axes.iter().find(|axis| !self.names().contains(&axis.name)) {
            return Err(PlanError {
                key: "axis",
                expected: format!("{} or {}", self.names()[0], self.names()[1]),
                found: other.name.to_string(),
                cure: "name an axis of this --machine".to_owned(),
            });
        }
        let [first, second] = self.names().map(|name| self.axis(name));
        let machine = match self.machine {
            Kind::Cartesian => Machine::Cartesian { x: first, y: second },
            Kind::Polar => Machine::Polar { r: first, c: second },
        };
        machine.validate()?;
        Ok(Limits { machine, scan_speed_mm_s: self.scan_speed, dwell_s: self.dwell })
    }

    /// The axes as they were used, in mm and degrees.
    pub(super) fn figures(&self) -> Vec<AxisFigures> {
        let figures = |name: char| {
            let [low, high, speed_per_s, acceleration_per_s2] = self.numbers(name);
            let end = |at: f64| at.is_finite().then_some(at);
            let axis = match name {
                'x' => "x",
                'y' => "y",
                'r' => "r",
                _ => "c",
            };
            let unit = if name == 'c' { "deg" } else { "mm" };
            let (low, high) = (end(low), end(high));
            AxisFigures { axis, unit, low, high, speed_per_s, acceleration_per_s2 }
        };
        self.names().map(figures).into_iter().collect()
    }

    fn names(&self) -> [char; 2] {
        match self.machine {
            Kind::Cartesian => ['x', 'y'],
            Kind::Polar => ['r', 'c'],
        }
    }

    fn numbers(&self, name: char) -> [f64; 4] {
        let given = self.axes.iter().rev().find(|axis| axis.name == name);
        let ends = [f64::NEG_INFINITY, f64::INFINITY];
        given.map_or(
            match name {
                'c' => [ends[0], ends[1], 360.0, 3600.0],
                _ => [ends[0], ends[1], 20.0, 200.0],
            },
            |axis| axis.numbers,
        )
    }

    fn axis(&self, name: char) -> Axis {
        let numbers = self.numbers(name);
        let [low, high, speed, acceleration] =
            if name == 'c' { numbers.map(f64::to_radians) } else { numbers };
        Axis { low, high, speed, acceleration }
    }
}

impl AxisFigures {
    /// The axis in a line.
    pub(super) fn line(&self) -> String {
        let AxisFigures { axis, unit, speed_per_s, acceleration_per_s2, .. } = self;
        let travel = match (self.low, self.high) {
            (Some(low), Some(high)) => format!("{low} to {high} {unit}"),
            (Some(low), None) => format!("from {low} {unit}"),
            (None, Some(high)) => format!("to {high} {unit}"),
            (None, None) => "without ends".to_owned(),
        };
        format!("{axis} {travel}, {speed_per_s} {unit}/s, {acceleration_per_s2} {unit}/s²")
    }
}

fn axis(word: &str) -> Result<NamedAxis, String> {
    let expected =
        || format!("expected AXIS=LOW,HIGH,SPEED,ACCELERATION as x=-50,50,20,200, found `{word}`");
    let (name, numbers) = word.split_once('=').ok_or_else(expected)?;
    let name = match name {
        "x" => 'x',
        "y" => 'y',
        "r" => 'r',
        "c" => 'c',
        _ => return Err(format!("expected an axis x, y, r or c, found `{name}`")),
    };
    let parsed: Result<Vec<f64>, _> =
        numbers.split(',').map(|number| number.trim().parse()).collect();
    let numbers: [f64; 4] = parsed.map_err(|_| expected())?.try_into().map_err(|_| expected())?;
    if numbers.iter().any(|number| number.is_nan()) {
        return Err(expected());
    }
    Ok(NamedAxis { name, numbers })
}

/// A place x,y in mm.
pub(super) fn place(word: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> =
        word.split(',').filter_map(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y] if word.split(',').count() == 2 && x.is_finite() && y.is_finite() => Ok([x, y]),
        _ => Err(format!("expected X,Y in mm, found `{word}`")),
    }
}

/// A length above 0 in mm.
pub(super) fn length(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(mm) if (1e-6..=1e6).contains(&mm) => Ok(mm),
        _ => Err(format!("expected a length from 1e-6 to 1e6 in mm, found `{word}`")),
    }
}

/// A number from 0.
pub(super) fn distance(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(number) if (0.0..=1e6).contains(&number) => Ok(number),
        _ => Err(format!("expected a number from 0 to 1e6, found `{word}`")),
    }
}

/// A share above 0 and up to 1.
pub(super) fn share(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(share) if share > 0.0 && share <= 1.0 => Ok(share),
        _ => Err(format!("expected a number above 0 and up to 1, found `{word}`")),
    }
}

fn speed(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(speed) if speed > 0.0 && speed.is_finite() => Ok(speed),
        _ => Err(format!("expected a speed above 0 in mm/s, found `{word}`")),
    }
}
