//! `asphera compare --shapes` and `--evaluate`: how alike clouds are, and how well that finds those of the same class.

use crate::cli::usage::misused;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use asphera_graph::compare::{
    Evaluation, GraphFeatures, ShapeDescriptor, Size, evaluation, graph_features, shape_descriptor,
};
use asphera_graph::{Choices, Cloud, StripChoice, extract};
use rayon::prelude::*;
use serde::Serialize;

use super::super::graph::function::FunctionChoice;
use super::super::output::Failure;
use super::super::progress::Progress;
use super::super::source::Source;
use super::super::text::TextArgs;

/// What of a cloud is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Method {
    /// Distances of pairs of points, and vibrations.
    Default,
    /// The feature matrix of the Point Cloud Graph.
    Seed,
}

/// How clouds are compared.
pub(super) struct How<'a> {
    pub(super) method: Method,
    pub(super) functions: Vec<FunctionChoice>,
    pub(super) strips: usize,
    pub(super) size: Size,
    pub(super) text: &'a TextArgs,
}

/// Data known of one cloud.
enum Descriptor {
    Shape(ShapeDescriptor),
    /// One graph a function.
    Graphs(Vec<GraphFeatures>),
}

/// Distances of clouds.
#[derive(Debug, PartialEq, Serialize)]
pub(super) struct ShapesReport {
    format: &'static str,
    method: &'static str,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    functions: Vec<String>,
    scale_free: bool,
    files: Vec<String>,
    /// Of each file to each: 0 of itself.
    distances: Vec<Vec<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    evaluation: Option<EvaluationFigures>,
}

/// How well the distances find shapes of the same class.
#[derive(Debug, PartialEq, Serialize)]
struct EvaluationFigures {
    /// The class of each file: the name of its folder.
    classes: Vec<String>,
    queries: usize,
    nearest_neighbour: f64,
    first_tier: f64,
    second_tier: f64,
    dcg: f64,
    mean_average_precision: f64,
    /// At the recalls 0, 0.1 … 1.
    precision: Vec<f64>,
    by_class: Vec<ClassFigures>,
}

#[derive(Debug, PartialEq, Serialize)]
struct ClassFigures {
    class: String,
    shapes: usize,
    nearest_neighbour: f64,
    mean_average_precision: f64,
}

/// The distances of some files.
pub(super) fn shapes(files: &[PathBuf], how: &How<'_>) -> Result<ShapesReport, Failure> {
    if files.len() < 2 {
        let found = files.len();
        return Err(misused(format!("{found} clouds: expected two at least to compare")));
    }
    let progress = Progress::start("compare");
    progress.count("shapes", Some(files.len() as u64));
    let mut descriptors = Vec::new();
    for file in files {
        let name = file.display();
        let source = Source::open(file, how.text, &progress)?;
        source.say_reading();
        let points: Vec<[f64; 3]> = source.points().collect();
        let found = descriptor(&points, how).map_err(|error| format!("{name}: {error}"))?;
        descriptors.push(found);
        progress.add(1);
    }
    let row = |a: &Descriptor| descriptors.iter().map(|b| a.distance(b)).collect::<Vec<f64>>();
    Ok(ShapesReport {
        format: "asphera.shapes/1",
        method: how.method.name(),
        functions: match how.method {
            Method::Default => Vec::new(),
            Method::Seed => how.functions.iter().map(FunctionChoice::kind).collect(),
        },
        scale_free: how.size == Size::Free,
        files: files.iter().map(|file| file.display().to_string()).collect(),
        distances: descriptors.par_iter().map(row).collect(),
        evaluation: None,
    })
}

/// The distances of all files of a folder of classes, and what they find.
pub(super) fn evaluated(folder: &Path, how: &How<'_>) -> Result<ShapesReport, Failure> {
    let mut files = Vec::new();
    let mut classes = Vec::new();
    for class in listed(folder)? {
        if !class.is_dir() {
            continue;
        }
        let name = class.file_name().unwrap_or_default().to_string_lossy().into_owned();
        for file in listed(&class)?.into_iter().filter(|file| file.is_file()) {
            files.push(file);
            classes.push(name.clone());
        }
    }
    let mut report = shapes(&files, how).map_err(|error| -> Failure {
        format!(
            "{}: {error}; a folder of each class with its files is looked for",
            folder.display()
        )
        .into()
    })?;
    report.evaluation =
        Some(figures(&classes, &report.distances).ok_or_else(|| {
            format!("{}: expected a class of two files at least", folder.display())
        })?);
    Ok(report)
}

/// What lies in a folder, by name.
fn listed(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failed = |error: std::io::Error| format!("cannot read {}: {error}", folder.display());
    let entries = std::fs::read_dir(folder).map_err(failed)?;
    let mut paths = Vec::new();
    for entry in entries {
        paths.push(entry.map_err(failed)?.path());
    }
    paths.sort();
    Ok(paths)
}

fn figures(classes: &[String], distances: &[Vec<f64>]) -> Option<EvaluationFigures> {
    let mut names = classes.to_vec();
    names.dedup();
    let numbers: Vec<usize> = classes
        .iter()
        .map(|class| names.iter().position(|name| name == class).unwrap_or(0))
        .collect();
    let found = evaluation(&numbers, |a, b| distances[a][b])?;
    let Evaluation { nearest_neighbour, first_tier, second_tier, dcg, .. } = found;
    let by_class = names.iter().enumerate().map(|(number, class)| {
        // Of the queries of this class alone: all others are a class of one each.
        let own: Vec<usize> = (numbers.iter().enumerate())
            .map(|(at, &of)| if of == number { 0 } else { at + 1 })
            .collect();
        let found = evaluation(&own, |a, b| distances[a][b]);
        ClassFigures {
            class: class.clone(),
            shapes: numbers.iter().filter(|&&of| of == number).count(),
            nearest_neighbour: found.as_ref().map_or(f64::NAN, |of| of.nearest_neighbour),
            mean_average_precision: found.map_or(f64::NAN, |of| of.mean_average_precision),
        }
    });
    Some(EvaluationFigures {
        by_class: by_class.filter(|class| class.shapes > 1).collect(),
        classes: classes.to_vec(),
        queries: found.queries,
        nearest_neighbour,
        first_tier,
        second_tier,
        dcg,
        mean_average_precision: found.mean_average_precision,
        precision: found.precision.to_vec(),
    })
}

fn descriptor(points: &[[f64; 3]], how: &How<'_>) -> Result<Descriptor, Failure> {
    let cloud = Cloud::new(points)?;
    if how.method == Method::Default {
        return Ok(Descriptor::Shape(shape_descriptor(&cloud, how.size)?));
    }
    let choices = Choices { strips: StripChoice::Uniform(how.strips), ..Choices::default() };
    let graph = |function: &FunctionChoice| -> Result<GraphFeatures, Failure> {
        Ok(graph_features(&extract(&cloud, &function.field(&cloud, None)?, &choices)?.graph))
    };
    Ok(Descriptor::Graphs(how.functions.iter().map(graph).collect::<Result<_, Failure>>()?))
}

impl Descriptor {
    fn distance(&self, other: &Descriptor) -> f64 {
        match (self, other) {
            (Descriptor::Shape(a), Descriptor::Shape(b)) => a.distance(b),
            (Descriptor::Graphs(a), Descriptor::Graphs(b)) => {
                a.iter().zip(b).map(|(a, b)| a.distance(b)).sum()
            }
            _ => f64::INFINITY,
        }
    }
}

impl Method {
    fn name(self) -> &'static str {
        match self {
            Method::Default => "default",
            Method::Seed => "seed",
        }
    }
}

impl ShapesReport {
    pub(super) fn summary(&self) -> String {
        let mut text = String::new();
        match &self.evaluation {
            Some(found) => found.write(&mut text),
            None => self.write(&mut text),
        }
        text
    }

    /// Each file with the one that is nearest to it.
    fn write(&self, text: &mut String) {
        let _ = writeln!(text, "method     {}", self.method);
        for (at, file) in self.files.iter().enumerate() {
            let others = (0..self.files.len()).filter(|&other| other != at);
            let row = &self.distances[at];
            let nearest = others.min_by(|&a, &b| row[a].total_cmp(&row[b]));
            let Some(nearest) = nearest else { continue };
            let _ = writeln!(text, "{:<9.4}  {file} to {}", row[nearest], self.files[nearest]);
        }
    }
}

impl EvaluationFigures {
    fn write(&self, text: &mut String) {
        let _ = writeln!(text, "{:<10} {}", "queries", self.queries);
        let figures = [
            ("nearest", self.nearest_neighbour),
            ("tier 1", self.first_tier),
            ("tier 2", self.second_tier),
            ("DCG", self.dcg),
            ("mAP", self.mean_average_precision),
        ];
        for (name, value) in figures {
            let _ = writeln!(text, "{name:<9}  {value:.4}");
        }
        for ClassFigures { class, shapes, nearest_neighbour, mean_average_precision } in
            &self.by_class
        {
            let _ = writeln!(
                text,
                "{class}: {shapes} shapes, nearest {nearest_neighbour:.4}, mAP {mean_average_precision:.4}"
            );
        }
    }
}
