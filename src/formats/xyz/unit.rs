//! Units of columns: of lengths, and of slopes.

use std::f64::consts::PI;
use std::fmt;

/// The unit of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unit {
    /// Nanometre.
    Nm,
    /// Micrometre.
    Um,
    /// Millimetre.
    Mm,
    /// Centimetre.
    Cm,
    /// Metre.
    M,
    /// Inch of 25.4 mm.
    In,
    /// Radian of slope: dz/dx as it is.
    Rad,
    /// Milliradian of slope.
    Mrad,
    /// Microradian of slope.
    Urad,
    /// Second of arc of slope.
    Arcsec,
}

impl Unit {
    /// The unit that a word names, in any case of letters.
    pub fn from_word(word: &str) -> Option<Unit> {
        Some(match word.trim().to_lowercase().as_str() {
            "nm" | "nanometre" | "nanometres" | "nanometer" | "nanometers" => Unit::Nm,
            "um" | "µm" | "μm" | "micron" | "microns" | "micrometre" | "micrometres"
            | "micrometer" | "micrometers" => Unit::Um,
            "mm" | "millimetre" | "millimetres" | "millimeter" | "millimeters" => Unit::Mm,
            "cm" | "centimetre" | "centimetres" | "centimeter" | "centimeters" => Unit::Cm,
            "m" | "metre" | "metres" | "meter" | "meters" => Unit::M,
            "in" | "inch" | "inches" => Unit::In,
            "rad" | "radian" | "radians" => Unit::Rad,
            "mrad" | "milliradian" | "milliradians" => Unit::Mrad,
            "urad" | "µrad" | "μrad" | "microrad" | "microradian" | "microradians" => Unit::Urad,
            "arcsec" | "arcsecond" | "arcseconds" => Unit::Arcsec,
            _ => return None,
        })
    }

    /// Whether it is a unit of slope, not of length.
    pub const fn is_slope(self) -> bool {
        matches!(self, Unit::Rad | Unit::Mrad | Unit::Urad | Unit::Arcsec)
    }

    /// A value in mm, or of a slope in rad. One rounded operation, and none in mm and rad.
    pub fn scaled(self, value: f64) -> f64 {
        match self {
            Unit::Mm | Unit::Rad => value,
            // Quotients by powers of ten are rounded once; products with 0.001 would be twice.
            Unit::Um | Unit::Mrad => value / 1e3,
            Unit::Nm | Unit::Urad => value / 1e6,
            Unit::Cm => value * 10.0,
            Unit::M => value * 1e3,
            Unit::In => value * 25.4,
            Unit::Arcsec => value * (PI / 648_000.0),
        }
    }

    /// Its symbol as the command line writes it.
    pub const fn name(self) -> &'static str {
        match self {
            Unit::Nm => "nm",
            Unit::Um => "um",
            Unit::Mm => "mm",
            Unit::Cm => "cm",
            Unit::M => "m",
            Unit::In => "in",
            Unit::Rad => "rad",
            Unit::Mrad => "mrad",
            Unit::Urad => "urad",
            Unit::Arcsec => "arcsec",
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
