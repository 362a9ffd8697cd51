//! `asphera measure`: the points of a file or a session through the same pipeline.

use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;

use clap::Args;

use super::OutputArgs;
use super::exit::Exit;
use super::face::{self, FaceArgs, Faces, name_of};
use super::files::{part, timed};
use super::output::{Failure, deliver, refuse_results};
use super::progress::Progress;
use super::serve::{bound, show};
use super::source::{Source, source_or_volume_help};
use super::text::TextArgs;
use super::threads::ThreadArgs;
use super::tip::TipArgs;
use crate::results;
use crate::shown::ShownMeasurement;
use asphera_measure::{Along, Part};

#[derive(Args)]
pub(super) struct MeasureArgs {
    #[arg(help = source_or_volume_help())]
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    /// The nominal: surface, aperture, what is fitted, tolerances. A session without it is held against its own.
    #[arg(long, value_name = "FILE")]
    nominal: Option<PathBuf>,
    /// Along which direction the points are projected for their mesh: z, nx,ny,nz, or fitted, from the first
    /// 1000 of them. The nominal's axis is taken to point there. none: they are meshed in space. auto: along z, and in space where they fold.
    /// Without it that of the session, or z.
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    along: Option<Along>,
    #[command(flatten)]
    tip: TipArgs,
    #[command(flatten)]
    face: FaceArgs,
    #[command(flatten)]
    output: OutputArgs,
    /// Show the measurement on the page at this address until Ctrl-C; of a volume with slices, faces and forbidden cells.
    #[arg(long, value_name = "ADDR")]
    listen: Option<SocketAddr>,
    /// Take the points in another order, drawn from this seed.
    #[arg(long, value_name = "SEED")]
    shuffle: Option<u64>,
    #[command(flatten)]
    threads: ThreadArgs,
}

pub(super) fn run(args: &MeasureArgs) -> Result<Exit, Failure> {
    args.threads.limit_process()?;
    refuse_results(&args.output)?;
    let page = args.listen.map(bound).transpose()?;
    // A nominal that cannot be used is told before long reading.
    let given = args.nominal.as_deref().map(part).transpose()?;
    let progress = Progress::start("measure");
    if face::is_volume(&args.source)? {
        args.tip.refuse("a volume holds values of cells")?;
        return of_volume(args, given, page, progress);
    }
    args.face.refuse(&args.source)?;
    let source = Source::open(&args.source, &args.text, &progress)?;
    let part = source.needed_part(given)?;
    let along = source.along(args.along);
    let tip = args.tip.tip(&source, along)?;
    let (mut measurement, timing) = timed(part, (along, tip), &source, args.shuffle, &progress)?;
    measurement.report.timing = timing;
    deliver(&measurement, &args.output, Some(progress))?;
    let exit = Exit::of(&measurement.report);
    if let Some(page) = page {
        show(ShownMeasurement::new(&name_of(&args.source), measurement, None), page)?;
    }
    Ok(exit)
}

/// Measures a face of a volume, or two; results of the second go into a folder of their own.
fn of_volume(
    args: &MeasureArgs,
    given: Option<Part>,
    page: Option<TcpListener>,
    progress: Progress,
) -> Result<Exit, Failure> {
    if args.face.second().is_some() {
        refuse_results(&of_second(&args.output))?;
    }
    let faces =
        face::measured(&args.source, &args.face, given, args.along, args.shuffle, &progress)?;
    let exit = deliver_faces(&faces, &args.output, progress)?;
    if let Some(page) = page {
        show(faces.shown(&args.source)?, page)?;
    }
    Ok(exit)
}

/// Writes and prints the figures of a face, and writes those of a second one.
pub(super) fn deliver_faces(
    faces: &Faces,
    output: &OutputArgs,
    progress: Progress,
) -> Result<Exit, Failure> {
    let Faces { first, second, .. } = faces;
    if let (Some(second), Some(folder)) = (second, &of_second(output).out) {
        results::write(folder, second)?;
    }
    deliver(first, output, Some(progress))?;
    let of_second = second.as_ref().map_or(Exit::Done, |second| Exit::of(&second.report));
    Ok(Exit::of(&first.report).or(of_second))
}

/// Where the results of the second face go.
fn of_second(output: &OutputArgs) -> OutputArgs {
    let out = output.out.as_ref().map(|folder| folder.join(SECOND));
    OutputArgs { out, ..output.clone() }
}

/// The folder of the results of the second face.
const SECOND: &str = "second";
