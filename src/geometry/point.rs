//! Measured points, and which of them the mesh admits.

use std::fmt;

/// A measured point: x, y, z in mm in the part's frame, z along the direction of projection.
pub type PointMm = [f64; 3];

/// A measured point with what is known of its height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Its place.
    pub at_mm: PointMm,
    /// Standard uncertainty of its z in the measured frame, mm; `None` where nothing was said of it.
    pub u_z_mm: Option<f64>,
}

impl From<PointMm> for Point {
    fn from(at_mm: PointMm) -> Point {
        Point { at_mm, u_z_mm: None }
    }
}

/// Number of a vertex: its index in the list of a mesh's points. It is never given again.
pub type VertexId = u32;

/// Largest admitted size of a coordinate in mm (one million kilometres).
///
/// Far above any part and any map projection in use, and low enough that every area, circumradius
/// and predicate of this crate stays finite.
pub const RANGE_MM: f64 = 1e12;

/// Coordinates smaller than this many mm are taken as zero.
///
/// The exact predicates need products of coordinates that do not underflow (see Shewchuk 1997,
/// doi:10.1007/PL00009321, section 5). Rounding moves a point by less than 1e-40 mm; the vertex
/// carries the rounded value, so that mesh and vertices agree exactly.
pub const TINY_MM: f64 = 1e-40;

/// Why a point was not admitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rejection {
    /// A coordinate is NaN or infinite.
    NotFinite,
    /// A coordinate is larger than [`RANGE_MM`].
    OutOfRange,
}

impl fmt::Display for Rejection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Rejection::NotFinite => "a coordinate is not finite",
            Rejection::OutOfRange => "a coordinate is larger than 1e12 mm",
        })
    }
}

/// The point as a vertex would carry it, or why it is not admitted.
#[inline]
pub fn admit(point: PointMm) -> Result<PointMm, Rejection> {
    if !point.iter().all(|coordinate| coordinate.is_finite()) {
        Err(Rejection::NotFinite)
    } else if point.iter().any(|coordinate| coordinate.abs() > RANGE_MM) {
        Err(Rejection::OutOfRange)
    } else {
        // Negative zero becomes zero as well: equal places then have equal bits.
        Ok(point.map(|coordinate| if coordinate.abs() < TINY_MM { 0.0 } else { coordinate }))
    }
}

/// Where the point lies in the plane of projection.
#[inline]
pub fn place(point: PointMm) -> [f64; 2] {
    [point[0], point[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn admits_the_range_and_rejects_the_rest() {
        assert_eq!(admit([RANGE_MM, -RANGE_MM, 0.0]), Ok([RANGE_MM, -RANGE_MM, 0.0]));
        assert_eq!(admit([RANGE_MM.next_up(), 0.0, 0.0]), Err(Rejection::OutOfRange));
        assert_eq!(admit([0.0, 0.0, -2e12]), Err(Rejection::OutOfRange));
        assert_eq!(admit([0.0, f64::NAN, 0.0]), Err(Rejection::NotFinite));
        assert_eq!(admit([0.0, 0.0, f64::NEG_INFINITY]), Err(Rejection::NotFinite));
    }

    #[test]
    fn takes_tiny_coordinates_as_zero() {
        let admitted = admit([-0.0, f64::MIN_POSITIVE / 4.0, -1e-41]).unwrap();
        assert_eq!(admitted.map(f64::to_bits), [0; 3]);
        assert_eq!(admit([TINY_MM, 1.0, 0.0]), Ok([TINY_MM, 1.0, 0.0]));
    }
}
