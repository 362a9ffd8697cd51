//! What a document asks of a finished measurement.

use crate::{Cut, Report, SectionRequest};

/// A finished measurement as a document draws it. Places lie in the plane of projection, mm: along z those are x and y of the
/// measured frame.
pub trait Measured {
    /// The figures.
    fn report(&self) -> &Report;

    /// The deviation on a grid along u and v, of no more nodes than a picture needs; `None` without a fit or without area.
    fn picture(&self) -> Option<Picture>;

    /// Where a place of the part frame lies, mm; `None` without a fit.
    fn on_plane(&self, part_mm: [f64; 3]) -> Option<[f64; 3]>;

    /// Smallest and largest u and v of the points, mm; `None` without a point.
    fn extent_mm(&self) -> Option<[[f64; 2]; 2]>;

    /// Smallest and largest u and v of the aperture as fitted, mm; `None` without a fit, and where every point counts.
    fn aperture_extent_mm(&self) -> Option<[[f64; 2]; 2]>;

    /// Whether a place lies in the aperture as fitted; not where every point counts.
    fn counts_at(&self, place_mm: [f64; 2]) -> bool;

    /// Cuts the surface; `None` without a point.
    fn section(&self, request: &SectionRequest) -> Cut;
}

/// The deviation at the nodes of a grid: columns along u, rows along v of the plane of projection.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns.
    pub nx: usize,
    /// Rows.
    pub ny: usize,
    /// Place of the first column, mm.
    pub x0_mm: f64,
    /// Place of the first row, mm.
    pub y0_mm: f64,
    /// From column to column, mm; positive.
    pub dx_mm: f64,
    /// From row to row, mm; positive.
    pub dy_mm: f64,
    /// Row after row, u fastest, nm; NaN where nothing was measured.
    pub values_nm: Vec<f64>,
}
