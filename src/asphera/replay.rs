//! A recorded session once more, through the same core and pipeline.

use std::path::Path;
use std::time::Duration;

use asphera_calibrate::Machine;
use asphera_contour::PlaceMm;
use asphera_link::Nanos;
use asphera_report::{SessionFigures, Verdict};
use thiserror::Error;

use crate::conclude::{Outcome, conclude, note_recovery, session_figures};
use asphera_measure::Part;

use crate::config::{Config, Problems};
use crate::contour::ContourPlan;
use crate::parts::{PartsPlan, RunningParts};
use crate::session::{self, Recovery, Session, What};
use crate::station::{AssembleError, Bench, Happening, Point, assemble};
use crate::weighing::Weighing;
use asphera_measure::{Along, Measurement, Pipeline, Systematic, Tip};

/// Why a session cannot be replayed.
#[derive(Debug, Error)]
pub enum ReplayError {
    /// The recording cannot be read.
    #[error("cannot read the recording")]
    Read(#[from] session::ReadError),
    /// The configuration in the recording cannot be used by this version.
    #[error("the configuration in the recording cannot be used:\n{0}")]
    Config(Problems),
    /// A driver refused its settings.
    #[error(transparent)]
    Assemble(#[from] AssembleError),
    /// Readings of its axes are more than three numbers a point.
    #[error(
        "expected a session of kind \"cartesian\" or \"polar\", or of a part that does not turn, found a line scanner or a tilting probe \
         over a part that turns: write its points to a file without [calibration], and give that file with --machine polar"
    )]
    NoBareReadings,
}

/// A recording whose configuration can be used, ready to be played.
pub struct Playback {
    session: Session,
    config: Config,
    bench: Bench,
}

/// The state of a recording that was played to its end: what its links delivered, and what it lacks.
#[derive(Clone, Debug)]
pub struct Played {
    outcome: Outcome,
    /// Errors that all its points have together.
    systematic: Vec<Systematic>,
    recovery: Recovery,
    /// The contour that the recording asks for, and the places it is of.
    contour: Option<(ContourPlan, Vec<PlaceMm>)>,
    /// The parts that it asks for.
    parts: Option<(PartsPlan, RunningParts)>,
}

impl Playback {
    /// Opens a recording: a session's folder, or one of its segments.
    ///
    /// # Errors
    ///
    /// When there is nothing to replay.
    pub fn open(path: &Path) -> Result<Playback, ReplayError> {
        let session = Session::open(path)?;
        let config = Config::parse("config.toml of the recording", session.config_toml())
            .map_err(ReplayError::Config)?;
        let bench = assemble(&config)?;
        Ok(Playback { session, config, bench })
    }

    /// The machine, and the recording with the bare readings of its axes for points: uncorrected, of a polar machine angle in
    /// rad, radius and height.
    ///
    /// # Errors
    ///
    /// As [`Playback::open`], and where readings of the axes are more than three numbers a point.
    pub fn bare(mut self) -> Result<(Machine, Playback), ReplayError> {
        let machine = self.config.kinematics.machine();
        self.config.kinematics =
            self.config.kinematics.bare().ok_or(ReplayError::NoBareReadings)?;
        self.config.calibration = None;
        self.config.tip = None;
        if let Some(thermal) = self.config.thermal.as_mut() {
            thermal.starts_with_angle = machine == Machine::Polar;
        }
        self.config.contour = None;
        self.config.parts = None;
        self.bench = assemble(&self.config)?;
        Ok((machine, self))
    }

    /// The part as the recording names it.
    pub fn part(&self) -> &Part {
        &self.config.part
    }

    /// Noise of the heights of its points, mm, where they were joined by time and it is stated.
    pub fn noise_mm(&self) -> Option<f64> {
        self.config.noise_mm()
    }

    /// The ball tip as the recording names it.
    pub fn tip(&self) -> Option<Tip> {
        self.config.tip
    }

    /// The direction of projection as the recording names it.
    pub fn along(&self) -> Along {
        self.config.along
    }

    /// Hands every point to `take`, good and flagged ones, in the order of the live run. `pace` is called before each
    /// entry with its time, and may wait. Damage within a recording is passed over and counted.
    pub fn play(self, mut pace: impl FnMut(Nanos), mut take: impl FnMut(&Point)) -> Played {
        let Playback { session, mut config, mut bench } = self;
        let mut contour = config.contour.take().map(|plan| (plan, Vec::new()));
        let mut parts = config.parts.take().map(|plan| {
            let running = RunningParts::new(&plan);
            (plan, running)
        });
        let mut take = |point: &Point| {
            if let Some((plan, running)) = parts.as_mut().filter(|_| point.is_good()) {
                let ended = running.take(&[point.position_mm]);
                ended.iter().for_each(|part| running.add(plan.judge(part)));
            }
            if let Some((plan, places)) = contour.as_mut().filter(|_| point.is_good()) {
                places.extend(plan.place(point.position_mm));
            }
            take(point);
        };
        let mut epochs = vec![0; config.links.len()];
        let mut ended = None;
        let mut entries = session.entries();
        while ended.is_none() {
            let Some(entry) = entries.next() else { break };
            // What cannot be read is counted by the reader and said at the end.
            let Ok(entry) = entry else { continue };
            pace(entry.at);
            let now = entry.at;
            match &entry.what {
                What::Opened { link } => {
                    epochs[*link] += 1;
                    bench.happened(now, *link, Happening::Opened { epoch: epochs[*link] });
                }
                What::Received { link, bytes } => {
                    bench.happened(now, *link, Happening::Received(bytes));
                }
                What::Closed { link, reason } => {
                    bench.happened(now, *link, Happening::Closed(reason));
                }
                What::Command(command) => bench.command(now, *command),
                // An order that was refused was not recorded.
                What::Scan(order) => drop(bench.scan(now, order)),
                What::HeldUp { until, suspended } => {
                    // What had been due by then had been done.
                    bench.advance(now);
                    bench.held_up(*until, *suspended);
                }
                What::Finish { reason } => {
                    // Why it ended was decided then; the rest of the time only has to pass.
                    bench.advance(now);
                    settle(&mut bench, &mut take);
                    ended = Some(reason.clone());
                    break;
                }
                // Points are made anew of what was received.
                What::Sent { .. } | What::Points(_) | What::Results(_) => continue,
            }
            settle(&mut bench, &mut take);
            if let Some(end) = bench.ended(now) {
                ended = Some(end.word().to_owned());
            }
        }
        let ended = ended.unwrap_or_else(|| {
            // Killed: what a driver still held back is counted as it is when a link is lost.
            for line in 0..config.links.len() {
                bench.happened(bench.now(), line, Happening::Closed("the recording ends here"));
            }
            "interrupted".to_owned()
        });
        bench.flush();
        settle(&mut bench, &mut take);
        let outcome = Outcome::new(&bench, session_figures(session.header(), &ended));
        let systematic = bench.systematic();
        // Reading on to the end shows whether the rest of the recording is whole.
        entries.by_ref().for_each(drop);
        Played { outcome, systematic, recovery: entries.recovery().clone(), contour, parts }
    }
}

impl Played {
    /// Adds to the figures of the points what the station and the recording know: contour, links, session, losses.
    pub fn conclude(self, measurement: &mut Measurement) {
        if let Some((plan, places)) = self.contour {
            plan.conclude(plan.contour(&places), measurement);
        }
        if let Some((plan, mut running)) = self.parts {
            let ended = running.finish();
            ended.iter().for_each(|part| running.add(plan.judge(part)));
            plan.conclude(running.found(), measurement);
        }
        conclude(measurement, self.outcome);
        note_recovery(&mut measurement.report.verdict, &self.recovery);
    }

    /// Errors that all its points have together, as far as their uncertainties are known.
    pub fn systematic(&self) -> impl Iterator<Item = Systematic> {
        self.systematic.iter().cloned()
    }

    /// The contour that the recording asks for.
    pub fn contour(&self) -> Option<&ContourPlan> {
        self.contour.as_ref().map(|(plan, _)| plan)
    }

    /// Losses of the session and of its recording, in the words of the verdict.
    pub fn losses(&self) -> Vec<String> {
        let mut verdict = Verdict::default();
        self.outcome.judge(&mut verdict);
        note_recovery(&mut verdict, &self.recovery);
        verdict.reasons
    }

    /// The session: id, start, station and end.
    pub fn session(&self) -> &SessionFigures {
        &self.outcome.session
    }
}

/// Replays a recording. `pace` is called before each entry with its time, and may wait.
///
/// The result is that of the live run, bit for bit, apart from its timing. What a damaged recording lacks
/// is said in the verdict's reasons.
///
/// # Errors
///
/// When there is nothing to replay. Damage within a recording is passed over and counted.
pub fn replay(path: &Path, pace: impl FnMut(Nanos)) -> Result<Measurement, ReplayError> {
    let playback = Playback::open(path)?;
    let mut pipeline =
        Pipeline::along(playback.part().clone(), playback.along()).with_tip(playback.tip());
    let weighing = Weighing::new(playback.part(), playback.noise_mm());
    let played =
        playback.play(pace, |point| pipeline.take(weighing.weighed(point), point.reasons()));
    pipeline.know_systematic(played.systematic());
    let mut measurement = pipeline.finish();
    played.conclude(&mut measurement);
    Ok(measurement)
}

/// Actions are dropped, as the live run did them; points go on.
fn settle(bench: &mut Bench, take: &mut impl FnMut(&Point)) {
    while bench.poll_action().is_some() {}
    bench.take_points().iter().for_each(take);
}

/// Waits so that entries come `speed` times as fast as they were recorded.
pub fn paced(speed: f64, clock: crate::clock::Clock) -> impl FnMut(Nanos) {
    move |at| {
        let due = Duration::try_from_secs_f64(at.as_secs_f64() / speed).unwrap_or(Duration::MAX);
        let passed = clock.now().since(Nanos::ZERO);
        if let Some(wait) = due.checked_sub(passed) {
            // Nothing else happens on this thread.
            std::thread::park_timeout(wait);
        }
    }
}
