//! `asphera reconstruct`: a surface in space through points, and the proof of what it is.

mod delaunay;
mod figures;
mod graph;
mod written;

use std::path::PathBuf;

use asphera_geometry::PointMm;
use asphera_reconstruct::{local, prove};
use clap::{Args, ValueEnum};

use self::delaunay::DelaunayMethod;
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
    /// Of --method alpha, and if you like of wrap: diameter of the ball that does not pass the surface, in mm.
    #[arg(long, value_name = "MM")]
    alpha: Option<f64>,
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
    /// Alpha shape: facets on which an empty ball of diameter --alpha can rest. Exact, no theorem.
    Alpha,
    /// Facets whose dual edges meet three cocones; right where the sampling ratio ε is below 0.05.
    Cocone,
    /// The convex hull shrunk along the flow towards the points: closed, no theorem.
    Convection,
    /// Tetrahedra carved from the convex hull until all points are open: closed, without handles, no theorem.
    Sculpture,
    /// Facets where a signed function of natural neighbours changes sign: bodies; right where ε is below 0.25.
    Natural,
    /// The flow of the distance, gathered at the surface; right where ε is below 0.01. With --alpha: the wrap complex.
    Wrap,
    /// Stars in tangent planes that weights make agree, one-sided surfaces too; right where ε is below 0.09.
    Tangential,
    /// Cocone in cells of an octree that are proven to know enough: the same surface, no triangulation of all points.
    Loccocone,
    /// Cocone in cells of an octree with a margin.
    SuperCocone,
    /// Noise left out, the border between balls inside and outside: bodies.
    RobustCocone,
}

impl MethodName {
    fn of_delaunay(self) -> Option<DelaunayMethod> {
        match self {
            MethodName::Local | MethodName::Graph => None,
            MethodName::Alpha => Some(DelaunayMethod::Alpha),
            MethodName::Cocone => Some(DelaunayMethod::Cocone),
            MethodName::Convection => Some(DelaunayMethod::Convection),
            MethodName::Sculpture => Some(DelaunayMethod::Sculpture),
            MethodName::Natural => Some(DelaunayMethod::Natural),
            MethodName::Wrap => Some(DelaunayMethod::Wrap),
            MethodName::Tangential => Some(DelaunayMethod::Tangential),
            MethodName::Loccocone => Some(DelaunayMethod::LocCocone),
            MethodName::SuperCocone => Some(DelaunayMethod::SuperCocone),
            MethodName::RobustCocone => Some(DelaunayMethod::RobustCocone),
        }
    }
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
    let takes_alpha = matches!(args.method, MethodName::Alpha | MethodName::Wrap);
    if (args.method == MethodName::Alpha || !takes_alpha) && takes_alpha != args.alpha.is_some() {
        return Err(
            "--method alpha and --alpha MM belong together: give both, MM as a few point spacings; --method wrap takes --alpha too"
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
    let mut figures = None;
    let mut stages = None;
    let reconstruction = if let Some(method) = args.method.of_delaunay() {
        let (found, of_method) = delaunay::surface(method, &points_mm, args.alpha)
            .map_err(|why| format!("{}: {why}", args.source.display()))?;
        figures = Some(of_method);
        found
    } else if args.method == MethodName::Graph {
        let (found, of_graph) = args.graph.surface(&points_mm, &clock)?;
        if let Some(why) = found.no_surface {
            return Err(format!("{}: {why}", args.source.display()).into());
        }
        stages = Some(of_graph);
        found.reconstruction
    } else {
        local(&points_mm)?
    };
    let meshed = clock.now();
    progress.stage("proving");
    let proof = prove(&points_mm, &reconstruction.facets)?;
    let times_s = [meshed.as_secs_f64(), clock.now().since(meshed).as_secs_f64()];
    let file = args.source.display().to_string();
    let report = ReconstructReport::new(file, &points_mm, &reconstruction, &proof, times_s)
        .with_stages(stages)
        .with_delaunay(figures, &proof);
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
