//! The figures of a form deviation: what standards and optical shops call it by.

use serde::{Deserialize, Serialize};

/// One figure with its meaning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FormFigure {
    /// Its identity: `pv`, `b`, `sq`.
    #[serde(default)]
    pub id: String,
    /// Its sign: `PV`, `PVr (Fringe 1 to 36)`, `B`.
    pub name: String,
    /// Deviation it is taken of: `as fitted`, `piston, tilt removed`, `over 1.2 mm`.
    pub variant: String,
    /// The terms removed before it was formed: `piston`, `tilt`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub removed: Vec<String>,
    /// Its value.
    pub value: f64,
    /// Unit of the value: `nm` or `µrad`.
    pub unit: String,
    /// Its standard uncertainty (k = 1) in the same unit; absent where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub u: Option<f64>,
    /// Its expanded uncertainty; absent where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expanded: Option<ExpandedFigures>,
    /// Result of simulated measurements; absent where none were made for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated: Option<SimulatedFigures>,
    /// Rise of the value by independent noise of the points on the average, of a largest slope at most, in the same unit;
    /// absent where that was not worked out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_adds: Option<f64>,
    /// The value without it; absent where only its bound is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without_noise: Option<f64>,
    /// Definition in one sentence.
    pub definition: String,
    /// The standard or paper that defines it.
    pub source: String,
}

/// An expanded uncertainty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExpandedFigures {
    /// Half the width of the interval about the value, in the unit of the value.
    pub value: f64,
    /// The coverage factor.
    pub k: f64,
    /// The probability that the interval holds the truth, 0 to 1.
    pub p: f64,
}

/// Result of simulated measurements of a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SimulatedFigures {
    /// Errors that they have: [`UncertaintyFigures::BUDGET`](crate::UncertaintyFigures::BUDGET) or
    /// [`UncertaintyFigures::NOISE_ONLY`](crate::UncertaintyFigures::NOISE_ONLY).
    pub model: String,
    /// Lower end of the interval that holds the figure of the part without these errors, at the places measured, in the unit of
    /// the figure.
    pub low: f64,
    /// Its upper end. Of an average the share of the noise is taken off, so that the interval may lie below the value. Of a
    /// range or an extreme it is above: a defect of a single point may hide in the noise.
    pub high: f64,
    /// Its probability, 0 to 1. An interval of a range or an extreme holds the truth at least so often, where noise makes
    /// all of it, too.
    pub p: f64,
    /// Scope of interval and u, in words.
    #[serde(default)]
    pub covers: String,
    /// The value less `bias`: what is left of the figure without noise. The interval is of this, and so is `u`.
    #[serde(default)]
    pub without_noise: f64,
    /// Rise of the value by noise, as far as the draws tell; of a range or an extreme, the most it may add with a
    /// probability of one half.
    pub bias: f64,
    /// Measurements simulated.
    pub draws: u32,
    /// Seed of the simulation.
    pub seed: u64,
}

/// The place from which places of the part, rings, Zernike terms and slopes along the meridian count.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OriginFigures {
    /// [`OriginFigures::VERTEX`], [`OriginFigures::MIDDLE_OF_APERTURE`], [`OriginFigures::MIDDLE_OF_POINTS`],
    /// [`OriginFigures::CENTRE`] or [`OriginFigures::AXIS`].
    pub place: String,
    /// Where it lies in the measured frame, mm.
    pub at_mm: [f64; 3],
}

impl OriginFigures {
    /// The vertex of the surface, on its axis.
    pub const VERTEX: &str = "vertex";
    /// The middle of the aperture, for the surface has no axis of its own there or the aperture lies beside it.
    pub const MIDDLE_OF_APERTURE: &str = "middle of the aperture";
    /// The middle of the smallest circle about the points, for there is neither an axis nor an aperture.
    pub const MIDDLE_OF_POINTS: &str = "middle of the points";
    /// The centre of a sphere that was fitted in space.
    pub const CENTRE: &str = "centre of the sphere";
    /// The axis of a cylinder that was fitted in space, abreast of the middle of its points.
    pub const AXIS: &str = "axis of the cylinder";
}

/// A deviation as a sum of Zernike terms, fitted together by area-weighted least squares.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ZernikeFigures {
    /// The order of the terms: `Fringe`.
    pub scheme: String,
    /// Meaning of a coefficient of 1: `height 1 at the rim`.
    pub normalisation: String,
    /// Radius in mm of the disc the terms refer to, about the origin.
    pub radius_mm: f64,
    /// The terms, by number.
    pub terms: Vec<ZernikeTerm>,
    /// Numbers of terms the places do not tell from lower ones; the sum is without them.
    #[serde(default)]
    pub indeterminate: Vec<u32>,
    /// RMS of what the sum leaves, in nm.
    pub residual_rms_nm: f64,
    /// Deviations that the terms were fitted to.
    #[serde(default)]
    pub source: Source,
}

/// Deviations that a figure is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// The deviation of every point.
    #[default]
    #[serde(rename = "points")]
    Points,
    /// The mean deviations in the cells of the running map, for Zernike terms in blocks of four, each with as
    /// much weight as it has points. What varies within is not seen.
    #[serde(rename = "map of cells")]
    Cells,
}

/// One Zernike term.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ZernikeTerm {
    /// Its number, from 1.
    pub index: u32,
    /// Its name: `defocus`, `primary astigmatism 45°`.
    pub name: String,
    /// Radial order.
    pub n: u32,
    /// Azimuthal order: of a cosine not negative, of a sine negative.
    pub m: i32,
    /// Its coefficient in nm of surface height.
    pub value_nm: f64,
}

/// How many points have which deviation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HistogramFigures {
    /// Where the first bin begins, in nm; a bin's lower end belongs to it.
    pub low_nm: f64,
    /// Width of every bin in nm.
    pub width_nm: f64,
    /// Points in each bin; the first and the last are not empty.
    pub counts: Vec<u64>,
    /// The largest PV of the whole deviation allowed, nm; absent without such a limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pv_limit_nm: Option<f64>,
    /// Deviations in the bins. Of cells, all points of a cell are in the bin of its mean.
    #[serde(default)]
    pub source: Source,
}

/// The mean deviation of one ring about the origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RingFigures {
    /// Inner radius in mm; belongs to it.
    pub from_mm: f64,
    /// Outer radius in mm; belongs to the next ring, that of the last ring to it.
    pub to_mm: f64,
    /// Points in it.
    pub points: u64,
    /// Share of sixteen equal sectors of it that hold a point.
    pub covered: f64,
    /// Area-weighted mean in nm; absent, as are the next two, where no point with an area lies in it.
    pub mean_nm: Option<f64>,
    /// Smallest deviation in nm.
    pub low_nm: Option<f64>,
    /// Largest deviation in nm.
    pub high_nm: Option<f64>,
}
