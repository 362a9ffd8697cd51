//! Drawings in the plane: lines of SVG and DXF files as cubic Bézier curves in mm.

mod affine;
mod arc;
mod dxf;
mod path;
mod style;
mod svg;
mod viewport;

use std::collections::BTreeMap;

pub use dxf::{read as read_dxf, read_and_count as read_dxf_and_count};
pub use svg::{read as read_svg, read_and_count as read_svg_and_count};

/// How many elements were left out, by their names; those of lines that are not shown are called `circle not shown`.
pub type LeftOut = BTreeMap<String, usize>;

/// Counts an element that is not shown.
fn count_hidden(left_out: &mut LeftOut, name: &str) {
    *left_out.entry(format!("{name} not shown")).or_default() += 1;
}

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
    pub fn through(corners: &[PlaceMm], closed: bool) -> Option<DrawnLine> {
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

    /// Corners of a polygon that runs no farther from the line than `within_mm`; of a closed line the first is not repeated.
    ///
    /// A piece is cut into equal steps of its parameter: a chord of a step 1/n is at most M/8n² off, M the largest second
    /// derivative, which is six times the largest second difference of the control points.
    pub fn corners(&self, within_mm: f64) -> Vec<PlaceMm> {
        let mut corners = Vec::new();
        for piece in &self.pieces {
            let [a, b, c, d] = *piece;
            let bend = |p: PlaceMm, q: PlaceMm, r: PlaceMm| {
                (p[0] - 2.0 * q[0] + r[0]).hypot(p[1] - 2.0 * q[1] + r[1])
            };
            let largest_mm = 6.0 * bend(a, b, c).max(bend(b, c, d));
            let count = (largest_mm / (8.0 * within_mm)).sqrt().ceil().clamp(1.0, MOST_STEPS);
            for step in 0..count as usize {
                let t = step as f64 / count;
                let s = 1.0 - t;
                let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
                corners.push([0, 1].map(|axis| (0..4).map(|k| weights[k] * piece[k][axis]).sum()));
            }
        }
        if let Some(last) = self.pieces.last().filter(|_| !self.closed) {
            corners.push(last[3]);
        }
        corners
    }

    /// The line with every control point changed.
    fn mapped(self, change: impl Fn(PlaceMm) -> PlaceMm) -> DrawnLine {
        let pieces = self.pieces.into_iter().map(|piece| piece.map(&change)).collect();
        DrawnLine { pieces, ..self }
    }
}

/// Steps of a piece at most, however close the polygon is asked for.
const MOST_STEPS: f64 = 10_000.0;

/// A straight piece.
fn straight(p: PlaceMm, q: PlaceMm) -> [PlaceMm; 4] {
    let at = |share: f64| [p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])];
    [p, at(1.0 / 3.0), at(2.0 / 3.0), q]
}

#[cfg(test)]
mod tests;
