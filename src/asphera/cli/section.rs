//! `asphera section`: the profile of a measured surface along a line, a circle, a radius or in a plane.

mod summary;

use std::path::{Path, PathBuf};

use asphera_geometry::VertexId;
use asphera_mesh::Mesh;
use asphera_report::SectionReport;
use asphera_surface::Plane;
use asphera_surface::sections::{CuttingPlane, SectionError, SectionPath};
use clap::{ArgGroup, Args};

use super::exit::Exit;
use super::files::{measured, part, refuse};
use super::output::{Failure, print, print_json, say};
use super::progress::Progress;
use super::source::{Source, source_help};
use super::text::TextArgs;
use super::usage::misused;
use crate::whole_file::write_bytes;
use asphera_measure::section::{Deviations, in_frame_of, report, report_of_plane};
use asphera_measure::{
    Along, Measurement, PointsSurface, SurfaceInSpace, no_area, refuse_path, surface_of_points,
};
use summary::summary;

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
    /// Along which direction the points are projected for their mesh: z, nx,ny,nz, or fitted, from the first 1000 of them. none:
    /// they are meshed in space, to be cut by --plane. auto: along z, and in space where they fold. Without it that of the
    /// session, or z.
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true)]
    along: Option<Along>,
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
        return Err(misused("--json and --out - both want stdout; give --out a file"));
    }
    if let Some(out) = to_file {
        refuse(out, [&args.source].into_iter().chain(&args.nominal), args.force)?;
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
        write_bytes(path, columns.csv())?;
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
    args.plane.map(|plane| in_frame(&Plane::XY, plane)).transpose()?;
    let given = args.nominal.as_deref().map(part).transpose()?;
    let is_given = given.is_some();
    let source = Source::open(&args.source, &args.text, progress)?;
    source.say_reading();
    let along = source.along(args.along);
    let mut report = match source.part(given) {
        Some(part) => {
            let found = measured(part, along, &source, progress)?;
            progress.stage("cutting");
            cut_measured(args, &found, is_given)?
        }
        None => {
            progress.stage("meshing");
            let surface = surface_of_points(source.points(), along);
            let surface = surface.map_err(|why| format!("{}: {why}", args.source.display()))?;
            progress.stage("cutting");
            match &surface {
                PointsSurface::InSpace(surface) => cut_in_space(args, surface, false)?,
                PointsSurface::InPlane { mesh, plane } => {
                    InPlane { mesh, plane, measurement: None }.cut(args)?
                }
            }
        }
    };
    report.reasons.extend(source.losses());
    Ok(report)
}

/// Cuts a measured surface, with the deviation from the nominal where it has a fit.
fn cut_measured(
    args: &SectionArgs,
    found: &Measurement,
    is_given: bool,
) -> Result<SectionReport, Failure> {
    let has_form = found.report.form.is_some();
    if !has_form && is_given {
        return Err(format!("there is no fit: {}", found.report.verdict.reasons.join("; ")).into());
    }
    if !has_form {
        say("the section has no deviation, because the nominal of the session has no fit here");
    }
    let surface = &found.surface;
    if let Some(surface) = surface.in_space() {
        return cut_in_space(args, surface, has_form);
    }
    let measurement = has_form.then_some(found);
    InPlane { mesh: surface.mesh(), plane: surface.plane(), measurement }.cut(args)
}

fn cut_in_space(
    args: &SectionArgs,
    surface: &SurfaceInSpace,
    with_deviation: bool,
) -> Result<SectionReport, Failure> {
    let name = args.source.display();
    let Some(plane) = args.plane else {
        let refused = match (args.line, args.radius) {
            (Some([x1, y1, x2, y2]), _) => refuse_path(Some(([x1, y1], [x2, y2]))),
            (_, Some(angle_deg)) => {
                let [x, y] = args.centre.unwrap_or_default();
                let (sin, cos) = angle_deg.to_radians().sin_cos();
                refuse_path(Some(([x, y], [x + cos, y + sin])))
            }
            _ => refuse_path(None),
        };
        return Err(format!("{name}: {refused}").into());
    };
    if surface.facets().is_empty() {
        return Err(format!("{name}: expected points that make a surface, found no facet").into());
    }
    Ok(surface.cut(&in_frame(&Plane::XY, plane)?, args.gap_limit, with_deviation)?)
}

/// A mesh in the frame of its plane of projection, and what was measured of it.
struct InPlane<'a> {
    mesh: &'a Mesh,
    plane: &'a Plane,
    /// Of a part with a fit.
    measurement: Option<&'a Measurement>,
}

impl InPlane<'_> {
    fn cut(&self, args: &SectionArgs) -> Result<SectionReport, Failure> {
        let InPlane { mesh, plane: projection, measurement } = *self;
        if *projection != Plane::XY {
            say(&format!(
                "x, y and z of the section are u, v and w of the plane of projection: {projection}"
            ));
        }
        if mesh.counts().triangles == 0 {
            return Err(format!("{}: {}", args.source.display(), no_area(mesh)).into());
        }
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
        if let Some(plane) = args.plane {
            let plane = in_frame(projection, plane)?;
            return Ok(report_of_plane(mesh, &plane, gap_limit_mm, deviations_nm)?);
        }
        Ok(report(mesh, &self.path(args)?, gap_limit_mm, deviations_nm)?)
    }

    fn path(&self, args: &SectionArgs) -> Result<SectionPath, Failure> {
        Ok(match (args.line, args.circle, args.radius) {
            (Some([x1, y1, x2, y2]), ..) => {
                SectionPath::Segment { from_mm: [x1, y1], to_mm: [x2, y2] }
            }
            (_, Some([x, y, radius_mm]), _) => {
                SectionPath::Circle { centre_mm: [x, y], radius_mm, start_rad: 0.0 }
            }
            (.., angle_deg) => {
                let origin_mm = self.measurement.and_then(|it| it.surface.on_plane([0.0; 3]));
                let fitted = origin_mm.map(|[u, v, _]| [u, v]);
                let centre_mm = args.centre.or(fitted).or_else(|| middle_mm(self.mesh));
                SectionPath::Radius {
                    centre_mm: centre_mm.ok_or_else(|| no_points(&args.source))?,
                    angle_rad: angle_deg.unwrap_or_default().to_radians(),
                }
            }
        })
    }
}

/// A plane a·x + b·y + c·z = d of the measured frame in the frame of the plane of projection.
fn in_frame(projection: &Plane, [a, b, c, d]: [f64; 4]) -> Result<CuttingPlane, SectionError> {
    in_frame_of(projection, [a, b, c], d)
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
