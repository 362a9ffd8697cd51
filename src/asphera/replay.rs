//! A recorded session once more, through the same core and pipeline.

use std::path::Path;
use std::time::Duration;

use asphera_link::Nanos;
use thiserror::Error;

use crate::conclude::{Outcome, conclude, note_recovery, session_figures};
use crate::config::{Config, Problems};
use crate::pipeline::{Measurement, Pipeline};
use crate::session::{self, Session, What};
use crate::station::{AssembleError, Bench, Happening, assemble};

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
}

/// Replays a recording. `pace` is called before each entry with its time, and may wait.
///
/// The result is that of the live run, bit for bit, apart from its timing. What a damaged recording lacks
/// is said in the verdict's reasons.
///
/// # Errors
///
/// When there is nothing to replay. Damage within a recording is passed over and counted.
pub fn replay(path: &Path, mut pace: impl FnMut(Nanos)) -> Result<Measurement, ReplayError> {
    let session = Session::open(path)?;
    let config = Config::parse("config.toml of the recording", session.config_toml())
        .map_err(ReplayError::Config)?;
    let mut bench = assemble(&config)?;
    let mut pipeline = Pipeline::along(config.part, config.along);
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
            What::Closed { link, reason } => bench.happened(now, *link, Happening::Closed(reason)),
            What::Command(command) => bench.command(now, *command),
            What::HeldUp { until } => {
                // What had been due by then had been done.
                bench.advance(now);
                bench.held_up(*until);
            }
            What::Finish { reason } => {
                // Why it ended was decided then; the rest of the time only has to pass.
                bench.advance(now);
                settle(&mut bench, &mut pipeline);
                ended = Some(reason.clone());
                break;
            }
            What::Sent { .. } | What::Results(_) => continue,
        }
        settle(&mut bench, &mut pipeline);
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
    settle(&mut bench, &mut pipeline);
    let outcome = Outcome::of(&bench, session_figures(session.header(), &ended));
    let mut measurement = pipeline.finish();
    conclude(&mut measurement, outcome);
    // Reading on to the end shows whether the rest of the recording is whole.
    entries.by_ref().for_each(drop);
    note_recovery(&mut measurement, entries.recovery());
    Ok(measurement)
}

/// What the core wants done has been done, in the live run; its points go on.
fn settle(bench: &mut Bench, pipeline: &mut Pipeline) {
    while bench.poll_action().is_some() {}
    bench.take_points().iter().for_each(|point| pipeline.take(point));
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
