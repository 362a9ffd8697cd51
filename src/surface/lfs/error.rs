//! What can be wrong with the arguments of a local feature size.

use thiserror::Error;

/// An argument from which no local feature size can be had.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum LfsError {
    /// A figure is not what it must be.
    #[error("{name} is {found}, but must be {allowed}")]
    Argument {
        /// Its name, unit included.
        name: &'static str,
        /// Value found.
        found: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A coordinate of a point is not finite or above [`RANGE_MM`](asphera_geometry::RANGE_MM).
    #[error("point {index} is ({x}, {y}, {z}) mm, but coordinates must be within ±1e12 mm")]
    Point {
        /// Its place in the list given.
        index: usize,
        /// Its coordinate x in mm.
        x: f64,
        /// Its coordinate y in mm.
        y: f64,
        /// Its coordinate z in mm.
        z: f64,
    },
    /// A normal is not finite, or so short that it has no direction.
    #[error("normal {index} is ({x}, {y}, {z}), but must be finite and not zero")]
    Normal {
        /// Its place in the list given, or the number of its point.
        index: usize,
        /// Its component x.
        x: f64,
        /// Its component y.
        y: f64,
        /// Its component z.
        z: f64,
    },
    /// Not every point came with a normal, or with a word that it has none.
    #[error("{points} points came with {normals} normals, but there must be one for each")]
    Lengths {
        /// How many points.
        points: usize,
        /// How many normals.
        normals: usize,
    },
    /// More points than can be numbered.
    #[error("{found} points are more than the 4294967294 that can be numbered")]
    TooMany {
        /// How many there would be.
        found: usize,
    },
    /// A raster with more places than are worth waiting for.
    #[error("{found} samples are more than the {most} that are allowed")]
    Samples {
        /// How many there would be.
        found: f64,
        /// How many are allowed.
        most: f64,
    },
    /// A nominal has no finite height, slope or second derivative in its own domain.
    #[error("the nominal is not finite at ({x:?}, {y:?}) mm, within its domain")]
    Nominal {
        /// Coordinate x in mm.
        x: f64,
        /// Coordinate y in mm.
        y: f64,
    },
    /// Two bounds that no value can keep.
    #[error(
        "{lower_mm} mm to {upper_mm} mm are no bounds: the lower must be at least zero and not above the upper"
    )]
    Bounds {
        /// The lower bound in mm.
        lower_mm: f64,
        /// The upper bound in mm.
        upper_mm: f64,
    },
}

/// The figure, if it is finite and not negative.
pub(super) fn not_negative(name: &'static str, found: f64) -> Result<f64, LfsError> {
    if found.is_finite() && found >= 0.0 {
        Ok(found)
    } else {
        Err(LfsError::Argument { name, found, allowed: "finite and not negative" })
    }
}

/// The figure, if it is finite and above zero.
pub(super) fn positive(name: &'static str, found: f64) -> Result<f64, LfsError> {
    if found.is_finite() && found > 0.0 {
        Ok(found)
    } else {
        Err(LfsError::Argument { name, found, allowed: "finite and above zero" })
    }
}
