//! `asphera replay`.

use std::path::PathBuf;

use asphera_link::Nanos;
use clap::Args;

use super::exit::Exit;
use super::output::{Failure, deliver, refuse_results};
use super::{OutputArgs, Speed};
use crate::clock::Clock;
use crate::replay::{paced, replay};
use crate::report::Timing;

#[derive(Args)]
pub(super) struct ReplayArgs {
    /// The recording: a folder session-…, or one of its segments.
    session: PathBuf,
    /// How many times as fast as it was recorded, or max. The result does not depend on it.
    #[arg(long, default_value = "max")]
    speed: Speed,
    #[command(flatten)]
    output: OutputArgs,
}

pub(super) fn run(args: &ReplayArgs) -> Result<Exit, Failure> {
    refuse_results(&args.output)?;
    let clock = Clock::start();
    let mut pace: Box<dyn FnMut(Nanos)> = match args.speed {
        Speed::Max => Box::new(|_| {}),
        Speed::Times(times) => Box::new(paced(times, clock)),
    };
    let mut measurement = replay(&args.session, &mut pace)?;
    let total_s = clock.now().as_secs_f64();
    let report = &mut measurement.report;
    report.timing = Timing {
        total_s,
        after_last_point_s: 0.0,
        points_per_s: report.points.received as f64 / total_s.max(1e-9),
    };
    deliver(&measurement, &args.output)?;
    Ok(Exit::of(&measurement.report))
}
