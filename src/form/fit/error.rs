//! Why there is no fit.

use thiserror::Error;

use crate::{ApertureError, Excluded, NominalError, Parameter, PointMm, Units};

/// Why there is no fit.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FitError {
    /// The nominal is none.
    #[error("the nominal is not usable")]
    Nominal(#[from] NominalError),
    /// The aperture is none.
    #[error("the aperture is not usable")]
    Aperture(#[from] ApertureError),
    /// A parameter was asked for that this nominal does not have.
    #[error("a {kind} has no parameter {parameter}")]
    NoSuchParameter {
        /// The parameter.
        parameter: Parameter,
        /// Kind of the nominal.
        kind: &'static str,
    },
    /// A parameter was asked for twice.
    #[error("parameter {0} is listed twice")]
    Repeated(Parameter),
    /// The start is not finite.
    #[error("the start pose has a number that is not finite")]
    Start,
    /// A loss with an impossible bend.
    #[error("the loss bends at {found} scales, expected a positive number such as 1.345 or 4.685")]
    Loss {
        /// The number found.
        found: f64,
    },
    /// A scale of the loss that is none.
    #[error(
        "the scale of the loss is {found_mm} mm, expected a positive finite length, or none to find it from the points"
    )]
    LossScale {
        /// The scale found, in mm.
        found_mm: f64,
    },
    /// Not one uncertainty for each point.
    #[error(
        "{found} uncertainties for {points} points, expected one for each point or none at all"
    )]
    UncertaintyCount {
        /// Points given.
        points: usize,
        /// Uncertainties given.
        found: usize,
    },
    /// An uncertainty that gives no weight.
    #[error(
        "the uncertainty of point {index} is {found_mm} mm, expected a positive finite length; leave a point out that is not to count"
    )]
    Uncertainty {
        /// Index of the first such point.
        index: usize,
        /// Value found, in mm.
        found_mm: f64,
    },
    /// There is no finite point.
    #[error("{}", no_points(*.given))]
    NoPoints {
        /// Points given.
        given: usize,
    },
    /// No finite point lies in the aperture.
    #[error(
        "none of {finite} finite points lies in the aperture; they reach from {} to {} mm: a height far off may stand for a missing one",
        place(.low_mm), place(.high_mm)
    )]
    OutsideAperture {
        /// Finite points.
        finite: usize,
        /// Smallest coordinates of the points in mm.
        low_mm: PointMm,
        /// Largest coordinates of the points in mm.
        high_mm: PointMm,
    },
    /// The fit moved the aperture to where no point lies.
    #[error(
        "the fit moved the part by ({tx_mm:.3}, {ty_mm:.3}) mm, where no point lies in the aperture: the points do not have the shape \
         of the nominal. Correct its radius and coefficients, or take tx and ty from `free`"
    )]
    Strayed {
        /// Move from the start along x, in mm.
        tx_mm: f64,
        /// Move along y, in mm.
        ty_mm: f64,
    },
    /// No point in the aperture stands over the nominal.
    #[error(
        "none of {inside} points in the aperture stands over the nominal{}; the nearest stands at {nearest_mm:.6} mm",
        end(*.domain_mm)
    )]
    OutsideDomain {
        /// Points in the aperture.
        inside: usize,
        /// Distance from the axis in mm at which the nominal ends.
        domain_mm: f64,
        /// How far from the axis the nearest of the points stands, in mm.
        nearest_mm: f64,
    },
    /// The nominal stands so high at the rim of the points that it is no surface of a part.
    #[error(
        "the nominal is {height_mm:e} mm high {reach_mm:.6} mm from its axis, as far as the points reach from their middle: correct its \
         coefficients, or give an aperture in which it is a surface"
    )]
    TooHigh {
        /// Half the larger side of the box about the points, in mm.
        reach_mm: f64,
        /// The least height there, in mm.
        height_mm: f64,
    },
    /// There is no fit, but there would be one if the points were in another unit.
    #[error("{0}")]
    Units(Units),
    /// Fewer points than parameters.
    #[error(
        "{used} of the points can be used, at least {needed} are needed for the free parameters"
    )]
    TooFewPoints {
        /// Usable points.
        used: usize,
        /// How many the free parameters need.
        needed: usize,
        /// Points left out.
        excluded: Excluded,
    },
    /// Coordinates so large that their squares are not finite.
    #[error("the sums over {used} points overflow")]
    Overflow {
        /// Usable points.
        used: usize,
    },
}

/// Where a nominal ends, if it does; one without an end may be too steep for any point to have a foot on it.
fn end(domain_mm: f64) -> String {
    if domain_mm.is_finite() {
        return format!(", which ends {domain_mm:.6} mm from its axis");
    }
    ", which is too high or too steep there: correct its coefficients".to_owned()
}

/// Words for a place where no point can be fitted.
fn no_points(given: usize) -> String {
    match given {
        0 => "there is no point to fit".to_owned(),
        given => format!("none of {given} points is finite"),
    }
}

/// A place as a person reads it.
fn place([x, y, z]: &PointMm) -> String {
    format!("({x:.4}, {y:.4}, {z:.4})")
}

impl FitError {
    /// Whether the points are elsewhere than the nominal.
    pub(crate) fn is_of_place(&self) -> bool {
        matches!(
            self,
            FitError::OutsideAperture { .. }
                | FitError::OutsideDomain { .. }
                | FitError::TooHigh { .. }
                | FitError::TooFewPoints { .. }
        )
    }
}
