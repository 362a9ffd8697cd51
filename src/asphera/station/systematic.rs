//! Errors of a station that all its points have together, as far as their uncertainties are known.
//!
//! Displacements are those where a point lies. That it lies elsewhere before its correction changes them by the product of two
//! small numbers.

use std::sync::Arc;

use asphera_calibrate::{Axes, Correction, Machine, Parameter};
use asphera_geometry::vector::plus;
use asphera_measure::Systematic;
use asphera_report::ThermalFigures;

use super::kinematics::{Axis, Kinematics};
use crate::calibration::{CalibrationFile, Uncertainties};

/// Sides of the centre on which the radial axis of a polar machine stood.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sides {
    pub(super) before: bool,
    pub(super) beyond: bool,
}

/// The systematic errors of a station: of its calibration, of the tables of its axes, of temperatures.
pub(super) fn systematic(
    kinematics: &Kinematics,
    sides: Sides,
    calibration: Option<&CalibrationFile>,
    thermal: Option<&ThermalFigures>,
) -> Vec<Systematic> {
    let places = Places::of(kinematics, sides);
    let mut all = Vec::new();
    if let Some(calibration) = calibration {
        of_calibration(calibration, places, &mut all);
    }
    all.extend(of_axes(kinematics, places));
    all.extend(thermal.filter(|found| found.u_um_per_m > 0.0).map(|found| {
        let u = found.u_um_per_m / UM_PER_M;
        Systematic::new("thermal expansion", move |at_mm| at_mm.map(|mm| u * mm))
    }));
    all
}

/// Where the axes stood at a point.
#[derive(Clone, Copy, Debug)]
enum Places {
    /// As the point says.
    Known {
        machine: Machine,
        /// Whether the radial axis stood beyond the centre.
        beyond: bool,
    },
    /// In more than one place, or in one that a point does not say.
    Unknown(&'static str),
}

impl Places {
    fn of(kinematics: &Kinematics, sides: Sides) -> Places {
        let machine = kinematics.machine();
        let beyond = sides.beyond;
        match kinematics {
            _ if machine == Machine::Cartesian => Places::Known { machine, beyond: false },
            Kinematics::Polar { .. } if sides.before && sides.beyond => Places::Unknown(BOTH_SIDES),
            Kinematics::Polar { .. } => Places::Known { machine, beyond },
            _ => Places::Unknown(TURNED),
        }
    }
}

fn axes_at(machine: Machine, beyond: bool, at_mm: [f64; 3]) -> Axes {
    match beyond {
        true => Axes::of_point_beyond(machine, at_mm),
        false => Axes::of_point(machine, at_mm),
    }
}

/// Parameters of a calibration, each a source, and its map.
fn of_calibration(calibration: &CalibrationFile, places: Places, all: &mut Vec<Systematic>) {
    for (source, errors) in sources(calibration.uncertainties()) {
        all.push(match places {
            Places::Known { machine, beyond } => {
                let field = |moves: Moves| {
                    move |at_mm| {
                        let axes = axes_at(machine, beyond, at_mm);
                        let moved = |sum, &(parameter, u): &(Parameter, f64)| {
                            plus(sum, u, parameter.displacement_mm(axes))
                        };
                        moves.iter().fold([0.0; 3], moved)
                    }
                };
                Systematic::several(source, errors.into_iter().map(field).collect())
            }
            Places::Unknown(why) => Systematic::not_counted(source, why),
        });
    }
    let absent = absent(calibration.correction());
    if !absent.is_empty() {
        let source = format!("calibration: {}", absent.join(", "));
        all.push(Systematic::not_counted(source, "the calibration file does not hold it"));
    }
    let terms = calibration.height_uncertainties();
    if !terms.is_empty() {
        let field = |term: &asphera_calibrate::HeightMap| {
            let term = term.clone();
            move |[x, y, _]: [f64; 3]| [0.0, 0.0, term.height_mm([x, y]).unwrap_or(0.0)]
        };
        let fields = terms.iter().map(field).collect();
        all.push(Systematic::several("calibration: map of heights", fields));
    }
}

/// What one error adds to parameters, for one standard deviation of it.
type Moves = Vec<(Parameter, f64)>;

/// Sources of a calibration with their independent errors: one where correlations are known, else one a parameter.
fn sources(u: &Uncertainties) -> Vec<(String, Vec<Moves>)> {
    let named = |names: &[&str]| format!("calibration: {}", names.join(", "));
    let parameters = || u.parameters.iter().map(|(parameter, _)| *parameter);
    if u.errors.is_empty() {
        let one = |&(parameter, u): &(Parameter, f64)| {
            (named(&[parameter.word()]), vec![vec![(parameter, u)]])
        };
        return u.parameters.iter().map(one).collect();
    }
    let names: Vec<&str> = parameters().map(Parameter::word).collect();
    let error = |error: &Vec<f64>| parameters().zip(error.iter().copied()).collect();
    vec![(named(&names), u.errors.iter().map(error).collect())]
}

/// Names of the parameters that a calibration does not hold.
fn absent(correction: &Correction) -> Vec<&'static str> {
    let held = |wanted| correction.values().iter().any(|(parameter, _)| *parameter == wanted);
    let all = correction.machine().parameters().iter().copied();
    all.filter(|parameter| !held(*parameter)).map(Parameter::word).collect()
}

/// Tables of errors along axes, each a source.
fn of_axes(kinematics: &Kinematics, places: Places) -> Vec<Systematic> {
    let named = match kinematics {
        Kinematics::Cartesian { x, y, z } => {
            vec![(x, Way::Along(0)), (y, Way::Along(1)), (z, Way::Along(2))]
        }
        Kinematics::Polar { rotary, radial, probe } => {
            vec![(rotary, Way::Turn), (radial, Way::Outwards), (probe, Way::Along(2))]
        }
        Kinematics::Line(_) | Kinematics::Tilting(_) => {
            let axes = kinematics.axes().into_iter();
            let tables = axes.filter_map(|axis| axis.errors);
            let source = |file: &str| Systematic::not_counted(source_of(file), NO_AXIS);
            return tables.map(|table| source(&table.file)).collect();
        }
    };
    named.into_iter().filter_map(|(axis, way)| of_axis(axis, way, places)).collect()
}

/// How an axis moves a point.
#[derive(Clone, Copy)]
enum Way {
    /// Along x, y or z.
    Along(usize),
    /// Along the radial axis.
    Outwards,
    /// About the axis of rotation.
    Turn,
}

fn of_axis(axis: &Axis, way: Way, places: Places) -> Option<Systematic> {
    let table = axis.errors.as_ref()?;
    let source = source_of(&table.file);
    let count = table.errors.uncertain_errors();
    let (machine, beyond) = match places {
        _ if count == 0 => return Some(Systematic::not_counted(source, "it has no column u")),
        Places::Unknown(why) => return Some(Systematic::not_counted(source, why)),
        Places::Known { machine, beyond } => (machine, beyond),
    };
    let field = |error: usize| {
        let table = Arc::clone(table);
        move |at_mm: [f64; 3]| {
            let u = |position: f64| table.errors.uncertain_error_at(error, position);
            match (axes_at(machine, beyond, at_mm), way) {
                (_, Way::Along(along)) => {
                    let mut by_mm = [0.0; 3];
                    by_mm[along] = u(at_mm[along]);
                    by_mm
                }
                (Axes::Polar { angle_rad, radius_mm, .. }, Way::Outwards) => {
                    let (sin, cos) = angle_rad.sin_cos();
                    [cos, sin, 0.0].map(|share| share * u(radius_mm))
                }
                (Axes::Polar { angle_rad, .. }, Way::Turn) => {
                    let [x, y, _] = at_mm;
                    [-y, x, 0.0].map(|mm| mm * u(angle_rad))
                }
                _ => [0.0; 3],
            }
        }
    };
    Some(Systematic::several(source, (0..count).map(field).collect()))
}

fn source_of(file: &str) -> String {
    format!("error table {file}")
}

const UM_PER_M: f64 = 1e6;
const BOTH_SIDES: &str =
    "the radial axis stood on both sides of the centre, and points do not say on which";
const TURNED: &str = "points of a line scanner or a tilting probe over a part that turns do not say where the axes stood";
const NO_AXIS: &str = "points of a line scanner or a tilting probe do not say where its axes stood";

#[cfg(test)]
mod tests;
