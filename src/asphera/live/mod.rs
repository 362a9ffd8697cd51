//! A station at work: ports, clock, recorder and pipeline around the core.
//!
//! Three threads of work, joined by channels: the links read and write ports; `core` holds the core,
//! decides the order of everything and hands it to the recorder; the pipeline makes figures. What a
//! person sees is put together in `view`.

mod backlog;
mod brake;
mod contour;
mod core;
mod evaluations;
mod lock;
mod outputs;
mod overflow;
mod parts;
mod recording;
mod view;
mod worker;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use asphera_link::Command;
use asphera_report::contour::SessionContour;
use asphera_report::parts::SessionParts;
use asphera_report::{
    Answer, ControlError, Cut, FormViewAnswer, Label, LiveStation, Outputs, Report, ResultFile,
    SamplingMaps, SectionRequest, SessionEntry, SessionFile, Snapshot, Term, Waypoints,
};
use thiserror::Error;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::task::JoinHandle;

use crate::config::Config;
use crate::session::RecordError;
use crate::sessions::{file, list};
use crate::station::{ArmError, AssembleError, ScanOrder};
use asphera_measure::{Measurement, Next};
use brake::Brake;

/// A finished session.
#[derive(Debug)]
pub struct Finished {
    /// All figures, mesh and map.
    pub measurement: Measurement,
    /// Where the recording is; `None` where recording failed.
    pub recording: Option<PathBuf>,
}

/// A session of which all is done: its figures, and the files beside its recording.
#[derive(Debug)]
pub struct Closed {
    /// The session.
    pub finished: Arc<Finished>,
    /// The result files that `[output]` asked for.
    pub outputs: Outputs,
}

/// Why a station cannot go on.
#[derive(Debug, Error)]
pub enum StationError {
    /// A driver refused its settings.
    #[error(transparent)]
    Assemble(#[from] AssembleError),
    /// The recording could not be begun.
    #[error("cannot record to {folder}")]
    Record {
        /// Where recordings go.
        folder: String,
        /// Why.
        source: RecordError,
    },
    /// Another station records into the same folder.
    #[error(
        "the folder of the recordings {folder} is in use by {holder}: stop that, or record elsewhere: another [session] dir (--out of demo)"
    )]
    Shared {
        /// Where recordings go.
        folder: String,
        /// Who has it.
        holder: String,
    },
    /// The folder of the recordings cannot be made.
    #[error("cannot make the folder {folder}")]
    Folder {
        /// Which.
        folder: String,
        /// Why.
        source: std::io::Error,
    },
    /// There was no random number for the session's name.
    #[error("the system gave no random number: {0}")]
    Random(getrandom::Error),
    /// The machine's calibration is out of date, or the host's clock is.
    #[error("{0}")]
    Calibration(String),
    /// A session is running already.
    #[error("a session is running; stop it first")]
    Running,
    /// No session is running.
    #[error("no session is running")]
    NotRunning,
    /// The scan cannot be armed.
    #[error(transparent)]
    Arm(#[from] ArmError),
    /// The figures could not be made.
    #[error("the figures could not be made; what was received is in {}", place(recording.as_deref()))]
    Pipeline {
        /// Where the recording is, if there is one.
        recording: Option<PathBuf>,
    },
    /// The station has ended.
    #[error("the station has ended")]
    Ended,
}

/// Fails where another station records into a folder.
///
/// # Errors
///
/// [`StationError::Shared`].
pub fn check_unshared(folder: &Path, station: &str) -> Result<(), StationError> {
    lock::Lock::take(folder, station).map(drop)
}

/// A running station. It ends when the handle is dropped.
pub struct Station {
    handle: Handle,
    closed: mpsc::Receiver<Result<Closed, StationError>>,
    commands_running: watch::Receiver<usize>,
    task: JoinHandle<()>,
}

/// Handle by which others ask a running station.
#[derive(Clone)]
pub struct Handle {
    control: mpsc::Sender<Control>,
    snapshots: watch::Receiver<Arc<Snapshot>>,
    report: watch::Receiver<Option<Arc<Report>>>,
    beats: watch::Receiver<u64>,
    recordings: Arc<Path>,
    brake: Brake,
}

/// Request to a station.
enum Control {
    Watch,
    Start(Label, oneshot::Sender<Result<(), StationError>>),
    Stop(oneshot::Sender<Result<(), StationError>>),
    Abandon(oneshot::Sender<Option<PathBuf>>),
    Scan(ScanOrder, oneshot::Sender<Result<(), StationError>>),
    Asked(Asked),
}

/// Question to its mesh. A reply that is dropped counts as none.
enum Asked {
    MeshPly(oneshot::Sender<Option<Vec<u8>>>),
    Maps(oneshot::Sender<Option<Arc<SamplingMaps>>>),
    Contour(oneshot::Sender<Option<Arc<SessionContour>>>),
    Parts(oneshot::Sender<Option<Arc<SessionParts>>>),
    Section(SectionRequest, oneshot::Sender<Cut>),
    Without(Vec<Term>, oneshot::Sender<FormViewAnswer>),
    Next(oneshot::Sender<Option<Next>>),
    /// Not answered: the pipeline stands until the other end is dropped.
    #[cfg(test)]
    Stand(std::sync::mpsc::Receiver<()>),
}

impl Station {
    /// Starts a station on the current tokio runtime. It opens nothing before it is told to: see
    /// [`Handle::watch_links`] and [`Handle::session`].
    ///
    /// # Errors
    ///
    /// When it cannot be set up.
    pub fn start(config: Config) -> Result<Station, StationError> {
        core::start(config)
    }

    /// For servers and signal handlers.
    pub fn handle(&self) -> Handle {
        self.handle.clone()
    }

    /// Waits until a session has ended and its result files are written.
    ///
    /// # Errors
    ///
    /// When its figures could not be made, or the station has ended.
    pub async fn closed(&mut self) -> Result<Closed, StationError> {
        self.closed.recv().await.unwrap_or(Err(StationError::Ended))
    }

    /// How many commands of `[output]` run.
    pub fn commands(&self) -> usize {
        *self.commands_running.borrow()
    }

    /// Waits until no command of `[output]` runs.
    pub async fn commands_ended(&mut self) {
        // A station that has ended runs none.
        let _ = self.commands_running.wait_for(|&running| running == 0).await;
    }
}

impl Drop for Station {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Handle {
    /// Starts or stops a session.
    ///
    /// # Errors
    ///
    /// When one is running already, or none is, or it cannot be recorded.
    pub async fn session(&self, command: Command) -> Result<(), StationError> {
        match command {
            Command::Start => self.begin(Label::default()).await,
            Command::Stop => self.told(Control::Stop).await,
        }
    }

    /// Starts a session of a part that is named.
    ///
    /// # Errors
    ///
    /// As [`Handle::session`].
    pub async fn begin(&self, label: Label) -> Result<(), StationError> {
        self.told(|reply| Control::Start(label, reply)).await
    }

    /// Arms the scan that the station drives, of the session that runs.
    ///
    /// # Errors
    ///
    /// When no session runs, there is no plan, or it is armed already.
    pub async fn arm_scan(&self) -> Result<(), StationError> {
        self.told(|reply| Control::Scan(ScanOrder::Arm, reply)).await
    }

    /// Halts every axis at once, then disarms the scan.
    ///
    /// # Errors
    ///
    /// When there is no plan, or the station has ended.
    pub async fn halt_scan(&self) -> Result<(), StationError> {
        self.brake.press();
        self.told(|reply| Control::Scan(ScanOrder::Halt, reply)).await
    }

    async fn told(
        &self,
        control: impl FnOnce(oneshot::Sender<Result<(), StationError>>) -> Control,
    ) -> Result<(), StationError> {
        let (reply, answer) = oneshot::channel();
        let sent = self.control.send(control(reply)).await;
        sent.map_err(|_| StationError::Ended)?;
        answer.await.map_err(|_| StationError::Ended)?
    }

    /// Gives up the final figures of a session that is ending: its recording is ended without them, and its folder given.
    /// `None` where no session is ending, or its recording is not complete.
    pub async fn abandon(&self) -> Option<PathBuf> {
        let (reply, folder) = oneshot::channel();
        self.control.send(Control::Abandon(reply)).await.ok()?;
        folder.await.ok()?
    }

    /// Where the session that runs is recorded, or the one that ended last.
    pub fn recording(&self) -> Option<PathBuf> {
        let snapshot = self.snapshots.borrow();
        let session = snapshot.session.as_ref()?;
        Some(self.recordings.join(&session.id))
    }

    /// Opens the links without a session, to show their state.
    pub async fn watch_links(&self) {
        // A station that has ended has nothing to show.
        let _ = self.control.send(Control::Watch).await;
    }

    /// `None` also where the station ends before it answers.
    async fn ask<T>(&self, ask: impl FnOnce(oneshot::Sender<Option<T>>) -> Asked) -> Option<T> {
        let (reply, answer) = oneshot::channel();
        self.control.send(Control::Asked(ask(reply))).await.ok()?;
        answer.await.ok()?
    }

    /// Counts on several times a second while the station gets on with its work: not where the pipeline hangs, nor where a disk
    /// or a link holds everything up.
    pub fn beats(&self) -> watch::Receiver<u64> {
        self.beats.clone()
    }

    /// The newest snapshot, and when there is a newer one.
    pub fn watch(&self) -> watch::Receiver<Arc<Snapshot>> {
        self.snapshots.clone()
    }
}

impl LiveStation for Handle {
    fn snapshot(&self) -> Arc<Snapshot> {
        Arc::clone(&self.snapshots.borrow())
    }

    fn snapshot_after(&self, sequence: u64) -> Answer<'_, Option<Arc<Snapshot>>> {
        let mut snapshots = self.snapshots.clone();
        Box::pin(async move {
            let newer = snapshots.wait_for(|snapshot| snapshot.sequence != sequence).await;
            newer.ok().map(|snapshot| Arc::clone(&snapshot))
        })
    }

    fn mesh_ply(&self) -> Answer<'_, Option<Vec<u8>>> {
        Box::pin(self.ask(Asked::MeshPly))
    }

    fn maps(&self) -> Answer<'_, Option<Arc<SamplingMaps>>> {
        Box::pin(self.ask(Asked::Maps))
    }

    fn contour(&self) -> Answer<'_, Option<Arc<SessionContour>>> {
        Box::pin(self.ask(Asked::Contour))
    }

    fn parts(&self) -> Answer<'_, Option<Arc<SessionParts>>> {
        Box::pin(self.ask(Asked::Parts))
    }

    fn section(&self, request: SectionRequest) -> Answer<'_, Cut> {
        Box::pin(self.ask(move |reply| Asked::Section(request, reply)))
    }

    fn without(&self, terms: Vec<Term>) -> Answer<'_, FormViewAnswer> {
        Box::pin(self.ask(move |reply| Asked::Without(terms, reply)))
    }

    fn waypoints(&self) -> Answer<'_, Option<Waypoints>> {
        Box::pin(async {
            let next = self.ask(Asked::Next).await?;
            // Up to 200,000 places are worth a thread of their own.
            tokio::task::spawn_blocking(move || next.waypoints()).await.ok()
        })
    }

    fn report(&self) -> Option<Arc<Report>> {
        self.report.borrow().clone()
    }

    fn sessions(&self) -> Answer<'_, Vec<SessionEntry>> {
        let recordings = Arc::clone(&self.recordings);
        Box::pin(async move {
            let listed = tokio::task::spawn_blocking(move || list(&recordings, LISTED));
            listed.await.unwrap_or_default()
        })
    }

    fn session_file(&self, id: String, of: ResultFile) -> Answer<'_, Option<SessionFile>> {
        let recordings = Arc::clone(&self.recordings);
        Box::pin(async move {
            let read = tokio::task::spawn_blocking(move || file(&recordings, &id, of));
            let (bytes, session) = read.await.ok()??;
            Some(SessionFile { bytes, session })
        })
    }

    fn start(&self, label: Label) -> Answer<'_, Result<(), ControlError>> {
        Box::pin(async { self.begin(label).await.map_err(control_error) })
    }

    fn stop(&self) -> Answer<'_, Result<(), ControlError>> {
        Box::pin(async { self.session(Command::Stop).await.map_err(control_error) })
    }

    fn arm_scan(&self) -> Answer<'_, Result<(), ControlError>> {
        Box::pin(async { Handle::arm_scan(self).await.map_err(control_error) })
    }

    fn halt_scan(&self) -> Answer<'_, Result<(), ControlError>> {
        Box::pin(async { Handle::halt_scan(self).await.map_err(control_error) })
    }
}

/// How many sessions are listed, the newest.
const LISTED: usize = 100;

fn control_error(error: StationError) -> ControlError {
    ControlError {
        conflict: matches!(
            error,
            StationError::Running
                | StationError::NotRunning
                | StationError::Calibration(_)
                | StationError::Arm(_)
        ),
        message: asphera_report::error_chain(&error),
    }
}

fn place(recording: Option<&Path>) -> String {
    recording.map_or_else(|| "no recording".to_owned(), |folder| folder.display().to_string())
}

#[cfg(test)]
mod tests;
