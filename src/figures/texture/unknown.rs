//! Why a texture parameter is unknown, and why a surface or a setting is refused.

use thiserror::Error;

/// Why the data do not tell a parameter.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Unknown {
    /// No node that counts.
    #[error("none of {given} nodes has a height and an area")]
    NoPoints {
        /// Nodes given.
        given: usize,
    },
    /// Fewer nodes than the parameter needs.
    #[error("{used} nodes, at least {needed} needed")]
    TooFewPoints {
        /// Nodes that count.
        used: usize,
        /// How many are needed.
        needed: usize,
    },
    /// A grid too narrow for lags in two directions.
    #[error("a grid of {rows} rows and {columns} columns, at least {needed} of each needed")]
    TooNarrow {
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// Rows and columns needed.
        needed: usize,
    },
    /// No triangle has three measured corners.
    #[error("no triangle has an area and three measured corners")]
    NoTriangle,
    /// All heights are equal, up to rounding.
    #[error("all heights are equal: there is no texture to describe")]
    Flat,
    /// Single nodes stand for so much of the area that the material ratio has no slope.
    #[error("no 40 % of the area holds two nodes: one stands for {largest_share} of it")]
    Lumped {
        /// Share of the area of the largest node.
        largest_share: f64,
    },
    /// The autocorrelation stays above the threshold in every direction, as far as it is known.
    #[error(
        "the autocorrelation stays above {threshold} in every direction, known up to {reach_mm:.4} mm"
    )]
    NeverFalls {
        /// The threshold.
        threshold: f64,
        /// Farthest lag looked at in mm.
        reach_mm: f64,
    },
    /// The autocorrelation stays above the threshold in some direction, as far as it is known.
    #[error(
        "the autocorrelation stays above {threshold} towards {direction_rad:.4} rad, known up to \
         {reach_mm:.4} mm: the aspect ratio is below {at_most:.4}"
    )]
    StaysInOneDirection {
        /// The threshold.
        threshold: f64,
        /// The direction, from +x towards +y, at least 0 and below π.
        direction_rad: f64,
        /// Farthest lag looked at in that direction, in mm.
        reach_mm: f64,
        /// The shortest decay over that lag: an upper bound of Str.
        at_most: f64,
    },
}

/// Why a surface or a setting is refused.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum TextureError {
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
    /// A length that is not a positive finite number.
    #[error("{name} is {value_mm} mm, expected a positive number")]
    Length {
        /// Which length.
        name: &'static str,
        /// Its value in mm.
        value_mm: f64,
    },
    /// A triangle that refers to a point there is not.
    #[error("triangle {triangle} has the corner {corner}, but there are {points} points")]
    Corner {
        /// Index of the triangle.
        triangle: usize,
        /// The index it refers to.
        corner: u32,
        /// Points given.
        points: usize,
    },
    /// The short cut-off is not below the long one.
    #[error("the S-filter's cut-off of {s_mm} mm is not below the L-filter's of {l_mm} mm")]
    Scale {
        /// Cut-off of the S-filter in mm.
        s_mm: f64,
        /// Cut-off of the L-filter in mm.
        l_mm: f64,
    },
    /// A tolerance that is not between 0 and 1.
    #[error("tolerance is {value}, expected above 0 and below 1")]
    Tolerance {
        /// Its value.
        value: f64,
    },
    /// No iteration is allowed.
    #[error("0 iterations allowed, expected at least 1")]
    Iterations,
    /// A threshold that is not between 0 and 1.
    #[error("threshold is {value}, expected above 0 and below 1")]
    Threshold {
        /// Its value.
        value: f64,
    },
}

/// Passes a positive finite length.
pub(super) fn positive(name: &'static str, value_mm: f64) -> Result<f64, TextureError> {
    if value_mm.is_finite() && value_mm > 0.0 {
        Ok(value_mm)
    } else {
        Err(TextureError::Length { name, value_mm })
    }
}
