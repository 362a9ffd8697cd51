//! Why a mesh cannot be cut as asked.

use asphera_geometry::Rejection;
use thiserror::Error;

/// Why a mesh cannot be cut as asked.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum SectionError {
    /// A place cannot be one of the mesh.
    #[error("{what} ({}, {}) mm: {rejection}", at_mm[0], at_mm[1])]
    Place {
        /// Which place.
        what: &'static str,
        /// Its x and y in mm.
        at_mm: [f64; 2],
        /// What is wrong with it.
        rejection: Rejection,
    },
    /// A segment that starts where it ends.
    #[error("the section starts and ends at ({}, {}) mm: it has no length", at_mm[0], at_mm[1])]
    ZeroLength {
        /// Where: x and y in mm.
        at_mm: [f64; 2],
    },
    /// A radius that is none.
    #[error("radius {radius_mm} mm: expected a number above 1e-40 and up to 1e12")]
    Radius {
        /// The radius in mm.
        radius_mm: f64,
    },
    /// An angle that is not finite, or of so many turns that its rounding would show.
    #[error("angle {angle_rad} rad: expected a number from -1000 to 1000")]
    Angle {
        /// The angle in rad.
        angle_rad: f64,
    },
    /// A limit for gaps that is none.
    #[error("gap limit {limit_mm} mm: expected a finite number above 0")]
    GapLimit {
        /// The limit in mm.
        limit_mm: f64,
    },
    /// A plane without a direction, or not finite, or out of range.
    #[error(
        "plane with normal ({}, {}, {}) and offset {offset_mm} mm: expected a finite normal with a size from 1e-100 to 1e100, and an offset up to 1e12 of that size",
        normal[0], normal[1], normal[2]
    )]
    Plane {
        /// The normal as given.
        normal: [f64; 3],
        /// The offset as given.
        offset_mm: f64,
    },
}
