//! `asphera reconstruct`: a surface in space through points, and the proof of what it is.

mod figures;
mod graph;
mod written;

use std::path::PathBuf;

use asphera_geometry::PointMm;
use asphera_reconstruct::{local, prove};
use clap::{Args, ValueEnum};

use self::figures::ReconstructReport;
use self::graph::GraphArgs;
use super::exit::Exit;
use super::files::refuse;
use super::output::{Failure, print, print_json};
use super::progress::Progress;
use super::source::{Source, source_help};
use super::text::TextArgs;
use crate::clock::Clock;

#[derive(Args)]
pub(super) struct ReconstructArgs {
    #[arg(help = source_help())]
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    /// How the surface is found.
    #[arg(long, value_enum, default_value = "local")]
    method: MethodName,
    #[command(flatten)]
    graph: GraphArgs,
    /// Write the surface, in mm of the file's frame.
    #[arg(short, long, value_name = "OUT.ply|.stl|.obj|.off")]
    out: Option<PathBuf>,
    /// Overwrite --out if it is there.
    #[arg(long)]
    force: bool,
    /// Threads to use; results do not depend on it.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print the figures as one JSON object on stdout, and nothing else there.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum MethodName {
    /// Stars in tangent planes: every point becomes a vertex.
    Local,
    /// A coarse surface through landmarks, from a graph of neighbours: topology rather than form.
    Graph,
}

pub(super) fn run(args: &ReconstructArgs) -> Result<Exit, Failure> {
    if let Some(out) = &args.out {
        refuse(out, &args.source, args.force)?;
        written::kind_of(out)?;
    }
    if args.method != MethodName::Graph && args.graph.is_asked() {
        return Err(
            "--kappa, --hops, --threshold, --faces and --sweep belong to --method graph; add it"
                .into(),
        );
    }
    if args.graph.sweeps() {
        return sweep(args);
    }
    let work = || made(args);
    let (report, points_mm, facets) = match args.threads {
        None => work()?,
        Some(threads) => {
            rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build()?.install(work)?
        }
    };
    if let Some(out) = &args.out {
        written::write(out, &points_mm, &facets)?;
    }
    if args.json {
        print_json(&report)?;
    } else {
        print(&report.summary());
    }
    Ok(Exit::Done)
}

/// A report, and the mesh that it is of.
type Made = (ReconstructReport, Vec<PointMm>, Vec<[u32; 3]>);

fn made(args: &ReconstructArgs) -> Result<Made, Failure> {
    let progress = Progress::start("reconstruct");
    let source = Source::open(&args.source, &args.text, &progress)?;
    let points_mm: Vec<PointMm> = source.points().collect();
    progress.stage("meshing");
    let clock = Clock::start();
    let (reconstruction, stages) = match args.method {
        MethodName::Local => (local(&points_mm)?, None),
        MethodName::Graph => {
            let (found, stages) = args.graph.surface(&points_mm, &clock)?;
            if let Some(why) = found.no_surface {
                return Err(format!("{}: {why}", args.source.display()).into());
            }
            (found.reconstruction, Some(stages))
        }
    };
    let meshed = clock.now();
    progress.stage("proving");
    let proof = prove(&points_mm, &reconstruction.facets)?;
    let times_s = [meshed.as_secs_f64(), clock.now().since(meshed).as_secs_f64()];
    let file = args.source.display().to_string();
    let report = ReconstructReport::new(file, &points_mm, &reconstruction, &proof, times_s)
        .with_stages(stages);
    Ok((report, points_mm, reconstruction.facets))
}

/// The table of `--sweep`.
fn sweep(args: &ReconstructArgs) -> Result<Exit, Failure> {
    if args.out.is_some() {
        return Err("--sweep prints a table and makes no surface: leave --out out".into());
    }
    let progress = Progress::start("reconstruct");
    let source = Source::open(&args.source, &args.text, &progress)?;
    let points_mm: Vec<PointMm> = source.points().collect();
    progress.stage("sweeping");
    let table = args.graph.table(&points_mm)?;
    drop(progress);
    if args.json {
        print_json(&table)?;
    } else {
        print(&table.summary());
    }
    Ok(Exit::Done)
}

#[cfg(test)]
mod tests;
