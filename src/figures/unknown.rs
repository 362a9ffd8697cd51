//! Why a figure is unknown, and why a setting is refused.

use thiserror::Error;

/// Why the data do not tell a figure.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Unknown {
    /// No point counts.
    #[error("no point with a deviation lies in the aperture")]
    NoPoints,
    /// Fewer points than the figure needs.
    #[error("{used} points, at least {needed} needed")]
    TooFewPoints {
        /// Points that count.
        used: usize,
        /// How many are needed.
        needed: usize,
    },
    /// All points lie on the axis.
    #[error("every point lies on the axis: no radius to refer to")]
    OnePlace,
    /// The places do not tell these Fringe terms apart from lower ones.
    #[error("the places do not determine the Fringe terms {terms:?}")]
    Indeterminate {
        /// Fringe numbers, ascending.
        terms: Vec<u8>,
    },
    /// The places do not tell a sphere from piston and tilt.
    #[error("the places do not determine a sphere beside piston and tilt")]
    IndeterminateSphere,
    /// The places do not determine every polynomial of a radial series.
    #[error("the places determine {determined} of {wanted} radial polynomials")]
    IndeterminateSeries {
        /// Polynomials that are determined.
        determined: usize,
        /// Polynomials asked for, piston and power included.
        wanted: usize,
    },
    /// The aperture reaches beyond the equator of the nominal sphere.
    #[error("the aperture reaches to {reach_mm} mm, beyond the sphere of radius {radius_mm} mm")]
    BeyondSphere {
        /// Farthest distance from the axis in mm.
        reach_mm: f64,
        /// Radius of the sphere in mm.
        radius_mm: f64,
    },
    /// The stations of a slope are too many to hold.
    #[error("{wanted} stations at a step of {step_mm} mm, at most {allowed}: enlarge the step")]
    TooManyStations {
        /// Stations the step asks for.
        wanted: f64,
        /// How many are allowed.
        allowed: usize,
        /// The step in mm.
        step_mm: f64,
    },
    /// No station has points all around it.
    #[error(
        "none of {stations} stations has points all around it within a length of {integration_mm} mm"
    )]
    Unsupported {
        /// Stations tried.
        stations: usize,
        /// Integration length in mm.
        integration_mm: f64,
    },
    /// Every run of samples without a gap is too short.
    #[error("the longest run without a gap has {longest} samples, at least {needed} needed")]
    ShortRun {
        /// Samples in the longest run.
        longest: usize,
        /// How many are needed.
        needed: usize,
    },
}

/// Why a setting is refused.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum SettingError {
    /// A length that is not a positive finite number.
    #[error("{name} is {value_mm} mm, expected a positive number")]
    Length {
        /// Which length.
        name: &'static str,
        /// Its value in mm.
        value_mm: f64,
    },
    /// A radius of curvature that is zero or not finite.
    #[error("radius of curvature is {value_mm} mm, expected a finite number other than 0")]
    Radius {
        /// Its value in mm.
        value_mm: f64,
    },
    /// A share that is not above 0 and at most 1.
    #[error("share is {value}, expected above 0 and at most 1")]
    Share {
        /// Its value.
        value: f64,
    },
    /// A band that is empty or negative.
    #[error("band from {from_per_mm} to {to_per_mm} cycles per mm is empty")]
    Band {
        /// Lower limit in cycles per mm.
        from_per_mm: f64,
        /// Upper limit in cycles per mm.
        to_per_mm: f64,
    },
    /// A grid whose size is not that of its list of heights.
    #[error("a grid of {rows} rows and {columns} columns, but {heights} heights")]
    Grid {
        /// Rows stated.
        rows: usize,
        /// Columns stated.
        columns: usize,
        /// Heights given.
        heights: usize,
    },
}

/// Passes a positive finite length.
pub(crate) fn positive(name: &'static str, value_mm: f64) -> Result<f64, SettingError> {
    if value_mm.is_finite() && value_mm > 0.0 {
        Ok(value_mm)
    } else {
        Err(SettingError::Length { name, value_mm })
    }
}
