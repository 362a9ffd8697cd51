//! A box in the plane.

/// A box in the plane with sides along the axes, in mm; its boundary belongs to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundsMm {
    /// The smallest x and the smallest y.
    pub low: [f64; 2],
    /// The largest x and the largest y.
    pub high: [f64; 2],
}
