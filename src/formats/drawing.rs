//! Drawings in the plane: lines of SVG and DXF files as cubic Bézier curves in mm.

mod affine;
mod arc;
mod dxf;
mod path;
mod svg;

pub use dxf::read as read_dxf;
pub use svg::read as read_svg;

/// A place in the plane: x to the right and y up, in mm.
pub type PlaceMm = [f64; 2];

/// A line of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnLine {
    /// Its pieces in order, cubic Bézier curves by their four control points in mm; each begins where the one before ended. Those of a
    /// straight line have their control points on it.
    pub pieces: Vec<[PlaceMm; 4]>,
    /// Whether it is closed; its last piece then ends where its first begins.
    pub closed: bool,
}

impl DrawnLine {
    /// The line through corners; if it is closed, with a side from the last to the first. None of fewer than two different places.
    fn through(corners: &[PlaceMm], closed: bool) -> Option<DrawnLine> {
        let mut corners = corners.to_vec();
        corners.dedup();
        if closed {
            corners.push(*corners.first()?);
            corners.dedup();
        }
        let pieces: Vec<[PlaceMm; 4]> =
            corners.windows(2).map(|pair| straight(pair[0], pair[1])).collect();
        (!pieces.is_empty()).then_some(DrawnLine { pieces, closed })
    }

    /// The line with every control point changed.
    fn mapped(self, change: impl Fn(PlaceMm) -> PlaceMm) -> DrawnLine {
        let pieces = self.pieces.into_iter().map(|piece| piece.map(&change)).collect();
        DrawnLine { pieces, ..self }
    }
}

/// A straight piece.
fn straight(p: PlaceMm, q: PlaceMm) -> [PlaceMm; 4] {
    let at = |share: f64| [p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])];
    [p, at(1.0 / 3.0), at(2.0 / 3.0), q]
}

#[cfg(test)]
mod tests;
