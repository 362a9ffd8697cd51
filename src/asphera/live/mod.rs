//! A station at work: ports, clock, recorder and pipeline around the core.
//!
//! Three threads of work, joined by channels: the links read and write ports; `core` holds the core,
//! decides the order of everything and hands it to the recorder; the pipeline makes figures. What a
//! person sees is put together in `view`.

mod core;
mod recording;
mod view;
mod worker;

use std::sync::Arc;

use asphera_link::Command;
use futures_util::future::BoxFuture;
use thiserror::Error;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::task::JoinHandle;

use crate::config::Config;
use crate::pipeline::Measurement;
use crate::publish::{ControlError, Source};
use crate::report::Report;
use crate::session::RecordError;
use crate::snapshot::Snapshot;
use crate::station::AssembleError;

/// A finished session.
#[derive(Debug)]
pub struct Finished {
    /// All figures, mesh and map.
    pub measurement: Measurement,
    /// Where the recording is; `None` where recording failed.
    pub recording: Option<std::path::PathBuf>,
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
    /// A session is running already.
    #[error("a session is running; stop it first")]
    Running,
    /// No session is running.
    #[error("no session is running")]
    NotRunning,
    /// The station has ended.
    #[error("the station has ended")]
    Ended,
}

/// A running station. It ends when the handle is dropped.
pub struct Station {
    handle: Handle,
    finished: mpsc::Receiver<Arc<Finished>>,
    task: JoinHandle<()>,
}

/// What others may ask of a running station.
#[derive(Clone)]
pub struct Handle {
    control: mpsc::Sender<Control>,
    snapshots: watch::Receiver<Arc<Snapshot>>,
    report: watch::Receiver<Option<Arc<Report>>>,
}

/// What a station is asked to do.
enum Control {
    Session(Command, oneshot::Sender<Result<(), StationError>>),
    MeshPly(oneshot::Sender<Option<Vec<u8>>>),
}

impl Station {
    /// Starts a station on the current tokio runtime; with `autostart` its first session too.
    ///
    /// # Errors
    ///
    /// When it cannot be set up, or its first session cannot be recorded.
    pub fn start(config: Config, autostart: bool) -> Result<Station, StationError> {
        core::start(config, autostart)
    }

    /// For servers and signal handlers.
    pub fn handle(&self) -> Handle {
        self.handle.clone()
    }

    /// Waits for the end of a session. `None` when the station has ended.
    pub async fn finished(&mut self) -> Option<Arc<Finished>> {
        self.finished.recv().await
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
        let (reply, answer) = oneshot::channel();
        let sent = self.control.send(Control::Session(command, reply)).await;
        sent.map_err(|_| StationError::Ended)?;
        answer.await.map_err(|_| StationError::Ended)?
    }

    /// The newest snapshot, and when there is a newer one.
    pub fn watch(&self) -> watch::Receiver<Arc<Snapshot>> {
        self.snapshots.clone()
    }
}

impl Source for Handle {
    fn snapshots(&self) -> watch::Receiver<Arc<Snapshot>> {
        self.watch()
    }

    fn mesh_ply(&self) -> BoxFuture<'_, Option<Vec<u8>>> {
        Box::pin(async {
            let (reply, answer) = oneshot::channel();
            self.control.send(Control::MeshPly(reply)).await.ok()?;
            answer.await.ok()?
        })
    }

    fn report(&self) -> Option<Arc<Report>> {
        self.report.borrow().clone()
    }

    fn start(&self) -> BoxFuture<'_, Result<(), ControlError>> {
        Box::pin(async { self.session(Command::Start).await.map_err(control_error) })
    }

    fn stop(&self) -> BoxFuture<'_, Result<(), ControlError>> {
        Box::pin(async { self.session(Command::Stop).await.map_err(control_error) })
    }
}

fn control_error(error: StationError) -> ControlError {
    ControlError {
        conflict: matches!(error, StationError::Running | StationError::NotRunning),
        message: crate::error_chain(&error),
    }
}
