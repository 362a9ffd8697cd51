//! Samples of known curves: dense as a condition asks, disturbed as wanted. So every method can be tried without data.

mod border;
mod disturb;
mod fine;
mod step;

pub use self::border::borders;
pub use self::disturb::{Disturbance, Disturbed};
pub use self::fine::TrueCurve;
pub use self::step::Spacing;
use crate::PlaceMm;

/// A line of cubic Bézier curves, each by its four control points in mm.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierLine {
    /// The curves in order; each begins where the one before ended.
    pub pieces: Vec<[PlaceMm; 4]>,
    /// Whether the last one ends where the first begins.
    pub closed: bool,
}

impl BezierLine {
    /// The polygon through corners; if it is closed, with a side from the last to the first. Sides without length are left out.
    pub fn through(corners_mm: &[PlaceMm], closed: bool) -> BezierLine {
        let sides = corners_mm.len().saturating_sub(usize::from(!closed));
        let next = corners_mm.iter().cycle().skip(1);
        let sides = corners_mm.iter().zip(next).take(sides).filter(|(p, q)| p != q);
        let pieces = sides.map(|(&p, &q)| {
            let at = |share: f64| [0, 1].map(|axis| p[axis] + share * (q[axis] - p[axis]));
            [p, at(1.0 / 3.0), at(2.0 / 3.0), q]
        });
        BezierLine { pieces: pieces.collect(), closed }
    }
}

/// Samples of one line of a curve, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SampledLine {
    /// Their places in mm.
    pub places_mm: Vec<PlaceMm>,
    /// The normal of the curve at each.
    pub normals: Vec<[f64; 2]>,
    /// The local feature size at each in mm.
    pub lfs_mm: Vec<f64>,
    /// Whether the line is closed.
    pub closed: bool,
}
