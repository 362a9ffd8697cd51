//! `asphera parts`: the parts of a scene, each with its place and its holes.

use std::fmt::Write as _;
use std::path::PathBuf;

use asphera_formats::ply;
use asphera_graph::{Choices, Cloud, auto_tau_mm, extract, functions};
use clap::Args;
use serde::Serialize;

use super::exit::Exit;
use super::files::refuse;
use super::graph::figures::{PartFigures, part_line, parts_of};
use super::graph::{TauArg, in_pool};
use super::output::{Failure, print, print_json, write_json};
use super::progress::Progress;
use super::source::{Source, source_help};
use super::text::TextArgs;

#[derive(Args)]
pub(super) struct PartsArgs {
    #[arg(help = source_help())]
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    /// Points nearer than this belong to one part; auto takes some six spacings of the points.
    #[arg(long, value_name = "auto|MM", default_value = "auto")]
    tau: TauArg,
    /// Write parts.json, and the points of each part as part-1.ply, part-2.ply, … into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Overwrite such files if they are there.
    #[arg(long)]
    force: bool,
    /// Threads to use; results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print the figures as one JSON object on stdout, and nothing else there.
    #[arg(long)]
    json: bool,
}

/// The parts of a scene. Lengths are mm of the file's frame.
#[derive(Debug, Serialize)]
struct PartsReport {
    format: &'static str,
    file: String,
    points: u64,
    spacing_mm: f64,
    tau_mm: f64,
    parts: Vec<PartFigures>,
    /// Pieces of too few points to be parts, and the points in them.
    islands: usize,
    island_points: u64,
}

pub(super) fn run(args: &PartsArgs) -> Result<Exit, Failure> {
    let progress = Progress::start("parts");
    let source = Source::open(&args.source, &args.text, &progress)?;
    let points: Vec<[f64; 3]> = source.points().collect();
    let name = args.source.display().to_string();
    progress.stage("parting");
    let (report, clouds) = in_pool(args.threads, || figures(&name, &points, args.tau.0))?;
    if let Some(folder) = &args.out {
        progress.stage("writing");
        let report_file = folder.join("parts.json");
        let file = |number: usize| folder.join(format!("part-{}.ply", number + 1));
        refuse(&report_file, &args.source, args.force)?;
        (0..clouds.len()).try_for_each(|number| refuse(&file(number), &args.source, args.force))?;
        std::fs::create_dir_all(folder)
            .map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
        write_json(&report_file, &report)?;
        for (number, points) in clouds.iter().enumerate() {
            let path = file(number);
            let file = std::fs::File::create(&path)
                .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
            let file = std::io::BufWriter::new(file);
            ply::write_mesh(file, points, &[], None, &["lengths in mm"])?;
        }
    }
    drop(progress);
    if args.json {
        print_json(&report)?;
    } else {
        print(&summary(&report));
        source.say_reading();
    }
    Ok(Exit::Done)
}

/// Places of a part, x y z in mm.
type Places = Vec<[f64; 3]>;

/// The report and the places of each part.
fn figures(
    file: &str,
    points: &[[f64; 3]],
    tau_mm: Option<f64>,
) -> Result<(PartsReport, Vec<Places>), Failure> {
    let cloud = Cloud::new(points).map_err(|error| format!("{file}: {error}"))?;
    if cloud.is_empty() {
        return Err(format!("{file}: no points: expected one at least; check the file").into());
    }
    // A single place has no spacing; any tau gives the same part.
    let tau_mm = tau_mm.or_else(|| auto_tau_mm(&cloud)).unwrap_or(1.0);
    let found = parts_of(&cloud, tau_mm)?;
    let mut clouds = Vec::new();
    let mut parts = Vec::new();
    for part in &found.parts {
        let places: Places =
            part.places.iter().map(|&place| cloud.places()[place as usize]).collect();
        // The holes are those that the graph along the longest axis of the part shows.
        let own = Cloud::new(&places)?;
        let height = functions::principal_height(&own, 1)?;
        let choices = Choices { tau_mm: Some(tau_mm), ..Choices::default() };
        let loops = extract(&own, &height, &choices)?.loops.len();
        parts.push(PartFigures {
            points: part.points,
            box_mm: part.box_mm,
            centre_mm: part.centre_mm,
            loops,
        });
        clouds.push(places);
    }
    let report = PartsReport {
        format: "asphera.parts/1",
        file: file.to_owned(),
        points: points.len() as u64,
        spacing_mm: cloud.spacing_mm().unwrap_or(0.0),
        tau_mm,
        parts,
        islands: found.islands.len(),
        island_points: found.islands.iter().map(|island| island.points).sum(),
    };
    Ok((report, clouds))
}

/// Lines for a terminal.
fn summary(report: &PartsReport) -> String {
    let mut text = format!(
        "{} points, {} parts, {} islands of {} points\n",
        report.points,
        report.parts.len(),
        report.islands,
        report.island_points
    );
    for (number, part) in (1..).zip(&report.parts) {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "{number:>4}  {}", part_line(part));
    }
    text
}
