//! Maps: of the deviation, of the sampling, and of the deviation with terms removed.

use std::fmt;

use serde::Serialize;

use crate::{HistogramFigures, PoseFigures, Refusal, Source};

/// Mean deviation over the aperture on a regular grid in the part frame.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Map {
    /// Columns.
    pub nx: usize,
    /// Rows.
    pub ny: usize,
    /// Centre of the first column in mm.
    pub x0_mm: f64,
    /// Centre of the first row (smallest y) in mm.
    pub y0_mm: f64,
    /// Column pitch in mm.
    pub dx_mm: f64,
    /// Row pitch in mm.
    pub dy_mm: f64,
    /// Row after row, x fastest, nm rounded to 0.1; `None` (null) where no point has landed.
    pub values_nm: Vec<Option<f64>>,
}

impl Map {
    /// The map of a part that lies level, in the measured frame: moved to where the middle of its first cell lies there.
    #[must_use]
    pub fn placed(self, pose: &PoseFigures) -> Map {
        let [x0_mm, y0_mm, _] = pose.to_measured([self.x0_mm, self.y0_mm, 0.0]);
        Map { x0_mm, y0_mm, ..self }
    }
}

/// Which maps of the sampling there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct MapsState {
    /// Grows with every change, from 1 in each session.
    pub version: u64,
    /// How many points had arrived when the mesh was looked at for them.
    pub as_of_points: u64,
}

/// Version of the layout of [`SamplingMaps`].
pub const MAPS_FORMAT: &str = "asphera.maps/1";

/// The sampling over the aperture, in the cells of the deviation map: the part frame. A triangle counts in
/// the cell of its centre and in every cell whose centre it holds.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SamplingMaps {
    /// [`MAPS_FORMAT`].
    pub format: &'static str,
    /// As in [`MapsState`].
    pub version: u64,
    /// How many points had arrived when the mesh was looked at.
    pub as_of_points: u64,
    /// Columns.
    pub nx: usize,
    /// Rows.
    pub ny: usize,
    /// Centre of the first column in mm.
    pub x0_mm: f64,
    /// Centre of the first row (smallest y) in mm.
    pub y0_mm: f64,
    /// Column pitch in mm.
    pub dx_mm: f64,
    /// Row pitch in mm.
    pub dy_mm: f64,
    /// The largest gap in each cell.
    pub gap_mm: MapLayer,
    /// The largest gap over local feature size in each cell.
    pub epsilon: MapLayer,
    /// How far noise turns the facets of each cell, root mean square, mean over their area.
    pub tilt_mrad: MapLayer,
    /// The share of each cell that is not sampled densely enough, 0 to 1.
    pub undersampled: MapLayer,
    /// The noise of the heights, one standard deviation.
    pub noise_sigma_nm: Option<f64>,
    /// Why it is not known.
    pub noise_unknown: Option<String>,
}

/// One value for each cell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapLayer {
    /// The largest value allowed.
    pub limit: Option<f64>,
    /// Row after row, x fastest, to four digits; `None` (null) where nothing is known.
    pub values: Vec<Option<f64>>,
}

/// Zernike terms that can be removed from a deviation that is looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Term {
    /// Fringe 1.
    Piston,
    /// Fringe 2 and 3.
    Tilt,
    /// Fringe 4.
    Power,
    /// Fringe 5 and 6, of third order.
    Astigmatism,
    /// Fringe 7 and 8, of third order.
    Coma,
    /// Fringe 9, of third order.
    Spherical,
}

impl Term {
    /// Every one.
    pub const ALL: [Term; 6] =
        [Term::Piston, Term::Tilt, Term::Power, Term::Astigmatism, Term::Coma, Term::Spherical];
}

impl fmt::Display for Term {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Term::Piston => "piston",
            Term::Tilt => "tilt",
            Term::Power => "power",
            Term::Astigmatism => "astigmatism",
            Term::Coma => "coma",
            Term::Spherical => "spherical",
        })
    }
}

/// The answer to a request for a view: the view, or why terms cannot be removed; `None` while there is no deviation.
pub type FormViewAnswer = Option<Result<FormView, Refusal>>;

/// Version of the layout of [`FormView`].
pub const FORM_VIEW_FORMAT: &str = "asphera.form-view/1";

/// The form deviation with Zernike terms taken out, to be looked at. All of it is of one moment. The verdict is
/// of the deviation as fitted, and never of this.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FormView {
    /// [`FORM_VIEW_FORMAT`].
    pub format: &'static str,
    /// Deviations that everything here is of: running figures are of the cells, each with as much weight as it has points,
    /// so that PV and RMS are those of the means of cells; final figures are of the points.
    pub source: Source,
    /// Points in the fit.
    pub as_of_points: u64,
    /// Whether these are running figures.
    pub provisional: bool,
    /// Terms removed: `piston`, `tilt`, `power`, `astigmatism`, `coma`, `spherical`.
    pub removed: Vec<String>,
    /// Each Fringe term that was taken out.
    pub terms: Vec<RemovedTerm>,
    /// Range of what is left.
    pub pv_nm: f64,
    /// Root mean square of what is left.
    pub rms_nm: f64,
    /// Mean of what is left in each cell.
    pub map: Map,
    /// How much of what is left there is.
    pub histogram: HistogramFigures,
}

/// A Fringe term that was taken out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RemovedTerm {
    /// Its Fringe number, from 1.
    pub index: u32,
    /// Its coefficient in nm of surface height, height 1 at the rim, fitted together with the others that were
    /// taken out and no more; `None` where the places do not tell it from lower ones.
    pub value_nm: Option<f64>,
}
