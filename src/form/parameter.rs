//! The parameters a fit can set free, with their names and units.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;

use crate::nominal::{HIGHEST_ORDER, LOWEST_ORDER};
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
}

impl Parameter {
    /// Shifts and tilts: all a rotationally symmetric part's pose has.
    pub const RIGID: [Parameter; 5] =
        [Parameter::Tx, Parameter::Ty, Parameter::Tz, Parameter::Rx, Parameter::Ry];

    /// The unit as text: `mm`, `rad`, `1` or `mm^-3` and so on.
    pub fn unit(self) -> String {
        match self {
            Parameter::Tx | Parameter::Ty | Parameter::Tz | Parameter::Radius => "mm".to_owned(),
            Parameter::Rx | Parameter::Ry | Parameter::Rz => "rad".to_owned(),
            Parameter::Conic => "1".to_owned(),
            Parameter::A(order) => format!("mm^{}", 1 - i32::from(order)),
        }
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
        }
    }

    /// Adds `step` to this parameter. What the nominal does not have stays untouched.
    pub(crate) fn add(self, step: f64, pose: &mut Pose, nominal: &mut Nominal) {
        match (self, nominal) {
            (Parameter::Tx, _) => pose.tx_mm += step,
            (Parameter::Ty, _) => pose.ty_mm += step,
            (Parameter::Tz, _) => pose.tz_mm += step,
            (Parameter::Rx, _) => pose.rx_rad += step,
            (Parameter::Ry, _) => pose.ry_rad += step,
            (Parameter::Rz, _) => pose.rz_rad += step,
            (Parameter::Radius, Nominal::Sphere { radius_mm }) => *radius_mm += step,
            (Parameter::Radius, Nominal::Asphere(asphere)) => asphere.radius_mm += step,
            (Parameter::Conic, Nominal::Asphere(asphere)) => asphere.conic += step,
            (Parameter::A(order), Nominal::Asphere(asphere)) => {
                if let Some(coefficient) = asphere.coefficient_mut(order) {
                    *coefficient += step;
                }
            }
            (Parameter::Radius | Parameter::Conic | Parameter::A(_), _) => {}
        }
    }
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
        }
    }
}

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

    #[test]
    fn names_and_units() {
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
            assert_eq!(parameter.unit(), unit);
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
