//! Methods for curves side by side on curves made for it.

use std::fmt::Write as _;

use asphera_contour::benchmark::{Category, Drawing, Score, Trial};
use asphera_contour::{Kind, Method};
use serde::Serialize;

use super::super::output::Failure;
use super::super::progress::Progress;
use super::data::drawings;
use super::{BenchmarkArgs, asked, named, seconds};
use crate::clock::Clock;

#[derive(Debug, PartialEq, Serialize)]
pub(super) struct CurvesReport {
    format: &'static str,
    trials: u32,
    seed: u64,
    /// The files of `--data`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    data: Vec<String>,
    categories: Vec<CategoryFigures>,
}

#[derive(Debug, PartialEq, Serialize)]
struct CategoryFigures {
    category: &'static str,
    /// By RMS, best first.
    methods: Vec<MethodFigures>,
    /// The best two of the published benchmark. Some of their methods are not among those here.
    published_best: [&'static str; 2],
}

/// Means over all trials.
#[derive(Debug, PartialEq, Serialize)]
struct MethodFigures {
    method: &'static str,
    /// Root mean square distance to the curve and back over the diagonal of its box; `None` where a trial gave no line.
    rms: Option<f64>,
    /// Harmonic mean of precision and recall of the edges.
    f: f64,
    /// Share of the samples with two edges.
    two_edges: f64,
    /// Time by the clock, s; the graph of the points is made before.
    run_s: f64,
}

pub(super) fn compared(args: &BenchmarkArgs) -> Result<CurvesReport, Failure> {
    let is_compared = |method: &Method| method.kind() == Kind::Curve || *method == Method::Auto;
    let methods = asked(args, "curves", is_compared)?;
    let drawn = args.data.as_deref().map(drawings).transpose()?.unwrap_or_default();
    let all = if args.data.is_some() { &Category::OF_DRAWINGS[..] } else { &Category::ALL };
    let categories = named(args, all, Category::name)?;
    let trials = match drawn.len() as u32 {
        0 => args.trials.unwrap_or(TRIALS),
        files => files * args.trials.unwrap_or(1),
    };
    let progress = Progress::start("benchmark");
    let categories = categories.into_iter().map(|category| {
        progress.stage(category.name());
        figures((category, &drawn), &methods, trials, args.seed)
    });
    Ok(CurvesReport {
        format: "asphera-benchmark 1",
        trials,
        seed: args.seed,
        data: drawn.iter().map(|(name, _)| name.clone()).collect(),
        categories: categories.collect::<Result<_, Failure>>()?,
    })
}

/// A set of samples of the category's own curve, or of the drawings in turn.
fn trial(category: Category, drawn: &[(String, Drawing)], seed: u64, number: u32) -> Trial {
    match drawn.get(number as usize % drawn.len().max(1)) {
        Some((_, drawing)) => category.trial_of(drawing, seed, number),
        None => category.trial(seed, number),
    }
}

fn figures(
    (category, drawn): (Category, &[(String, Drawing)]),
    methods: &[Method],
    trials: u32,
    seed: u64,
) -> Result<CategoryFigures, Failure> {
    let mut sums = vec![(Score { rms: 0.0, f: 0.0, two_edges: 0.0 }, 0.0); methods.len()];
    let share = f64::from(trials).recip();
    for number in 0..trials {
        let trial = trial(category, drawn, seed, number);
        for ((sum, run_s), method) in sums.iter_mut().zip(methods) {
            let clock = Clock::start();
            let score = trial.score(*method)?;
            *run_s += share * seconds(&clock);
            sum.rms += share * score.rms;
            sum.f += share * score.f;
            sum.two_edges += share * score.two_edges;
        }
    }
    let mut rows: Vec<((Score, f64), &'static str)> =
        sums.into_iter().zip(methods).map(|(sum, method)| (sum, method.name())).collect();
    rows.sort_by(|((a, _), _), ((b, _), _)| a.rms.total_cmp(&b.rms).then(b.f.total_cmp(&a.f)));
    let methods = rows.into_iter().map(|((Score { rms, f, two_edges }, run_s), method)| {
        MethodFigures { method, rms: rms.is_finite().then_some(rms), f, two_edges, run_s }
    });
    Ok(CategoryFigures {
        category: category.name(),
        methods: methods.collect(),
        published_best: category.published_best(),
    })
}

impl CurvesReport {
    pub(super) fn summary(&self) -> String {
        let mut text = format!("{} curves a category, seed {}\n", self.trials, self.seed);
        if !self.data.is_empty() {
            // Writing into a String cannot fail.
            let _ = writeln!(text, "of {}", self.data.join(", "));
        }
        for CategoryFigures { category, methods, published_best } in &self.categories {
            // Writing into a String cannot fail.
            let _ = writeln!(
                text,
                "\n{category:<20} {:>12} {:>8} {:>10} {:>10}",
                "RMS/box", "F", "two edges", "ms"
            );
            for MethodFigures { method, rms, f, two_edges, run_s } in methods {
                let rms = rms.map_or("no line".to_owned(), |rms| format!("{rms:.3e}"));
                let _ = writeln!(
                    text,
                    "  {method:<18} {rms:>12} {f:>8.4} {two_edges:>10.4} {:>10.2}",
                    1e3 * run_s
                );
            }
            let best: Vec<&str> = methods.iter().take(2).map(|row| row.method).collect();
            let _ = writeln!(
                text,
                "  best {}; published {}",
                best.join(", "),
                published_best.join(", ")
            );
        }
        text
    }
}

/// Curves of each category unless it is said how many.
const TRIALS: u32 = 10;

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::super::super::{Cli, Command};
    use super::*;

    fn of(words: &[&str]) -> Result<CurvesReport, String> {
        let words = ["asphera", "benchmark", "curves", "--trials", "2"].iter().chain(words);
        match Cli::try_parse_from(words).map(|cli| cli.command) {
            Ok(Command::Benchmark(args)) => compared(&args).map_err(|failure| failure.to_string()),
            Ok(_) => panic!("another command"),
            Err(error) => Err(error.to_string()),
        }
    }

    #[test]
    fn a_category_has_every_method_by_its_figures() {
        let report =
            of(&["--category", "multiple", "--methods", "nn-crust,emst-curve,auto"]).unwrap();
        let rows = &report.categories[0].methods;
        assert_eq!((report.categories.len(), rows.len()), (1, 3));
        assert!(rows.windows(2).all(|pair| pair[0].rms <= pair[1].rms));
        let found = rows.iter().find(|row| row.method == "nn-crust").unwrap();
        assert_eq!((found.f, found.two_edges), (1.0, 1.0));
        let summary = report.summary();
        assert!(summary.contains("published peel, hnn-crust"), "{summary}");
    }

    #[test]
    fn what_is_not_there_is_refused() {
        assert!(of(&["--category", "wide"]).unwrap_err().contains("expected one of non-uniform"));
        assert!(of(&["--methods", "emst"]).unwrap_err().contains("expected methods for curves"));
        assert!(of(&["--methods", "x"]).unwrap_err().starts_with("no method is called `x`"));
        assert!(of(&["--trials", "0"]).is_err());
    }
}
