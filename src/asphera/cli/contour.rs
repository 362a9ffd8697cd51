//! `asphera contour`: the curve or the area that points in the plane are samples of.

mod draw;
mod given;
mod slab;
mod summary;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use asphera_contour::{Kind, Method, PlaceMm};
use asphera_geometry::PointMm;
use asphera_report::contour::ContourReport;
use clap::Args;

use self::given::Given;
use self::slab::{Cutting, cut};
use self::summary::summary;
use super::exit::Exit;
use super::files::refuse;
use super::output::{Failure, print, print_json, say};
use super::progress::Progress;
use super::source::{Content, Source, source_help};
use super::summary::short;
use super::text::TextArgs;
use crate::whole_file::write_bytes;

#[derive(Args)]
pub(super) struct ContourArgs {
    #[arg(help = source_help(), required_unless_present = "methods")]
    source: Option<PathBuf>,
    #[command(flatten)]
    text: TextArgs,
    /// How the curve or region is found; --methods lists the names. `auto` chooses by the points: an area, or a border
    /// without its outliers and noise. Without it a recorded session is done as its table [contour] says, anything else by hnn-crust.
    #[arg(long, value_name = "NAME")]
    method: Option<String>,
    /// Parameters of the method or graph, as delta=2.5 or gamma0=0.3,gamma1=-0.3.
    #[arg(long, value_name = "KEY=VALUE,…")]
    set: Option<String>,
    /// Places within regions and the labels of these, for delaunay-painting and colour-by-numbers: 1.5,2=hole;8,2=plate, lengths in mm.
    #[arg(long, value_name = "X,Y=LABEL;…", allow_hyphen_values = true, conflicts_with = "graph")]
    hints: Option<String>,
    /// The nominal outline, as it lies: .svg, .dxf, a .json of contour, or corners of a polygon in order as text. The report holds
    /// every point against it.
    #[arg(long, value_name = "NOMINAL", conflicts_with = "graph")]
    outline: Option<PathBuf>,
    /// Cuts a body: takes points near the plane a·x + b·y + c·z = d only, lengths in mm, and lays them on it. 0,0,1,5 keeps x and y at z = 5 mm.
    #[arg(long, value_name = "A,B,C,D", requires = "within", allow_hyphen_values = true)]
    plane: Option<Cutting>,
    /// How far from --plane points may lie, in mm.
    #[arg(long, value_name = "MM", requires = "plane")]
    within: Option<f64>,
    /// Deviations from lines and arcs up to so many mm make no feature of their own; 0 for those of noise only.
    #[arg(long, value_name = "MM", conflicts_with = "graph")]
    tolerance: Option<f64>,
    /// Closes gaps up to so many mm between ends of curves: by the corner in which straight ends meet, or by the curve whose
    /// curvature varies least. Every closed gap is listed; lengths, areas and features are without it.
    #[arg(long, value_name = "MM", conflicts_with = "graph")]
    gaps: Option<f64>,
    /// Closed curves are sections of airfoils: chord, thickness and radii of the edges are told.
    #[arg(long, conflicts_with = "graph")]
    airfoil: bool,
    /// A proximity graph instead; --methods lists the names.
    #[arg(long, value_name = "NAME", conflicts_with = "method")]
    graph: Option<String>,
    /// List all methods and graphs with parameters, guarantee and source, and end.
    #[arg(long, exclusive = true)]
    methods: bool,
    /// Print the edges as CSV on stdout: pairs of rows of points, counted from 0.
    #[arg(long)]
    edges: bool,
    /// Print the outcome as one JSON object on stdout.
    #[arg(long, conflicts_with = "edges")]
    json: bool,
    /// Where the chains go: .csv, .svg or .dxf (R12); lengths in mm.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Overwrite --out if it is there.
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &ContourArgs) -> Result<Exit, Failure> {
    let Some(source) = args.source.as_deref() else {
        print(&listed());
        return Ok(Exit::Done);
    };
    let drawing = args.out.as_deref().map(draw::drawing_of).transpose()?;
    if let Some(out) = &args.out {
        refuse(out, [source].into_iter().chain(args.outline.as_deref()), args.force)?;
    }
    let report = found(args, source)?;
    if let Some((out, drawing)) = args.out.as_deref().zip(drawing) {
        write_bytes(out, drawing(&report))?;
    }
    if args.json {
        print_json(&report)?;
    } else if args.edges {
        let mut text = "from,to\n".to_owned();
        for [from, to] in &report.edges {
            // Writing into a String cannot fail.
            let _ = writeln!(text, "{from},{to}");
        }
        print(&text);
        say(summary(&report).trim_end());
    } else {
        print(&summary(&report));
    }
    Ok(Exit::Done)
}

/// Reads the points and finds the curve.
fn found(args: &ContourArgs, path: &Path) -> Result<ContourReport, Failure> {
    let given = Given::new(args)?;
    let progress = Progress::start("contour");
    let source = match args.plane {
        Some(_) => {
            let source = Source::open(path, &args.text, &progress)?;
            source.say_reading();
            source
        }
        None => opened(path, &args.text, &progress)?,
    };
    let recorded = match source.content() {
        Content::Session(session) => session.contour(),
        Content::File(_) => None,
    };
    if recorded.is_some() {
        say("contour    as [contour] of the recording says, but for the options given");
    }
    let points = match given.slab(recorded) {
        Some(slab) => cut(&slab, path, source.points())?,
        None => flat(&source),
    };
    let settings = given.settings(recorded.map(|plan| &plan.settings))?;
    settings.contour(&points, &mut |stage| progress.stage(stage)).map_err(|error| {
        match error.is_of_points() {
            true => format!("{}: {error}", path.display()).into(),
            false => error.into(),
        }
    })
}

/// The places of the points in the plane: x and y, or of two columns both.
pub(super) fn places(
    path: &Path,
    text: &TextArgs,
    progress: &Progress,
) -> Result<Vec<PlaceMm>, Failure> {
    Ok(flat(&opened(path, text, progress)?))
}

/// The points at a path, of which stderr says how they were read; two columns will do.
fn opened(path: &Path, text: &TextArgs, progress: &Progress) -> Result<Source, Failure> {
    let source = Source::open_in_plane(path, text, progress)?;
    source.say_reading();
    Ok(source)
}

/// The places of the points in the plane. Heights that differ by more than a thousandth of its extent are left out, and stderr
/// says so.
fn flat(source: &Source) -> Vec<PlaceMm> {
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let values = || source.points().map(|point| point[axis]);
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    });
    let extent = |[low, high]: [f64; 2]| high - low;
    if !is_profile(source) && extent(z) > FLAT * extent(x).max(extent(y)) {
        let [low, high] = z.map(short);
        let name = source.path().display();
        say(&format!(
            "heights    {low} to {high} mm of {name} are left out; a body is cut by `contour --plane A,B,C,D --within MM`"
        ));
    }
    laid(source)
}

/// Heights that differ by less than this share of the extent are those of a flat edge.
const FLAT: f64 = 1e-3;

/// Whether a file has two columns, of which the second counts as y.
fn is_profile(source: &Source) -> bool {
    match source.content() {
        Content::File(topography) => {
            topography.source().taken.as_ref().is_some_and(|taken| taken.columns.len() == 2)
        }
        Content::Session(_) => false,
    }
}

fn laid(source: &Source) -> Vec<PlaceMm> {
    let is_profile = is_profile(source);
    let place = |[x, y, z]: PointMm| if is_profile { [x, z] } else { [x, y] };
    source.points().map(place).collect()
}

/// The table of `--methods`.
fn listed() -> String {
    let mut text = String::new();
    for (kind, title) in [
        (Kind::Curve, "Curves (--method)"),
        (Kind::Region, "Regions (--method)"),
        (Kind::Graph, "Graphs (--graph)"),
    ] {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "{title}");
        for method in Method::ALL.iter().filter(|method| method.kind() == kind) {
            let _ = writeln!(text, "  {}", method.name());
            let _ = writeln!(text, "    guarantee  {}", method.guarantee());
            let _ = writeln!(text, "    source     {}", method.source());
            for parameter in method.parameters() {
                let _ = writeln!(
                    text,
                    "    {}={}  {} to {}: {}",
                    parameter.name,
                    parameter.default,
                    parameter.low,
                    parameter.high,
                    parameter.meaning
                );
            }
        }
    }
    text
}

#[cfg(test)]
mod tests;
