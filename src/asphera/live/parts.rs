//! The parts of the running session: a part that ended is measured in a thread of its own while the next one is scanned.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use asphera_geometry::PointMm;
use asphera_graph::RunningPart;
use asphera_link::Nanos;
use asphera_report::parts::SessionParts;
use tokio::sync::watch;
use tracing::error;

use super::worker::PERIOD;
use crate::parts::{Judged, PartsPlan, RunningParts};
use crate::station::Point;

/// Finds the parts of points and has those that ended measured, one after the other.
pub(super) struct Parts {
    plan: Arc<PartsPlan>,
    running: RunningParts,
    jobs: Sender<RunningPart>,
    done: Receiver<Judged>,
    thread: JoinHandle<()>,
    newest: watch::Sender<Option<Arc<SessionParts>>>,
    has_news: bool,
    shown_at: Nanos,
}

impl Parts {
    pub(super) fn start(
        plan: PartsPlan,
        newest: watch::Sender<Option<Arc<SessionParts>>>,
    ) -> std::io::Result<Parts> {
        let plan = Arc::new(plan);
        // Not bounded: what lies in it are the points of parts, which the scan has given already.
        let (jobs, work) = channel::<RunningPart>();
        let (finished, done) = channel();
        let judging = plan.clone();
        let thread = std::thread::Builder::new().name("parts".to_owned()).spawn(move || {
            // In the common pool the mesh would wait for a part.
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().ok();
            while let Ok(part) = work.recv() {
                let judged = match &pool {
                    Some(pool) => pool.install(|| judging.judge(&part)),
                    None => judging.judge(&part),
                };
                if finished.send(judged).is_err() {
                    return;
                }
            }
        })?;
        let running = RunningParts::new(&plan);
        Ok(Parts {
            plan,
            running,
            jobs,
            done,
            thread,
            newest,
            has_news: false,
            shown_at: Nanos::ZERO,
        })
    }

    /// Whether all points together have no form.
    pub(super) fn has_no_whole(&self) -> bool {
        self.plan.has_no_whole
    }

    pub(super) fn take(&mut self, points: &[Point]) {
        let good = points.iter().filter(|point| point.is_good());
        let places: Vec<PointMm> = good.map(|point| point.position_mm).collect();
        let ended = self.running.take(&places);
        self.has_news |= !places.is_empty();
        self.hand_over(ended);
    }

    /// Shows what is known, where that changed; as often as running figures at most.
    pub(super) fn keep_up(&mut self, now: Nanos) {
        while let Ok(judged) = self.done.try_recv() {
            self.running.add(judged);
            self.has_news = true;
        }
        if self.has_news && now.since(self.shown_at) >= PERIOD {
            (self.has_news, self.shown_at) = (false, now);
            self.newest.send_replace(Some(Arc::new(self.running.found())));
        }
    }

    /// Ends the scan; the parts that are left are measured meanwhile.
    pub(super) fn finish(mut self) -> FinalParts {
        let ended = self.running.finish();
        self.hand_over(ended);
        FinalParts(self)
    }

    fn hand_over(&mut self, ended: Vec<RunningPart>) {
        for part in ended {
            // The thread ends with the channel, not before; a part that it cannot take stays waiting.
            let _ = self.jobs.send(part);
        }
    }
}

/// The parts of a session whose points are all there.
pub(super) struct FinalParts(Parts);

impl FinalParts {
    /// Waits for the last part. Parts that could not be measured count as waiting.
    pub(super) fn wait(self) -> (Arc<PartsPlan>, SessionParts) {
        let Parts { plan, mut running, jobs, done, thread, .. } = self.0;
        drop(jobs);
        done.into_iter().for_each(|judged| running.add(judged));
        if thread.join().is_err() {
            error!("parts could not be measured: their thread broke off");
        }
        (plan, running.found())
    }
}
