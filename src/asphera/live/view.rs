//! What a person sees now: snapshots put together from the core and the newest figures.

use std::collections::VecDeque;
use std::sync::Arc;

use asphera_link::Nanos;
use asphera_report::contour::{ContourState, SessionContour};
use asphera_report::parts::SessionParts;
use asphera_report::{
    Backlog, Connection, LinkState, MapsState, Outputs, Progress, SamplingFigures, SessionFigures,
    Snapshot, State, Waiting,
};
use asphera_surface::coverage::{Progress as Left, completion};
use tokio::sync::watch;
use tracing::{info, warn};

use super::Finished;
use crate::config::{Config, LinkConfig};
use crate::parts::{heights_of_parts, sampling_without_whole};
use crate::snapshot::{empty, take_measurement};
use crate::station::{Bench, Line};
use asphera_measure::RunningFigures;

/// What a running session has made so far.
pub(super) struct Running {
    pub(super) figures: Option<Arc<RunningFigures>>,
    pub(super) contour: Option<Arc<SessionContour>>,
    pub(super) parts: Option<Arc<SessionParts>>,
    /// Points that wait for the pipeline, where it does not keep up.
    pub(super) backlog: Option<Backlog>,
    /// Why the recording is in trouble.
    pub(super) trouble: Option<String>,
}

/// Makes snapshots.
pub(super) struct View {
    links: Vec<LinkConfig>,
    expected_points: Option<u64>,
    /// Whether points have a form as a whole: not where they are parts alone.
    has_whole: bool,
    sender: watch::Sender<Arc<Snapshot>>,
    snapshot: Snapshot,
    points: Meter,
    readings: Vec<Meter>,
    behind: Behind,
    finished: Option<Arc<Finished>>,
}

impl View {
    pub(super) fn new(config: &Config) -> View {
        let snapshot = empty(&config.name);
        View {
            links: config.links.clone(),
            expected_points: config.expected_points(),
            has_whole: !config.parts.as_ref().is_some_and(|plan| plan.has_no_whole),
            sender: watch::Sender::new(Arc::new(snapshot.clone())),
            snapshot,
            points: Meter::default(),
            readings: vec![Meter::default(); config.links.len()],
            behind: Behind::default(),
            finished: None,
        }
    }

    pub(super) fn watch(&self) -> watch::Receiver<Arc<Snapshot>> {
        self.sender.subscribe()
    }

    /// A session begins: nothing of the one before is shown any more.
    pub(super) fn begin(&mut self, session: SessionFigures) {
        self.finished = None;
        self.behind = Behind::default();
        self.points = Meter::default();
        self.readings.iter_mut().for_each(|meter| *meter = Meter::default());
        self.snapshot = Snapshot {
            sequence: self.snapshot.sequence,
            state: State::Measuring,
            session: Some(session),
            ..empty(&self.snapshot.station)
        };
    }

    pub(super) fn state(&mut self, state: State) {
        self.snapshot.state = state;
    }

    /// A session ended at this time of its clock: its report is shown until the next one begins.
    pub(super) fn complete(&mut self, at: Nanos, finished: Arc<Finished>) {
        let report = &finished.measurement.report;
        // A short session may have ended before anything of it was shown.
        self.snapshot.elapsed_s = at.as_secs_f64();
        let done = report.points.received + report.points.lost;
        self.snapshot.progress =
            progress(0.0, done, self.expected_points, 0, &SamplingFigures::default());
        take_measurement(&mut self.snapshot, &finished.measurement);
        self.finished = Some(finished);
    }

    /// The results of a session are written, unless the next one has begun.
    pub(super) fn left(&mut self, session: &str, outputs: Outputs) {
        if self.snapshot.session.as_ref().is_some_and(|shown| shown.id == session) {
            self.snapshot.outputs = Some(outputs);
        }
    }

    /// A session ended without figures.
    pub(super) fn failed(&mut self, reason: &str) {
        self.snapshot.state = State::Failed;
        // They went with the pipeline.
        self.snapshot.maps = None;
        self.snapshot.contour = None;
        self.snapshot.parts = None;
        self.snapshot.verdict.outlook = None;
        self.snapshot.verdict.reasons = vec![reason.to_owned()];
    }

    /// The session that ended last.
    pub(super) fn finished(&self) -> Option<Arc<Finished>> {
        self.finished.clone()
    }

    /// Sends a snapshot: the core's state now and, while a session runs, its newest figures.
    pub(super) fn show(&mut self, now: Nanos, bench: &Bench, session: Option<Running>) {
        let snapshot = &mut self.snapshot;
        snapshot.sequence += 1;
        snapshot.links = bench
            .lines()
            .iter()
            .zip(&self.links)
            .zip(&mut self.readings)
            .map(|((line, config), meter)| link_state(now, line, config, meter, bench))
            .collect();
        snapshot.scan = bench.scanner().map(|scanner| scanner.figures(now));
        if let Some(Running { figures, contour, parts, backlog, trouble }) = session {
            snapshot.elapsed_s = now.as_secs_f64();
            if let Some(figures) = figures {
                snapshot.points = figures.points.clone();
                snapshot.mesh = figures.mesh.clone();
                snapshot.progress.pending_points = figures.pending;
                match self.has_whole {
                    true => take_whole(snapshot, &figures),
                    false => take_parts(snapshot, &figures),
                }
            }
            snapshot.parts = parts.map(|parts| parts.state());
            snapshot.contour =
                contour.map(|contour| ContourState { as_of_points: contour.as_of_points });
            snapshot.points.lost = bench.lost();
            snapshot.verdict.reasons = trouble
                .map(|trouble| format!("the recording is in trouble: {trouble}"))
                .into_iter()
                .collect();
            let waiting = waiting(now, bench).filter(|_| snapshot.state == State::Measuring);
            let done = snapshot.points.received + snapshot.points.lost;
            snapshot.progress = progress(
                self.points.rate_hz(now, snapshot.points.received),
                done,
                self.expected_points,
                snapshot.progress.pending_points,
                &snapshot.sampling,
            );
            snapshot.progress.waiting = waiting;
            snapshot.progress.backlog = backlog;
            self.behind.note(backlog);
        }
        self.sender.send_replace(Arc::new(self.snapshot.clone()));
    }
}

/// Takes what is said of points that are parts alone.
fn take_parts(snapshot: &mut Snapshot, figures: &RunningFigures) {
    snapshot.sampling = sampling_without_whole(&figures.sampling);
    snapshot.map = heights_of_parts(figures.map.clone(), figures.form.as_ref());
}

/// Takes what is said of all points together.
fn take_whole(snapshot: &mut Snapshot, figures: &RunningFigures) {
    snapshot.sampling = figures.sampling.clone();
    snapshot.form = figures.form.clone();
    snapshot.map = figures.map.clone();
    snapshot.maps = figures
        .maps
        .as_ref()
        .map(|maps| MapsState { version: maps.version, as_of_points: maps.as_of_points });
    snapshot.convergence = figures.convergence.clone();
    snapshot.verdict.outlook = figures.outlook.clone();
}

fn progress(
    rate_hz: f64,
    done: u64,
    expected: Option<u64>,
    pending_points: u64,
    sampling: &SamplingFigures,
) -> Progress {
    let open_mm2 = sampling.undersampled_area_mm2.zip(sampling.uncovered_area_mm2);
    let density = sampling.spacing_median_mm.map(|spacing_mm| (spacing_mm * spacing_mm).recip());
    let left = completion(&Left {
        area_left_mm2: open_mm2.map_or(0.0, |(undersampled, uncovered)| undersampled + uncovered),
        points_per_mm2: density.filter(|density| open_mm2.is_some() && density.is_finite()),
        points_left: expected.map(|expected| expected.saturating_sub(done) as f64),
        rate_hz,
    })
    .ok();
    Progress {
        expected_points: expected,
        fraction: expected.map(|expected| (done as f64 / expected as f64).min(1.0)),
        rate_hz,
        eta_s: left.and_then(|left| left.by_plan_s),
        eta_coverage_s: left.and_then(|left| left.by_coverage_s),
        pending_points,
        backlog: None,
        waiting: None,
    }
}

/// What the log says of a processing that does not keep up: that it began, that it grew twice as long, that it ended.
#[derive(Default)]
struct Behind {
    /// The delay that was said last, s; 0 where processing keeps up.
    said_s: f64,
}

impl Behind {
    fn note(&mut self, backlog: Option<Backlog>) {
        match backlog {
            Some(backlog) if backlog.behind_s >= (2.0 * self.said_s).max(SAID_S) => {
                self.said_s = backlog.behind_s;
                warn!("{backlog}");
            }
            None if self.said_s > 0.0 => {
                self.said_s = 0.0;
                info!("processing has caught up");
            }
            _ => {}
        }
    }
}

/// A shorter delay of the processing is not worth a line of the log, s.
const SAID_S: f64 = 2.0;

/// What the scan waits for, unless it has begun.
fn waiting(now: Nanos, bench: &Bench) -> Option<Waiting> {
    if bench.last_primary().is_some() {
        return None;
    }
    let links: Vec<String> = bench.unready().map(str::to_owned).collect();
    let ends_in_s = bench.first_by().map(|due| due.since(now).as_secs_f64());
    Some(match links.is_empty() {
        true => Waiting::FirstTrigger { ends_in_s },
        false => Waiting::Devices { links, ends_in_s },
    })
}

fn link_state(
    now: Nanos,
    line: &Line,
    config: &LinkConfig,
    meter: &mut Meter,
    bench: &Bench,
) -> LinkState {
    let figures = line.traffic();
    let age = line.last_reading().map(|last| now.since(last));
    let stale = age.is_some_and(|age| age > config.stale_after);
    LinkState {
        name: config.name.clone(),
        kind: config.kind.to_owned(),
        address: config.endpoint.to_string(),
        devices: line.device_names().map(str::to_owned).collect(),
        state: match (line.is_open(), line.is_online()) {
            (false, _) => Connection::Opening,
            (true, false) => Connection::Waiting,
            (true, true) if stale => Connection::Stale,
            (true, true) => Connection::Connected,
        },
        rate_hz: meter.rate_hz(now, line.readings()),
        readings: line.readings(),
        received_bytes: figures.received_bytes,
        errors: line.errors(),
        lost: bench.lost_on(line),
        reconnects: figures.opened.saturating_sub(1),
        age_s: age.map(|age| age.as_secs_f64()),
        last_error: line.last_error().map(str::to_owned),
    }
}

/// A rate over the last second.
#[derive(Clone, Default)]
struct Meter {
    counts: VecDeque<(Nanos, u64)>,
}

impl Meter {
    /// Takes the count at `now` and gives its growth a second over the last second.
    fn rate_hz(&mut self, now: Nanos, count: u64) -> f64 {
        self.counts.push_back((now, count));
        while self.counts.len() > 2 && now.since(self.counts[1].0).as_secs_f64() >= 1.0 {
            self.counts.pop_front();
        }
        let (since, from) = self.counts[0];
        let span = now.since(since).as_secs_f64();
        if span > 0.0 { count.saturating_sub(from) as f64 / span } else { 0.0 }
    }
}
