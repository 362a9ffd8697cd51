//! `asphera parts`: the parts of a scene, each with its place and its holes; with a library, which entry each one is.

mod figures;
mod files;
mod summary;

use std::path::{Path, PathBuf};

use asphera_formats::{Cloud as Points, Format};
use asphera_geometry::PointMm;
use asphera_graph::compare::Size;
use asphera_graph::{Cloud, auto_tau_mm};
use asphera_measure::{Along, Measurement, Part};
use asphera_report::parts::PartReport;
use clap::Args;

use self::figures::PartsReport;
use super::exit::Exit;
use super::files::measured;
use super::graph::TauArg;
use super::output::{Failure, print, print_json};
use super::progress::Progress;
use super::sampled::SampledArgs;
use super::source::{Source, source_help};
use super::text::TextArgs;
use super::threads::ThreadArgs;
use super::usage::misused;
use crate::parts::{Library, Scene, form, judged, matched};

#[derive(Args)]
pub(super) struct PartsArgs {
    #[arg(help = source_help())]
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    #[command(flatten)]
    sampled: SampledArgs,
    /// Points nearer than this belong to one part; auto takes some six spacings of the points.
    #[arg(long, value_name = "auto|MM", default_value = "auto")]
    tau: TauArg,
    /// The folder of what parts may be: nominals (.toml), lens files (.zmx), meshes and earlier scans, in mm. The scene is seen from
    /// +z.
    #[arg(long, value_name = "DIR")]
    library: Option<PathBuf>,
    /// The largest difference of a part from an entry that fits, RMS; auto takes three times the noise of the points and 1/2000 of
    /// the part's diameter.
    #[arg(long, value_name = "auto|MM", default_value = "auto", requires = "library")]
    within: TauArg,
    /// Recognise parts whatever their size; touching parts are not taken apart then.
    #[arg(long, requires = "library", conflicts_with = "measure")]
    scale_free: bool,
    /// Measure each part with its nominal, which confirms the match, or does not.
    #[arg(long, requires = "library")]
    measure: bool,
    /// Write parts.json, points.ply with the part of every point, and the points of each part as part-1.ply, part-2.ply, … into this
    /// folder; results of parts that were measured into part-1, part-2, ….
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite such files if they are there.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Print the figures as one JSON object on stdout, and nothing else there.
    #[arg(long)]
    json: bool,
}

/// The points of a scene as they were read.
struct Read<'a> {
    path: &'a Path,
    /// In mm, in the order of the file.
    points: &'a [PointMm],
    /// The standard uncertainties of their heights in mm; empty where the file has none.
    u_mm: &'a [f64],
    format: Format,
    progress: &'a Progress,
}

impl Read<'_> {
    /// Measures points of a part in the frame of its nominal.
    fn measured(
        &self,
        nominal: Part,
        points_mm: Vec<PointMm>,
        uncertainties_mm: Vec<f64>,
    ) -> Result<Measurement, Failure> {
        let cloud = Points { points_mm, uncertainties_mm, ..Points::default() };
        let source = Source::of_cloud(self.path, cloud, self.format);
        measured(nominal, Along::Z, &source, self.progress)
    }
}

/// All that was found of a scene.
struct Done {
    report: PartsReport,
    scene: Scene,
    /// Of each part, if it was measured.
    measurements: Vec<Option<Measurement>>,
    exit: Exit,
}

/// Fails where results would be taken for nominals the next time.
fn refuse_library(out: &Path, library: &Path) -> Result<(), Failure> {
    match (out.canonicalize(), library.canonicalize()) {
        (Ok(out), Ok(library)) if out == library => Err(misused(format!(
            "--out and --library are both {}: expected two folders",
            out.display()
        ))),
        _ => Ok(()),
    }
}

pub(super) fn run(args: &PartsArgs) -> Result<Exit, Failure> {
    let progress = Progress::start("parts");
    // A library that cannot be used is told before long reading.
    let library = args.library.as_deref();
    if library.is_some() {
        progress.stage("reading the library");
    }
    let scan = |path: &Path| {
        let source = Source::open(path, &TextArgs::default(), &progress);
        source.map(|source| source.points().collect()).map_err(|error| error.to_string())
    };
    if let (Some(library), Some(out)) = (library, &args.out) {
        refuse_library(out, library)?;
    }
    let library = library.map(|folder| Library::open(folder, &scan)).transpose()?;
    let source = args.sampled.open(&args.source, &args.text, &progress)?;
    let points: Vec<PointMm> = source.points().collect();
    let (u_mm, format) = source.uncertainties_mm();
    let path = &*args.source;
    let done = args.threads.run(|| {
        let read = Read { path, points: &points, u_mm, format, progress: &progress };
        done(args, &read, library.as_ref())
    })?;
    if let Some(folder) = &args.out {
        progress.stage("writing");
        let out = files::Out { folder, source: path, overwrite: args.force };
        out.write(&done, &points)?;
    }
    drop(progress);
    if args.json {
        print_json(&done.report)?;
    } else {
        print(&done.report.summary());
    }
    source.say_reading();
    Ok(done.exit)
}

/// Finds the parts of a scene, what they are, and their form.
fn done(args: &PartsArgs, read: &Read<'_>, library: Option<&Library>) -> Result<Done, Failure> {
    let file = read.path.display().to_string();
    read.progress.stage("parting");
    let cloud = Cloud::new(read.points).map_err(|error| format!("{file}: {error}"))?;
    if cloud.is_empty() {
        return Err(format!("{file}: no points: expected one at least; check the file").into());
    }
    // A single place has no spacing; any tau gives the same part.
    let tau_mm = args.tau.0.or_else(|| auto_tau_mm(&cloud)).unwrap_or(1.0);
    let size = if args.scale_free { Size::Free } else { Size::Counts };
    let scene = Scene::new(&cloud, tau_mm, library, (size, args.within.0))?;
    let (mut parts, mut measurements, mut exit) = (Vec::new(), Vec::new(), Exit::Done);
    for part in &scene.parts {
        let found = part.recognition.as_ref().zip(library);
        let mut found = found.map(|(found, library)| matched(found, library, size));
        let library = library
            .filter(|_| args.measure && found.as_ref().is_some_and(|found| found.reason.is_none()));
        let formed = match library {
            Some(library) => {
                form(part, (read.points, read.u_mm), library, &|part, points, u_mm| {
                    read.measured(part, points, u_mm)
                })?
            }
            None => None,
        };
        if args.measure && found.as_ref().is_some_and(|found| found.reason.is_some()) {
            exit = exit.or(Exit::Undecided);
        }
        let (mut form_figures, mut measurement) = (None, None);
        if let Some(formed) = formed {
            exit = exit.or(match formed.reason {
                Some(_) => Exit::Undecided,
                None => Exit::of(&formed.measurement.report),
            });
            found = found.map(|found| judged(found, formed.reason));
            (form_figures, measurement) = (formed.form, Some(formed.measurement));
        }
        parts.push(PartReport { figures: part.figures.clone(), found, form: form_figures });
        measurements.push(measurement);
    }
    let report = PartsReport {
        format: "asphera.parts/1",
        file,
        points: read.points.len() as u64,
        spacing_mm: cloud.spacing_mm().unwrap_or(0.0),
        tau_mm,
        entries: library.map(|library| library.entries.len()),
        parts,
        islands: scene.islands,
        island_points: scene.island_points,
        crumbs: scene.crumbs,
    };
    Ok(Done { report, scene, measurements, exit })
}

#[cfg(test)]
mod tests;
