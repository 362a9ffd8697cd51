//! What the server asks of a station.

use std::sync::Arc;

use futures_util::future::BoxFuture;
use tokio::sync::watch;

use crate::pipeline::{FormViewAnswer, Waypoints};
use crate::report::{Label, Report, SessionFigures};
use crate::results::ResultFile;
use crate::section::{Cut, SectionRequest};
use crate::sessions::SessionEntry;
use crate::snapshot::{SamplingMaps, Snapshot, Term};

/// A station as the server sees it. Every method may be called at any time from any task.
pub trait Source: Send + Sync + 'static {
    /// A receiver of the newest snapshot. A closed channel ends the streams that watch it.
    fn snapshots(&self) -> watch::Receiver<Arc<Snapshot>>;

    /// The mesh as a PLY file, in mm; `None` while no point has landed. At most one runs at a time.
    fn mesh_ply(&self) -> BoxFuture<'_, Option<Vec<u8>>>;

    /// The newest maps of the sampling; `None` while there are none. At most one runs at a time.
    fn maps(&self) -> BoxFuture<'_, Option<Arc<SamplingMaps>>>;

    /// A section of the mesh as it is now.
    fn section(&self, request: SectionRequest) -> BoxFuture<'_, Cut>;

    /// The deviation as it is now without `terms`; `None` while there is none. At most one runs at a time.
    fn without(&self, terms: Vec<Term>) -> BoxFuture<'_, FormViewAnswer>;

    /// Places to measure next, as comma-separated values; `None` while nothing is known of the sampling. At
    /// most one runs at a time.
    fn waypoints(&self) -> BoxFuture<'_, Option<Waypoints>>;

    /// The report of the last session; `None` before the first one ended.
    fn report(&self) -> Option<Arc<Report>>;

    /// The sessions that lie in the folder of the recordings, the newest first.
    fn sessions(&self) -> BoxFuture<'_, Vec<SessionEntry>>;

    /// A result file of one of them; `None` where there is none.
    fn session_file(&self, id: String, of: ResultFile) -> BoxFuture<'_, Option<SessionFile>>;

    /// Starts a session of a part. Runs to its end even where the client hangs up.
    fn start(&self, label: Label) -> BoxFuture<'_, Result<(), ControlError>>;

    /// Stops the session. Runs to its end even where the client hangs up.
    fn stop(&self) -> BoxFuture<'_, Result<(), ControlError>>;
}

/// A result file of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionFile {
    /// What it holds.
    pub bytes: Vec<u8>,
    /// The session, where its `report.json` tells.
    pub session: Option<SessionFigures>,
}

/// Why a session could not be started or stopped.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct ControlError {
    /// Whether the station's state forbids it (answered with 409) rather than a fault (500).
    pub conflict: bool,
    /// What stands in the way, in words for the operator.
    pub message: String,
}
