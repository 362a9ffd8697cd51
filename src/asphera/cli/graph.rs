//! `asphera graph`: parts, holes and branches of points, without a mesh.

pub(super) mod figures;
mod files;
pub(super) mod function;
mod resolutions;

use std::path::PathBuf;
use std::str::FromStr;

use asphera_formats::read_with_column;
use asphera_graph::{Choices, Growth, Pieces, StripChoice};
use clap::{Args, ValueEnum};

use self::function::FunctionChoice;
use super::exit::Exit;
use super::files::{read, refuse};
use super::output::{Failure, print, print_json, write_json};
use super::progress::Progress;
use super::sampled::SampledArgs;
use super::source::{Source, source_help};
use super::text::TextArgs;
use super::threads::ThreadArgs;
use super::usage::misused;

#[derive(Args)]
pub(super) struct GraphArgs {
    #[arg(help = source_help())]
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    #[command(flatten)]
    sampled: SampledArgs,
    /// The function whose range is cut into strips: height:x, height:y, height:z, height:DX,DY,DZ; pca:1 to pca:3, the height along a
    /// principal axis; centre, point:X,Y,Z, axis:X,Y,Z,DX,DY,DZ: distances; log, square, saddle of the coordinates; geodesic from an
    /// end, geodesic:N the mean over N sources; laplacian:N the Nth eigenfunction; harmonic from end to end; heat:T what heat is left
    /// after the time T, in units of the slowest decay; arrival, the number of each point in the order in which they came; column:N the
    /// numbers of column N of a text file.
    #[arg(long, value_name = "FUNCTION", default_value = "pca:1")]
    function: FunctionChoice,
    /// The strips: auto, a number of equal width, equal:N of equally many points, or the values between them.
    #[arg(
        long,
        value_name = "auto|N|equal:N|V0,V1,…",
        default_value = "auto",
        allow_hyphen_values = true
    )]
    strips: StripsArg,
    /// Also give the graphs of strips twice as wide, four times as wide and so on, this often. Each graph maps onto the coarser one.
    /// A number of strips must be a multiple of 2 to this power.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=16))]
    halvings: u32,
    /// Points nearer than this belong together; auto takes some six spacings of the points.
    #[arg(long, value_name = "auto|MM", default_value = "auto")]
    tau: TauArg,
    /// Neighbours among which pieces grow, for --components grown.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=200))]
    k: u16,
    /// How the pieces of a strip are found: all points nearer than tau, or growth among k neighbours.
    #[arg(long, value_enum, default_value = "exact")]
    components: ComponentsName,
    /// Loops that are open over less than this are minor; in mm, or units of the function.
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = length)]
    min_loop: f64,
    /// Write graph.json, graph.ply and points.ply into this folder.
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

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum ComponentsName {
    Exact,
    Grown,
}

#[derive(Clone, Debug, PartialEq)]
struct StripsArg(StripChoice);

impl FromStr for StripsArg {
    type Err = String;

    fn from_str(word: &str) -> Result<StripsArg, String> {
        let count = |word: &str| word.parse::<usize>().ok().filter(|count| *count > 0);
        if word == "auto" {
            return Ok(StripsArg(StripChoice::Auto));
        }
        if let Some(count) = word.strip_prefix("equal:").and_then(count) {
            return Ok(StripsArg(StripChoice::EqualCount(count)));
        }
        if let Some(count) = count(word) {
            return Ok(StripsArg(StripChoice::Uniform(count)));
        }
        let values: Option<Vec<f64>> = word
            .split(',')
            .map(|value| value.trim().parse().ok().filter(|v: &f64| v.is_finite()))
            .collect();
        values
            .filter(|values| values.len() > 1)
            .map(|values| StripsArg(StripChoice::Between(values)))
            .ok_or_else(|| {
                format!(
                    "expected auto, a number from 1, equal:N or two values or more, found `{word}`"
                )
            })
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TauArg(pub(super) Option<f64>);

impl FromStr for TauArg {
    type Err = String;

    fn from_str(word: &str) -> Result<TauArg, String> {
        match (word, word.parse::<f64>()) {
            ("auto", _) => Ok(TauArg(None)),
            (_, Ok(tau_mm)) if tau_mm.is_finite() && tau_mm > 0.0 => Ok(TauArg(Some(tau_mm))),
            _ => Err(format!("expected auto or a length in mm above 0, found `{word}`")),
        }
    }
}

impl GraphArgs {
    /// Halved strips are pieces of coarser ones if pieces are exact.
    fn check(&self) -> Result<(), Failure> {
        match (self.halvings, self.components) {
            (1.., ComponentsName::Grown) => Err(misused(format!(
                "--halvings {}: expected --components exact, whose pieces lie in those of coarser strips; found grown",
                self.halvings
            ))),
            _ => Ok(()),
        }
    }

    fn choices(&self) -> Choices {
        let pieces = match self.components {
            ComponentsName::Exact => Pieces::Exact,
            ComponentsName::Grown => {
                Pieces::Grown(Growth { k: self.k.into(), ..Growth::default() })
            }
        };
        let strips = self.strips.0.clone();
        Choices { tau_mm: self.tau.0, strips, pieces, min_loop: self.min_loop }
    }

    /// The numbers of the points that are the function, where it is a column or arrival.
    fn values(&self, source: &Source, points: usize) -> Result<Option<Vec<f64>>, Failure> {
        let column = match self.function {
            FunctionChoice::Column(column) => column,
            FunctionChoice::Arrival if self.sampled.is_asked() => {
                return Err(misused(
                    "--function arrival: points that --sample draws came in no order; leave one of both out",
                ));
            }
            FunctionChoice::Arrival => return Ok(Some((0..points).map(|at| at as f64).collect())),
            _ => return Ok(None),
        };
        let name = self.source.display().to_string();
        if self.sampled.is_asked() || source.origin().is_none() {
            return Err(format!(
                "{name}: expected a file of text for column:{column}, whose points have one; found none that is read as such: \
                 take another --function"
            )
            .into());
        }
        let bytes = read(source.file())?;
        let (_, values) = read_with_column(&name, &bytes, &self.text.options(), column)
            .map_err(|error| format!("{name}: {error}"))?;
        Ok(Some(values))
    }
}

pub(super) fn run(args: &GraphArgs) -> Result<Exit, Failure> {
    args.check()?;
    let file = |name: &str| args.out.as_deref().map(|folder| folder.join(name));
    for path in FILES.into_iter().filter_map(file) {
        refuse(&path, [&args.source], args.force)?;
    }
    let progress = Progress::start("graph");
    let source = args.sampled.open(&args.source, &args.text, &progress)?;
    let points: Vec<[f64; 3]> = source.points().collect();
    let name = args.source.display().to_string();
    let values = args.values(&source, points.len())?;
    let outcome = args.threads.run(|| {
        let function = (&args.function, values.as_deref());
        figures::of((&name, &points), function, (&args.choices(), args.halvings), &progress)
    })?;
    drop(points);
    if let Some(folder) = &args.out {
        progress.stage("writing");
        std::fs::create_dir_all(folder)
            .map_err(|error| format!("cannot make {}: {error}", folder.display()))?;
        write_json(&folder.join(FILES[0]), &outcome.whole())?;
        files::write_graph(&folder.join(FILES[1]), &outcome)?;
        files::write_points(&folder.join(FILES[2]), &outcome)?;
    }
    drop(progress);
    if args.json {
        print_json(&outcome.report)?;
    } else {
        print(&outcome.report.summary());
    }
    source.say_reading();
    Ok(Exit::Done)
}

fn length(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err(format!("expected 0 or a length in mm above it, found `{word}`")),
    }
}

/// The files of `--out`.
const FILES: [&str; 3] = ["graph.json", "graph.ply", "points.ply"];

#[cfg(test)]
mod tests;
