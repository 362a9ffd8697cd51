//! `asphera benchmark curves`: the methods of `contour` side by side on curves made for it.

use std::fmt::Write as _;

use asphera_contour::benchmark::{Category, Score};
use asphera_contour::{Kind, Method};
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::exit::Exit;
use super::output::{Failure, print, print_json};
use super::progress::Progress;

#[derive(Args)]
pub(super) struct BenchmarkArgs {
    /// What is compared.
    #[arg(value_enum)]
    kind: Compared,
    /// One category only: non-uniform, uniform-noise, non-uniform-noise, outliers, manifold, non-manifold, sharp, open or multiple.
    #[arg(long, value_name = "C")]
    category: Option<String>,
    /// These methods only; `auto` is the choice by the points.
    #[arg(long, value_name = "A,B,…", value_delimiter = ',')]
    methods: Vec<String>,
    /// How many curves of each category.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    trials: u32,
    /// Seed of the curves and their noise.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Print the figures as one JSON object on stdout.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Compared {
    /// Methods for curves.
    Curves,
}

#[derive(Debug, PartialEq, Serialize)]
struct BenchmarkReport {
    format: &'static str,
    trials: u32,
    seed: u64,
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
}

pub(super) fn run(args: &BenchmarkArgs) -> Result<Exit, Failure> {
    let Compared::Curves = args.kind;
    let report = compared(args)?;
    if args.json {
        print_json(&report)?;
    } else {
        print(&report.summary());
    }
    Ok(Exit::Done)
}

fn compared(args: &BenchmarkArgs) -> Result<BenchmarkReport, Failure> {
    let is_compared = |method: &Method| method.kind() == Kind::Curve || *method == Method::Auto;
    let methods: Vec<Method> = match args.methods.is_empty() {
        true => Method::ALL.into_iter().filter(is_compared).collect(),
        false => {
            args.methods.iter().map(|name| Method::from_name(name)).collect::<Result<_, _>>()?
        }
    };
    if let Some(other) = methods.iter().find(|method| !is_compared(method)) {
        let name = other.name();
        return Err(
            format!("--methods {name}: expected methods for curves, found another kind").into()
        );
    }
    let categories: Vec<Category> =
        match &args.category {
            None => Category::ALL.to_vec(),
            Some(name) => {
                let found = Category::ALL.into_iter().find(|category| category.name() == name);
                let names = Category::ALL.map(|category| category.name()).join(", ");
                vec![found.ok_or_else(|| {
                    format!("--category: expected one of {names}, found `{name}`")
                })?]
            }
        };
    let progress = Progress::start("benchmark");
    let categories = categories.into_iter().map(|category| {
        progress.stage(category.name());
        figures(category, &methods, args)
    });
    Ok(BenchmarkReport {
        format: "asphera-benchmark 1",
        trials: args.trials,
        seed: args.seed,
        categories: categories.collect::<Result<_, Failure>>()?,
    })
}

fn figures(
    category: Category,
    methods: &[Method],
    args: &BenchmarkArgs,
) -> Result<CategoryFigures, Failure> {
    let mut sums = vec![Score { rms: 0.0, f: 0.0, two_edges: 0.0 }; methods.len()];
    for number in 0..args.trials {
        let trial = category.trial(args.seed, number);
        for (sum, method) in sums.iter_mut().zip(methods) {
            let score = trial.score(*method)?;
            sum.rms += score.rms / f64::from(args.trials);
            sum.f += score.f / f64::from(args.trials);
            sum.two_edges += score.two_edges / f64::from(args.trials);
        }
    }
    let mut rows: Vec<(Score, &'static str)> =
        sums.into_iter().zip(methods).map(|(sum, method)| (sum, method.name())).collect();
    rows.sort_by(|a, b| a.0.rms.total_cmp(&b.0.rms).then(b.0.f.total_cmp(&a.0.f)));
    let methods = rows.into_iter().map(|(Score { rms, f, two_edges }, method)| MethodFigures {
        method,
        rms: rms.is_finite().then_some(rms),
        f,
        two_edges,
    });
    Ok(CategoryFigures {
        category: category.name(),
        methods: methods.collect(),
        published_best: category.published_best(),
    })
}

impl BenchmarkReport {
    fn summary(&self) -> String {
        let mut text = format!("{} curves a category, seed {}\n", self.trials, self.seed);
        for CategoryFigures { category, methods, published_best } in &self.categories {
            // Writing into a String cannot fail.
            let _ =
                writeln!(text, "\n{category:<20} {:>12} {:>8} {:>10}", "RMS/box", "F", "two edges");
            for MethodFigures { method, rms, f, two_edges } in methods {
                let rms = rms.map_or("no line".to_owned(), |rms| format!("{rms:.3e}"));
                let _ = writeln!(text, "  {method:<18} {rms:>12} {f:>8.4} {two_edges:>10.4}");
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

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::super::{Cli, Command};
    use super::*;

    fn of(words: &[&str]) -> Result<BenchmarkReport, String> {
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
