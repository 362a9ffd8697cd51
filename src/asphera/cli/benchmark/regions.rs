//! Methods for regions side by side on areas made for it.

use std::fmt::Write as _;

use asphera_contour::benchmark::{Distribution, Drawing, DrawingError, RegionTrial, Shape};
use asphera_contour::{Kind, Method};
use serde::Serialize;

use super::super::output::Failure;
use super::super::progress::Progress;
use super::super::usage::misused;
use super::data::drawings;
use super::{BenchmarkArgs, asked, named, seconds};
use crate::clock::Clock;

#[derive(Debug, PartialEq, Serialize)]
pub(super) struct RegionsReport {
    format: &'static str,
    trials: u32,
    seed: u64,
    /// Points that the areas hold, about.
    points: [usize; 3],
    shapes: Vec<ShapeFigures>,
}

#[derive(Debug, PartialEq, Serialize)]
struct ShapeFigures {
    /// Its name, or that of its file.
    shape: String,
    /// By the mean of `l2`, best first; methods that refuse some of the points last.
    methods: Vec<MethodFigures>,
}

#[derive(Debug, PartialEq, Serialize)]
struct MethodFigures {
    method: &'static str,
    /// Area that is in one of region and truth only over the true area, mean; `None` where the method refuses some of the points.
    l2: Option<f64>,
    /// Share of the sets in which parts and holes are as many as in truth.
    topology: f64,
    /// Time by the clock for a set, s; the graph of the points is made before.
    run_s: f64,
    distributions: Vec<DistributionFigures>,
}

#[derive(Debug, PartialEq, Serialize)]
struct DistributionFigures {
    distribution: &'static str,
    /// `l2` for each of `points`.
    l2: [Option<f64>; 3],
}

pub(super) fn compared(args: &BenchmarkArgs) -> Result<RegionsReport, Failure> {
    let methods = asked(args, "regions that points fill", |method| {
        method.kind() == Kind::Region && !method.is_of_strokes()
    })?;
    let areas = areas(args)?;
    let trials = args.trials.unwrap_or(TRIALS);
    let progress = Progress::start("benchmark");
    let mut shapes = Vec::new();
    for (shape, area) in areas {
        progress.stage(&shape);
        let mut rows = Vec::new();
        for &method in &methods {
            let row = figures(&area, method, trials, args.seed);
            rows.push(row.map_err(|why| format!("{shape}: {why}"))?);
        }
        let rank = |row: &MethodFigures| row.l2.unwrap_or(f64::INFINITY);
        rows.sort_by(|a, b| rank(a).total_cmp(&rank(b)));
        shapes.push(ShapeFigures { shape, methods: rows });
    }
    Ok(RegionsReport {
        format: "asphera-benchmark-regions 1",
        trials,
        seed: args.seed,
        points: POINTS,
        shapes,
    })
}

/// Where points are laid.
enum Area {
    Shape(Shape),
    Drawing(Drawing),
}

/// The areas that were asked for, by their names.
fn areas(args: &BenchmarkArgs) -> Result<Vec<(String, Area)>, Failure> {
    let Some(folder) = &args.data else {
        let shapes = named(args, &Shape::ALL, Shape::name)?;
        let named = |shape: Shape| (shape.name().to_owned(), Area::Shape(shape));
        return Ok(shapes.into_iter().map(named).collect());
    };
    if args.category.is_some() {
        return Err(misused("--data takes all areas of its folder: leave --category out"));
    }
    Ok(drawings(folder)?.into_iter().map(|(name, drawn)| (name, Area::Drawing(drawn))).collect())
}

fn figures(
    area: &Area,
    method: Method,
    trials: u32,
    seed: u64,
) -> Result<MethodFigures, DrawingError> {
    let (mut right, mut run_s) = (0, 0.0);
    let mut score = |trial: &RegionTrial| {
        let clock = Clock::start();
        // A method may refuse points: too many for one whose time grows with their square.
        let found = trial.score(method).ok();
        run_s += seconds(&clock);
        right += u32::from(found.is_some_and(|found| found.topology));
        found.map(|found| found.l2)
    };
    let trial = |distribution: Distribution, points: usize, number: u32| match area {
        Area::Shape(shape) => Ok(shape.trial(distribution, points, seed, number)),
        Area::Drawing(drawing) => {
            RegionTrial::of_drawing(drawing, (distribution, points), (seed, number))
        }
    };
    let mut distributions = Vec::new();
    for distribution in Distribution::ALL {
        let mut l2 = [None; 3];
        for (l2, points) in l2.iter_mut().zip(POINTS) {
            let mut all = Vec::new();
            for number in 0..trials {
                all.push(score(&trial(distribution, points, number)?));
            }
            let all: Option<Vec<f64>> = all.into_iter().collect();
            *l2 = all.map(|all| all.iter().sum::<f64>() / f64::from(trials));
        }
        distributions.push(DistributionFigures { distribution: distribution.name(), l2 });
    }
    let sets = (POINTS.len() * Distribution::ALL.len()) as f64;
    let all: Option<Vec<f64>> = distributions.iter().flat_map(|row| row.l2).collect();
    Ok(MethodFigures {
        method: method.name(),
        l2: all.map(|all| all.iter().sum::<f64>() / sets),
        topology: f64::from(right) / (sets * f64::from(trials)),
        run_s: run_s / (sets * f64::from(trials)),
        distributions,
    })
}

impl RegionsReport {
    pub(super) fn summary(&self) -> String {
        let RegionsReport { trials, seed, points, .. } = self;
        let points = points.map(|points| points.to_string()).join(", ");
        let mut text = format!(
            "L2 error: area in one of region and truth only, over the true area; mean of {trials} x about {points} points, seed {seed}\n"
        );
        for ShapeFigures { shape, methods } in &self.shapes {
            // Writing into a String cannot fail.
            let _ = write!(text, "\n{shape:<14} {:>8}", "all");
            for distribution in Distribution::ALL {
                let _ = write!(text, " {:>8}", distribution.name());
            }
            let _ = writeln!(text, " {:>9} {:>8}", "topology", "ms");
            for row in methods {
                let _ = write!(text, "  {:<12} {:>8}", row.method, share(row.l2));
                for DistributionFigures { l2, .. } in &row.distributions {
                    let all: Option<Vec<f64>> = l2.iter().copied().collect();
                    let mean = all.map(|all| all.iter().sum::<f64>() / all.len() as f64);
                    let _ = write!(text, " {:>8}", share(mean));
                }
                let _ = writeln!(text, " {:>9.2} {:>8.1}", row.topology, 1e3 * row.run_s);
            }
            let best: Vec<&str> = methods.iter().take(2).map(|row| row.method).collect();
            let _ = writeln!(
                text,
                "  best {}; the source ranks no methods for regions",
                best.join(", ")
            );
        }
        text
    }
}

fn share(l2: Option<f64>) -> String {
    l2.map_or("refused".to_owned(), |l2| format!("{l2:.4}"))
}

/// Sets of points of each kind unless it is said how many.
const TRIALS: u32 = 1;
/// Points that an area holds, about.
const POINTS: [usize; 3] = [500, 2000, 8000];

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::super::super::{Cli, Command};
    use super::*;

    fn of(words: &[&str]) -> Result<RegionsReport, String> {
        let words = ["asphera", "benchmark", "regions"].iter().chain(words);
        match Cli::try_parse_from(words).map(|cli| cli.command) {
            Ok(Command::Benchmark(args)) => compared(&args).map_err(|failure| failure.to_string()),
            Ok(_) => panic!("another command"),
            Err(error) => Err(error.to_string()),
        }
    }

    #[test]
    fn a_shape_has_every_method_by_its_figures() {
        let report = of(&["--category", "ring", "--methods", "alpha,auto,rgg"]).unwrap();
        let rows = &report.shapes[0].methods;
        assert_eq!((report.shapes.len(), rows.len()), (1, 3));
        let l2 = |name: &str| rows.iter().find(|row| row.method == name).unwrap().l2.unwrap();
        // One fills the hole, a third of the ring's area.
        assert!(l2("auto") < 0.1 && (0.25..0.45).contains(&l2("rgg")), "{rows:?}");
        assert!(rows.windows(2).all(|pair| pair[0].l2 <= pair[1].l2));
        let summary = report.summary();
        assert!(summary.contains("SBDI") && summary.contains("best auto"), "{summary}");
    }

    #[test]
    fn what_is_not_there_is_refused() {
        assert!(of(&["--category", "open"]).unwrap_err().contains("expected one of disc, blob"));
        assert!(of(&["--methods", "crust"]).unwrap_err().contains("expected methods for regions"));
        // Points that fill an area are no strokes, and nobody gives hints: such methods would find nothing.
        for method in ["triangle-growing", "delaunay-painting", "colour-by-numbers"] {
            let refused = of(&["--methods", method]).unwrap_err();
            assert!(refused.contains("expected methods for regions that points fill"), "{refused}");
        }
    }
}
