//! The catalogue of figures: a variant and a row a figure, and nothing about a figure stands elsewhere.

use super::definition::Unit;
use super::statistic::Statistic;
use super::subject::Subject;
use super::texture::Parameter;

/// Which figure, variant included.
///
/// `Display` gives the short sign, [`Definition::text`] the meaning, [`Definition::source`] where the
/// figure comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// A parameter of surface texture.
    Texture(Parameter),
}

/// All that is said of a figure.
pub(super) struct Row {
    /// Its identity in reports, and its key in configurations before the unit.
    pub(super) id: &'static str,
    /// Its short sign, as tables and sentences have it.
    pub(super) symbol: &'static str,
    /// Its long sign, which tells it from its kin.
    pub(super) name: &'static str,
    /// The unit of its values.
    pub(super) unit: Unit,
    /// What of the deviation it judges.
    pub(super) subject: Subject,
    /// What it makes of the deviations.
    pub(super) statistic: Statistic,
    /// Definition in one sentence.
    pub(super) text: &'static str,
    /// The standard or paper that defines it.
    pub(super) source: &'static str,
}

impl Definition {
    /// Figures of deviations that a limit can be given for.
    pub const LIMITED: [Definition; 15] = [
        Definition::PeakToValley,
        Definition::RmsOverPoints,
        Definition::RmsAboutMean,
        Definition::RobustPeakToValley { share: 0.99 },
        Definition::Pvr { terms: 36 },
        Definition::Sagitta,
        Definition::Irregularity,
        Definition::InvariantIrregularity,
        Definition::RmsTotal,
        Definition::RmsIrregularity,
        Definition::RmsVariant,
        Definition::MeridionalSlopeMax,
        Definition::MeridionalSlopeRms,
        Definition::GradientMax,
        Definition::GradientRms,
    ];

    /// Figures that are formed of points and a nominal, each where its identity is asked for.
    pub const OF_POINTS: [Definition; 1] = [Definition::MinimumZone];

    /// Further figures that a limit can be given for: of more than deviations, so that they are formed at the end alone.
    pub const AT_END: [Definition; 4] = [
        Definition::MinimumZone,
        Definition::Texture(Parameter::Sa),
        Definition::Texture(Parameter::Sq),
        Definition::Texture(Parameter::Sz),
    ];

    pub(super) fn row(&self) -> &'static Row {
        match self {
            Definition::PeakToValley => &PEAK_TO_VALLEY,
            Definition::RmsOverPoints => &RMS_OVER_POINTS,
            Definition::RmsAboutZero => &RMS_ABOUT_ZERO,
            Definition::RmsAboutMean => &RMS_ABOUT_MEAN,
            Definition::RobustPeakToValley { share: 0.99 } => &ROBUST,
            Definition::RobustPeakToValley { .. } => &ROBUST_OF_SHARE,
            Definition::Pvr { terms: 36 } => &PVR,
            Definition::Pvr { .. } => &PVR_37,
            Definition::Sagitta => &SAGITTA,
            Definition::Irregularity => &IRREGULARITY,
            Definition::InvariantIrregularity => &INVARIANT_IRREGULARITY,
            Definition::RmsTotal => &RMS_TOTAL,
            Definition::RmsIrregularity => &RMS_IRREGULARITY,
            Definition::RmsVariant => &RMS_VARIANT,
            Definition::MinimumZone => &MINIMUM_ZONE,
            Definition::MeridionalSlopeMax => &MERIDIONAL_SLOPE_MAX,
            Definition::MeridionalSlopeRms => &MERIDIONAL_SLOPE_RMS,
            Definition::GradientMax => &GRADIENT_MAX,
            Definition::GradientRms => &GRADIENT_RMS,
            Definition::Texture(parameter) => parameter.row(),
        }
    }
}

const PEAK_TO_VALLEY: Row = Row {
    id: "pv",
    symbol: "PV",
    name: "PV",
    unit: Unit::Nanometres,
    subject: Subject::Deviation,
    statistic: Statistic::Extreme,
    text: "largest minus smallest deviation at the measured places",
    source: ISO_14999_4,
};
const RMS_OVER_POINTS: Row = Row {
    id: "rms",
    symbol: "RMS",
    name: "RMS over the points",
    unit: Unit::Nanometres,
    subject: Subject::Deviation,
    statistic: Statistic::MeanSquare,
    text: "root of the mean square about the nominal, every measured point counted alike",
    source: "no standard: of the measured places, however densely they lie",
};
const RMS_ABOUT_ZERO: Row = Row {
    id: "rms_by_area",
    symbol: "RMS by area",
    name: "RMS by area",
    unit: Unit::Nanometres,
    subject: Subject::Deviation,
    statistic: Statistic::MeanSquare,
    text: "root of the area-weighted mean square about the nominal",
    source: ISO_14999_4,
};
const RMS_ABOUT_MEAN: Row = Row {
    id: "rms_about_mean",
    symbol: "RMS about the mean",
    name: "RMS about the mean, by area",
    unit: Unit::Nanometres,
    subject: Subject::Deviation,
    statistic: Statistic::MeanSquare,
    text: "root of the area-weighted mean square about the mean",
    source: ISO_14999_4,
};
const ROBUST: Row = Row {
    id: "pv99",
    symbol: "PV99%",
    name: "PV",
    unit: Unit::Nanometres,
    subject: Subject::Deviation,
    statistic: Statistic::Extreme,
    text: "range of the deviations after half of the remaining share of the area is left out \
               at either end, by whole points",
    source: "no standard: share and rule as stated",
};
const ROBUST_OF_SHARE: Row = Row { id: "pv_of_share", symbol: "PV of a share", ..ROBUST };
const PVR: Row = Row {
    id: "pvr",
    symbol: "PVr",
    name: "PVr",
    unit: Unit::Nanometres,
    subject: Subject::Deviation,
    statistic: Statistic::Compound,
    text: "peak to valley, at the measured places, of the least-squares sum of Fringe terms, \
               piston included, plus three times the RMS of the residual",
    source: "Evans, Optical Fabrication and Testing 2008, OWA4, and ISO 14999-4:2015; Fringe \
             terms 1 to 36",
};
const PVR_37: Row = Row {
    id: "pvr_37",
    source: "Evans, Optical Fabrication and Testing 2008, OWA4, and ISO 14999-4:2015; Fringe \
             terms 1 to 36 and (12, 0) (prysm counts on to (6, 6))",
    ..PVR
};
const SAGITTA: Row = Row {
    id: "a",
    symbol: "A",
    name: "A",
    unit: Unit::Nanometres,
    subject: Subject::Indication,
    statistic: Statistic::Coefficient,
    text: "peak to valley over the aperture of the approximating sphere, for aspheres of the \
               quadratic part",
    source: ISO_10110_5,
};
const IRREGULARITY: Row = Row {
    id: "b",
    symbol: "B",
    name: "B",
    unit: Unit::Nanometres,
    subject: Subject::Indication,
    statistic: Statistic::Compound,
    text: "peak to valley of what piston, tilt and the approximating sphere leave",
    source: ISO_10110_5,
};
const INVARIANT_IRREGULARITY: Row = Row {
    id: "c",
    symbol: "C",
    name: "C",
    unit: Unit::Nanometres,
    subject: Subject::Indication,
    statistic: Statistic::Compound,
    text: "peak to valley of the azimuthal mean of the irregularity",
    source: ISO_10110_5,
};
const RMS_TOTAL: Row = Row {
    id: "rmst",
    symbol: "RMSt",
    name: "RMSt",
    unit: Unit::Nanometres,
    subject: Subject::Indication,
    statistic: Statistic::MeanSquare,
    text: "RMS of what piston and tilt leave",
    source: ISO_10110_5,
};
const RMS_IRREGULARITY: Row = Row {
    id: "rmsi",
    symbol: "RMSi",
    name: "RMSi",
    unit: Unit::Nanometres,
    subject: Subject::Indication,
    statistic: Statistic::MeanSquare,
    text: "RMS of the irregularity",
    source: ISO_10110_5,
};
const RMS_VARIANT: Row = Row {
    id: "rmsa",
    symbol: "RMSa",
    name: "RMSa",
    unit: Unit::Nanometres,
    subject: Subject::Indication,
    statistic: Statistic::MeanSquare,
    text: "RMS of the irregularity less its azimuthal mean",
    source: ISO_10110_5,
};
const MINIMUM_ZONE: Row = Row {
    id: "minimum_zone",
    symbol: "minimum zone",
    name: "PV, minimum zone",
    unit: Unit::Nanometres,
    subject: Subject::Points,
    statistic: Statistic::Extreme,
    text: "distance of the two nearest parallels of the nominal between which every point lies, \
               pose and free parameters being those that make it least",
    source: "minimax (Chebyshev) criterion; of planes the minimum zone of ISO 12781-1:2011",
};
const MERIDIONAL_SLOPE_MAX: Row = Row {
    id: "slope_max",
    symbol: "slope max",
    name: "meridional slope, max",
    unit: Unit::Microradians,
    subject: Subject::Slope,
    statistic: Statistic::LargestSlope,
    text: "largest slope of the deviation along the meridian, by local planes over the \
               integration length, per mm across the axis",
    source: ISO_10110_12,
};
const MERIDIONAL_SLOPE_RMS: Row = Row {
    id: "slope_rms",
    symbol: "slope RMS",
    name: "meridional slope, RMS",
    unit: Unit::Microradians,
    subject: Subject::Slope,
    statistic: Statistic::MeanSquareSlope,
    text: "RMS slope of the deviation along the meridian, by local planes over the \
               integration length, per mm across the axis",
    source: ISO_10110_12,
};
const GRADIENT_MAX: Row = Row {
    id: "gradient_max",
    symbol: "gradient max",
    name: "gradient, max",
    unit: Unit::Microradians,
    subject: Subject::Slope,
    statistic: Statistic::LargestSlope,
    text: "largest gradient of the deviation, by local planes over the integration length, per \
               mm across the axis",
    source: ISO_10110_12,
};
const GRADIENT_RMS: Row = Row {
    id: "gradient_rms",
    symbol: "gradient RMS",
    name: "gradient, RMS",
    unit: Unit::Microradians,
    subject: Subject::Slope,
    statistic: Statistic::MeanSquareSlope,
    text: "RMS gradient of the deviation, by local planes over the integration length, per mm \
               across the axis",
    source: ISO_10110_12,
};

const ISO_14999_4: &str = "ISO 14999-4:2015";
const ISO_10110_5: &str = "ISO 10110-5:2015, functions of ISO 14999-4:2015";
const ISO_10110_12: &str = "ISO 10110-12:2019";
