//! `asphera reconstruct`: a surface in space through points, and the proof of what it is.

mod comparison;
mod delaunay;
mod figures;
mod graph;
mod shelf;
mod tiled;
mod written;

use std::path::PathBuf;

use asphera_geometry::PointMm;
use asphera_reconstruct::{Proof, Reconstruction, local, prove};
use clap::{Args, ValueEnum};

use self::comparison::{Comparison, Truth};
use self::delaunay::{DelaunayFigures, DelaunayMethod};
use self::figures::ReconstructReport;
use self::graph::{GraphArgs, GraphStages};
use super::exit::Exit;
use super::files::refuse;
use super::output::{Failure, print, print_json};
use super::progress::Progress;
use super::source::{Source, source_help};
use super::text::TextArgs;
use super::threads::ThreadArgs;
use super::usage::misused;
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
    /// From the surface to the probe that looked at it: open parts are turned so that they face this way. Closed ones face outwards.
    #[arg(long, value_name = "X,Y,Z", value_parser = way, allow_hyphen_values = true)]
    toward: Option<[f64; 3]>,
    /// Run every method and print a row of figures for each.
    #[arg(long, conflicts_with_all = ["method", "out", "sweep", "toward"])]
    compare: bool,
    /// With --compare: the true surface, to which distances are given.
    #[arg(long, value_name = "MESH", requires = "compare")]
    truth: Option<PathBuf>,
    /// Write the surface, in mm of the file's frame.
    #[arg(short, long, value_name = "OUT.ply|.stl|.obj|.off")]
    out: Option<PathBuf>,
    /// Overwrite --out if it is there.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    threads: ThreadArgs,
    /// Print the figures as one JSON object on stdout, and nothing else there.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum MethodName {
    /// Stars in tangent planes: every point becomes a vertex.
    Local,
    /// A coarse surface through landmarks, from a graph of neighbours: topology rather than form. --put-back adds the other points.
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

/// Three numbers that are not all 0.
fn way(word: &str) -> Result<[f64; 3], String> {
    let numbers: Vec<f64> = word.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    match (<[f64; 3]>::try_from(&numbers[..]), word.split(',').count()) {
        (Ok(way @ [x, y, z]), 3) if (x * x + y * y + z * z).is_normal() => Ok(way),
        _ => Err(format!(
            "expected the way to the probe as three numbers that are not all 0, like 0,0,1; found `{word}`"
        )),
    }
}

pub(super) fn run(args: &ReconstructArgs) -> Result<Exit, Failure> {
    if let Some(out) = &args.out {
        refuse(out, [&args.source].into_iter().chain(&args.truth), args.force)?;
        written::kind_of(out)?;
    }
    if args.compare {
        return compare(args);
    }
    if args.method != MethodName::Graph && args.graph.is_asked() {
        return Err(misused(
            "--kappa, --hops, --threshold, --faces, --order, --put-back, --tiles, --batch and --sweep belong to --method graph; add it",
        ));
    }
    let takes_alpha = matches!(args.method, MethodName::Alpha | MethodName::Wrap);
    if (args.method == MethodName::Alpha || !takes_alpha) && takes_alpha != args.alpha.is_some() {
        return Err(misused(
            "--method alpha and --alpha MM belong together: give both, MM as a few point spacings; --method wrap takes --alpha too",
        ));
    }
    if args.graph.sweeps() {
        return sweep(args);
    }
    let (report, points_mm, facets) = args.threads.run(|| made(args))?;
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

/// The points of the source; stderr says how they were read.
fn read_points(args: &ReconstructArgs, progress: &Progress) -> Result<Vec<PointMm>, Failure> {
    let source = Source::open(&args.source, &args.text, progress)?;
    source.say_reading();
    Ok(source.points().collect())
}

/// A report, and the mesh that it is of.
type Made = (ReconstructReport, Vec<PointMm>, Vec<[u32; 3]>);

fn made(args: &ReconstructArgs) -> Result<Made, Failure> {
    if let Some(megabytes) = args.graph.tiles() {
        return tiled::made(args, megabytes);
    }
    let progress = Progress::start("reconstruct");
    let points_mm = read_points(args, &progress)?;
    progress.stage("meshing");
    let clock = Clock::start();
    let Found { surface, figures, stages } = found(args, args.method, &points_mm, &clock)?;
    let reconstruction = match args.toward {
        Some(way) => surface.facing(&points_mm, way),
        None => surface,
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

/// A surface, and the figures of its method.
struct Found {
    surface: Reconstruction,
    figures: Option<DelaunayFigures>,
    stages: Option<GraphStages>,
}

fn found(
    args: &ReconstructArgs,
    method: MethodName,
    points_mm: &[PointMm],
    clock: &Clock,
) -> Result<Found, Failure> {
    let named = |why: &dyn std::fmt::Display| format!("{}: {why}", args.source.display());
    if let Some(method) = method.of_delaunay() {
        let (surface, figures) =
            delaunay::surface(method, points_mm, args.alpha).map_err(|why| named(&why))?;
        if surface.facets.is_empty() {
            return Err(named(&no_facet(points_mm.len(), args.alpha)).into());
        }
        return Ok(Found { surface, figures: Some(figures), stages: None });
    }
    if method == MethodName::Graph {
        let (found, stages) = args.graph.surface(points_mm, clock)?;
        if let Some(why) = found.no_surface {
            return Err(named(&why).into());
        }
        let surface = found.reconstruction;
        return Ok(Found { surface, figures: None, stages: Some(stages) });
    }
    let surface = local(points_mm)?;
    if surface.facets.is_empty() {
        return Err(named(&no_facet(points_mm.len(), None)).into());
    }
    Ok(Found { surface, figures: None, stages: None })
}

/// Why points have no surface, and what to do.
fn no_facet(points: usize, alpha_mm: Option<f64>) -> String {
    let cure = match alpha_mm {
        Some(alpha_mm) => format!("give a larger --alpha than {alpha_mm} mm, or measure more"),
        None => "measure more places, not all on a line".to_owned(),
    };
    format!("expected points that span an area, found {points} and no facet through them; {cure}")
}

/// The table of `--compare`.
fn compare(args: &ReconstructArgs) -> Result<Exit, Failure> {
    let table = args.threads.run(|| compared(args))?;
    if args.json {
        print_json(&table)?;
    } else {
        print(&table.summary());
    }
    Ok(Exit::Done)
}

fn compared(args: &ReconstructArgs) -> Result<Comparison, Failure> {
    let progress = Progress::start("reconstruct");
    let truth = args.truth.as_deref();
    let truth_mesh = truth.map(|path| Truth::open(path, &args.text.options())).transpose()?;
    let points_mm = read_points(args, &progress)?;
    let file = args.source.display().to_string();
    let mut table = Comparison::new(file, points_mm.len(), truth);
    for &method in MethodName::value_variants() {
        let Some(name) = method.to_possible_value() else { continue };
        let name = name.get_name().to_owned();
        if method == MethodName::Alpha && args.alpha.is_none() {
            table.add_refused(name, "left out: give --alpha MM".to_owned());
            continue;
        }
        progress.stage(&name);
        let clock = Clock::start();
        // A wrap of a ball is a complex, and no surface to compare.
        let found = match method {
            MethodName::Wrap => delaunay::surface(DelaunayMethod::Wrap, &points_mm, None)
                .map(|(surface, figures)| Found { surface, figures: Some(figures), stages: None }),
            _ => found(args, method, &points_mm, &clock),
        };
        let seconds = clock.now().as_secs_f64();
        match found {
            Err(why) => table.add_refused(name, why.to_string()),
            Ok(Found { surface, figures, .. }) => {
                let guarantee = |proof: &Proof| match &figures {
                    Some(figures) => figures.guarantee(proof),
                    None if method == MethodName::Graph => figures::GRAPH_GUARANTEE.to_owned(),
                    None => figures::LOCAL_GUARANTEE.to_owned(),
                };
                let truth = truth_mesh.as_ref();
                table.add(name, &points_mm, (&surface, seconds), guarantee, truth)?;
            }
        }
    }
    Ok(table)
}

/// The table of `--sweep`.
fn sweep(args: &ReconstructArgs) -> Result<Exit, Failure> {
    if args.out.is_some() {
        return Err(misused("--sweep prints a table and makes no surface: leave --out out"));
    }
    let progress = Progress::start("reconstruct");
    let points_mm = read_points(args, &progress)?;
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
