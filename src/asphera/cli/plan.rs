//! `asphera plan`: the path of a probe over a part, or through the places that lack points, with its times.

mod figures;
mod machine;
mod missing;

use std::io::{self, Write};
use std::path::{Path as FilePath, PathBuf};

use asphera_measure::{Along, Part, design_spacing};
use asphera_plan::{Aperture, Path, Schedule, Spacing, Way, lay, schedule, short_order};
use clap::{Args, ValueEnum};

use self::figures::{Figures, Gone, Needed, Regions};
use self::machine::MachineArgs;
use self::missing::Missing;
use super::columns::{self, Style};
use super::exit::Exit;
use super::files::{part, refuse};
use super::output::{Failure, print, print_json};
use super::progress::Progress;
use super::text::TextArgs;
use super::usage::misused;
use crate::station::plan_aperture;

#[derive(Args)]
pub(super) struct PlanArgs {
    /// With --path a nominal file: the path goes over its aperture. Without it what was measured, as `asphera sampling` takes it: the path
    /// goes through the places to measure next.
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    /// The path over the aperture.
    #[arg(long, value_enum)]
    path: Option<PathKind>,
    /// Largest distance of lines or turns, and of points on them, in mm.
    #[arg(long, value_name = "MM", requires = "path", value_parser = machine::length)]
    spacing: Option<f64>,
    /// The same as the nominal needs it: no gap exceeds E times the local feature size, nor the nominal's limit of gaps.
    #[arg(long, value_name = "E", requires = "path", value_parser = machine::share)]
    from_epsilon: Option<f64>,
    /// A point at every such length from the beginning of a line, in mm, as a trigger gives them. Without it points are even from end to end.
    #[arg(long, value_name = "MM", requires = "path", value_parser = machine::length)]
    trigger: Option<f64>,
    /// The path goes so far beyond the edge of the aperture, in mm.
    #[arg(long, value_name = "MM", requires = "path", default_value_t = 0.0, value_parser = machine::distance)]
    margin: f64,
    /// A raster whose lines all run towards +x.
    #[arg(long, requires = "path")]
    one_way: bool,
    /// A spiral or rings from the edge to the centre.
    #[arg(long, requires = "path")]
    inward: bool,
    /// The centre of the aperture in the frame of the machine, mm.
    #[arg(long, value_name = "X,Y", requires = "path", value_parser = machine::place, allow_hyphen_values = true)]
    centre: Option<[f64; 2]>,
    /// The nominal of what was measured. A session without it is held against its own.
    #[arg(long, value_name = "FILE", conflicts_with = "path")]
    nominal: Option<PathBuf>,
    /// Along which direction the points are projected for their mesh: z, nx,ny,nz, or fitted.
    #[arg(long, value_name = "DIRECTION", conflicts_with = "path", allow_hyphen_values = true)]
    along: Option<Along>,
    /// Where the probe stands at first, mm. Without it the first place of a path; of places to measure next 0,0.
    #[arg(long, value_name = "X,Y", value_parser = machine::place, allow_hyphen_values = true)]
    from: Option<[f64; 2]>,
    #[command(flatten)]
    machine: MachineArgs,
    /// The points in order, as columns of text: .csv, .xyz, .txt or .asc.
    #[arg(short, long, value_name = "PLAN.csv")]
    out: PathBuf,
    /// Overwrite PLAN if it is there.
    #[arg(long)]
    force: bool,
    /// Print the figures as one JSON object on stdout, and nothing else there.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum PathKind {
    /// Lines along x, there and back.
    Raster,
    /// A spiral with a turn at the edge.
    Spiral,
    /// Circles about the centre.
    Rings,
    /// Lines between the centre and the edge.
    Meridians,
}

/// A plan to be written.
struct Planned {
    schedule: Schedule,
    /// Heights of places, in the order of the points; none of a path.
    heights_mm: Vec<f64>,
    figures: Figures,
}

pub(super) fn run(args: &PlanArgs) -> Result<Exit, Failure> {
    let style = Style::of(&args.out)?;
    refuse(&args.out, [&args.source].into_iter().chain(&args.nominal), args.force)?;
    let progress = Progress::start("plan");
    let planned = match args.path {
        Some(kind) => over_aperture(args, kind, &progress)?,
        None => through_missing(args, &progress)?,
    };
    progress.stage("writing");
    columns::whole(&args.out, |writer| write(writer, style, args, &planned))?;
    drop(progress);
    if args.json {
        print_json(&planned.figures)?;
    } else {
        print(&planned.figures.to_string());
    }
    Ok(Exit::Done)
}

/// A path over the aperture of a nominal.
fn over_aperture(args: &PlanArgs, kind: PathKind, progress: &Progress) -> Result<Planned, Failure> {
    let name = args.source.display().to_string();
    if args.text.is_given() {
        return Err(misused(format!(
            "--columns, --unit, --skip-lines, --pitch and --keep-marks: expected points that were measured, found --path over the nominal {name}, \
             which states its units itself: leave them out"
        )));
    }
    let limits = args.machine.limits().map_err(misused)?;
    let part = part(&args.source)?;
    let aperture = aperture_of(&part, &name)?.widened(args.margin);
    progress.stage("local feature size");
    let needed = args.from_epsilon.map(|epsilon| Needed::new(&part, epsilon, &name)).transpose()?;
    let spacing_mm = match (args.spacing, &needed) {
        (Some(spacing_mm), None) => spacing_mm,
        (None, Some(needed)) => needed.spacing_mm,
        (Some(spacing_mm), Some(needed)) => spacing_mm.min(needed.spacing_mm),
        (None, None) => {
            return Err(misused(
                "--path: expected --spacing MM or --from-epsilon E, found neither",
            ));
        }
    };
    refuse_directions(args, kind)?;
    let way = if args.inward { Way::In } else { Way::Out };
    let path = match kind {
        PathKind::Raster => Path::Raster { pitch_mm: spacing_mm, one_way: args.one_way },
        PathKind::Spiral => Path::Spiral { pitch_mm: spacing_mm, way },
        PathKind::Rings => Path::Rings { pitch_mm: spacing_mm, way },
        PathKind::Meridians => Path::Meridians { pitch_mm: spacing_mm },
    };
    progress.stage("laying the path");
    let pieces = lay(&path, &aperture, args.centre.unwrap_or_default())?;
    let spacing = match args.trigger {
        Some(mm) => Spacing::Every { mm },
        None => Spacing::AtMost { mm: spacing_mm },
    };
    let mut schedule = schedule(&pieces, spacing, &limits, args.from)?;
    let [x0, y0] = args.centre.unwrap_or_default();
    // A spiral over a rectangle leaves it at the sides.
    schedule.points.retain(|point| aperture.contains([point.at_mm[0] - x0, point.at_mm[1] - y0]));
    let kind = kind.to_possible_value().map_or_else(String::new, |kind| kind.get_name().to_owned());
    let gone = Gone { path: kind, spacing_mm: Some(spacing_mm), pieces: pieces.len() };
    let figures = Figures::new(args, gone, &schedule).with_needed(needed);
    Ok(Planned { schedule, heights_mm: Vec::new(), figures })
}

/// Fails where a direction is asked for that a path does not have.
fn refuse_directions(args: &PlanArgs, kind: PathKind) -> Result<(), Failure> {
    let turns = matches!(kind, PathKind::Spiral | PathKind::Rings);
    if args.one_way && kind != PathKind::Raster {
        return Err(misused("--one-way: expected --path raster: leave it out for other paths"));
    }
    if args.inward && !turns {
        return Err(misused(
            "--inward: expected --path spiral or rings: leave it out for other paths",
        ));
    }
    Ok(())
}

/// A short path through the places to measure next.
fn through_missing(args: &PlanArgs, progress: &Progress) -> Result<Planned, Failure> {
    let limits = args.machine.limits().map_err(misused)?;
    let Missing { places_mm, regions, left_out, coverage } = missing::find(args, progress)?;
    progress.stage("ordering the places");
    let from_mm = args.from.unwrap_or_default();
    let flat: Vec<[f64; 2]> = places_mm.iter().map(|&[x, y, _]| [x, y]).collect();
    let order = short_order(from_mm, &flat)?;
    let ordered: Vec<[f64; 2]> = order.iter().map(|&index| flat[index]).collect();
    let pieces: Vec<asphera_plan::Piece> =
        ordered.iter().map(|&at_mm| asphera_plan::Piece::Stop { at_mm }).collect();
    let schedule = schedule(&pieces, Spacing::AtMost { mm: 1.0 }, &limits, Some(from_mm))?;
    let heights_mm = order.iter().map(|&index| places_mm[index][2]).collect();
    let gone = Gone { path: "next".to_owned(), spacing_mm: None, pieces: pieces.len() };
    let as_listed_mm = asphera_plan::path_length_mm(from_mm, flat);
    let regions = Regions { regions, left_out, coverage, as_listed_mm };
    let figures = Figures::new(args, gone, &schedule).with_regions(regions);
    Ok(Planned { schedule, heights_mm, figures })
}

/// The aperture of a part as plain numbers.
fn aperture_of(part: &Part, name: &str) -> Result<Aperture, Failure> {
    plan_aperture(&part.aperture).ok_or_else(|| {
        format!(
            "{name}: [aperture]: expected circle, rectangle or annulus, found none: give the region the path is to cover"
        )
        .into()
    })
}

/// Writes the points: place, axes of a polar machine, time.
fn write(
    writer: &mut impl Write,
    style: Style,
    args: &PlanArgs,
    planned: &Planned,
) -> io::Result<()> {
    let polar = args.machine.is_polar();
    let with_heights = !planned.heights_mm.is_empty();
    let mut names = vec!["x[mm]", "y[mm]"];
    names.extend(with_heights.then_some("z[mm]"));
    names.extend(polar.then_some(["r[mm]", "c[deg]"]).into_iter().flatten());
    names.push("t[s]");
    columns::head(writer, style, &[], &names)?;
    for (index, point) in planned.schedule.points.iter().enumerate() {
        let mut numbers = vec![point.at_mm[0], point.at_mm[1]];
        numbers.extend(planned.heights_mm.get(index));
        if polar {
            numbers.extend([point.axes[0], point.axes[1].to_degrees()]);
        }
        numbers.push(point.t_s);
        // To a hundredth of a nanometre: no machine tells finer places, and files stay half as long.
        let rounded: Vec<f64> =
            numbers.iter().map(|number| (1e8 * number).round() / 1e8 + 0.0).collect();
        columns::row(writer, style, &rounded)?;
    }
    Ok(())
}

impl Needed {
    fn new(part: &Part, epsilon: f64, name: &str) -> Result<Needed, Failure> {
        let found = design_spacing(part, epsilon).map_err(|why| format!("{name}: {why}"))?;
        if found.spacing_mm.is_infinite() {
            return Err(format!(
                "--from-epsilon: expected a surface that bends, found {} in {name}: give --spacing MM",
                part.nominal.kind()
            )
            .into());
        }
        Ok(Needed {
            epsilon,
            spacing_mm: found.spacing_mm,
            lfs_min_mm: found.lfs_min_mm,
            slope_max: found.slope_max,
        })
    }
}

/// Where a plan came from, for its figures.
fn shown(path: &FilePath) -> String {
    path.display().to_string()
}

#[cfg(test)]
mod tests;
