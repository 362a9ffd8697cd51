//! The task that holds the core: it decides the order of everything.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use asphera_link::{Command, Nanos};
use asphera_report::contour::SessionContour;
use asphera_report::{Label, Outputs, Report, State, Timing};
use asphera_transport::{Link, LinkCommand, LinkEvent, LinkSettings, What as LinkWhat};
use tokio::sync::{mpsc, oneshot, watch};
use tokio::task::{JoinError, JoinSet};
use tokio::time::{Instant, sleep_until};
use tracing::{debug, error, info, warn};

use super::brake::Brake;
use super::lock::Lock;
use super::overflow::Overflow;
use super::recording::Recording;
use super::view::{Running, View};
use super::worker::{FiguresWatch, Worker};
use super::{Asked, Closed, Control, Finished, Handle, Station, StationError, outputs};
use crate::clock::Clock;
use crate::conclude::{Outcome, conclude, session_figures};
use crate::config::Config;
use crate::contour::ContourPlan;
use crate::results;
use crate::session::{
    Disk, Entry, Header, LinkInfo, PointCloud, RecordedPoint, Recorder, ResultsJson, SessionId,
    What,
};
use crate::station::{Action, Bench, Ended, Happening, Point, assemble};
use crate::weighing::Weighing;
use asphera_measure::{Measurement, undecide};

mod scan;

/// Starts a station's task.
pub(super) fn start(config: Config) -> Result<Station, StationError> {
    let lock = Lock::take(&config.recordings, &config.name)?;
    let (control, controls) = mpsc::channel(16);
    let (closed_sender, closed) = mpsc::channel(4);
    let (report_sender, report) = watch::channel(None);
    let (beat, beats) = watch::channel(0);
    let (commands, commands_running) = watch::channel(0);
    let (sender, events) = mpsc::channel(EVENTS);
    let view = View::new(&config);
    let snapshots = view.watch();
    let recordings = config.recordings.as_path().into();
    let core = Core {
        bench: assemble(&config)?,
        config,
        clock: Clock::start(),
        links: Vec::new(),
        sender,
        events,
        controls,
        view,
        session: None,
        figures: None,
        closed: closed_sender,
        report: report_sender,
        awake_by: Instant::now(),
        beat,
        turns: 0,
        leaving: JoinSet::new(),
        commands,
        noted: Vec::new(),
        brake: Brake::default(),
        decider: scan::Decider::default(),
        _lock: lock,
    };
    let brake = core.brake.clone();
    let handle = Handle { control, snapshots, report, beats, recordings, brake };
    Ok(Station { handle, closed, commands_running, task: tokio::spawn(core.run()) })
}

struct Core {
    config: Config,
    clock: Clock,
    bench: Bench,
    links: Vec<Link>,
    sender: mpsc::Sender<LinkEvent>,
    events: mpsc::Receiver<LinkEvent>,
    controls: mpsc::Receiver<Control>,
    view: View,
    session: Option<Session>,
    /// Figures of the session.
    figures: Option<FiguresWatch>,
    closed: mpsc::Sender<Result<Closed, StationError>>,
    report: watch::Sender<Option<Arc<Report>>>,
    /// When the task is to run again at the latest.
    awake_by: Instant,
    /// Counts on while the station gets on with its work.
    beat: watch::Sender<u64>,
    /// Of the pipeline, when it was looked at last.
    turns: u64,
    /// Results of sessions that ended, being written.
    leaving: JoinSet<Closed>,
    /// How many commands of `[output]` run.
    commands: watch::Sender<usize>,
    /// Points that are not recorded yet.
    noted: Vec<RecordedPoint>,
    brake: Brake,
    decider: scan::Decider,
    /// The folder of the recordings.
    _lock: Lock,
}

/// Resources of a running session.
struct Session {
    header: Header,
    recording: Recording,
    worker: Worker,
    /// While the final figures are made.
    ending: Option<Ending>,
}

struct Ending {
    at: Nanos,
    outcome: Outcome,
    measurement: oneshot::Receiver<Measurement>,
    /// To be answered from the final figures.
    asked: Vec<Asked>,
}

impl Core {
    async fn run(mut self) {
        let mut next_view = Instant::now();
        loop {
            // What was just done may itself have waited, for the pipeline or the recorder.
            self.awake().await;
            let due = self.next_due();
            self.awake_by = self.awake_by.max(due.min(next_view));
            tokio::select! {
                // In this order, so that a flood of bytes starves neither an operator nor the page.
                biased;
                control = self.controls.recv() => match control {
                    Some(control) => {
                        self.awake().await;
                        self.control(control).await;
                    }
                    None => return,
                },
                measurement = ended(&mut self.session) => self.conclude(measurement).await,
                decision = scan::decided(&mut self.decider) => self.decide(decision).await,
                Some(left) = self.leaving.join_next() => self.left(left),
                () = sleep_until(next_view) => {
                    self.show().await;
                    next_view = Instant::now() + VIEW_PERIOD;
                }
                () = newer_figures(&mut self.figures) => {
                    self.show().await;
                    next_view = Instant::now() + VIEW_PERIOD;
                }
                event = self.events.recv() => if let Some(event) = event {
                    self.awake().await;
                    self.event(event).await;
                },
                () = sleep_until(due) => {
                    self.awake().await;
                    self.advance().await;
                }
            }
        }
    }

    /// Sends a snapshot: at least every [`VIEW_PERIOD`], and as soon as there are newer figures.
    async fn show(&mut self) {
        self.awake().await;
        let clock = &self.clock;
        let running = self.session.as_ref().map(|session| Running {
            figures: session.worker.figures(),
            contour: session.worker.contour(),
            parts: session.worker.parts(),
            backlog: session.worker.backlog(clock),
            trouble: session.recording.trouble(),
        });
        self.view.show(clock.now(), &self.bench, running);
        self.record_points(self.bench.now()).await;
        self.end_certain_fail().await;
        self.beat();
    }

    /// Says that the station gets on, unless the pipeline has not come back for more since the last time. Final figures take as
    /// long as they take.
    fn beat(&mut self) {
        let turns = match &self.session {
            Some(session) if session.ending.is_none() => Some(session.worker.turns()),
            _ => None,
        };
        if turns.is_none_or(|turns| turns != self.turns) {
            self.beat.send_modify(|beats| *beats += 1);
        }
        self.turns = turns.unwrap_or(0);
    }

    /// The task runs: if it should have long before, the core is told that the host was held up. Timers do not run out while a
    /// computer is suspended, so that is looked for as well.
    async fn awake(&mut self) {
        let now = Instant::now();
        let suspended = self.clock.catch_up();
        if !suspended.is_zero() {
            warn!(?suspended, "the computer was suspended");
        }
        let by = now.saturating_duration_since(self.awake_by);
        if by > HELD_UP || !suspended.is_zero() {
            let until = self.clock.at(now.into());
            debug!(?by, "the host was held up");
            self.bench.held_up(until, suspended);
            self.record(self.bench.now(), What::HeldUp { until, suspended }).await;
        }
        self.awake_by = now;
    }

    /// When the core or the end of the scan wants the time.
    fn next_due(&self) -> Instant {
        let measuring = self.session.as_ref().is_some_and(|session| session.ending.is_none());
        let idle = self.bench.idle_at().or(self.bench.first_by()).filter(|_| measuring);
        let due = self.bench.poll_timeout().into_iter().chain(idle).min();
        due.map_or_else(|| Instant::now() + VIEW_PERIOD, |due| self.clock.instant(due).into())
    }

    /// Something happened on a link. It is recorded before anything that follows from it.
    async fn event(&mut self, event: LinkEvent) {
        let LinkEvent { link, at, what } = event;
        // Not the time now: if this task was held up, what was read in time must not count as late.
        let now = self.clock.at(at.into()).max(self.bench.now());
        let is_new = matches!(what, LinkWhat::Opened { .. } | LinkWhat::Closed(_));
        match what {
            LinkWhat::Opened { epoch } => {
                self.record(now, What::Opened { link }).await;
                self.bench.happened(now, link, Happening::Opened { epoch });
            }
            LinkWhat::Received(bytes) => {
                self.bench.happened(now, link, Happening::Received(&bytes));
                self.record(now, What::Received { link, bytes }).await;
            }
            LinkWhat::Closed(reason) => {
                warn!(link = %self.config.links[link].name, %reason, "link lost");
                self.bench.happened(now, link, Happening::Closed(&reason));
                self.record(now, What::Closed { link, reason }).await;
            }
            LinkWhat::OpenFailed(reason) => {
                // Tried again and again: said once.
                if self.bench.lines()[link].last_error() != Some(&reason) {
                    warn!(link = %self.config.links[link].name, %reason, "link does not open");
                }
                self.bench.happened(now, link, Happening::OpenFailed(&reason));
            }
            LinkWhat::BusError(error) => {
                warn!(link = %self.config.links[link].name, %error, "trouble on the bus");
                self.bench.happened(now, link, Happening::OpenFailed(&error));
            }
        }
        if is_new {
            self.connect_brake();
        }
        self.settle(now).await;
    }

    /// Lets time pass.
    async fn advance(&mut self) {
        let now = self.clock.now();
        self.bench.advance(now);
        self.settle(now).await;
    }

    /// Does what the core wants done, hands its points on, and sees whether the scan is over.
    async fn settle(&mut self, now: Nanos) {
        while let Some(action) = self.bench.poll_action() {
            match action {
                Action::Send { line, epoch, bytes } => {
                    self.record(now, What::Sent { link: line, bytes: bytes.clone() }).await;
                    let link = &self.links[line];
                    self.brake
                        .unless_pressed(line, || link.command(LinkCommand::Send { epoch, bytes }));
                }
                Action::Confirm { line } => self.links[line].command(LinkCommand::Confirm),
                Action::Reopen { line, epoch } => {
                    self.links[line].command(LinkCommand::Reopen { epoch });
                }
            }
        }
        let points = self.bench.take_points();
        self.note_points(now, &points).await;
        let Some(session) = self.session.as_mut().filter(|session| session.ending.is_none()) else {
            return;
        };
        if !points.is_empty() && session.worker.points(points).await.is_err() {
            self.end(now, "failed").await;
        } else if let Some(ended) = self.bench.ended(now) {
            self.end(now, ended.word()).await;
        } else if self.bench.first_by().is_some_and(|due| due <= now) {
            self.end(now, Ended::Idle.word()).await;
        } else {
            self.ask_decision();
        }
    }

    async fn record(&mut self, at: Nanos, what: What) {
        if let Some(session) = self.session.as_ref().filter(|session| session.ending.is_none()) {
            session.recording.append(Entry { at, what }).await;
        }
    }

    /// Gathers points for the recording: a message for each of few would cost more than they do.
    async fn note_points(&mut self, now: Nanos, points: &[Point]) {
        if !self.config.records_points || self.session.is_none() {
            return;
        }
        self.noted.extend(points.iter().map(|point| RecordedPoint {
            at: point.host,
            count: point.count,
            position_mm: point.is_good().then_some(point.position_mm),
            flags: point.flags,
        }));
        if self.noted.len() >= NOTED {
            self.record_points(now).await;
        }
    }

    async fn record_points(&mut self, now: Nanos) {
        if !self.noted.is_empty() {
            let cloud = PointCloud::new(now, &self.noted);
            self.noted.clear();
            self.record(now, What::Points(cloud)).await;
        }
    }

    /// Answers from the session that ended last, beside the core.
    fn answer(&self, asked: Asked) {
        let finished = self.view.finished();
        let in_xy = self.config.contour.as_ref().is_some_and(ContourPlan::is_in_xy);
        tokio::task::spawn_blocking(move || {
            let measurement = finished.as_ref().map(|finished| &finished.measurement);
            // Whoever asked may have gone; then there is nobody to answer.
            match asked {
                Asked::MeshPly(reply) => {
                    let _ = reply.send(measurement.and_then(results::finished_mesh_ply));
                }
                Asked::Next(reply) => {
                    let _ = reply.send(measurement.and_then(|done| done.next.clone()));
                }
                #[cfg(test)]
                Asked::Stand(_) => {}
                Asked::Maps(reply) => {
                    let _ = reply.send(measurement.and_then(|done| done.surface.maps()));
                }
                Asked::Contour(reply) => {
                    let report = measurement.map(|done| &done.report);
                    let _ = reply.send(report.and_then(|report| final_contour(report, in_xy)));
                }
                Asked::Parts(reply) => {
                    let parts = measurement.and_then(|done| done.report.parts.clone());
                    let _ = reply.send(parts.map(Arc::new));
                }
                Asked::Section(request, reply) => {
                    let _ = reply.send(measurement.and_then(|done| done.surface.section(&request)));
                }
                Asked::Without(terms, reply) => {
                    let _ = reply.send(measurement.and_then(|done| done.surface.without(&terms)));
                }
            }
        });
    }

    async fn control(&mut self, control: Control) {
        match control {
            Control::Asked(asked) => match &mut self.session {
                None => self.answer(asked),
                Some(Session { ending: None, worker, .. }) => match asked {
                    Asked::MeshPly(reply) => worker.mesh_ply(reply).await,
                    Asked::Section(request, reply) => worker.section(request, reply).await,
                    Asked::Next(reply) => worker.next(reply).await,
                    #[cfg(test)]
                    Asked::Stand(until) => worker.stand(until).await,
                    Asked::Maps(reply) => {
                        let figures = worker.figures();
                        let _ = reply.send(figures.and_then(|figures| figures.maps.clone()));
                    }
                    Asked::Contour(reply) => {
                        let _ = reply.send(worker.contour());
                    }
                    Asked::Parts(reply) => {
                        let _ = reply.send(worker.parts());
                    }
                    Asked::Without(terms, reply) => {
                        let figures = worker.figures();
                        // Some milliseconds, which the links shall not wait for.
                        tokio::task::spawn_blocking(move || {
                            let _ = reply.send(figures.and_then(|figures| figures.without(&terms)));
                        });
                    }
                },
                // The pipeline is busy with the final figures; whoever comes in great number gets none.
                Some(Session { ending: Some(ending), .. }) => {
                    if ending.asked.len() < ASKED {
                        ending.asked.push(asked);
                    }
                }
            },
            Control::Watch => self.open_links().await,
            Control::Start(label, reply) => {
                let started = match self.session {
                    Some(_) => Err(StationError::Running),
                    None => self.begin(label).await,
                };
                let _ = reply.send(started);
            }
            Control::Scan(order, reply) => {
                let _ = reply.send(self.scan(order).await);
            }
            Control::Abandon(reply) => {
                let _ = reply.send(self.abandon().await);
            }
            Control::Stop(reply) => match &self.session {
                Some(session) => {
                    let running = session.ending.is_none();
                    let _ = reply.send(Ok(()));
                    if running {
                        self.stop().await;
                    }
                }
                None => {
                    let _ = reply.send(Err(StationError::NotRunning));
                }
            },
        }
    }

    /// Ends a session at an operator's word, with all that had been read by then.
    async fn stop(&mut self) {
        for _ in 0..EVENTS {
            let Ok(event) = self.events.try_recv() else { break };
            self.event(event).await;
        }
        if self.session.as_ref().is_some_and(|session| session.ending.is_none()) {
            let now = self.clock.now();
            self.bench.advance(now);
            self.end(now, "stopped").await;
        }
    }

    /// Gives up the final figures of a session that is ending; gives its recording, which is whole but for them.
    async fn abandon(&mut self) -> Option<PathBuf> {
        let session = self.session.take_if(|session| session.ending.is_some())?;
        let ending = session.ending?;
        self.view.failed("the figures were given up: the station ends");
        let reason = &ending.outcome.session.ended;
        session.recording.finish(ending.at, reason, None).await.ok()
    }

    /// Begins a session: everything starts anew, the clock, the core and the connections, so that the
    /// recording holds all that a replay needs.
    async fn begin(&mut self, label: Label) -> Result<(), StationError> {
        let bench = assemble(&self.config)?;
        let clock = Clock::start();
        let calibration = bench.calibration();
        if let Some(why) =
            calibration.and_then(|calibration| calibration.refusal(clock.started_wall_ns()))
        {
            return Err(StationError::Calibration(why));
        }
        let header = Header {
            id: SessionId::random().map_err(StationError::Random)?,
            station: self.config.name.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            started_wall_ns: clock.started_wall_ns(),
            config_toml: self.config.text.clone(),
            links: self
                .config
                .links
                .iter()
                .map(|link| LinkInfo {
                    name: link.name.clone(),
                    kind: link.kind.to_owned(),
                    address: link.endpoint.to_string(),
                })
                .collect(),
            label,
        };
        let dir = &self.config.recordings;
        let folder = |source| StationError::Folder { folder: dir.display().to_string(), source };
        std::fs::create_dir_all(dir).map_err(folder)?;
        let mut recorder = Recorder::create(
            dir,
            header.clone(),
            self.config.recording,
            Box::new(Disk),
            clock.now(),
        )
        .map_err(|source| StationError::Record { folder: dir.display().to_string(), source })?;
        info!(folder = %recorder.folder().display(), "session begins");
        // The first entry, so that a replay begins as the session did.
        let start = Entry { at: clock.now(), what: What::Command(Command::Start) };
        recorder
            .append(&start)
            .map_err(|source| StationError::Record { folder: dir.display().to_string(), source })?;
        let recording = Recording::start(recorder, clock.clone()).map_err(folder)?;
        let Config { part, along, tip, contour, parts, .. } = &self.config;
        let (part, plans) = (part.clone(), (contour.clone(), parts.clone()));
        let expected = self.config.expected_points();
        let weighing = Weighing::new(&part, self.config.noise_mm());
        let by_tip = (*along, *tip, self.config.has_systematic());
        let overflow = Overflow::beside(dir, self.config.recording.reserve_bytes);
        let timed = (clock.clone(), overflow);
        let worker = Worker::start(part, by_tip, expected, plans, weighing, timed);
        let worker = worker.map_err(folder)?;
        self.clock = clock;
        self.bench = bench;
        self.decider = scan::Decider::new(self.config.scan.as_ref());
        self.noted.clear();
        self.view.begin(session_figures(&header, ""));
        self.figures = Some(worker.watch());
        self.session = Some(Session { header, recording, worker, ending: None });
        // What the old connections still deliver must not reach the new core: a new channel.
        let (sender, events) = mpsc::channel(EVENTS);
        (self.sender, self.events) = (sender, events);
        self.bench.command(start.at, Command::Start);
        self.open_links().await;
        Ok(())
    }

    /// Opens the links anew. A port is opened for one link alone, so the old ones close first.
    async fn open_links(&mut self) {
        for link in self.links.drain(..) {
            link.close().await;
        }
        self.links = self
            .config
            .links
            .iter()
            .enumerate()
            .map(|(index, link)| {
                let settings = LinkSettings {
                    index,
                    endpoint: link.endpoint.clone(),
                    backoff: link.backoff.clone(),
                };
                Link::spawn(settings, self.sender.clone())
            })
            .collect();
    }

    /// The scan is over: the devices are told, and the final figures are asked for.
    async fn end(&mut self, now: Nanos, ended: &str) {
        info!(ended, "scan over");
        self.bench.flush();
        let points = self.bench.take_points();
        self.note_points(now, &points).await;
        self.record_points(now).await;
        let Some(session) = &mut self.session else { return };
        if !points.is_empty() {
            // A pipeline that died is found when its figures do not come.
            let _ = session.worker.points(points).await;
        }
        let measurement = session.worker.finish(self.bench.systematic()).await;
        let outcome = Outcome::new(&self.bench, session_figures(&session.header, ended));
        session.ending = Some(Ending { at: now, outcome, measurement, asked: Vec::new() });
        self.view.state(State::Finishing);
        self.bench.command(now, Command::Stop);
        Box::pin(self.settle(now)).await;
    }

    /// The final figures are there, or the pipeline died.
    async fn conclude(&mut self, measurement: Option<Measurement>) {
        let Some(session) = self.session.take() else { return };
        // The last of them are no longer shown, and need no memory.
        self.figures = None;
        let Some(ending) = session.ending else { return };
        let Some(mut measurement) = measurement else {
            error!("the pipeline ended without figures");
            self.view.failed("the figures could not be made: the pipeline ended");
            let recording = session.recording.finish(ending.at, "failed", None).await.ok();
            let _ = self.closed.try_send(Err(StationError::Pipeline { recording }));
            return;
        };
        let last_point = ending.outcome.last_point.unwrap_or(ending.at);
        let reason = ending.outcome.session.ended.clone();
        conclude(&mut measurement, ending.outcome);
        let failed = session.recording.stopped();
        if let Some(failure) = &failed {
            undecide(&mut measurement.report.verdict, incomplete(failure));
        }
        let now = self.clock.now();
        let report = &mut measurement.report;
        report.timing = Timing {
            total_s: now.as_secs_f64(),
            after_last_point_s: now.since(last_point).as_secs_f64(),
            points_per_s: report.points.received as f64 / ending.at.as_secs_f64().max(1e-9),
            most_behind_s: session.worker.most_behind_s(),
        };
        // A report is numbers and text; should it be no JSON, the recording still ends without it.
        let results = ResultsJson::encode(&*report).ok();
        let recording = session.recording.finish(ending.at, &reason, results).await;
        // The last writes may fail, too.
        if let (Err(failure), None) = (&recording, &failed) {
            undecide(&mut measurement.report.verdict, incomplete(failure));
        }
        let finished = Arc::new(Finished { measurement, recording: recording.ok() });
        self.report.send_replace(Some(Arc::new(finished.measurement.report.clone())));
        self.view.complete(ending.at, finished.clone());
        ending.asked.into_iter().for_each(|asked| self.answer(asked));
        let config = self.config.output.clone();
        let folder = self.config.recordings.join(session.header.folder_name());
        let commands = self.commands.clone();
        self.leaving.spawn_blocking(move || {
            let outputs = outputs::write(&config, &finished, &folder);
            outputs::run_command(&config, &finished, folder, &commands);
            Closed { finished, outputs }
        });
    }

    /// The results of a session are written.
    fn left(&mut self, left: Result<Closed, JoinError>) {
        let closed = match left {
            Ok(left) => left,
            Err(error) => {
                error!(%error, "the results could not be written");
                let Some(finished) = self.view.finished() else { return };
                let problem = Some("the results could not be written: see the log".to_owned());
                Closed { finished, outputs: Outputs { problem, ..Outputs::default() } }
            }
        };
        if let Some(session) = &closed.finished.measurement.report.session {
            self.view.left(&session.id, closed.outputs.clone());
        }
        // Whoever waited for the end of a session may have gone.
        let _ = self.closed.try_send(Ok(closed));
    }
}

/// The contour of a session that has ended.
fn final_contour(report: &Report, in_xy: bool) -> Option<Arc<SessionContour>> {
    let contour = report.contour.clone()?;
    Some(Arc::new(SessionContour { as_of_points: report.points.received, in_xy, contour }))
}

fn incomplete(failure: &str) -> String {
    format!("the recording is not complete: {failure}")
}

/// The final figures, once a session is ending; never before.
async fn ended(session: &mut Option<Session>) -> Option<Measurement> {
    match session.as_mut().and_then(|session| session.ending.as_mut()) {
        Some(ending) => (&mut ending.measurement).await.ok(),
        None => std::future::pending().await,
    }
}

/// Figures newer than those of the last snapshot, once there are any.
async fn newer_figures(figures: &mut Option<FiguresWatch>) {
    // Figures of a pipeline that has ended get no newer.
    let is_newer = match figures {
        Some(figures) => figures.changed().await.is_ok(),
        None => false,
    };
    if !is_newer {
        std::future::pending::<()>().await;
    }
}

const VIEW_PERIOD: Duration = Duration::from_millis(150);
/// A host later than this was held up: what the links delivered may not have been read.
const HELD_UP: Duration = Duration::from_millis(100);
/// Questions that may wait for the final figures.
const ASKED: usize = 256;
/// Points of a message of the recording, unless they come slowly.
const NOTED: usize = 1024;
/// Reads of ports that may wait for the core.
const EVENTS: usize = 256;
