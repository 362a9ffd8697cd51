//! The state of a station at one moment.

use std::fmt;

use serde::Serialize;

use crate::contour::ContourState;
use crate::parts::PartsState;
use crate::{
    FeatureFigures, FormFigures, Map, MapsState, MeshFigures, Points, SamplingFigures, ScanFigures,
    SessionFigures, Verdict, VolumeState,
};

/// Version of the layout of [`Snapshot`].
pub const SNAPSHOT_FORMAT: &str = "asphera.snapshot/1";

/// The state of a station at one moment.
#[derive(Clone, Debug, Serialize)]
pub struct Snapshot {
    /// [`SNAPSHOT_FORMAT`].
    pub format: &'static str,
    /// Grows by one with every snapshot; a gap means that a slow reader missed some.
    pub sequence: u64,
    /// Name of the station.
    pub station: String,
    /// State of the station.
    pub state: State,
    /// Seconds since the session started; 0 without one.
    pub elapsed_s: f64,
    /// The session, while there is one and after it ended.
    pub session: Option<SessionFigures>,
    /// How far the scan is.
    pub progress: Progress,
    /// Counts of the points by their fate.
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
    /// Pass, fail or undecided. Undecided until the session ended; until then `outlook` says what is certain already.
    pub verdict: Verdict,
    /// Mean deviation over the aperture.
    pub map: Option<Map>,
    /// Which maps of the sampling there are to be had; they are too large to come with every snapshot.
    pub maps: Option<MapsState>,
    /// Which contour there is, where the configuration asks for one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contour: Option<ContourState>,
    /// Which parts there are, where the configuration asks for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parts: Option<PartsState>,
    /// The volume that was measured, where it was one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeState>,
    /// The scan that the station drives, where the configuration has a plan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scan: Option<ScanFigures>,
    /// PV and RMS against points, from the first fit to now; thinned to a bounded number of rows.
    pub convergence: Convergence,
    /// Files the session left in its folder, once that is written.
    pub outputs: Option<Outputs>,
    /// Every link.
    pub links: Vec<LinkState>,
}

/// Files that a session left in its folder.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Outputs {
    /// Names of the files.
    pub files: Vec<String>,
    /// Why there are not all that were asked for.
    pub problem: Option<String>,
}

/// State of the station.
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
    /// Points that are recorded and wait to be processed; `None` where processing keeps up.
    pub backlog: Option<Backlog>,
    /// Reason why a session has no reading yet; `None` once the scan has begun.
    pub waiting: Option<Waiting>,
}

/// Delay of the processing: points that are recorded and not worked on yet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Backlog {
    /// Points that wait.
    pub waiting_points: u64,
    /// Seconds since the first of them was read.
    pub behind_s: f64,
}

impl fmt::Display for Backlog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Backlog { waiting_points, behind_s } = self;
        write!(
            f,
            "processing is {behind_s:.1} s behind: {waiting_points} points are recorded and wait"
        )
    }
}

/// Reason why a session has no reading yet.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "for", rename_all = "snake_case")]
pub enum Waiting {
    /// Devices that are not there, or not set up yet.
    Devices {
        /// The links they are on.
        links: Vec<String>,
        /// Seconds until the session ends without them; absent while a link is not open.
        ends_in_s: Option<f64>,
    },
    /// Every device is ready: the first trigger.
    FirstTrigger {
        /// Seconds until the session ends without one.
        ends_in_s: Option<f64>,
    },
}

/// PV and RMS against points: columns of equal length.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Convergence {
    /// Points in the fit.
    pub points: Vec<u64>,
    /// PV in nm.
    pub pv_nm: Vec<f64>,
    /// Standard uncertainty (k = 1) of PV in nm; `None` where it is not known.
    pub pv_u_nm: Vec<Option<f64>>,
    /// RMS in nm.
    pub rms_nm: Vec<f64>,
    /// Standard uncertainty (k = 1) of RMS in nm; `None` where it is not known.
    pub rms_u_nm: Vec<Option<f64>>,
    /// Sources of the uncertainty of PV, or why it is not known.
    pub pv_u_basis: String,
    /// Sources of the uncertainty of RMS, or why it is not known.
    pub rms_u_basis: String,
}

impl Convergence {
    /// Adds PV and RMS of a fit to `points` points with their uncertainties, and what those are made of.
    pub fn push(
        &mut self,
        points: u64,
        [pv_nm, rms_nm]: [f64; 2],
        [pv_u_nm, rms_u_nm]: [Option<f64>; 2],
        [pv_u_basis, rms_u_basis]: [String; 2],
    ) {
        self.points.push(points);
        self.pv_nm.push(pv_nm);
        self.pv_u_nm.push(pv_u_nm);
        self.rms_nm.push(rms_nm);
        self.rms_u_nm.push(rms_u_nm);
        (self.pv_u_basis, self.rms_u_basis) = (pv_u_basis, rms_u_basis);
    }

    /// Drops every other row: the shape of the curve stays.
    pub fn thin(&mut self) {
        thin(&mut self.points);
        thin(&mut self.pv_nm);
        thin(&mut self.pv_u_nm);
        thin(&mut self.rms_nm);
        thin(&mut self.rms_u_nm);
    }
}

/// Keeps the first, the third, and so on.
fn thin<T: Copy>(column: &mut Vec<T>) {
    *column = column.iter().copied().step_by(2).collect();
}

/// One link as an operator wants to see it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LinkState {
    /// Name in the configuration.
    pub name: String,
    /// `serial`, `tcp`, `slcan-serial`, `slcan-tcp`, `socketcan`, `socketcand`, `candump`, `file`, `replay`.
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
