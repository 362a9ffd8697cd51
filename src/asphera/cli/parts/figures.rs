//! The figures of the parts of a scene as JSON writes them: `asphera.parts/1`.

use asphera_report::parts::PartReport;
use serde::Serialize;

/// The parts of a scene. Lengths are mm of the file's frame.
#[derive(Debug, Serialize)]
pub(super) struct PartsReport {
    pub(super) format: &'static str,
    pub(super) file: String,
    pub(super) points: u64,
    pub(super) spacing_mm: f64,
    pub(super) tau_mm: f64,
    /// Entries of the library; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) entries: Option<usize>,
    pub(super) parts: Vec<PartReport>,
    /// Pieces of too few points to be parts, and the points in them.
    pub(super) islands: usize,
    pub(super) island_points: u64,
    /// Points left over where touching parts were taken apart.
    #[serde(skip_serializing_if = "is_0")]
    pub(super) crumbs: u64,
}

fn is_0(count: &u64) -> bool {
    *count == 0
}
