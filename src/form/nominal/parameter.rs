//! The parameters a fit can set free, with their names and units.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use crate::nominal::{HIGHEST_ORDER, LOWEST_ORDER, power_unit};
use crate::pose::within_half_turn;
use crate::shape::ShapeParameter;
use crate::{Nominal, Pose};

/// One parameter of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Parameter {
    /// Shift along x, `tx`, mm.
    Tx,
    /// Shift along y, `ty`, mm.
    Ty,
    /// Shift along z, `tz`, mm.
    Tz,
    /// Rotation about x, `rx`, rad.
    Rx,
    /// Rotation about y, `ry`, rad.
    Ry,
    /// Rotation about z, `rz`, rad.
    Rz,
    /// Radius of curvature at the vertex, `radius`, mm.
    Radius,
    /// Conic constant, `conic`, a number.
    Conic,
    /// Coefficient of `r^n` with n even from 4 to 20, `A4` to `A20`, mm^(1−n).
    A(u8),
    /// A parameter of a freeform, by its place in the list of
    /// [`Shape::parameters`](crate::shape::Shape::parameters). Its name and unit are the shape's:
    /// [`Parameter::name`] and [`Parameter::unit`].
    Shape(u16),
}

/// Why a text names no parameter.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum ParameterError {
    /// The text is none of the names.
    #[error(
        "unknown parameter {name:?}, expected tx, ty, tz, rx, ry, rz, radius, conic or A4, A6 to A20"
    )]
    Unknown {
        /// The text.
        name: String,
    },
    /// The nominal has no parameter of this name.
    #[error("a {kind} has no parameter {name:?}, expected one of {expected}")]
    NotOfNominal {
        /// The text.
        name: String,
        /// Kind of the nominal.
        kind: &'static str,
        /// The names it has, those of the pose included.
        expected: String,
    },
}

impl Parameter {
    /// Shifts and tilts: all a rotationally symmetric part's pose has.
    pub const RIGID: [Parameter; 5] =
        [Parameter::Tx, Parameter::Ty, Parameter::Tz, Parameter::Rx, Parameter::Ry];

    /// Shifts and turns: all a pose has.
    pub const POSE: [Parameter; 6] =
        [Parameter::Tx, Parameter::Ty, Parameter::Tz, Parameter::Rx, Parameter::Ry, Parameter::Rz];

    /// Its name: as [`Parameter`] is displayed, but for a parameter of a freeform as the shape calls it.
    pub fn name(self, nominal: &Nominal) -> String {
        let of_shape = match (self, nominal) {
            (Parameter::Shape(index), Nominal::Freeform(shape)) => {
                shape.parameters().into_iter().nth(usize::from(index))
            }
            _ => None,
        };
        of_shape.map_or_else(|| self.to_string(), |parameter| parameter.name)
    }

    /// The unit as text: `mm`, `rad`, `1` or `mm^-3` and so on; `None` where the nominal has no such
    /// parameter.
    pub fn unit(self, nominal: &Nominal) -> Option<String> {
        let own = match self {
            Parameter::Tx | Parameter::Ty | Parameter::Tz | Parameter::Radius => "mm".to_owned(),
            Parameter::Rx | Parameter::Ry | Parameter::Rz => "rad".to_owned(),
            Parameter::Conic => "1".to_owned(),
            Parameter::A(order) => power_unit(order),
            Parameter::Shape(index) => {
                let parameters = nominal.freeform()?.parameters();
                return parameters.into_iter().nth(usize::from(index)).map(|found| found.unit);
            }
        };
        nominal.has(self).then_some(own)
    }

    /// The value this parameter has in a pose and a nominal; `None` where the nominal has no such
    /// parameter.
    pub fn value(self, pose: &Pose, nominal: &Nominal) -> Option<f64> {
        match self {
            Parameter::Tx => Some(pose.tx_mm),
            Parameter::Ty => Some(pose.ty_mm),
            Parameter::Tz => Some(pose.tz_mm),
            Parameter::Rx => Some(pose.rx_rad),
            Parameter::Ry => Some(pose.ry_rad),
            Parameter::Rz => Some(pose.rz_rad),
            Parameter::Radius => nominal.radius_mm(),
            Parameter::Conic => nominal.asphere().map(|asphere| asphere.conic),
            Parameter::A(order) => nominal.asphere().and_then(|asphere| asphere.coefficient(order)),
            Parameter::Shape(index) => {
                let parameters = nominal.freeform()?.parameters();
                parameters.get(usize::from(index)).map(|parameter| parameter.value)
            }
        }
    }
}

impl Nominal {
    /// Whether this kind of surface has the parameter. Every part has those of the pose.
    pub fn has(&self, parameter: Parameter) -> bool {
        match parameter {
            Parameter::Radius => matches!(self, Nominal::Sphere { .. } | Nominal::Asphere(_)),
            Parameter::Conic => self.asphere().is_some(),
            Parameter::A(order) => {
                self.asphere().is_some_and(|asphere| asphere.coefficient(order).is_some())
            }
            Parameter::Shape(index) => {
                self.freeform().is_some_and(|shape| usize::from(index) < shape.parameters().len())
            }
            _ => true,
        }
    }

    /// The parameter of this name, in the words of this nominal: a freeform's `radius` is that of its
    /// shape. Fails on a name that pose and nominal do not have.
    pub fn parameter(&self, name: &str) -> Result<Parameter, ParameterError> {
        let every = self.parameters();
        if let Some((parameter, _)) = every.iter().find(|(_, known)| known == name) {
            return Ok(*parameter);
        }
        let names: Vec<&str> = every.iter().map(|(_, known)| known.as_str()).collect();
        Err(ParameterError::NotOfNominal {
            name: name.to_owned(),
            kind: self.kind(),
            expected: names.join(", "),
        })
    }

    /// All parameters a fit of this nominal can set free, with their names: those of the pose, then those
    /// of the shape.
    pub fn parameters(&self) -> Vec<(Parameter, String)> {
        let pose = Parameter::POSE.map(|parameter| (parameter, parameter.to_string()));
        let mut every = pose.to_vec();
        if let Nominal::Freeform(shape) = self {
            let own = (0..).map(Parameter::Shape).zip(shape.parameters());
            every.extend(own.map(|(parameter, found)| (parameter, found.name)));
            return every;
        }
        let powers = (LOWEST_ORDER..=HIGHEST_ORDER).step_by(2).map(Parameter::A);
        let own = [Parameter::Radius, Parameter::Conic].into_iter().chain(powers);
        every.extend(
            own.filter(|&parameter| self.has(parameter))
                .map(|parameter| (parameter, parameter.to_string())),
        );
        every
    }
}

/// Pose and nominal after a change of parameters, given as (parameter, step in its unit); `None` if that
/// makes no pose or no nominal.
///
/// A radius is stepped in its curvature: see [`stepped_radius_mm`].
pub(crate) fn moved(
    changes: impl IntoIterator<Item = (Parameter, f64)>,
    pose: &Pose,
    nominal: &Nominal,
) -> Option<(Pose, Nominal)> {
    let (mut pose, mut nominal) = (*pose, nominal.clone());
    let mut values: Option<Vec<ShapeParameter>> = None;
    for (parameter, step) in changes {
        match (parameter, &mut nominal) {
            (Parameter::Tx, _) => pose.tx_mm += step,
            (Parameter::Ty, _) => pose.ty_mm += step,
            (Parameter::Tz, _) => pose.tz_mm += step,
            (Parameter::Rx, _) => pose.rx_rad = within_half_turn(pose.rx_rad + step),
            (Parameter::Ry, _) => pose.ry_rad = within_half_turn(pose.ry_rad + step),
            (Parameter::Rz, _) => pose.rz_rad = within_half_turn(pose.rz_rad + step),
            (Parameter::Radius, Nominal::Sphere { radius_mm }) => {
                *radius_mm = stepped_radius_mm(*radius_mm, step);
            }
            (Parameter::Radius, Nominal::Asphere(asphere)) => {
                asphere.radius_mm = stepped_radius_mm(asphere.radius_mm, step);
            }
            (Parameter::Conic, Nominal::Asphere(asphere)) => asphere.conic += step,
            (Parameter::A(order), Nominal::Asphere(asphere)) => {
                *asphere.coefficient_mut(order)? += step;
            }
            (Parameter::Shape(index), Nominal::Freeform(shape)) => {
                let parameters = values.get_or_insert_with(|| shape.parameters());
                let changed = parameters.get_mut(usize::from(index))?;
                changed.value = if changed.is_radius() {
                    stepped_radius_mm(changed.value, step)
                } else {
                    changed.value + step
                };
            }
            (Parameter::Radius | Parameter::Conic | Parameter::A(_) | Parameter::Shape(_), _) => {
                return None;
            }
        }
    }
    if let (Some(values), Nominal::Freeform(shape)) = (values, &nominal) {
        let values: Vec<f64> = values.iter().map(|parameter| parameter.value).collect();
        nominal = Nominal::Freeform(shape.with_parameters(&values).ok()?);
    }
    (pose.is_finite() && nominal.validate().is_ok()).then_some((pose, nominal))
}

/// The radius whose curvature is that of `radius_mm` after a step: 1/R − step/R², of which `step` is the first order.
///
/// Heights are nearly linear in the curvature, and a flat surface is no border of it. So a start with the wrong sign,
/// or far too flat a one, arrives in a few steps, where steps of R would go to infinity.
fn stepped_radius_mm(radius_mm: f64, step_mm: f64) -> f64 {
    radius_mm / (1.0 - step_mm / radius_mm)
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Parameter::Tx => f.write_str("tx"),
            Parameter::Ty => f.write_str("ty"),
            Parameter::Tz => f.write_str("tz"),
            Parameter::Rx => f.write_str("rx"),
            Parameter::Ry => f.write_str("ry"),
            Parameter::Rz => f.write_str("rz"),
            Parameter::Radius => f.write_str("radius"),
            Parameter::Conic => f.write_str("conic"),
            Parameter::A(order) => write!(f, "A{order}"),
            Parameter::Shape(index) => write!(f, "shape[{index}]"),
        }
    }
}

/// Names of a pose and of a rotational nominal; those of a freeform only it can tell
/// ([`Nominal::parameter`]).
impl FromStr for Parameter {
    type Err = ParameterError;

    fn from_str(name: &str) -> Result<Parameter, ParameterError> {
        let unknown = || ParameterError::Unknown { name: name.to_owned() };
        Ok(match name {
            "tx" => Parameter::Tx,
            "ty" => Parameter::Ty,
            "tz" => Parameter::Tz,
            "rx" => Parameter::Rx,
            "ry" => Parameter::Ry,
            "rz" => Parameter::Rz,
            "radius" => Parameter::Radius,
            "conic" => Parameter::Conic,
            _ => {
                let order = (LOWEST_ORDER..=HIGHEST_ORDER)
                    .step_by(2)
                    .find(|order| name == format!("A{order}"))
                    .ok_or_else(unknown)?;
                Parameter::A(order)
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Asphere;

    #[test]
    fn names_and_units() {
        let asphere = Nominal::Asphere(Asphere::new(10.0, 0.0, &[]).unwrap());
        let table = [
            ("tx", Parameter::Tx, "mm"),
            ("ty", Parameter::Ty, "mm"),
            ("tz", Parameter::Tz, "mm"),
            ("rx", Parameter::Rx, "rad"),
            ("ry", Parameter::Ry, "rad"),
            ("rz", Parameter::Rz, "rad"),
            ("radius", Parameter::Radius, "mm"),
            ("conic", Parameter::Conic, "1"),
            ("A4", Parameter::A(4), "mm^-3"),
            ("A20", Parameter::A(20), "mm^-19"),
        ];
        for (name, parameter, unit) in table {
            assert_eq!(name.parse(), Ok(parameter));
            assert_eq!(parameter.to_string(), name);
            assert_eq!(parameter.unit(&asphere).as_deref(), Some(unit));
            assert_eq!(asphere.parameter(name), Ok(parameter));
        }
    }

    #[test]
    fn odd_low_high_and_padded_orders_are_unknown() {
        for name in ["A2", "A5", "A22", "A04", "a4", "A", "", "Tx"] {
            let error = name.parse::<Parameter>().unwrap_err();
            assert_eq!(error, ParameterError::Unknown { name: name.to_owned() });
        }
    }
}
