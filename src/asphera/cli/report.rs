//! `asphera report`: a session or a file on paper.

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit::Exit;
use super::face::{self, FaceArgs};
use super::files::{part, refuse, timed};
use super::output::{Failure, print};
use super::progress::Progress;
use super::source::{Content, Source, source_or_volume_help};
use super::summary::summary;
use super::text::TextArgs;
use super::tip::TipArgs;
use super::usage::misused;
use crate::whole_file::write_bytes;
use asphera_measure::{Along, Measurement};
use asphera_paper::{Provenance, SourceFile, html, qif};
use asphera_report::Label;

use crate::results::command_line;

#[derive(Args)]
pub(super) struct ReportArgs {
    #[arg(help = source_or_volume_help())]
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    /// The report: one HTML file that needs nothing beside itself, and prints on A4.
    #[arg(short, long, value_name = "OUT.html")]
    out: PathBuf,
    /// Write the results as a QIF 3 document too.
    #[arg(long, value_name = "OUT.xml")]
    qif: Option<PathBuf>,
    /// The nominal; a recording without it is held against its own.
    #[arg(long, value_name = "FILE")]
    nominal: Option<PathBuf>,
    /// Along which direction the points are projected for their mesh: z, nx,ny,nz, or fitted, from the first 1000 of
    /// them. none: they are meshed in space. auto: along z, and in space where they fold. Without it that of the recording, or z.
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    along: Option<Along>,
    #[command(flatten)]
    tip: TipArgs,
    #[command(flatten)]
    face: FaceArgs,
    /// What was measured: name or drawing number, for the head of the report. It goes before that of the recording.
    #[arg(long, value_name = "TEXT")]
    part: Option<String>,
    /// The serial number of the part.
    #[arg(long, value_name = "TEXT")]
    serial: Option<String>,
    /// Who measured it.
    #[arg(long, value_name = "TEXT")]
    operator: Option<String>,
    /// Overwrite --out and --qif if they are there.
    #[arg(long)]
    force: bool,
}

impl ReportArgs {
    /// The files that are read.
    fn read(&self) -> impl Iterator<Item = &Path> {
        let others = self.nominal.as_deref().into_iter().chain(self.face.second());
        [&*self.source].into_iter().chain(others)
    }
}

pub(super) fn run(args: &ReportArgs) -> Result<Exit, Failure> {
    refuse(&args.out, args.read(), args.force)?;
    if let Some(qif) = &args.qif {
        refuse(qif, args.read(), args.force)?;
        if *qif == args.out {
            return Err(misused(format!("--out and --qif are both {}", qif.display())));
        }
    }
    let label = Label {
        part: args.part.clone(),
        serial: args.serial.clone(),
        operator: args.operator.clone(),
    };
    let label = label.tidied().map_err(|problem| misused(format!("--{problem}")))?;
    let mut provenance = Provenance { label, command: command_line(), ..Provenance::default() };
    let given = args.nominal.as_deref().map(part).transpose()?;
    let progress = Progress::start("report");
    if face::is_volume(&args.source)? {
        args.tip.refuse("a volume holds values of cells")?;
        provenance.files = files_of_volume(args)?;
        let faces = face::measured(&args.source, &args.face, given, args.along, None, &progress)?;
        return deliver(args, &faces.first, &provenance, progress);
    }
    args.face.refuse(&args.source)?;
    let source = Source::open(&args.source, &args.text, &progress)?;
    refuse(&args.out, [source.file()], args.force)?;
    let part = source.needed_part(given)?;
    provenance.files = match source.content() {
        Content::File(_) => vec![SourceFile::read(source.file())?],
        Content::Session(_) => SourceFile::read_session(source.file())?,
    };
    if let Some(nominal) = &args.nominal {
        provenance.files.push(SourceFile::read(nominal)?);
    }
    if let Some(origin) = source.origin() {
        provenance.date = origin.date.clone();
        provenance.instrument = origin.instrument.clone();
    }
    let along = source.along(args.along);
    let tip = args.tip.tip(&source, along)?;
    let (measurement, _) = timed(part, (along, tip), &source, None, &progress)?;
    deliver(args, &measurement, &provenance, progress)
}

/// The files that the report of a volume is made from; of a folder of slices none is named.
fn files_of_volume(args: &ReportArgs) -> Result<Vec<SourceFile>, Failure> {
    let volume = Some(args.source.as_path()).filter(|path| path.is_file());
    let nominals = args.nominal.as_deref().into_iter().chain(args.face.second());
    let files = volume.into_iter().chain(nominals);
    Ok(files.map(SourceFile::read).collect::<Result<_, _>>()?)
}

/// Writes the papers and prints the summary.
fn deliver(
    args: &ReportArgs,
    measurement: &Measurement,
    provenance: &Provenance,
    progress: Progress,
) -> Result<Exit, Failure> {
    progress.stage("drawing the report");
    write_bytes(&args.out, html(measurement, provenance))?;
    if let Some(path) = &args.qif {
        write_bytes(path, qif(&measurement.report, provenance))?;
    }
    drop(progress);
    print(&summary(&measurement.report, false));
    Ok(Exit::of(&measurement.report))
}
