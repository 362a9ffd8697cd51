//! Functions on a cloud: a value a place.

mod algebraic;
mod axes;
mod chebyshev;
mod cholesky;
mod dissection;
mod distance;
mod eigenfunctions;
mod geodesic;
mod harmonic;
mod heat;
mod height;
mod jacobi;
mod krylov;
mod laplacian;
mod pieces;
mod ring;

pub use algebraic::{logarithm, saddle, squared_norm};
pub use axes::{PrincipalAxes, principal_axes};
pub use distance::{distance_from_axis, distance_from_centre, distance_from_point};
pub use eigenfunctions::{Eigenfunctions, MOST_EIGENFUNCTIONS, eigenfunction, eigenfunctions};
pub use geodesic::{MOST_SOURCES, geodesic, geodesic_from_ends, geodesic_mean};
pub use harmonic::{harmonic, harmonic_between_ends};
pub use heat::{HEAT_EIGENFUNCTIONS, heat_kernel};
pub use height::{height, principal_height};
pub(crate) use jacobi::eigen;

use thiserror::Error;

use crate::cloud::CloudError;

/// The values of a function, one a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// The values, in the order of places.
    pub values: Vec<f64>,
    /// The values are lengths in mm that change by no more than the way gone.
    pub is_length: bool,
    /// Another function would do as well: a multiple eigenvalue, or ends that are equally far apart. Another cloud of the same
    /// body may have that one.
    pub is_multiple: bool,
}

impl Field {
    pub(crate) fn length(values: Vec<f64>) -> Field {
        Field { values, is_length: true, is_multiple: false }
    }

    pub(crate) fn number(values: Vec<f64>) -> Field {
        Field { values, is_length: false, is_multiple: false }
    }

    /// Given values, such as a column of the file, one a place.
    pub fn given(values: Vec<f64>) -> Field {
        Field::number(values)
    }

    /// The least and the largest value; `None` without values, or where one is not finite.
    pub fn range(&self) -> Option<[f64; 2]> {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for &value in &self.values {
            if !value.is_finite() {
                return None;
            }
            range = [range[0].min(value), range[1].max(value)];
        }
        (range[0] <= range[1]).then_some(range)
    }
}

/// Numbers as a person gives them.
fn listed(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

/// Reason why a function has no values.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FunctionError {
    /// The cloud has no places.
    #[error("no points: expected one at least; check the file")]
    NoPoints,
    /// A direction without length.
    #[error("the direction is {}: expected one that is finite and not 0", listed(direction))]
    Direction {
        /// The direction.
        direction: Vec<f64>,
    },
    /// A point that is not finite.
    #[error("the point is {} mm: expected finite coordinates", listed(point_mm))]
    Point {
        /// The point in mm.
        point_mm: Vec<f64>,
    },
    /// An axis that the cloud does not have.
    #[error("principal axis {found}: expected 1 to {dimensions}")]
    Axis {
        /// The axis, counted from 1.
        found: usize,
        /// How many there are.
        dimensions: usize,
    },
    /// A number of sources that is none.
    #[error("{found} sources: expected 1 to {most}")]
    Sources {
        /// How many were asked for.
        found: usize,
        /// How many there may be.
        most: usize,
    },
    /// A source that is no place.
    #[error("source {found}: expected the number of a place below {places}")]
    Source {
        /// The number.
        found: u32,
        /// How many places there are.
        places: usize,
    },
    /// A cloud in pieces, where one is wanted.
    #[error(
        "the points lie in {pieces} pieces between which nothing flows: expected one; take the largest piece alone (`asphera parts --out`), or more neighbours"
    )]
    Pieces {
        /// How many pieces there are.
        pieces: usize,
    },
    /// A number of eigenfunctions that is none.
    #[error("{found} eigenfunctions: expected 1 to {most}")]
    Eigenfunctions {
        /// How many were asked for.
        found: usize,
        /// How many there may be.
        most: usize,
    },
    /// A time of diffusion that is none.
    #[error("the time of diffusion is {found}: expected a finite number above 0")]
    Time {
        /// The time.
        found: f64,
    },
    /// A fixed value that is not finite.
    #[error("the value of place {place} is {value}: expected a finite number")]
    Fixed {
        /// The place.
        place: u32,
        /// The value.
        value: f64,
    },
    /// Rounds that do not come to an end.
    #[error(
        "no solution to {tolerance:e} in {rounds} rounds: {residual:e} is left; the points may hang together by a thread"
    )]
    Unsolved {
        /// The residual wanted.
        tolerance: f64,
        /// Rounds that were made.
        rounds: usize,
        /// The residual left.
        residual: f64,
    },
    /// Neighbours cannot be listed.
    #[error(transparent)]
    Cloud(#[from] CloudError),
}
