//! `asphera measure`: the points of a file through the same pipeline.

use std::path::PathBuf;

use clap::Args;

use super::OutputArgs;
use super::exit::Exit;
use super::files::{note_reading, part, pipeline, points_help, topography};
use super::output::{Failure, deliver, refuse_results};
use super::text::TextArgs;
use super::unit_doubt::UnitCheck;
use crate::clock::Clock;
use crate::pipeline::Along;
use crate::report::Timing;

#[derive(Args)]
pub(super) struct MeasureArgs {
    #[arg(help = points_help())]
    file: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    /// The nominal: surface, aperture, what is fitted, tolerances.
    #[arg(long, value_name = "FILE")]
    nominal: PathBuf,
    /// Along which direction the points are projected for their mesh: z, nx,ny,nz, or fitted, from the first
    /// 1000 of them. The nominal's axis is taken to point there.
    #[arg(long, value_name = "DIRECTION", default_value = "z", allow_hyphen_values = true)]
    along: Along,
    #[command(flatten)]
    output: OutputArgs,
    /// Take the points in another order, drawn from this seed.
    #[arg(long, value_name = "SEED")]
    shuffle: Option<u64>,
    /// Threads to use; results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

pub(super) fn run(args: &MeasureArgs) -> Result<Exit, Failure> {
    if let Some(threads) = args.threads {
        rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global()?;
    }
    refuse_results(&args.output)?;
    let part = part(&args.nominal)?;
    let topography = topography(&args.file, &args.text)?;

    let check = UnitCheck::of(&topography, &part);
    let mut pipeline = pipeline(part, args.along, &topography, &args.file)?;
    let clock = Clock::start();
    let mut points: Vec<[f64; 3]> = topography.points().collect();
    if let Some(seed) = args.shuffle {
        shuffle(&mut points, seed);
    }
    pipeline.take_positions(points.iter().copied());
    pipeline.take_gaps(topography.missing() as u64);
    let landed = clock.now();
    let mut measurement = pipeline.finish();
    let done = clock.now();
    measurement.report.timing = Timing {
        total_s: done.as_secs_f64(),
        after_last_point_s: done.since(landed).as_secs_f64(),
        points_per_s: points.len() as f64 / done.as_secs_f64().max(1e-9),
    };
    note_reading(&mut measurement, &topography, check);
    deliver(&measurement, &args.output)?;
    Ok(Exit::of(&measurement.report))
}

/// Fisher and Yates's shuffle, driven by SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
fn shuffle(points: &mut [[f64; 3]], seed: u64) {
    let mut state = seed;
    for last in (1..points.len()).rev() {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut draw = state;
        draw = (draw ^ (draw >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        draw = (draw ^ (draw >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        draw ^= draw >> 31;
        // A multiplication instead of a division: the bias is below 2^-32 for any file that fits memory.
        let other = (u128::from(draw) * (last as u128 + 1)) >> 64;
        points.swap(last, other as usize);
    }
}
