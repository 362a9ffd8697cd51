//! `asphera replay`.

use std::path::PathBuf;

use asphera_link::Nanos;
use asphera_report::Timing;
use clap::Args;

use super::exit::Exit;
use super::files::{part, refuse_weights};
use super::output::{Failure, deliver, refuse_results};
use super::progress::Progress;
use super::source::session_at;
use super::{OutputArgs, Speed};
use crate::clock::Clock;
use crate::replay::{Playback, paced};
use crate::weighing::Weighing;
use asphera_measure::Pipeline;

#[derive(Args)]
pub(super) struct ReplayArgs {
    /// The recording: a folder session-…, one of its segments, or a folder of --out with one.
    session: PathBuf,
    /// How many times as fast as it was recorded, or max. The result does not depend on it.
    #[arg(long, default_value = "max")]
    speed: Speed,
    /// Hold the same points against this nominal instead of the recorded one.
    #[arg(long, value_name = "FILE")]
    nominal: Option<PathBuf>,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &ReplayArgs) -> Result<Exit, Failure> {
    refuse_results(&args.output)?;
    let session = session_at(&args.session)?;
    let given = args.nominal.as_deref().map(part).transpose()?;
    let progress = Progress::start("replay");
    let clock = Clock::start();
    let mut pace: Box<dyn FnMut(Nanos)> = match args.speed {
        Speed::Max => Box::new(|_| {}),
        Speed::Times(times) => Box::new(paced(times, clock.clone())),
    };
    let playback = Playback::open(&session)?;
    let part = given.unwrap_or_else(|| playback.part().clone());
    let weighing = Weighing::new(&part, playback.noise_mm());
    refuse_weights(&part, &weighing, &session)?;
    let mut pipeline = Pipeline::along(part, playback.along()).with_tip(playback.tip());
    progress.count("replaying", None);
    let played = playback.play(&mut pace, |point| {
        pipeline.take(weighing.weighed(point), point.reasons());
        progress.add(1);
    });
    pipeline.know_systematic(played.systematic());
    let mut measurement = pipeline.finish_by_steps(&mut |step| progress.step(step));
    played.conclude(&mut measurement);
    let total_s = clock.now().as_secs_f64();
    let report = &mut measurement.report;
    report.timing = Timing {
        total_s,
        after_last_point_s: 0.0,
        points_per_s: report.points.received as f64 / total_s.max(1e-9),
        most_behind_s: 0.0,
    };
    deliver(&measurement, &args.output, Some(progress))?;
    Ok(Exit::of(&measurement.report))
}
