//! The thread that writes the recording.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use asphera_link::Nanos;
use tokio::runtime::Handle;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::timeout;
use tracing::error;

use crate::clock::Clock;
use crate::session::{Entry, Recorder, ResultsJson};
use asphera_report::error_chain;

/// Hands entries to the recorder's thread.
pub(super) struct Recording {
    entries: mpsc::Sender<Job>,
    /// Why nothing is handed to the disk any more.
    failure: watch::Sender<Option<String>>,
    disk: Arc<Disk>,
    clock: Clock,
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

/// Data known of the disk beside its errors.
struct Disk {
    /// Time at which the call that runs began, or [`IDLE`].
    busy_since: AtomicU64,
}

impl Disk {
    fn hangs_for(&self, now: Nanos) -> Option<Duration> {
        let since = self.busy_since.load(Ordering::Relaxed);
        let hangs = (since != IDLE).then(|| now.since(Nanos::from_nanos(since)));
        hangs.filter(|&hangs| hangs >= HANGS)
    }
}

impl Recording {
    /// Starts the thread. It ends when it has finished, or the recording is dropped.
    pub(super) fn start(recorder: Recorder, clock: Clock) -> std::io::Result<Recording> {
        let (entries, receiver) = mpsc::channel(QUEUE);
        let (failure, _) = watch::channel(None);
        let disk = Arc::new(Disk { busy_since: AtomicU64::new(IDLE) });
        let runtime = Handle::current();
        let writer = Writer {
            recorder,
            clock: clock.clone(),
            disk: Arc::clone(&disk),
            failure: failure.clone(),
        };
        std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || writer.run(&runtime, receiver))?;
        Ok(Recording { entries, failure, disk, clock })
    }

    /// Why recording stopped for good, if it did.
    pub(super) fn stopped(&self) -> Option<String> {
        self.failure.borrow().clone()
    }

    /// The same, or that the disk has not answered for some time, which may pass.
    pub(super) fn trouble(&self) -> Option<String> {
        self.stopped().or_else(|| self.disk.hangs_for(self.clock.now()).map(unanswered))
    }

    /// Hands over an entry; waits while the disk is behind, which holds the links back. A disk that takes nothing
    /// at all for [`HANGS`] gets nothing any more: the measurement goes on without a recording.
    pub(super) async fn append(&self, entry: Entry) {
        if self.failure.borrow().is_some() {
            return;
        }
        // The thread ends only after it was told to finish, so that only time can run out.
        if timeout(HANGS, self.entries.send(Job::Entry(entry))).await.is_err() {
            self.give_up();
        }
    }

    /// Ends the recording once everything is on the disk, and gives its folder.
    ///
    /// # Errors
    ///
    /// Why the recording is not complete, in words: it stopped before, or the disk failed or gave no answer for [`HANGS`].
    pub(super) async fn finish(
        &self,
        at: Nanos,
        reason: &str,
        results: Option<ResultsJson>,
    ) -> Result<PathBuf, String> {
        let (reply, folder) = oneshot::channel();
        let job = Job::Finish { at, reason: reason.to_owned(), results, reply };
        let finished = timeout(HANGS, async {
            // A disk that was given up takes no more, though there may be room again.
            if self.failure.borrow().is_some() {
                return None;
            }
            self.entries.send(job).await.ok()?;
            folder.await.ok()?
        });
        match finished.await {
            Ok(Some(folder)) => Ok(folder),
            Ok(None) => Err(self.stopped().unwrap_or_else(|| "the recorder ended".to_owned())),
            Err(_) => {
                self.give_up();
                Err(self.stopped().unwrap_or_else(|| unanswered(HANGS)))
            }
        }
    }

    fn give_up(&self) {
        let hangs = self.disk.hangs_for(self.clock.now()).unwrap_or(HANGS);
        let words = unanswered(hangs);
        error!(error = %words, "recording stopped; the measurement goes on without it");
        self.failure.send_if_modified(|failure| {
            let first = failure.is_none();
            if first {
                *failure = Some(words);
            }
            first
        });
    }
}

fn unanswered(hangs: Duration) -> String {
    format!("the disk has not answered for {} s", hangs.as_secs())
}

/// What the thread has.
struct Writer {
    recorder: Recorder,
    clock: Clock,
    disk: Arc<Disk>,
    failure: watch::Sender<Option<String>>,
}

impl Writer {
    fn run(mut self, runtime: &Handle, mut jobs: mpsc::Receiver<Job>) {
        loop {
            let due = self.recorder.poll_timeout();
            let wait = due.map_or(PATIENCE, |due| due.since(self.clock.now()));
            let job = runtime.block_on(async { timeout(wait, jobs.recv()).await });
            self.disk.busy_since.store(self.clock.now().as_nanos(), Ordering::Relaxed);
            // What waited when the disk was given up is written still: it follows on what is there.
            let stopped = self.recorder.is_stopped();
            let result = match job {
                Ok(Some(Job::Finish { at, reason, results, reply })) => {
                    // Nobody waits any more where that took too long.
                    let _ = reply.send(self.finish(at, &reason, results.as_ref()));
                    return;
                }
                Ok(None) => return,
                _ if stopped => Ok(()),
                Ok(Some(Job::Entry(entry))) => self.recorder.append(&entry),
                Err(_) => self.recorder.tick(self.clock.now()),
            };
            self.disk.busy_since.store(IDLE, Ordering::Relaxed);
            if let Err(error) = result {
                let words = error_chain(&error);
                error!(error = %words, "recording stopped; the measurement goes on without it");
                self.failure.send_replace(Some(words));
            }
        }
    }

    /// The folder, if the recording is whole.
    fn finish(self, at: Nanos, reason: &str, results: Option<&ResultsJson>) -> Option<PathBuf> {
        let stopped = self.recorder.is_stopped();
        match self.recorder.finish(at, reason, results) {
            Ok(summary) => (!stopped).then_some(summary.folder),
            // Why it stopped was said when it did.
            Err(_) if stopped => None,
            Err(error) => {
                let words = error_chain(&error);
                error!(error = %words, "the recording could not be ended");
                self.failure.send_replace(Some(words));
                None
            }
        }
    }
}

/// How long a disk may take nothing before that is said; and then, with the queue full, before it is given up.
const HANGS: Duration = Duration::from_secs(3);
/// Stands for no call.
const IDLE: u64 = u64::MAX;
/// How long the thread waits for a job.
const PATIENCE: Duration = Duration::from_millis(500);
/// Entries that may wait, each at most one read of a port (16 KiB): those of a disk that gives no answer for some seconds.
const QUEUE: usize = 16_384;
