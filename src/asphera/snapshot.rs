//! What a person or a machine wants to know now: the only thing `publish` sees.

use serde::Serialize;

use crate::report::{
    FeatureFigures, FormFigures, MeshFigures, Points, SamplingFigures, SessionFigures, Verdict,
};

/// Version of the snapshot's layout.
pub const FORMAT: &str = "asphera.snapshot/1";

/// The state of a station at one moment.
#[derive(Clone, Debug, Serialize)]
pub struct Snapshot {
    /// [`FORMAT`].
    pub format: &'static str,
    /// Grows by one with every snapshot; a gap means that a slow reader missed some.
    pub sequence: u64,
    /// Name of the station.
    pub station: String,
    /// What the station is doing.
    pub state: State,
    /// Seconds since the session started; 0 without one.
    pub elapsed_s: f64,
    /// The session, while there is one and after it ended.
    pub session: Option<SessionFigures>,
    /// How far the scan is.
    pub progress: Progress,
    /// What became of the points.
    pub points: Points,
    /// The mesh.
    pub mesh: MeshFigures,
    /// The sampling.
    pub sampling: SamplingFigures,
    /// Defects, and which way the surface bends: once the session ended.
    #[serde(flatten)]
    pub features: FeatureFigures,
    /// The form, as soon as a fit can be made.
    pub form: Option<FormFigures>,
    /// Pass, fail or undecided. Undecided until the session ended.
    pub verdict: Verdict,
    /// Mean deviation over the aperture.
    pub map: Option<Map>,
    /// Which maps of the sampling there are to be had; they are too large to come with every snapshot.
    pub maps: Option<MapsState>,
    /// PV and RMS against points, from the first fit to now; thinned to a bounded number of rows.
    pub convergence: Convergence,
    /// Every link.
    pub links: Vec<LinkState>,
}

/// What the station is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum State {
    /// No session.
    Idle,
    /// A session runs.
    Measuring,
    /// The last point has landed; the final fit is being made.
    Finishing,
    /// The session ended and the report stands.
    Complete,
    /// The session ended without a report; the verdict's reasons say why.
    Failed,
}

/// How far the scan is.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Progress {
    /// Points expected, where the configuration says.
    pub expected_points: Option<u64>,
    /// 0 to 1, where it is known.
    pub fraction: Option<f64>,
    /// Points a second over the last second.
    pub rate_hz: f64,
    /// Seconds left at that rate by the scan plan, where it is known.
    pub eta_s: Option<f64>,
    /// Seconds left at that rate until all of the aperture is covered, as densely as the points lie so far, where
    /// that is known; as of `sampling.as_of_points`.
    pub eta_coverage_s: Option<f64>,
    /// Points received but not yet in the mesh.
    pub pending_points: u64,
}

/// Mean deviation over the aperture on a regular grid in the part frame.
#[derive(Clone, Debug, Serialize)]
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

/// PV and RMS against points: three columns of equal length.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Convergence {
    /// Points in the fit.
    pub points: Vec<u64>,
    /// PV in nm.
    pub pv_nm: Vec<f64>,
    /// RMS in nm.
    pub rms_nm: Vec<f64>,
}

/// One link as an operator wants to see it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinkState {
    /// Name in the configuration.
    pub name: String,
    /// `serial`, `tcp`, `slcan-serial`, `slcan-tcp`, `socketcan`, `replay`.
    pub kind: String,
    /// Port or address.
    pub address: String,
    /// Devices on it.
    pub devices: Vec<String>,
    /// Where it stands.
    pub state: Connection,
    /// Readings a second over the last second.
    pub rate_hz: f64,
    /// Readings since the start.
    pub readings: u64,
    /// Bytes since the start.
    pub received_bytes: u64,
    /// Faults, discarded runs of bytes and flagged readings since the start.
    pub errors: u64,
    /// Readings lost, as count gaps tell.
    pub lost: u64,
    /// Times it was opened again after a loss.
    pub reconnects: u64,
    /// Seconds since the last reading; `None` before the first.
    pub age_s: Option<f64>,
    /// The last trouble, in words.
    pub last_error: Option<String>,
}

/// Where a link stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Connection {
    /// Being opened, or waiting to be opened again.
    Opening,
    /// Open; no valid frame yet.
    Waiting,
    /// A valid frame has arrived.
    Connected,
    /// Connected, but silent for longer than it should be: shown values are old.
    Stale,
    /// Closed, and not to be opened again.
    Closed,
}
