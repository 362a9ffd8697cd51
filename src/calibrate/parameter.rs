//! Parameters of machines: names, units, and how each moves a point.

use asphera_geometry::vector::Vector;

use crate::correction::Axes;

/// Kind of machine, which decides on its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Machine {
    /// Three linear axes, of which z is the probe's.
    Cartesian,
    /// A turning part, a radial axis, and a probe along the axis of rotation.
    Polar,
}

impl Machine {
    /// Word in files and on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Machine::Cartesian => "cartesian",
            Machine::Polar => "polar",
        }
    }

    /// The machine of a word.
    pub fn of_word(word: &str) -> Option<Machine> {
        [Machine::Cartesian, Machine::Polar].into_iter().find(|machine| machine.word() == word)
    }

    /// Its parameters, in the order of files.
    pub fn parameters(self) -> &'static [Parameter] {
        match self {
            Machine::Cartesian => &[
                Parameter::ScaleX,
                Parameter::ScaleY,
                Parameter::ScaleZ,
                Parameter::Squareness,
                Parameter::TiltX,
                Parameter::TiltY,
            ],
            Machine::Polar => &[
                Parameter::OffsetRadial,
                Parameter::OffsetTangential,
                Parameter::ScaleRadial,
                Parameter::ScaleZ,
                Parameter::TiltRadial,
                Parameter::TiltTangential,
            ],
        }
    }
}

/// Error of a machine. Its value times its effect is added to a point to correct it.
///
/// Their order is that of [`Machine::parameters`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Parameter {
    /// Relative scale of x: adds x to x.
    ScaleX,
    /// Relative scale of y: adds y to y.
    ScaleY,
    /// Place of the probe along the radial axis: adds 1 mm outwards.
    OffsetRadial,
    /// Distance by which the radial axis passes the axis of rotation: adds 1 mm in the sense of growing angles.
    OffsetTangential,
    /// Relative scale of the radial axis: adds the radius outwards.
    ScaleRadial,
    /// Relative scale of z: adds z to z.
    ScaleZ,
    /// Squareness of the axis y against x: adds y to x.
    Squareness,
    /// Tilt of the probe, or of the axis z, in the plane of x: adds z to x.
    TiltX,
    /// Tilt of the probe, or of the axis z, in the plane of y: adds z to y.
    TiltY,
    /// Tilt of the probe in the plane of the radial axis: adds z outwards.
    TiltRadial,
    /// Tilt of the probe across the radial axis: adds z in the sense of growing angles.
    TiltTangential,
}

/// What a parameter measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A ratio of lengths, in files in µm a metre.
    Ratio,
    /// An angle in rad, in files in µrad.
    Angle,
    /// A length in mm, in files in µm.
    Length,
}

impl Quantity {
    /// Unit in files and for people.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Ratio => "µm/m",
            Quantity::Angle => "µrad",
            Quantity::Length => "µm",
        }
    }

    /// Suffix of keys in files.
    pub fn suffix(self) -> &'static str {
        match self {
            Quantity::Ratio => "um_per_m",
            Quantity::Angle => "urad",
            Quantity::Length => "um",
        }
    }

    /// How many units of files a value of 1 is.
    pub fn units(self) -> f64 {
        match self {
            Quantity::Ratio | Quantity::Angle => 1e6,
            Quantity::Length => 1e3,
        }
    }
}

impl Parameter {
    /// Word in files and on the command line, without its unit.
    pub fn word(self) -> &'static str {
        match self {
            Parameter::ScaleX => "scale_x",
            Parameter::ScaleY => "scale_y",
            Parameter::ScaleZ => "scale_z",
            Parameter::Squareness => "squareness",
            Parameter::TiltX => "tilt_x",
            Parameter::TiltY => "tilt_y",
            Parameter::OffsetRadial => "offset_radial",
            Parameter::OffsetTangential => "offset_tangential",
            Parameter::ScaleRadial => "scale_radial",
            Parameter::TiltRadial => "tilt_radial",
            Parameter::TiltTangential => "tilt_tangential",
        }
    }

    /// The quantity it measures.
    pub fn quantity(self) -> Quantity {
        match self {
            Parameter::OffsetRadial | Parameter::OffsetTangential => Quantity::Length,
            Parameter::ScaleX | Parameter::ScaleY | Parameter::ScaleZ | Parameter::ScaleRadial => {
                Quantity::Ratio
            }
            Parameter::Squareness
            | Parameter::TiltX
            | Parameter::TiltY
            | Parameter::TiltRadial
            | Parameter::TiltTangential => Quantity::Angle,
        }
    }

    /// How a point moves for a value of 1 of the parameter, mm: where its axes stand.
    pub fn displacement_mm(self, axes: Axes) -> Vector {
        let (place, outward) = axes.place();
        self.effect(place, outward)
    }

    /// How a point moves for a value of 1: `place` in mm, `outward` the direction of the radial axis.
    ///
    /// Parameters of a polar machine take the radius along `outward`, which is negative where the axis has passed
    /// the centre.
    pub(crate) fn effect(self, place: Vector, outward: [f64; 2]) -> Vector {
        let [x, y, z] = place;
        let [cos, sin] = outward;
        let along = |value: f64| [value * cos, value * sin, 0.0];
        let around = |value: f64| [-value * sin, value * cos, 0.0];
        match self {
            Parameter::ScaleX => [x, 0.0, 0.0],
            Parameter::ScaleY => [0.0, y, 0.0],
            Parameter::ScaleZ => [0.0, 0.0, z],
            Parameter::Squareness => [y, 0.0, 0.0],
            Parameter::TiltX => [z, 0.0, 0.0],
            Parameter::TiltY => [0.0, z, 0.0],
            Parameter::OffsetRadial => along(1.0),
            Parameter::OffsetTangential => around(1.0),
            Parameter::ScaleRadial => along(x * cos + y * sin),
            Parameter::TiltRadial => along(z),
            Parameter::TiltTangential => around(z),
        }
    }
}
