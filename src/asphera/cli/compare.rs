//! `asphera compare`: how far two contours differ, and how alike shapes are.

mod shapes;

use std::path::{Path, PathBuf};

use asphera_contour::{
    Agreement, Deviation, Graph, IouError, PlaceMm, agreement, intersection_over_union,
};
use asphera_graph::compare::Size;
use asphera_report::contour::{CONTOUR_FORMAT, ContourReport};
use clap::Args;
use serde::Serialize;
use shapes::{How, Method};

use super::contour::places;
use super::exit::Exit;
use super::files::read;
use super::graph::function::FunctionChoice;
use super::output::{Failure, print, print_json};
use super::progress::Progress;
use super::text::TextArgs;
use super::usage::misused;

#[derive(Args)]
pub(super) struct CompareArgs {
    /// The contour that was found and the true one: each a .json that `contour --json` wrote, or points in order round a closed
    /// line. With --shapes: two clouds or more.
    #[arg(required_unless_present = "evaluate", conflicts_with = "evaluate", num_args = 1..)]
    files: Vec<PathBuf>,
    /// Compare the clouds of the files: how alike their shapes are.
    #[arg(long)]
    shapes: bool,
    /// Compare all files of a folder that has a folder of each class: how well shapes find those of their class.
    #[arg(long, value_name = "DIR")]
    evaluate: Option<PathBuf>,
    /// Of shapes: distances of pairs of points and vibrations, or the feature matrix of the Point Cloud Graph.
    /// Without it the former.
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// The functions of the graphs of --method seed, as `asphera graph --function` takes them. Without it pca:1.
    #[arg(long, visible_alias = "functions", value_name = "FUNCTION", value_delimiter = ' ')]
    function: Vec<FunctionChoice>,
    /// The strips of these graphs, 1 or more: the same for all shapes, for sizes of graphs count. Without it 50.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    strips: Option<u16>,
    /// Compare shapes whatever their size.
    #[arg(long)]
    scale_free: bool,
    #[command(flatten)]
    text: TextArgs,
    /// Print the figures as one JSON object on stdout.
    #[arg(long)]
    json: bool,
}

/// Figures of two contours. What cannot be told is absent, and `unknown` says why.
#[derive(Debug, PartialEq, Serialize)]
struct ComparisonReport {
    format: &'static str,
    /// Largest distance from a corner of either to the lines of the other, mm.
    hausdorff_mm: f64,
    /// Root mean square of those distances, mm.
    rms_mm: f64,
    /// Area in common over the area of either, of closed lines; a line within another is a hole.
    #[serde(skip_serializing_if = "Option::is_none")]
    iou: Option<f64>,
    /// Share of the edges found that are true.
    #[serde(skip_serializing_if = "Option::is_none")]
    precision: Option<f64>,
    /// Share of the true edges that were found.
    #[serde(skip_serializing_if = "Option::is_none")]
    recall: Option<f64>,
    unknown: Vec<String>,
}

/// A contour to be compared.
struct Contour {
    /// Places in order, and whether the last is joined to the first.
    lines: Vec<(Vec<PlaceMm>, bool)>,
    /// Its edges by rows, and of how many points; none of points in order.
    edges: Option<(usize, Graph)>,
}

pub(super) fn run(args: &CompareArgs) -> Result<Exit, Failure> {
    if args.shapes || args.evaluate.is_some() {
        return run_shapes(args);
    }
    let given = [
        (args.method.is_some(), "--method"),
        (!args.function.is_empty(), "--function"),
        (args.strips.is_some(), "--strips"),
        (args.scale_free, "--scale-free"),
    ];
    if let Some((_, option)) = given.into_iter().find(|(is_given, _)| *is_given) {
        return Err(misused(format!(
            "{option} is of shapes: add --shapes, or leave it out for contours"
        )));
    }
    let report = compared(args)?;
    if args.json {
        print_json(&report)?;
    } else {
        print(&summary(&report));
    }
    Ok(Exit::Done)
}

/// The function of graphs where none is given.
const FIRST_AXIS: &str = "pca:1";
/// Their strips.
const STRIPS: u16 = 50;

impl CompareArgs {
    /// How shapes are compared.
    fn how(&self) -> Result<How<'_>, Failure> {
        let method = self.method.unwrap_or(Method::Default);
        if method == Method::Default && (!self.function.is_empty() || self.strips.is_some()) {
            return Err(misused("--function and --strips are of --method seed: add it"));
        }
        let functions = match &self.function[..] {
            [] => vec![FIRST_AXIS.parse()?],
            given => given.to_vec(),
        };
        Ok(How {
            method,
            functions,
            strips: self.strips.unwrap_or(STRIPS).into(),
            size: if self.scale_free { Size::Free } else { Size::Counts },
            text: &self.text,
        })
    }
}

fn run_shapes(args: &CompareArgs) -> Result<Exit, Failure> {
    let how = args.how()?;
    let report = match &args.evaluate {
        Some(folder) => shapes::evaluated(folder, &how)?,
        None => shapes::shapes(&args.files, &how)?,
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(&report.summary());
    }
    Ok(Exit::Done)
}

fn compared(args: &CompareArgs) -> Result<ComparisonReport, Failure> {
    let [found_file, true_file] = &args.files[..] else {
        let found = args.files.len();
        return Err(misused(format!(
            "expected two contours, found {found}; --shapes compares clouds"
        )));
    };
    let [found, truth] = [found_file, true_file].map(|path| contour(path, &args.text));
    let (found, truth) = (found?, truth?);
    let Some(Deviation { hausdorff_mm, rms_mm }) =
        Deviation::between_lines(&found.lines, &truth.lines)
    else {
        let empty = if found.lines.is_empty() { found_file } else { true_file };
        return Err(format!("{} holds no line: expected one with points", empty.display()).into());
    };
    let mut unknown = Vec::new();
    let [found_lines, true_lines] = [&found, &truth].map(closed_lines);
    let iou = match (found_lines, true_lines) {
        (Some(found), Some(truth)) => overlap([(found_file, &found), (true_file, &truth)])
            .map_err(|why| unknown.push(format!("iou: {why}")))
            .ok(),
        _ => {
            unknown.push("iou: an open line encloses no area".to_owned());
            None
        }
    };
    let edges = match (&found.edges, &truth.edges) {
        (Some((n, found)), Some((m, truth))) if n == m => Some(agreement(found, truth)),
        (Some((n, _)), Some((m, _))) => {
            unknown.push(format!(
                "precision, recall: expected the same points in both, found {n} and {m}"
            ));
            None
        }
        _ => {
            unknown.push(
                "precision, recall: expected edges by rows, as contour --json writes them, in both"
                    .to_owned(),
            );
            None
        }
    };
    Ok(ComparisonReport {
        format: "asphera-comparison 1",
        hausdorff_mm,
        rms_mm,
        iou,
        precision: edges.map(|Agreement { precision, .. }| precision),
        recall: edges.map(|Agreement { recall, .. }| recall),
        unknown,
    })
}

/// The contour of a file.
fn contour(path: &Path, text: &TextArgs) -> Result<Contour, Failure> {
    if path.extension().is_none_or(|ending| ending != "json") {
        let places = places(path, text, &Progress::start("compare"))?;
        if places.len() < 3 {
            return Err(format!(
                "{}: expected three places or more, in order round a closed line, found {}",
                path.display(),
                places.len()
            )
            .into());
        }
        return Ok(Contour { lines: vec![(places, true)], edges: None });
    }
    let name = path.display();
    let report: ContourReport = serde_json::from_slice(&read(path)?)
        .map_err(|error| format!("{name}: expected what contour --json writes: {error}"))?;
    if report.format != CONTOUR_FORMAT {
        return Err(
            format!("{name}: expected format {CONTOUR_FORMAT}, found {}", report.format).into()
        );
    }
    let edges = Graph::new(report.edges);
    let lines = report.chains.into_iter().map(|chain| (chain.points_mm, chain.closed)).collect();
    Ok(Contour { lines, edges: Some((report.input.points, edges)) })
}

/// Area in common over the area of either. Why not, where places of a file are in no order: their lines cross each other
/// everywhere, and enclose nothing.
fn overlap([found, truth]: [(&PathBuf, &Vec<Vec<PlaceMm>>); 2]) -> Result<f64, String> {
    intersection_over_union(found.1, truth.1).map_err(|error| match error {
        IouError::NoOrder { of } => {
            let file = [found.0, truth.0][of].display();
            format!("expected places in order round a closed line in {file}, found one that crosses itself everywhere")
        }
        other => other.to_string(),
    })
}

/// The lines of a contour if all are closed.
fn closed_lines(contour: &Contour) -> Option<Vec<Vec<PlaceMm>>> {
    contour.lines.iter().map(|(places, closed)| closed.then(|| places.clone())).collect()
}

fn summary(report: &ComparisonReport) -> String {
    let mut text =
        format!("hausdorff  {:.6} mm\nrms        {:.6} mm\n", report.hausdorff_mm, report.rms_mm);
    let shares = [("iou", report.iou), ("precision", report.precision), ("recall", report.recall)];
    for (name, share) in shares {
        if let Some(share) = share {
            text.push_str(&format!("{name:<10} {share:.6}\n"));
        }
    }
    report.unknown.iter().for_each(|unknown| text.push_str(&format!("unknown    {unknown}\n")));
    text
}

#[cfg(test)]
mod tests;
