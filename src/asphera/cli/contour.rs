//! `asphera contour`: the curve or the area that points in the plane are samples of.

mod draw;
mod features;
mod figures;
pub(super) mod report;
mod sampled;
mod slab;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use asphera_contour::features::Course;
use asphera_contour::{
    Choice, FoundCurve, Graph, Kind, Method, MethodError, Parameters, PlaceMm, SampleId, Samples,
    Triangulation,
};
use asphera_geometry::PointMm;
use clap::Args;

use self::features::features_of;
use self::figures::{CircleFigures, DeviationFigures};
use self::report::ContourReport;
use self::slab::Cutting;
use super::exit::Exit;
use super::files::refuse;
use super::output::{Failure, print, print_json, say};
use super::progress::Progress;
use super::source::{Content, Source, source_help};
use super::text::TextArgs;

#[derive(Args)]
pub(super) struct ContourArgs {
    #[arg(help = source_help(), required_unless_present = "methods")]
    source: Option<PathBuf>,
    #[command(flatten)]
    text: TextArgs,
    /// How the curve or region is found; --methods lists the names. `auto` chooses by the points: an area, or a border
    /// without its outliers and noise.
    #[arg(long, value_name = "NAME", default_value = "hnn-crust")]
    method: String,
    /// Parameters of the method or graph, as delta=2.5 or gamma0=0.3,gamma1=-0.3.
    #[arg(long, value_name = "KEY=VALUE,…", default_value = "", hide_default_value = true)]
    set: String,
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
    #[arg(long, value_name = "MM", default_value_t = 0.0, conflicts_with = "graph")]
    tolerance: f64,
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
        refuse(out, source, args.force)?;
    }
    let report = found(args, source)?;
    if let Some((out, drawing)) = args.out.as_deref().zip(drawing) {
        std::fs::write(out, drawing(&report))
            .map_err(|error| format!("cannot write {}: {error}", out.display()))?;
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
        say(report.summary().trim_end());
    } else {
        print(&report.summary());
    }
    Ok(Exit::Done)
}

/// Reads the points and finds the curve.
fn found(args: &ContourArgs, path: &Path) -> Result<ContourReport, Failure> {
    let method = Method::from_name(args.graph.as_deref().unwrap_or(&args.method))?;
    let is_graph = |method: &Method| method.kind() == Kind::Graph;
    if is_graph(&method) != args.graph.is_some() {
        let (flag, other) = match args.graph {
            Some(_) => ("--graph", "--method"),
            None => ("--method", "--graph"),
        };
        let names = Method::ALL.iter().filter(|named| is_graph(named) != is_graph(&method));
        let names = names.map(Method::name).collect::<Vec<_>>().join(", ");
        let name = method.name();
        return Err(format!("{flag} {name}: expected one of {names}; give {other} {name}").into());
    }
    let parameters = Parameters::parse(&args.set)?;
    let progress = Progress::start("contour");
    let points = taken(args, path, &progress)?;
    progress.stage("meshing");
    let name = path.display();
    let samples = Samples::new(&points).map_err(|error| format!("{name}: {error}"))?;
    if samples.len() < 3 {
        return Err(format!(
            "{name}: expected three different places or more, found {} in {} points; measure more of the curve",
            samples.len(),
            samples.points()
        )
        .into());
    }
    let triangulation = Triangulation::new(samples);
    if triangulation.triangles().is_empty() {
        return Err(format!(
            "{name}: expected points round a curve, found all {} on one straight line; asphera section and asphera measure \
             work on profiles",
            triangulation.len()
        )
        .into());
    }
    progress.stage(method.name());
    let parameters = method.chosen(&triangulation, &parameters)?;
    let region = method.region(&triangulation, &parameters)?;
    let (mut report, used, courses) = match region {
        _ if method == Method::Auto => by_points(&triangulation, &parameters)?,
        Some(region) => {
            let report = ContourReport::of_region(&triangulation, method, &parameters, &region);
            (report, joined(&triangulation, region.border()), Vec::new())
        }
        None => {
            let curve = method.curve(&triangulation, &parameters)?;
            let report = ContourReport::new(&triangulation, method, &parameters, &curve);
            let courses = match method.kind() {
                Kind::Curve => Course::of_curve(&triangulation, &curve, &[]),
                Kind::Region | Kind::Graph => Vec::new(),
            };
            (report, used_of(&triangulation, &curve, &[]), courses)
        }
    };
    if report.sampling.is_some() && report.chains.len() == 1 {
        report.circle = CircleFigures::of(&used);
    }
    progress.stage("features");
    let (features, unknown) = features_of(&courses, args.tolerance, args.airfoil);
    report.features = features;
    report.unknown.extend(unknown);
    if args.airfoil && courses.is_empty() {
        let why = "airfoil: expected a closed curve, found none; give a method of curves";
        report.unknown.push(why.to_owned());
    }
    if let Some(outline) = &args.outline {
        report.deviation = Some(DeviationFigures::of(outline, &used, report.input.noise_sigma_mm)?);
    }
    Ok(report)
}

/// The places that the arguments ask for: of all points, or of those near a plane on it.
fn taken(args: &ContourArgs, path: &Path, progress: &Progress) -> Result<Vec<PlaceMm>, Failure> {
    if !(args.tolerance >= 0.0 && args.tolerance.is_finite()) {
        return Err(format!("--tolerance {}: expected 0 mm or more", args.tolerance).into());
    }
    if let Some(within) = args.within.filter(|within| !(*within > 0.0 && within.is_finite())) {
        return Err(format!("--within {within}: expected more than 0 mm").into());
    }
    match args.plane.zip(args.within) {
        Some((plane, within_mm)) => {
            let source = Source::open(path, &args.text, progress)?;
            plane.places(path, source.points(), within_mm)
        }
        None => places(path, &args.text, progress),
    }
}

/// The places of samples that an edge joins.
fn joined(triangulation: &Triangulation, graph: &Graph) -> Vec<PlaceMm> {
    let degrees = graph.degrees(triangulation.len());
    let places = triangulation.samples().places().iter().zip(degrees);
    places.filter(|(_, degree)| *degree > 0).map(|(&place, _)| place).collect()
}

/// The places that a curve was made of: all but outliers where noise was taken away, else those that it joins.
fn used_of(
    triangulation: &Triangulation,
    curve: &FoundCurve,
    outliers: &[SampleId],
) -> Vec<PlaceMm> {
    if curve.places_mm.is_none() {
        return joined(triangulation, &curve.graph);
    }
    let is_used = |sample: &SampleId| outliers.binary_search(sample).is_err();
    let used = (0..triangulation.len() as SampleId).filter(is_used);
    used.map(|sample| triangulation.place(sample)).collect()
}

/// The outcome by the method that the points ask for, the points it was made of, and the courses of its curves.
fn by_points(
    triangulation: &Triangulation,
    parameters: &Parameters,
) -> Result<(ContourReport, Vec<PlaceMm>, Vec<Course>), MethodError> {
    let choice = Choice::new(triangulation);
    let method = choice.method;
    let (report, used, courses) = match method.region(triangulation, parameters)? {
        Some(region) => {
            let report = ContourReport::of_region(triangulation, method, parameters, &region);
            (report, joined(triangulation, region.border()), Vec::new())
        }
        None => {
            let curve = choice.curve(triangulation).unwrap_or_default();
            let report = ContourReport::new(triangulation, method, parameters, &curve);
            let courses = Course::of_curve(triangulation, &curve, &choice.outliers);
            (report, used_of(triangulation, &curve, &choice.outliers), courses)
        }
    };
    Ok((report.chosen(&choice), used, courses))
}

/// The places of the points in the plane: x and y, or of two columns both.
pub(super) fn places(
    path: &Path,
    text: &TextArgs,
    progress: &Progress,
) -> Result<Vec<PlaceMm>, Failure> {
    let source = match Source::open(path, text, progress) {
        Ok(source) => source,
        // Two columns that nothing names are refused as a profile: heights or slopes. Here they are x and y.
        Err(failure) => match text.of_plane() {
            Some(plane) => Source::open(path, &plane, progress).map_err(|_| failure)?,
            None => return Err(failure),
        },
    };
    let is_profile = match source.content() {
        Content::File(topography) => topography
            .source()
            .taken
            .as_ref()
            .is_some_and(|taken| taken.columns.iter().all(|column| column.name != "y")),
        Content::Session(_) => false,
    };
    let place = |[x, y, z]: PointMm| if is_profile { [x, z] } else { [x, y] };
    Ok(source.points().map(place).collect())
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
