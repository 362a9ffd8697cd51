//! `asphera section`: the profile of a measured surface along a line, a circle, a radius or in a plane.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use asphera_geometry::VertexId;
use asphera_mesh::Mesh;
use asphera_report::SectionReport;
use asphera_surface::Plane;
use asphera_surface::sections::{CuttingPlane, SectionError, SectionPath};
use clap::{ArgGroup, Args};

use super::exit::Exit;
use super::files::{measured, meshed, part, refuse};
use super::output::{Failure, print, print_json, say};
use super::progress::Progress;
use super::source::{Source, source_help};
use super::text::TextArgs;
use asphera_measure::section::{Deviations, report, report_of_plane};
use asphera_measure::{NOT_IN_SPACE, no_area};

#[derive(Args)]
#[command(group = ArgGroup::new("path").required(true).args(["line", "circle", "radius", "plane"]))]
pub(super) struct SectionArgs {
    #[arg(help = source_help())]
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    /// From one place to another, in mm of the measured frame; u and v of the plane if a session was projected along another
    /// direction than z.
    #[arg(long, value_name = "X1,Y1,X2,Y2", value_parser = numbers::<4>, allow_hyphen_values = true)]
    line: Option<[f64; 4]>,
    /// Around a centre, counter-clockwise from its right, in mm of the measured frame.
    #[arg(long, value_name = "X,Y,R", value_parser = numbers::<3>, allow_hyphen_values = true)]
    circle: Option<[f64; 3]>,
    /// From the centre outwards, in degrees counter-clockwise from the direction of x.
    #[arg(long, value_name = "DEG", value_parser = number, allow_hyphen_values = true)]
    radius: Option<f64>,
    /// All of the surface in the plane a·x + b·y + c·z = d of the measured frame: any direction, lengths in mm;
    /// each piece begins at s = 0.
    #[arg(long, value_name = "A,B,C,D", value_parser = numbers::<4>, allow_hyphen_values = true)]
    plane: Option<[f64; 4]>,
    /// The centre of --radius in mm; without it that of the fitted nominal, or else the middle of the
    /// points.
    #[arg(long, value_name = "X,Y", value_parser = numbers::<2>, allow_hyphen_values = true, conflicts_with_all = ["line", "circle", "plane"])]
    centre: Option<[f64; 2]>,
    /// The nominal, fitted as by `measure`: the deviation from it is a further column. A session without it is held
    /// against its own.
    #[arg(long, value_name = "FILE")]
    nominal: Option<PathBuf>,
    /// The section breaks where the nearest point is farther than this, mm; without it that of the
    /// nominal, or else four times the mean distance of the points.
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true)]
    gap_limit: Option<f64>,
    /// Where the CSV goes; without it, or with -, to stdout.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Overwrite --out if it is there.
    #[arg(long)]
    force: bool,
    /// Print the figures as one JSON object on stdout; the CSV is written only where --out says.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &SectionArgs) -> Result<Exit, Failure> {
    let to_file = args.out.as_deref().filter(|path| *path != Path::new("-"));
    if args.json && args.out.is_some() && to_file.is_none() {
        return Err("--json and --out - both want stdout; give --out a file".into());
    }
    if let Some(out) = to_file {
        refuse(out, &args.source, args.force)?;
    }
    let progress = Progress::start("section");
    let mut report = cut(args, &progress)?;
    if report.pieces.is_empty() {
        return Err(format!(
            "the section meets no measured surface: it lies outside the points of {}, or in a gap of them",
            args.source.display()
        )
        .into());
    }
    drop(progress);
    let columns = report.points.take().unwrap_or_default();
    if let Some(path) = to_file {
        fs::write(path, columns.csv())
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    }
    if args.json {
        print_json(&report)?;
    } else if to_file.is_some() {
        print(&summary(&report));
    } else {
        print(&columns.csv());
        say(summary(&report).trim_end());
    }
    Ok(Exit::Done)
}

/// Meshes the points and cuts the surface.
fn cut(args: &SectionArgs, progress: &Progress) -> Result<SectionReport, Failure> {
    // A plane that cannot be is told before anything is read.
    let plane = args.plane;
    plane.map(|plane| on(&Plane::XY, plane)).transpose()?;
    let given = args.nominal.as_deref().map(part).transpose()?;
    let is_given = given.is_some();
    let source = Source::open(&args.source, &args.text, progress)?;
    source.say_reading();
    let measured = |part| measured(part, source.along(None), &source, progress);
    let found = source.part(given).map(measured).transpose()?;
    let surface = found.as_ref().map(|found| &found.surface);
    let mut measurement = found.as_ref();
    if !is_given && measurement.is_some_and(|found| found.report.form.is_none()) {
        say("the section has no deviation, because the nominal of the session has no fit here");
        measurement = None;
    }
    let projection = surface.map_or(&Plane::XY, |surface| surface.plane());
    if *projection != Plane::XY {
        say(&format!(
            "x, y and z of the section are u, v and w of the session's plane: {projection}"
        ));
    }
    let unmeasured;
    let mesh = match surface {
        Some(surface) => surface.mesh(),
        None => {
            unmeasured = meshed(&source, progress);
            &unmeasured
        }
    };
    if found.as_ref().is_some_and(|found| found.report.mesh.reconstruction.is_some()) {
        return Err(format!("{}: {NOT_IN_SPACE}", args.source.display()).into());
    }
    if mesh.counts().triangles == 0 {
        return Err(format!("{}: {}", args.source.display(), no_area(mesh)).into());
    }
    progress.stage("cutting");
    let form = measurement.map(|measurement| {
        let reasons = || measurement.report.verdict.reasons.join("; ");
        measurement.report.form.as_ref().ok_or_else(|| format!("there is no fit: {}", reasons()))
    });
    let form = form.transpose()?;
    let gap_limit_mm = args.gap_limit.or_else(|| match measurement {
        Some(measurement) => measurement.report.sampling.gap_limit_mm,
        None => mean_distance_mm(mesh).map(|distance_mm| GAP_LIMIT_DISTANCES * distance_mm),
    });
    let deviations_nm = measurement.map(|measurement| {
        |vertices: &[VertexId]| {
            let of = |vertex: &VertexId| measurement.deviations_nm[*vertex as usize];
            vertices.iter().map(of).collect::<Vec<f64>>()
        }
    });
    let deviations_nm = deviations_nm.as_ref().map(|of| of as &Deviations);
    let with_losses = |mut report: SectionReport| {
        report.reasons.extend(source.losses());
        report
    };
    if let Some(plane) = plane {
        let plane = on(projection, plane)?;
        return Ok(with_losses(report_of_plane(mesh, &plane, gap_limit_mm, deviations_nm)?));
    }
    let path = match (args.line, args.circle, args.radius) {
        (Some([x1, y1, x2, y2]), ..) => SectionPath::Segment { from_mm: [x1, y1], to_mm: [x2, y2] },
        (_, Some([x, y, radius_mm]), _) => {
            SectionPath::Circle { centre_mm: [x, y], radius_mm, start_rad: 0.0 }
        }
        (.., angle_deg) => {
            let origin_mm = surface.filter(|_| form.is_some()).and_then(|it| it.on_plane([0.0; 3]));
            let fitted = origin_mm.map(|[u, v, _]| [u, v]);
            let centre_mm = args.centre.or(fitted).or_else(|| middle_mm(mesh));
            SectionPath::Radius {
                centre_mm: centre_mm.ok_or_else(|| no_points(&args.source))?,
                angle_rad: angle_deg.unwrap_or_default().to_radians(),
            }
        }
    };
    Ok(with_losses(report(mesh, &path, gap_limit_mm, deviations_nm)?))
}

/// A plane a·x + b·y + c·z = d of the measured frame in the frame of the plane of projection.
fn on(projection: &Plane, [a, b, c, d]: [f64; 4]) -> Result<CuttingPlane, SectionError> {
    if *projection == Plane::XY {
        return CuttingPlane::new([a, b, c], d);
    }
    let along = |[x, y, z]: [f64; 3]| a * x + b * y + c * z;
    CuttingPlane::new(projection.axes().map(along), d - along(projection.origin_mm()))
}

fn no_points(file: &Path) -> String {
    format!("{} has no points", file.display())
}

/// The middle of the smallest box around the points.
fn middle_mm(mesh: &Mesh) -> Option<[f64; 2]> {
    let first = mesh.points().first()?;
    let middle = |axis: usize| {
        let (low, high) =
            mesh.points().iter().fold((first[axis], first[axis]), |(low, high), at| {
                (low.min(at[axis]), high.max(at[axis]))
            });
        low / 2.0 + high / 2.0
    };
    Some([middle(0), middle(1)])
}

/// The side of the square that each point has on average.
fn mean_distance_mm(mesh: &Mesh) -> Option<f64> {
    let distance_mm = (mesh.area().projected_mm2 / mesh.counts().vertices as f64).sqrt();
    (distance_mm > 0.0).then_some(distance_mm)
}

/// The figures as a person reads them.
fn summary(report: &SectionReport) -> String {
    let mut text = String::new();
    // Writing into a String cannot fail.
    let _ = write_summary(&mut text, report);
    text
}

fn write_summary(text: &mut String, report: &SectionReport) -> std::fmt::Result {
    let pieces = match report.pieces.len() {
        1 => "one piece".to_owned(),
        count => format!("{count} pieces"),
    };
    writeln!(text, "section    {:.6} mm in {pieces}", report.length_mm)?;
    if let Some(height) = &report.height {
        writeln!(
            text,
            "height     PV {:.6} mm, mean {:.6} mm, RMS about it {:.6} mm",
            height.pv_mm, height.mean_mm, height.rms_about_mean_mm
        )?;
        if let Some(line) = &height.line {
            write!(text, "line       slope {:.9}", line.slope)?;
            if let Some(u) = line.u_slope {
                write!(text, " (u {u:.1e})")?;
            }
            writeln!(text, ", left PV {:.1} nm, RMS {:.2} nm", line.pv_nm, line.rms_nm)?;
        }
        if let Some(circle) = &height.circle {
            match circle.radius_mm.zip(circle.u_radius_mm) {
                Some((radius, u)) => write!(text, "circle     radius {radius:.6} mm (u {u:.1e})")?,
                None => write!(text, "circle     none: the curvature is not significant")?,
            }
            writeln!(text, ", left PV {:.1} nm, RMS {:.2} nm", circle.pv_nm, circle.rms_nm)?;
        }
    }
    if let Some(deviation) = &report.deviation {
        writeln!(
            text,
            "deviation  PV {:.1} nm, RMS {:.2} nm, mean {:.2} nm over {:.6} mm",
            deviation.pv_nm, deviation.rms_nm, deviation.mean_nm, deviation.length_mm
        )?;
    }
    report.reasons.iter().try_for_each(|reason| writeln!(text, "  {reason}"))
}

/// As many finite numbers as are asked for, with commas between.
fn numbers<const N: usize>(word: &str) -> Result<[f64; N], String> {
    let found = word.split(',').map(number).collect::<Result<Vec<f64>, String>>()?;
    let count = found.len();
    found.try_into().map_err(|_| format!("expected {N} numbers with commas between, found {count}"))
}

fn number(word: &str) -> Result<f64, String> {
    match word.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("expected a finite number, found `{word}`")),
    }
}

/// As `measure` does where the nominal gives no limit.
const GAP_LIMIT_DISTANCES: f64 = 4.0;

#[cfg(test)]
mod tests;
