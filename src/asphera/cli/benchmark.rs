//! `asphera benchmark`: the methods of `contour` side by side, on curves and regions made for it.

mod curves;
mod data;
mod regions;

use crate::cli::usage::misused;
use std::path::PathBuf;

use asphera_contour::Method;
use clap::{Args, ValueEnum};
use serde::Serialize;

use super::exit::Exit;
use super::output::{Failure, print, print_json};
use crate::clock::Clock;

#[derive(Args)]
pub(super) struct BenchmarkArgs {
    /// What is compared.
    #[arg(value_enum)]
    kind: Compared,
    /// One category only. Curves: non-uniform, uniform-noise, non-uniform-noise, outliers, manifold, non-manifold, sharp, open or
    /// multiple. Regions: disc, blob, star, letter, horseshoe, ring, plate or parts.
    #[arg(long, value_name = "C")]
    category: Option<String>,
    /// Curves of this folder instead: .svg, .dxf, and .png with a dark shape. The categories of curves that make shapes of their own
    /// are left out; `regions` takes the areas that the lines go round.
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// These methods only; `auto` is the choice by the points.
    #[arg(long, value_name = "A,B,…", value_delimiter = ',')]
    methods: Vec<String>,
    /// How many sets of points of each category: 10 for curves, 1 for regions, unless given. With --data of each file: 1.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    trials: Option<u32>,
    /// Seed of shapes, points and noise.
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
    /// Methods for regions: eight shapes, three densities, six distributions.
    Regions,
}

pub(super) fn run(args: &BenchmarkArgs) -> Result<Exit, Failure> {
    match args.kind {
        Compared::Curves => {
            let report = curves::compared(args)?;
            said(args, &report, || report.summary())
        }
        Compared::Regions => {
            let report = regions::compared(args)?;
            said(args, &report, || report.summary())
        }
    }
}

fn said(
    args: &BenchmarkArgs,
    report: &impl Serialize,
    summary: impl FnOnce() -> String,
) -> Result<Exit, Failure> {
    if args.json {
        print_json(report)?;
    } else {
        print(&summary());
    }
    Ok(Exit::Done)
}

/// The methods that are compared, all of a kind unless some are named.
fn asked(
    args: &BenchmarkArgs,
    kind: &str,
    is_compared: impl Fn(&Method) -> bool,
) -> Result<Vec<Method>, Failure> {
    if args.methods.is_empty() {
        return Ok(Method::ALL.into_iter().filter(|method| is_compared(method)).collect());
    }
    let methods: Vec<Method> = args
        .methods
        .iter()
        .map(|name| Method::from_name(name))
        .collect::<Result<_, _>>()
        .map_err(misused)?;
    match methods.iter().find(|method| !is_compared(method)) {
        None => Ok(methods),
        Some(other) => {
            let name = other.name();
            let found =
                format!("--methods {name}: expected methods for {kind}, found another kind");
            Err(misused(found))
        }
    }
}

/// The category that is named, or all of them.
fn named<C: Copy>(
    args: &BenchmarkArgs,
    all: &[C],
    name: impl Fn(&C) -> &'static str,
) -> Result<Vec<C>, Failure> {
    let Some(asked) = &args.category else { return Ok(all.to_vec()) };
    let found = all.iter().copied().find(|category| name(category) == asked);
    let found = found.ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(&name).collect();
        misused(format!("--category: expected one of {}, found `{asked}`", names.join(", ")))
    })?;
    Ok(vec![found])
}

fn seconds(clock: &Clock) -> f64 {
    clock.now().as_nanos() as f64 * 1e-9
}
