//! The thread that makes figures of points.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use asphera_link::Nanos;
use asphera_report::contour::SessionContour;
use asphera_report::parts::SessionParts;
use asphera_report::{Backlog, Cut, SectionRequest};
use tokio::runtime::Handle;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::task::spawn_blocking;
use tokio::time::sleep;
use tracing::{debug, error};

use super::backlog::Waiting;
use super::contour::Contours;
use super::evaluations::Evaluations;
use super::overflow::Overflow;
use super::parts::Parts;
use crate::clock::Clock;
use crate::contour::ContourPlan;
use crate::parts::PartsPlan;
use crate::results;
use crate::station::Point;
use crate::weighing::Weighing;
use asphera_measure::Part;
use asphera_measure::{Along, Measurement, Next, Pipeline, RunningFigures, Systematic, Tip};

mod queue;

use queue::{Queue, Turn};

/// Newest running figures, if there are any.
pub(super) type FiguresWatch = watch::Receiver<Option<Arc<RunningFigures>>>;

/// Hands points to the pipeline's thread.
pub(super) struct Worker {
    work: mpsc::Sender<Work>,
    waiting: Waiting,
    overflow: Overflow,
    figures: FiguresWatch,
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
    Finish(Vec<Systematic>, oneshot::Sender<Measurement>),
    /// The thread stands until the other end is dropped: a pipeline that does not keep up.
    #[cfg(test)]
    Stand(std::sync::mpsc::Receiver<()>),
}

impl Worker {
    /// Starts the thread for one part, of which no more than so many points will come. It ends when it has finished, or the worker is dropped.
    pub(super) fn start(
        part: Part,
        (along, tip, awaits_systematic): (Along, Option<Tip>, bool),
        expected_points: Option<u64>,
        (contour, parts): (Option<ContourPlan>, Option<PartsPlan>),
        weighing: Weighing,
        (clock, overflow): (Clock, Overflow),
    ) -> std::io::Result<Worker> {
        let (work, receiver) = mpsc::channel(QUEUE);
        let (sender, figures) = watch::channel(None);
        let runtime = Handle::current();
        let pipeline = Pipeline::along(part, along)
            .with_tip(tip)
            .awaiting_systematic(awaits_systematic)
            .expecting(expected_points);
        let turns = Arc::new(AtomicU64::new(0));
        let waiting = Waiting::with_room(overflow.room_points());
        let pace = Pace::new(clock, turns.clone(), waiting.clone());
        let (contours, newest) = watch::channel(None);
        let contours = contour.map(|plan| Contours::new(plan, contours));
        let (part_news, found) = watch::channel(None);
        let parts = parts.map(|plan| Parts::start(plan, part_news)).transpose()?;
        let line = Line { pipeline, weighing, contours, parts };
        std::thread::Builder::new().name("pipeline".to_owned()).spawn({
            let queue = Queue { work: receiver, overflow: overflow.clone() };
            move || run(line, pace, &runtime, queue, &sender)
        })?;
        Ok(Worker { work, waiting, overflow, figures, contour: newest, parts: found, turns })
    }

    /// The newest running figures.
    pub(super) fn figures(&self) -> Option<Arc<RunningFigures>> {
        self.figures.borrow().clone()
    }

    /// The newest running figures, and when there are newer ones.
    pub(super) fn watch(&self) -> FiguresWatch {
        self.figures.clone()
    }

    /// Points that wait to be worked on and for how long; `None` where the pipeline keeps up.
    pub(super) fn backlog(&self, clock: &Clock) -> Option<Backlog> {
        self.waiting.backlog(clock)
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

    /// Longest delay of the processing so far, s; 0 where it kept up.
    pub(super) fn most_behind_s(&self) -> f64 {
        self.waiting.most_behind_s()
    }

    /// Hands over points. Where memory has no room they wait in a file, and those after them, until it has been read. Where the disk has
    /// no room either, this waits, which holds the links back. Fails when the pipeline has died.
    pub(super) async fn points(&self, points: Vec<Point>) -> Result<(), Died> {
        if !self.overflow.is_waiting() && self.waiting.try_hand_over(&points) {
            return self.send(points).await;
        }
        let overflow = self.overflow.clone();
        let appended = spawn_blocking(move || {
            let appended = overflow.append(&points);
            (points, appended)
        });
        let (points, appended) = appended.await.map_err(|_| Died)?;
        match appended {
            Ok(()) => {
                self.waiting.hand_aside(&points);
                return if self.work.is_closed() { Err(Died) } else { Ok(()) };
            }
            Err(error) => debug!(%error, "points that wait for the pipeline hold the links back"),
        }
        // What waits in the file comes before these.
        while self.overflow.is_waiting() {
            if self.work.is_closed() {
                return Err(Died);
            }
            sleep(PERIOD).await;
        }
        tokio::select! {
            () = self.waiting.hand_over(&points) => {}
            () = self.work.closed() => return Err(Died),
        }
        self.send(points).await
    }

    async fn send(&self, points: Vec<Point>) -> Result<(), Died> {
        self.work.send(Work::Points(points)).await.map_err(|_| Died)
    }

    /// Lets the thread stand until the other end is dropped.
    #[cfg(test)]
    pub(super) async fn stand(&self, until: std::sync::mpsc::Receiver<()>) {
        let _ = self.work.send(Work::Stand(until)).await;
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

    /// Asks for the final figures, with these errors that all points have together.
    pub(super) async fn finish(
        &self,
        systematic: Vec<Systematic>,
    ) -> oneshot::Receiver<Measurement> {
        let (reply, measurement) = oneshot::channel();
        let _ = self.work.send(Work::Finish(systematic, reply)).await;
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

impl Pace {
    /// Gives points of the file to the makers of figures.
    fn take_overflown(&self, line: &mut Line, points: &[Point]) {
        self.waiting.begin(points);
        line.take(points);
        self.waiting.taken_aside(points);
    }

    /// The same with all of the file: what is asked for needs all points so far.
    fn catch_up(&self, line: &mut Line, overflow: &Overflow) -> std::io::Result<()> {
        while overflow.is_waiting() {
            self.turns.fetch_add(1, Ordering::Relaxed);
            self.take_overflown(line, &overflow.take()?);
        }
        Ok(())
    }
}

fn run(
    line: Line,
    pace: Pace,
    runtime: &Handle,
    queue: Queue,
    figures: &watch::Sender<Option<Arc<RunningFigures>>>,
) {
    // Without these points there are no figures; the recording has all that they were made of.
    if let Err(error) = work(line, pace, runtime, queue, figures) {
        error!(%error, "points that waited in a file cannot be read back: asphera replay makes the figures of the recording");
    }
}

fn work(
    mut line: Line,
    mut pace: Pace,
    runtime: &Handle,
    mut queue: Queue,
    figures: &watch::Sender<Option<Arc<RunningFigures>>>,
) -> std::io::Result<()> {
    loop {
        pace.turns.fetch_add(1, Ordering::Relaxed);
        match queue.next(runtime)? {
            Turn::Work(Work::Points(points)) => {
                pace.waiting.begin(&points);
                line.take(&points);
                pace.waiting.taken(&points);
            }
            Turn::Overflown(points) => pace.take_overflown(&mut line, &points),
            Turn::Work(Work::MeshPly(reply)) => {
                // A client that hung up no longer wants it.
                let _ = reply.send(results::mesh_ply(&line.pipeline));
            }
            Turn::Work(Work::Section(request, reply)) => {
                let _ = reply.send(line.pipeline.section(&request));
            }
            Turn::Work(Work::Next(reply)) => {
                let whole = !line.parts.as_ref().is_some_and(Parts::has_no_whole);
                let _ = reply.send(line.pipeline.next().filter(|_| whole).cloned());
            }
            Turn::Work(Work::Assess(reply)) => {
                pace.catch_up(&mut line, &queue.overflow)?;
                let newest = Arc::new(line.pipeline.figures_of_all());
                figures.send_replace(Some(Arc::clone(&newest)));
                let _ = reply.send(newest);
            }
            Turn::Work(Work::Finish(systematic, reply)) => {
                pace.catch_up(&mut line, &queue.overflow)?;
                figures.send_replace(Some(Arc::new(line.pipeline.figures())));
                line.pipeline.know_systematic(systematic);
                let _ = reply.send(line.finish());
                return Ok(());
            }
            #[cfg(test)]
            Turn::Work(Work::Stand(until)) => drop(until.recv()),
            Turn::End => return Ok(()),
            Turn::Nothing => {}
        }
        if let Some(contours) = &mut line.contours {
            contours.keep_up(pace.clock.now());
        }
        if let Some(parts) = &mut line.parts {
            parts.keep_up(pace.clock.now());
        }
        if let Some(newer) = pace.figures(&mut line.pipeline) {
            figures.send_replace(Some(Arc::new(newer)));
        }
    }
}

/// Times of the thread: when it makes figures, and when it may evaluate the whole mesh.
struct Pace {
    clock: Clock,
    turns: Arc<AtomicU64>,
    waiting: Waiting,
    evaluations: Evaluations,
    /// When figures were made last.
    shown_at: Nanos,
    /// Points that the pipeline had received then.
    shown: u64,
    /// Points that the core had handed over then.
    handed: u64,
    /// Points a second that the core hands over.
    rate_hz: f64,
}

impl Pace {
    fn new(clock: Clock, turns: Arc<AtomicU64>, waiting: Waiting) -> Pace {
        let shown_at = clock.now();
        let evaluations = Evaluations::default();
        Pace { clock, turns, waiting, evaluations, shown_at, shown: 0, handed: 0, rate_hz: 0.0 }
    }

    /// Figures, if they are due and there are newer points. The mesh is evaluated where that is due and may hold points up.
    fn figures(&mut self, pipeline: &mut Pipeline) -> Option<RunningFigures> {
        let (began, received) = (self.clock.now(), pipeline.received());
        let since_s = began.since(self.shown_at).as_secs_f64();
        if received == self.shown && !pipeline.awaits_evaluation() || since_s < PERIOD.as_secs_f64()
        {
            return None;
        }
        let handed = self.waiting.handed();
        // A pause of a moment, as at the end of a line, is none.
        self.rate_hz = ((handed - self.handed) as f64 / since_s).max(self.rate_hz * RATE_STAYS);
        (self.shown, self.shown_at, self.handed) = (received, began, handed);
        let now_s = began.as_secs_f64();
        if !self.evaluations.may_begin(now_s, received, self.rate_hz, self.waiting.points()) {
            return Some(pipeline.figures_without_evaluation());
        }
        let before = pipeline.evaluations();
        let figures = pipeline.figures();
        if pipeline.evaluations() > before {
            self.evaluations.took(now_s, self.clock.now().as_secs_f64(), received);
        }
        Some(figures)
    }
}

/// How often running figures are made: more than five times a second.
pub(super) const PERIOD: Duration = Duration::from_millis(120);
/// Share of a rate that is left after figures without a new point: a tenth after some five seconds.
const RATE_STAYS: f64 = 0.95;
/// Batches of points and questions that may wait.
const QUEUE: usize = 65_536;

#[cfg(test)]
mod tests;
