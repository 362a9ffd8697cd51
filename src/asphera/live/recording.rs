//! The thread that writes the recording.

use std::path::PathBuf;
use std::time::Duration;

use asphera_link::Nanos;
use tokio::runtime::Handle;
use tokio::sync::{mpsc, oneshot};
use tokio::time::timeout;
use tracing::error;

use crate::clock::Clock;
use crate::error_chain;
use crate::session::{Entry, Recorder, ResultsJson};

/// Hands entries to the recorder's thread.
pub(super) struct Recording {
    entries: mpsc::Sender<Job>,
    failure: tokio::sync::watch::Receiver<Option<String>>,
}

enum Job {
    Entry(Entry),
    Finish {
        at: Nanos,
        reason: String,
        results: Option<ResultsJson>,
        reply: oneshot::Sender<Option<PathBuf>>,
    },
}

impl Recording {
    /// Starts the thread. It ends when it has finished, or the recording is dropped.
    pub(super) fn start(recorder: Recorder, clock: Clock) -> std::io::Result<Recording> {
        let (entries, receiver) = mpsc::channel(QUEUE);
        let (failed, failure) = tokio::sync::watch::channel(None);
        let runtime = Handle::current();
        std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || run(recorder, clock, &runtime, receiver, &failed))?;
        Ok(Recording { entries, failure })
    }

    /// Why recording stopped, if it did.
    pub(super) fn failure(&self) -> Option<String> {
        self.failure.borrow().clone()
    }

    /// Hands over an entry; waits while the disk is behind, which holds the links back.
    pub(super) async fn append(&self, entry: Entry) {
        // The thread ends only after it was told to finish.
        let _ = self.entries.send(Job::Entry(entry)).await;
    }

    /// Ends the recording; gives its folder once everything is on the disk, or nothing if that failed.
    pub(super) async fn finish(
        &self,
        at: Nanos,
        reason: &str,
        results: Option<ResultsJson>,
    ) -> Option<PathBuf> {
        let (reply, folder) = oneshot::channel();
        let job = Job::Finish { at, reason: reason.to_owned(), results, reply };
        self.entries.send(job).await.ok()?;
        folder.await.ok()?
    }
}

fn run(
    mut recorder: Recorder,
    clock: Clock,
    runtime: &Handle,
    mut jobs: mpsc::Receiver<Job>,
    failed: &tokio::sync::watch::Sender<Option<String>>,
) {
    loop {
        let wait = recorder.poll_timeout().map_or(IDLE, |due| due.since(clock.now()));
        let job = runtime.block_on(async { timeout(wait, jobs.recv()).await });
        let result = match job {
            Ok(Some(Job::Entry(_))) if recorder.is_stopped() => Ok(()),
            Ok(Some(Job::Entry(entry))) => recorder.append(&entry),
            Ok(Some(Job::Finish { at, reason, results, reply })) => {
                let stopped = recorder.is_stopped();
                let folder = match recorder.finish(at, &reason, results.as_ref()) {
                    Ok(summary) if !stopped => Some(summary.folder),
                    Ok(_) => None,
                    Err(error) => {
                        error!(error = %error_chain(&error), "the recording could not be ended");
                        None
                    }
                };
                let _ = reply.send(folder);
                return;
            }
            Ok(None) => return,
            Err(_) if recorder.is_stopped() => Ok(()),
            Err(_) => recorder.tick(clock.now()),
        };
        if let Err(error) = result {
            let words = error_chain(&error);
            error!(error = %words, "recording stopped; the measurement goes on without it");
            failed.send_replace(Some(words));
        }
    }
}

const IDLE: Duration = Duration::from_millis(500);
/// Entries that may wait; each is at most one read of a port.
const QUEUE: usize = 4096;
