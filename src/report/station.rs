//! What a front asks of a station.

use std::pin::Pin;
use std::sync::Arc;

use serde::Serialize;

use crate::contour::SessionContour;
use crate::parts::SessionParts;
use crate::{
    Cut, FormViewAnswer, Label, Report, ResultFile, SamplingMaps, SectionRequest, SessionFigures,
    SliceAnswer, SliceRequest, Snapshot, Status, Term, VolumeView,
};

/// An answer to come.
pub type Answer<'a, T> = Pin<Box<dyn Future<Output = T> + Send + 'a>>;

/// A station as a front sees it. Every method may be called at any time from any task.
pub trait LiveStation: Send + Sync + 'static {
    /// The newest snapshot.
    fn snapshot(&self) -> Arc<Snapshot>;

    /// The first snapshot whose number is not `sequence`: at once where the newest one is another. `None` when the station
    /// ends. Dropping the answer costs nothing.
    fn snapshot_after(&self, sequence: u64) -> Answer<'_, Option<Arc<Snapshot>>>;

    /// The mesh as a PLY file, in mm; `None` while no point has landed. At most one runs at a time.
    fn mesh_ply(&self) -> Answer<'_, Option<Vec<u8>>>;

    /// The newest maps of the sampling; `None` while there are none. At most one runs at a time.
    fn maps(&self) -> Answer<'_, Option<Arc<SamplingMaps>>>;

    /// The newest contour of the session; `None` while there is none.
    fn contour(&self) -> Answer<'_, Option<Arc<SessionContour>>>;
    /// The parts of the session that ended up to now; `None` where none are asked for.
    fn parts(&self) -> Answer<'_, Option<Arc<SessionParts>>>;

    /// The volume that was measured; `None` of a station, which measures points.
    fn volume(&self) -> Answer<'_, Option<Arc<VolumeView>>> {
        Box::pin(std::future::ready(None))
    }

    /// A slice of that volume. At most one runs at a time.
    fn volume_slice(&self, _request: SliceRequest) -> Answer<'_, SliceAnswer> {
        Box::pin(std::future::ready(None))
    }

    /// A section of the mesh as it is now.
    fn section(&self, request: SectionRequest) -> Answer<'_, Cut>;

    /// The deviation as it is now without `terms`; `None` while there is none. At most one runs at a time.
    fn without(&self, terms: Vec<Term>) -> Answer<'_, FormViewAnswer>;

    /// Places to measure next, as comma-separated values; `None` while nothing is known of the sampling. At
    /// most one runs at a time.
    fn waypoints(&self) -> Answer<'_, Option<Waypoints>>;

    /// The report of the last session; `None` before the first one ended.
    fn report(&self) -> Option<Arc<Report>>;

    /// The sessions that lie in the folder of the recordings, the newest first.
    fn sessions(&self) -> Answer<'_, Vec<SessionEntry>>;

    /// A result file of one of them; `None` where there is none.
    fn session_file(&self, id: String, of: ResultFile) -> Answer<'_, Option<SessionFile>>;

    /// Starts a session of a part. Runs to its end even where the client hangs up.
    fn start(&self, label: Label) -> Answer<'_, Result<(), ControlError>>;

    /// Stops the session. Runs to its end even where the client hangs up.
    fn stop(&self) -> Answer<'_, Result<(), ControlError>>;

    /// Arms the scan that the station drives: from now on it moves axes.
    fn arm_scan(&self) -> Answer<'_, Result<(), ControlError>> {
        Box::pin(std::future::ready(Err(ControlError::no_scan())))
    }

    /// Halts every axis and disarms the scan. The halt is sent before this returns its answer, which may take longer.
    fn halt_scan(&self) -> Answer<'_, Result<(), ControlError>> {
        Box::pin(std::future::ready(Err(ControlError::no_scan())))
    }
}

/// A session as a list shows it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SessionEntry {
    /// Name of its folder.
    pub id: String,
    /// When it began, RFC 3339, UTC; `None` where no `report.json` says so.
    pub started: Option<String>,
    /// Part and operator.
    pub label: Label,
    /// Why it ended; `None` where no `report.json` says so.
    pub ended: Option<String>,
    /// The verdict.
    pub verdict: Option<Status>,
    /// Points in the fit.
    pub points: Option<u64>,
    /// PV in nm.
    pub pv_nm: Option<f64>,
    /// RMS in nm.
    pub rms_nm: Option<f64>,
    /// The result files that are there.
    pub files: Vec<&'static str>,
}

/// A result file of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionFile {
    /// Content.
    pub bytes: Vec<u8>,
    /// The session, where its `report.json` tells.
    pub session: Option<SessionFigures>,
}

/// Places to measure, as text.
#[derive(Clone, Debug, PartialEq)]
pub struct Waypoints {
    /// Comma-separated values, one place a line, under the names `region,x_mm,y_mm,z_mm`: regions from 1 on,
    /// places in the measured frame.
    pub csv: String,
    /// How many places there are.
    pub places: usize,
    /// How many regions they are for.
    pub regions: usize,
    /// How many regions are left out, since places would be more than a bound or no spacing is known.
    pub left_out: usize,
}

/// Why a session could not be started or stopped.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct ControlError {
    /// Whether the station's state forbids it (answered with 409) rather than a fault (500).
    pub conflict: bool,
    /// Obstacle, in words for the operator.
    pub message: String,
}

impl ControlError {
    /// The answer of a station that drives no scan.
    fn no_scan() -> ControlError {
        let message =
            "this station drives no scan: its configuration has no [scan.plan], and no device has a program".to_owned();
        ControlError { conflict: true, message }
    }
}
