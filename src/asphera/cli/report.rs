//! `asphera report`: a session or a file on paper.

use std::fs;
use std::path::{Path, PathBuf};

use asphera_formats::KINDS;
use clap::Args;

use super::exit::Exit;
use super::files::{measured, part, refuse, topography};
use super::output::{Failure, print};
use super::summary;
use super::text::TextArgs;
use crate::paper::{Provenance, SourceFile, html, qif};
use crate::pipeline::{Along, Measurement};
use crate::replay::replay;

#[derive(Args)]
pub(super) struct ReportArgs {
    #[arg(help = format!(
        "A recording (a folder session-…, or one of its segments .mcap), or the points of a file: {KINDS}"
    ))]
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    /// The report: one HTML file that needs nothing beside itself, and prints on A4.
    #[arg(short, long, value_name = "OUT.html")]
    out: PathBuf,
    /// Write the results as a QIF 3 document too.
    #[arg(long, value_name = "OUT.xml")]
    qif: Option<PathBuf>,
    /// The nominal, for points of a file; a recording holds its own.
    #[arg(long, value_name = "FILE")]
    nominal: Option<PathBuf>,
    /// Along which direction the points of a file are projected for their mesh: z, nx,ny,nz, or fitted, from
    /// the first 1000 of them.
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    along: Option<Along>,
    /// What was measured: a name or serial number for the head of the report.
    #[arg(long, value_name = "TEXT")]
    part: Option<String>,
    /// Overwrite --out and --qif if they are there.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &ReportArgs) -> Result<Exit, Failure> {
    refuse(&args.out, &args.source, args.force)?;
    if let Some(qif) = &args.qif {
        refuse(qif, &args.source, args.force)?;
        if *qif == args.out {
            return Err(format!("--out and --qif are both {}", qif.display()).into());
        }
    }
    let command: Vec<String> =
        std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
    let mut provenance =
        Provenance { part: args.part.clone(), command: command.join(" "), ..Provenance::default() };
    let measurement = if is_recording(&args.source) {
        recorded(args, &mut provenance)?
    } else {
        of_file(args, &mut provenance)?
    };
    write(&args.out, &html(&measurement, &provenance))?;
    if let Some(path) = &args.qif {
        write(path, &qif(&measurement.report, &provenance))?;
    }
    print(&summary::of(&measurement.report));
    Ok(Exit::of(&measurement.report))
}

fn recorded(args: &ReportArgs, provenance: &mut Provenance) -> Result<Measurement, Failure> {
    for (given, name) in [(args.nominal.is_some(), "--nominal"), (args.along.is_some(), "--along")]
    {
        if given {
            return Err(format!(
                "{name} is for points of a file; {} is a recording, which holds its own configuration",
                args.source.display()
            )
            .into());
        }
    }
    provenance.files = SourceFile::of_session(&args.source)?;
    Ok(replay(&args.source, |_| {})?)
}

fn of_file(args: &ReportArgs, provenance: &mut Provenance) -> Result<Measurement, Failure> {
    let Some(nominal) = &args.nominal else {
        return Err(format!(
            "{} is a file of points: --nominal FILE says what the part should be",
            args.source.display()
        )
        .into());
    };
    let topography = topography(&args.source, &args.text)?;
    provenance.files = vec![SourceFile::of(&args.source)?, SourceFile::of(nominal)?];
    provenance.date = topography.source().date.clone();
    provenance.instrument = topography.source().instrument.clone();
    measured(part(nominal)?, args.along.unwrap_or(Along::Z), &topography, &args.source)
}

fn is_recording(source: &Path) -> bool {
    source.is_dir() || source.extension().is_some_and(|extension| extension == "mcap")
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    fs::write(path, text)
        .map_err(|error| format!("cannot write {}: {error}", path.display()).into())
}
