//! The thread that makes figures of points.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use asphera_report::contour::SessionContour;
use asphera_report::parts::SessionParts;
use asphera_report::{Cut, SectionRequest};
use tokio::runtime::Handle;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::timeout;

use super::contour::Contours;
use super::parts::Parts;
use crate::clock::Clock;
use crate::contour::ContourPlan;
use crate::parts::PartsPlan;
use crate::results;
use crate::station::Point;
use crate::weighing::Weighing;
use asphera_measure::Part;
use asphera_measure::{Along, Measurement, Next, Pipeline, RunningFigures};

/// Hands points to the pipeline's thread.
pub(super) struct Worker {
    work: mpsc::Sender<Work>,
    figures: watch::Receiver<Option<Arc<RunningFigures>>>,
    contour: watch::Receiver<Option<Arc<SessionContour>>>,
    parts: watch::Receiver<Option<Arc<SessionParts>>>,
    turns: Arc<AtomicU64>,
}

/// The pipeline's thread has ended before it was told to finish.
#[derive(Debug)]
pub(super) struct Died;

enum Work {
    Points(Vec<Point>),
    MeshPly(oneshot::Sender<Option<Vec<u8>>>),
    Section(SectionRequest, oneshot::Sender<Cut>),
    Next(oneshot::Sender<Option<Next>>),
    Assess(oneshot::Sender<Arc<RunningFigures>>),
    Finish(oneshot::Sender<Measurement>),
}

impl Worker {
    /// Starts the thread for one part, of which no more than so many points will come. It ends when it has finished, or the worker is dropped.
    pub(super) fn start(
        part: Part,
        along: Along,
        expected_points: Option<u64>,
        (contour, parts): (Option<ContourPlan>, Option<PartsPlan>),
        weighing: Weighing,
        clock: Clock,
    ) -> std::io::Result<Worker> {
        let (work, receiver) = mpsc::channel(QUEUE);
        let (sender, figures) = watch::channel(None);
        let runtime = Handle::current();
        let pipeline = Pipeline::along(part, along).expecting(expected_points);
        let turns = Arc::new(AtomicU64::new(0));
        let turned = turns.clone();
        let (contours, newest) = watch::channel(None);
        let contours = contour.map(|plan| Contours::new(plan, contours));
        let (part_news, found) = watch::channel(None);
        let parts = parts.map(|plan| Parts::start(plan, part_news)).transpose()?;
        let line = Line { pipeline, weighing, contours, parts };
        std::thread::Builder::new()
            .name("pipeline".to_owned())
            .spawn(move || run(line, clock, &runtime, receiver, &sender, &turned))?;
        Ok(Worker { work, figures, contour: newest, parts: found, turns })
    }

    /// The newest running figures.
    pub(super) fn figures(&self) -> Option<Arc<RunningFigures>> {
        self.figures.borrow().clone()
    }

    /// The newest contour; `None` where none is asked for, or there is none yet.
    pub(super) fn contour(&self) -> Option<Arc<SessionContour>> {
        self.contour.borrow().clone()
    }

    /// The newest parts; `None` where none are asked for, or no point came yet.
    pub(super) fn parts(&self) -> Option<Arc<SessionParts>> {
        self.parts.borrow().clone()
    }

    /// How often the pipeline has come back for more: more than eight times a second, unless something holds it up.
    pub(super) fn turns(&self) -> u64 {
        self.turns.load(Ordering::Relaxed)
    }

    /// Hands over points; waits while the pipeline is behind, which holds the links back. Fails when the
    /// pipeline has died.
    pub(super) async fn points(&self, points: Vec<Point>) -> Result<(), Died> {
        self.work.send(Work::Points(points)).await.map_err(|_| Died)
    }

    /// Asks for the mesh as a PLY file.
    pub(super) async fn mesh_ply(&self, reply: oneshot::Sender<Option<Vec<u8>>>) {
        let _ = self.work.send(Work::MeshPly(reply)).await;
    }

    /// Asks for a section.
    pub(super) async fn section(&self, request: SectionRequest, reply: oneshot::Sender<Cut>) {
        let _ = self.work.send(Work::Section(request, reply)).await;
    }

    /// Asks what to measure next.
    pub(super) async fn next(&self, reply: oneshot::Sender<Option<Next>>) {
        let _ = self.work.send(Work::Next(reply)).await;
    }

    /// Asks for figures of all points so far. `None` where the pipeline has died.
    pub(super) fn assess(
        &self,
    ) -> impl Future<Output = Option<Arc<RunningFigures>>> + Send + 'static {
        let work = self.work.clone();
        async move {
            let (reply, figures) = oneshot::channel();
            work.send(Work::Assess(reply)).await.ok()?;
            figures.await.ok()
        }
    }

    /// Asks for the final figures.
    pub(super) async fn finish(&self) -> oneshot::Receiver<Measurement> {
        let (reply, measurement) = oneshot::channel();
        let _ = self.work.send(Work::Finish(reply)).await;
        measurement
    }
}

/// Makers of figures that the thread hands its points to.
struct Line {
    pipeline: Pipeline,
    weighing: Weighing,
    contours: Option<Contours>,
    parts: Option<Parts>,
}

impl Line {
    fn take(&mut self, points: &[Point]) {
        for point in points {
            self.pipeline.take(self.weighing.weighed(point), point.reasons());
        }
        if let Some(contours) = &mut self.contours {
            contours.take(points);
        }
        if let Some(parts) = &mut self.parts {
            parts.take(points);
        }
    }

    /// The final figures; the contour is formed and the last parts are measured meanwhile.
    fn finish(self) -> Measurement {
        let parts = self.parts.map(Parts::finish);
        let contour = self.contours.map(Contours::finish);
        let mut measurement = self.pipeline.finish();
        if let Some(contour) = contour {
            let (plan, contour) = contour.wait();
            plan.conclude(contour, &mut measurement);
        }
        if let Some(parts) = parts {
            let (plan, found) = parts.wait();
            plan.conclude(found, &mut measurement);
        }
        measurement
    }
}

fn run(
    mut line: Line,
    clock: Clock,
    runtime: &Handle,
    mut work: mpsc::Receiver<Work>,
    figures: &watch::Sender<Option<Arc<RunningFigures>>>,
    turns: &AtomicU64,
) {
    let mut shown_at = clock.now();
    let mut shown = 0;
    loop {
        turns.fetch_add(1, Ordering::Relaxed);
        let next = runtime.block_on(async { timeout(PERIOD, work.recv()).await });
        match next {
            Ok(Some(Work::Points(points))) => {
                line.take(&points);
            }
            Ok(Some(Work::MeshPly(reply))) => {
                // A client that hung up no longer wants it.
                let _ = reply.send(results::mesh_ply(&line.pipeline));
            }
            Ok(Some(Work::Section(request, reply))) => {
                let _ = reply.send(line.pipeline.section(&request));
            }
            Ok(Some(Work::Next(reply))) => {
                let _ = reply.send(line.pipeline.next().cloned());
            }
            Ok(Some(Work::Assess(reply))) => {
                let newest = Arc::new(line.pipeline.figures_of_all());
                figures.send_replace(Some(Arc::clone(&newest)));
                let _ = reply.send(newest);
            }
            Ok(Some(Work::Finish(reply))) => {
                figures.send_replace(Some(Arc::new(line.pipeline.figures())));
                let _ = reply.send(line.finish());
                return;
            }
            Ok(None) => return,
            Err(_) => {}
        }
        if let Some(contours) = &mut line.contours {
            contours.keep_up(clock.now());
        }
        if let Some(parts) = &mut line.parts {
            parts.keep_up(clock.now());
        }
        let now = clock.now();
        if line.pipeline.received() != shown && now.since(shown_at) >= PERIOD {
            shown = line.pipeline.received();
            shown_at = now;
            figures.send_replace(Some(Arc::new(line.pipeline.figures())));
        }
    }
}

/// How often running figures are made: more than five times a second.
pub(super) const PERIOD: Duration = Duration::from_millis(120);
/// Batches of points that may wait.
const QUEUE: usize = 1024;
