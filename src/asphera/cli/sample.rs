//! `asphera sample`: samples of a known curve, so that methods can be tried without data.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use asphera_contour::PlaceMm;
use asphera_contour::sampler::{
    BezierLine, Disturbance, Disturbed, SampledLine, Spacing, TrueCurve, borders,
};
use asphera_formats::drawing::{DrawnLine, LeftOut, read_dxf_and_count, read_svg_and_count};
use asphera_formats::mask;
use clap::Args;
use serde::Serialize;

use super::columns::Style;
use super::exit::Exit;
use super::files::{read, refuse};
use super::output::{Failure, print, print_json};
use super::summary::short;
use super::usage::misused;
use crate::contour::truth_report;
use crate::whole_file::write_bytes;

#[derive(Args)]
pub(super) struct SampleArgs {
    /// The curve: a drawing (.svg, .dxf) in mm, or an image (.png), whose shape is darker than half way from black to white.
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
    /// Width of a pixel of an image. Without it 1 mm.
    #[arg(long, value_name = "MM", value_parser = positive)]
    pixel: Option<f64>,
    /// The shape of an image is light on dark.
    #[arg(long)]
    light: bool,
    /// Where the samples go: x and y in mm, a line each, in the order of the curve, outliers last. A .csv has commas and a head.
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
    /// How many elements of a drawing were not read, by their names.
    #[serde(skip_serializing_if = "LeftOut::is_empty")]
    left_out: LeftOut,
    /// What of an image is its shape.
    #[serde(skip_serializing_if = "Option::is_none")]
    image: Option<ImageFigures>,
}

/// The pixels of an image.
#[derive(Debug, PartialEq, Serialize)]
struct ImageFigures {
    pixels: usize,
    /// Those of the shape.
    shape: usize,
    /// Whether it is the light ones.
    light: bool,
    /// Those whose red, green and blue differ: the mean of these counts.
    coloured: usize,
    /// Those less than half opaque, which are no shape.
    transparent: usize,
}

/// A curve with its samples, and what was not taken of its file.
struct Taken {
    curve: TrueCurve,
    samples: Vec<SampledLine>,
    left_out: LeftOut,
    image: Option<ImageFigures>,
}

pub(super) fn run(args: &SampleArgs) -> Result<Exit, Failure> {
    for file in std::iter::once(&args.out).chain(&args.truth) {
        refuse(file, [&args.curve], args.force)?;
    }
    if std::iter::once(&args.out).chain(&args.truth).any(|file| file.as_os_str() == "-") {
        return Err(misused("--out and --truth: expected names of files, found -"));
    }
    if args.truth.as_ref() == Some(&args.out) {
        let name = args.out.display();
        return Err(misused(format!("--out and --truth are both {name}: expected two files")));
    }
    if let Some(path) = &args.truth {
        truth_kind(path)?;
    }
    if !is_of_places(&args.out) {
        let name = args.out.display();
        return Err(misused(format!(
            "{name}: expected a name in .xy, .xyz, .txt or .csv, found another"
        )));
    }
    let Taken { curve, samples: lines, left_out, image } = sampled(args)?;
    let disturbance = Disturbance {
        of_box: args.noise,
        of_lfs: args.noise_lfs,
        outliers_percent: args.outliers,
        seed: args.seed,
    };
    let points = disturbance.apply(&curve, &lines);
    write_bytes(&args.out, places(&args.out, &points.points_mm))?;
    if let Some(path) = &args.truth {
        write_bytes(path, truth(path, &curve, &points)?)?;
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
        left_out,
        image,
    };
    if args.json {
        print_json(&report)?;
    } else {
        print(&report.summary(&args.out));
    }
    Ok(Exit::Done)
}

/// The curve of the file and its samples.
fn sampled(args: &SampleArgs) -> Result<Taken, Failure> {
    let name = args.curve.display();
    let bytes = read(&args.curve)?;
    let spacing = Spacing { epsilon: args.epsilon, rho: args.rho, chord_mm: args.chord };
    let ending = args.curve.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let named =
        |error: asphera_formats::ReadError| -> Failure { format!("{name}: {error}").into() };
    let is_image = ending.as_deref() == Some("png");
    if !is_image && (args.pixel.is_some() || args.light) {
        return Err(misused(format!(
            "{name}: --pixel and --light are of an image (.png): leave them out"
        )));
    }
    let (drawn, left_out) = match ending.as_deref() {
        Some("svg") => read_svg_and_count(&bytes).map_err(named)?,
        Some("dxf") => read_dxf_and_count(&bytes).map_err(named)?,
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
    if samples.is_empty() {
        let but = match left_out.is_empty() {
            true => String::new(),
            false => format!(" but {}", counts(&left_out)),
        };
        return Err(format!("{name}: expected a path or a shape, found none{but}").into());
    }
    Ok(Taken { curve, samples, left_out, image: None })
}

/// So many steps along a border of pixels are averaged, three times over, before it is sampled by its local feature size.
const SMOOTHED: usize = 3;

/// The borders of an image: all their places, or samples of the smoothed ones.
fn image(args: &SampleArgs, bytes: &[u8], spacing: &Spacing) -> Result<Taken, Failure> {
    let name = args.curve.display();
    let mask = mask::read(bytes, args.light).map_err(|error| format!("{name}: {error}"))?;
    let lines = borders(&mask.set, mask.columns, mask.rows, args.pixel.unwrap_or(PIXEL_MM));
    if lines.is_empty() {
        let cure = "give --light for a light shape on dark";
        return Err(format!("{name}: expected a dark shape, found no dark pixel; {cure}").into());
    }
    let figures = ImageFigures {
        pixels: mask.set.len(),
        shape: mask.set.iter().filter(|set| **set).count(),
        light: args.light,
        coloured: mask.coloured,
        transparent: mask.transparent,
    };
    let taken =
        |curve, samples| Taken { curve, samples, left_out: LeftOut::new(), image: Some(figures) };
    let lines: Vec<(Vec<PlaceMm>, bool)> = lines.into_iter().map(|line| (line, true)).collect();
    let curve = TrueCurve::of_places(&lines);
    if *spacing == Spacing::default() {
        let samples = curve.every_place();
        return Ok(taken(curve, samples));
    }
    let curve = curve.smoothed(SMOOTHED);
    let samples = curve.sampled(spacing);
    Ok(taken(curve, samples))
}

/// Width of a pixel where none is given.
const PIXEL_MM: f64 = 1.0;

/// How the truth is written.
#[derive(Clone, Copy, PartialEq)]
enum TruthKind {
    Report,
    Places,
}

/// How the name of a file asks for the truth.
fn truth_kind(path: &Path) -> Result<TruthKind, Failure> {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("json") => Ok(TruthKind::Report),
        _ if is_of_places(path) => Ok(TruthKind::Places),
        _ => Err(misused(format!(
            "{}: expected a name in .json or .xy, found another",
            path.display()
        ))),
    }
}

/// Whether places go into a file of this name.
fn is_of_places(path: &Path) -> bool {
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    // A device or a pipe has no ending.
    matches!(ending.as_deref(), None | Some("xy" | "xyz" | "txt" | "asc" | "csv"))
}

/// The text of the truth.
fn truth(path: &Path, curve: &TrueCurve, points: &Disturbed) -> Result<String, Failure> {
    let lines = curve.lines_mm();
    if truth_kind(path)? == TruthKind::Report {
        let report = truth_report(&points.points_mm, &points.edges, lines);
        return Ok(serde_json::to_string(&report)?);
    }
    let all: Vec<PlaceMm> = lines.into_iter().flat_map(|(places, _)| places).collect();
    Ok(places(path, &all))
}

/// x and y, a line each, with all digits: of a .csv with commas, below a head.
fn places(path: &Path, places: &[PlaceMm]) -> String {
    let is_csv = Style::by_name(path) == Some(Style::Commas);
    let mut text = String::new();
    if is_csv {
        text.push_str("x[mm],y[mm]\n");
    }
    let separator = if is_csv { ',' } else { ' ' };
    for [x, y] in places {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "{x}{separator}{y}");
    }
    text
}

/// Elements that were left out, as `2 use, 1 text`.
fn counts(left_out: &LeftOut) -> String {
    let words: Vec<String> =
        left_out.iter().map(|(name, count)| format!("{count} {name}")).collect();
    words.join(", ")
}

impl ImageFigures {
    /// What of the image is the shape.
    fn words(&self) -> String {
        let ImageFigures { pixels, shape, light, coloured, transparent } = self;
        let way = if *light { "lighter" } else { "darker" };
        let mut text = format!(
            "shape      {shape} of {pixels} pixels, {way} than half way from black to white"
        );
        if *coloured > 0 {
            text.push_str(&format!(
                "; of {coloured} coloured ones the mean of red, green and blue counts"
            ));
        }
        if *transparent > 0 {
            text.push_str(&format!("; {transparent} less than half opaque are left out"));
        }
        text.push('\n');
        text
    }
}

impl SampleReport {
    fn summary(&self, out: &Path) -> String {
        let mut text = format!(
            "curve      {} lines, {} closed, {} mm across\n",
            self.lines,
            self.closed,
            short(self.diagonal_mm)
        );
        if !self.left_out.is_empty() {
            let found = counts(&self.left_out);
            text.push_str(&format!(
                "left out   {found}: paths and basic shapes alone are read, where they are shown\n"
            ));
        }
        text.extend(self.image.as_ref().map(ImageFigures::words));
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
