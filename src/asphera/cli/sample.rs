//! `asphera sample`: samples of a known curve, so that methods can be tried without data.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use asphera_contour::PlaceMm;
use asphera_contour::sampler::{
    BezierLine, Disturbance, Disturbed, SampledLine, Spacing, TrueCurve, borders,
};
use asphera_formats::drawing::{DrawnLine, read_dxf, read_svg};
use asphera_formats::mask;
use clap::Args;
use serde::Serialize;

use super::exit::Exit;
use super::files::{read, refuse};
use super::output::{Failure, print, print_json};
use super::summary::short;
use super::usage::misused;
use crate::contour::truth_report;

#[derive(Args)]
pub(super) struct SampleArgs {
    /// The curve: a drawing (.svg, .dxf) in mm, or a black and white image (.png).
    curve: PathBuf,
    /// Every place of the curve gets a sample nearer than E times its local feature size.
    #[arg(long, value_name = "E", value_parser = positive)]
    epsilon: Option<f64>,
    /// The same with the least local feature size between two samples.
    #[arg(long, value_name = "R", value_parser = positive)]
    rho: Option<f64>,
    /// No place of the curve is farther from the line between two samples.
    #[arg(long, value_name = "MM", value_parser = positive)]
    chord: Option<f64>,
    /// Move every sample within a disc: its radius over the diagonal of the box round the curve.
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = share)]
    noise: f64,
    /// Move every sample along the normal: the largest way over the local feature size.
    #[arg(long, value_name = "S", default_value_t = 0.0, value_parser = share)]
    noise_lfs: f64,
    /// Points anywhere in the box round the curve, in % of the samples.
    #[arg(long, value_name = "PCT", default_value_t = 0.0, value_parser = percent)]
    outliers: f64,
    /// Seed of the random numbers.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Width of a pixel of an image.
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = positive)]
    pixel: f64,
    /// The shape of an image is light on dark.
    #[arg(long)]
    light: bool,
    /// Where the samples go: x and y in mm, a line each, in the order of the curve, outliers last.
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Where the truth goes: .json, which `asphera compare` takes, or .xy, the places of the curve in order.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Print the figures as one JSON object on stdout.
    #[arg(long)]
    json: bool,
    /// Overwrite files that are there.
    #[arg(long)]
    force: bool,
}

/// Figures of samples that were made. Lengths are mm.
#[derive(Debug, PartialEq, Serialize)]
struct SampleReport {
    format: &'static str,
    /// How many lines the curve has, and how many of them are closed.
    lines: usize,
    closed: usize,
    /// The diagonal of the box round it.
    diagonal_mm: f64,
    /// Its least local feature size; beside corners it counts as 1/200 of the diagonal.
    lfs_least_mm: Option<f64>,
    /// How many samples were made, and how many outliers beside them.
    samples: usize,
    outliers: usize,
    seed: u64,
}

pub(super) fn run(args: &SampleArgs) -> Result<Exit, Failure> {
    for file in std::iter::once(&args.out).chain(&args.truth) {
        refuse(file, &args.curve, args.force)?;
    }
    if std::iter::once(&args.out).chain(&args.truth).any(|file| file.as_os_str() == "-") {
        return Err(misused("--out and --truth: expected names of files, found -"));
    }
    if args.truth.as_ref() == Some(&args.out) {
        let name = args.out.display();
        return Err(misused(format!("--out and --truth are both {name}: expected two files")));
    }
    let (curve, lines) = sampled(args)?;
    let disturbance = Disturbance {
        of_box: args.noise,
        of_lfs: args.noise_lfs,
        outliers_percent: args.outliers,
        seed: args.seed,
    };
    let points = disturbance.apply(&curve, &lines);
    write(&args.out, &columns(&points.points_mm))?;
    if let Some(path) = &args.truth {
        write(path, &truth(path, &curve, &points)?)?;
    }
    let least_mm = curve.least_lfs_mm();
    let report = SampleReport {
        format: "asphera-sample 1",
        lines: lines.len(),
        closed: lines.iter().filter(|line| line.closed).count(),
        diagonal_mm: curve.diagonal_mm(),
        lfs_least_mm: least_mm.is_finite().then_some(least_mm),
        samples: points.points_mm.len() - points.outliers,
        outliers: points.outliers,
        seed: args.seed,
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(&report.summary(&args.out));
    }
    Ok(Exit::Done)
}

/// The curve of the file and its samples.
fn sampled(args: &SampleArgs) -> Result<(TrueCurve, Vec<SampledLine>), Failure> {
    let name = args.curve.display();
    let bytes = read(&args.curve)?;
    let spacing = Spacing { epsilon: args.epsilon, rho: args.rho, chord_mm: args.chord };
    let ending = args.curve.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let named =
        |error: asphera_formats::ReadError| -> Failure { format!("{name}: {error}").into() };
    let drawn = match ending.as_deref() {
        Some("svg") => read_svg(&bytes).map_err(named)?,
        Some("dxf") => read_dxf(&bytes).map_err(named)?,
        Some("png") => return image(args, &bytes, &spacing),
        _ => {
            return Err(format!(
                "{name}: expected a curve as .svg, .dxf or .png, found another name"
            )
            .into());
        }
    };
    if spacing == Spacing::default() {
        return Err(misused(format!(
            "{name}: expected --epsilon, --rho or --chord, found none; they say how dense samples are"
        )));
    }
    let lines: Vec<BezierLine> = drawn
        .into_iter()
        .map(|DrawnLine { pieces, closed }| BezierLine { pieces, closed })
        .collect();
    let curve = TrueCurve::of_beziers(&lines, &spacing);
    let samples = curve.sampled(&spacing);
    match samples.is_empty() {
        true => Err(format!("{name}: expected a path or a shape, found none").into()),
        false => Ok((curve, samples)),
    }
}

/// So many steps along a border of pixels are averaged, three times over, before it is sampled by its local feature size.
const SMOOTHED: usize = 3;

/// The borders of an image: all their places, or samples of the smoothed ones.
fn image(
    args: &SampleArgs,
    bytes: &[u8],
    spacing: &Spacing,
) -> Result<(TrueCurve, Vec<SampledLine>), Failure> {
    let name = args.curve.display();
    let mask = mask::read(bytes, args.light).map_err(|error| format!("{name}: {error}"))?;
    let lines = borders(&mask.set, mask.columns, mask.rows, args.pixel);
    if lines.is_empty() {
        let cure = "give --light for a light shape on dark";
        return Err(format!("{name}: expected a dark shape, found no dark pixel; {cure}").into());
    }
    let lines: Vec<(Vec<PlaceMm>, bool)> = lines.into_iter().map(|line| (line, true)).collect();
    let curve = TrueCurve::of_places(&lines);
    if *spacing == Spacing::default() {
        let samples = curve.every_place();
        return Ok((curve, samples));
    }
    let curve = curve.smoothed(SMOOTHED);
    let samples = curve.sampled(spacing);
    Ok((curve, samples))
}

/// The text of the truth.
fn truth(path: &Path, curve: &TrueCurve, points: &Disturbed) -> Result<String, Failure> {
    let lines = curve.lines_mm();
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("json") => {
            let report = truth_report(&points.points_mm, &points.edges, lines);
            Ok(serde_json::to_string(&report)?)
        }
        Some("xy" | "xyz" | "txt") => {
            Ok(columns(&lines.into_iter().flat_map(|(places, _)| places).collect::<Vec<_>>()))
        }
        _ => {
            Err(format!("{}: expected a name in .json or .xy, found another", path.display())
                .into())
        }
    }
}

/// x and y, a line each, with all digits.
fn columns(places: &[PlaceMm]) -> String {
    let mut text = String::new();
    for [x, y] in places {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "{x} {y}");
    }
    text
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let failed = |error| format!("cannot write {}: {error}", path.display()).into();
    std::fs::write(path, text).map_err(failed)
}

impl SampleReport {
    fn summary(&self, out: &Path) -> String {
        let mut text = format!(
            "curve      {} lines, {} closed, {} mm across\n",
            self.lines,
            self.closed,
            short(self.diagonal_mm)
        );
        if let Some(least_mm) = self.lfs_least_mm {
            text.push_str(&format!("feature    {} mm at least\n", short(least_mm)));
        }
        text.push_str(&format!(
            "samples    {}, and {} outliers, seed {}, in {}\n",
            self.samples,
            self.outliers,
            self.seed,
            out.display()
        ));
        text
    }
}

fn positive(word: &str) -> Result<f64, String> {
    within(word, |value| value > 0.0, "a number above 0")
}

fn share(word: &str) -> Result<f64, String> {
    within(word, |value| (0.0..=1.0).contains(&value), "a number from 0 to 1")
}

fn percent(word: &str) -> Result<f64, String> {
    within(word, |value| (0.0..=1000.0).contains(&value), "a number from 0 to 1000")
}

fn within(word: &str, is_right: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    let value = word.parse::<f64>().ok().filter(|value| value.is_finite() && is_right(*value));
    value.ok_or_else(|| format!("expected {expected}, found `{word}`"))
}

#[cfg(test)]
mod tests;
