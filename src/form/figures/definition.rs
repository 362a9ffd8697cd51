//! What a figure means, and where that is laid down.

use std::fmt;

/// A figure with its meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// What it is.
    pub definition: Definition,
    /// Its value in [`Definition::unit`].
    pub value: f64,
}

impl Figure {
    pub(crate) fn new(definition: Definition, value: f64) -> Figure {
        Figure { definition, value }
    }
}

impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", self.definition, self.value, self.definition.unit())
    }
}

/// Unit of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Nanometres of surface height.
    Nanometres,
    /// Microradians, that is nanometres per millimetre.
    Microradians,
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Unit::Nanometres => "nm",
            Unit::Microradians => "µrad",
        })
    }
}

/// Which figure of a form deviation, variant included.
///
/// `Display` gives the short sign, [`Definition::text`] the meaning, [`Definition::source`] where the
/// figure comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Definition {
    /// Largest minus smallest deviation.
    PeakToValley,
    /// Root of the mean square about the nominal, every point counted alike.
    RmsOverPoints,
    /// Root of the mean square about the nominal, by area.
    RmsAboutZero,
    /// Root of the mean square about the mean.
    RmsAboutMean,
    /// Peak to valley of the middle share of the area.
    RobustPeakToValley {
        /// The share, above 0 and at most 1.
        share: f64,
    },
    /// Robust peak to valley from a Fringe fit and its residual.
    Pvr {
        /// Fringe terms of the fit, piston included: 36 or 37.
        terms: u8,
    },
    /// A of `3/A(B/C)`.
    Sagitta,
    /// B of `3/A(B/C)`.
    Irregularity,
    /// C of `3/A(B/C)`.
    InvariantIrregularity,
    /// RMSt.
    RmsTotal,
    /// RMSi.
    RmsIrregularity,
    /// RMSa.
    RmsVariant,
    /// Width of the minimum zone.
    MinimumZone,
    /// Largest slope along the meridian.
    MeridionalSlopeMax,
    /// RMS slope along the meridian.
    MeridionalSlopeRms,
    /// Largest gradient.
    GradientMax,
    /// RMS gradient.
    GradientRms,
}

impl Definition {
    /// The unit of its values.
    pub fn unit(&self) -> Unit {
        match self {
            Definition::MeridionalSlopeMax
            | Definition::MeridionalSlopeRms
            | Definition::GradientMax
            | Definition::GradientRms => Unit::Microradians,
            _ => Unit::Nanometres,
        }
    }

    /// What the figure is, in one sentence.
    pub fn text(&self) -> &'static str {
        match self {
            Definition::PeakToValley => "largest minus smallest deviation at the measured places",
            Definition::RmsOverPoints => {
                "root of the mean square about the nominal, every measured point counted alike"
            }
            Definition::RmsAboutZero => "root of the area-weighted mean square about the nominal",
            Definition::RmsAboutMean => "root of the area-weighted mean square about the mean",
            Definition::RobustPeakToValley { .. } => {
                "range of the deviations after half of the remaining share of the area is left out \
                 at either end, by whole points"
            }
            Definition::Pvr { .. } => {
                "peak to valley, at the measured places, of the least-squares sum of Fringe terms, \
                 piston included, plus three times the RMS of the residual"
            }
            Definition::Sagitta => {
                "peak to valley over the aperture of the approximating sphere, for aspheres of the \
                 quadratic part"
            }
            Definition::Irregularity => {
                "peak to valley of what piston, tilt and the approximating sphere leave"
            }
            Definition::InvariantIrregularity => {
                "peak to valley of the azimuthal mean of the irregularity"
            }
            Definition::RmsTotal => "RMS of what piston and tilt leave",
            Definition::RmsIrregularity => "RMS of the irregularity",
            Definition::RmsVariant => "RMS of the irregularity less its azimuthal mean",
            Definition::MinimumZone => {
                "distance of the two nearest parallels of the nominal between which every point lies, \
                 pose and free parameters being those that make it least"
            }
            Definition::MeridionalSlopeMax => {
                "largest slope of the deviation along the meridian, by local planes over the \
                 integration length"
            }
            Definition::MeridionalSlopeRms => {
                "RMS slope of the deviation along the meridian, by local planes over the \
                 integration length"
            }
            Definition::GradientMax => {
                "largest gradient of the deviation, by local planes over the integration length"
            }
            Definition::GradientRms => {
                "RMS gradient of the deviation, by local planes over the integration length"
            }
        }
    }

    /// The standard or paper that defines the figure; for the robust range, which none defines, that.
    pub fn source(&self) -> &'static str {
        match self {
            Definition::PeakToValley | Definition::RmsAboutZero | Definition::RmsAboutMean => {
                "ISO 14999-4:2015"
            }
            Definition::RmsOverPoints => {
                "no standard: of the measured places, however densely they lie"
            }
            Definition::RobustPeakToValley { .. } => "no standard: share and rule as stated",
            Definition::Pvr { terms: 36 } => {
                "Evans, Optical Fabrication and Testing 2008, OWA4, and ISO 14999-4:2015; Fringe \
                 terms 1 to 36"
            }
            Definition::Pvr { .. } => {
                "Evans, Optical Fabrication and Testing 2008, OWA4, and ISO 14999-4:2015; Fringe \
                 terms 1 to 36 and (12, 0) (prysm counts on to (6, 6))"
            }
            Definition::Sagitta
            | Definition::Irregularity
            | Definition::InvariantIrregularity
            | Definition::RmsTotal
            | Definition::RmsIrregularity
            | Definition::RmsVariant => "ISO 10110-5:2015, functions of ISO 14999-4:2015",
            Definition::MinimumZone => {
                "minimax (Chebyshev) criterion; of planes the minimum zone of ISO 12781-1:2011"
            }
            Definition::MeridionalSlopeMax
            | Definition::MeridionalSlopeRms
            | Definition::GradientMax
            | Definition::GradientRms => "ISO 10110-12:2019",
        }
    }
}

impl fmt::Display for Definition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Definition::PeakToValley => "PV",
            Definition::RmsOverPoints => "RMS over the points",
            Definition::RmsAboutZero => "RMS by area",
            Definition::RmsAboutMean => "RMS about the mean, by area",
            Definition::RobustPeakToValley { share } => return write!(f, "PV{}%", percent(*share)),
            Definition::Pvr { terms } => return write!(f, "PVr (Fringe 1 to {terms})"),
            Definition::Sagitta => "A",
            Definition::Irregularity => "B",
            Definition::InvariantIrregularity => "C",
            Definition::RmsTotal => "RMSt",
            Definition::RmsIrregularity => "RMSi",
            Definition::RmsVariant => "RMSa",
            Definition::MinimumZone => "PV, minimum zone",
            Definition::MeridionalSlopeMax => "meridional slope, max",
            Definition::MeridionalSlopeRms => "meridional slope, RMS",
            Definition::GradientMax => "gradient, max",
            Definition::GradientRms => "gradient, RMS",
        })
    }
}

/// A share in percent, without the rounding of the product with 100.
fn percent(share: f64) -> f64 {
    (share * 1e11).round() / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_names_its_variant() {
        let robust = Figure::new(Definition::RobustPeakToValley { share: 0.995 }, 12.5);
        assert_eq!(robust.to_string(), "PV99.5% 12.5 nm");
        assert_eq!(Definition::Pvr { terms: 37 }.to_string(), "PVr (Fringe 1 to 37)");
        assert_ne!(Definition::Pvr { terms: 36 }.source(), Definition::Pvr { terms: 37 }.source());
        assert_eq!(Definition::GradientRms.unit().to_string(), "µrad");
    }
}
