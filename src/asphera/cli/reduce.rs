//! `asphera reduce`: a dense cloud to the points that are enough.

mod figures;
mod laid;
mod limits;
mod noise;
mod space;

use std::io::{self, Write};
use std::path::PathBuf;

use asphera_form::{Aperture, Pose};
use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_surface::noise::assess_spacing;
use asphera_surface::reduce::{Averaged, Keep, Target, average, reduce, spread};
use asphera_surface::{Criteria, Plane, StateCounts, assess};
use clap::{ArgGroup, Args, ValueEnum};
use figures::{Averages, Condition, Figures, Input, Lfs, Range, Spacings, Sparse};
use laid::Laid;
use limits::Limits;
use noise::NoiseWanted;

use super::columns::{self, Style};
use super::exit::Exit;
use super::files::{meshed, part, refuse};
use super::output::{Failure, print, print_json};
use super::progress::Progress;
use super::source::{Source, source_help};
use super::text::TextArgs;
use asphera_measure::Part;
use asphera_measure::{Along, Readings, Sampled, feature_size, folded, no_area};

#[derive(Args)]
#[command(group(ArgGroup::new("limit").args(["epsilon", "rho"]).required(true).multiple(true)))]
pub(super) struct ReduceArgs {
    #[arg(help = source_help())]
    source: PathBuf,
    #[command(flatten)]
    text: TextArgs,
    /// Largest distance from the surface to a kept point, as a share of the local feature size; above 0, up to 1.
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    epsilon: Option<f64>,
    /// The same as a share of the reach, the smallest local feature size of all: one spacing everywhere. With E as well
    /// the smaller of both counts at each place.
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    rho: Option<f64>,
    /// Standard deviation of the heights in nm, or auto to take it from the points. Kept points are so far apart that
    /// noise tilts no facet by more than the limit; 0 leaves that out.
    #[arg(long, value_name = "S", default_value = "auto")]
    noise: NoiseWanted,
    /// The largest tilt of a facet by noise in rad, root mean square; above 0, below π/2. As large as E if not given,
    /// or R if that is smaller: so far the surface itself turns between samples that these allow.
    #[arg(long, value_name = "RAD")]
    tilt: Option<f64>,
    /// How many points to keep, as far as both conditions leave a choice.
    #[arg(long, value_enum, default_value_t = KeepWanted::Fewest)]
    keep: KeepWanted,
    /// The nominal, for the local feature size, as `asphera sampling` takes it. A session without it has its own; of a
    /// file without it the size follows from the points.
    /// Averages are then of the deviations from it.
    #[arg(long, value_name = "FILE")]
    nominal: Option<PathBuf>,
    /// Give each kept point the height of a surface fitted to all points about it, and its standard uncertainty as a
    /// fourth column. Without this no point is moved.
    #[arg(long)]
    average: bool,
    /// The kept points, as columns of text in mm: .xyz, .txt, .asc or .csv.
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// Overwrite OUT if it is there.
    #[arg(long)]
    force: bool,
    /// none: the points are meshed in space, and topology is kept too. auto: along z, and in space where they fold. z: along z.
    /// Without it that of the session, or z.
    #[arg(long, value_name = "DIRECTION", allow_hyphen_values = true, value_parser = direction)]
    along: Option<Along>,
    /// Print what happened as one JSON object on stdout, and nothing else there.
    #[arg(long)]
    json: bool,
}

/// Which spacing is taken between what the noise needs and what ε allows.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum KeepWanted {
    /// As few as the sampling condition allows.
    Fewest,
    /// As many as give facets with the truest normals: noise and bending turn them alike.
    Truest,
    /// As many as the noise allows.
    Most,
}

impl KeepWanted {
    /// As it is written on the command line.
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

impl From<KeepWanted> for Keep {
    fn from(wanted: KeepWanted) -> Keep {
        match wanted {
            KeepWanted::Fewest => Keep::Fewest,
            KeepWanted::Truest => Keep::Truest,
            KeepWanted::Most => Keep::Most,
        }
    }
}

pub(super) fn run(args: &ReduceArgs) -> Result<Exit, Failure> {
    // What can be wrong without the points is told before they are read.
    let limits = Limits::new(args.epsilon, args.rho)?;
    target(args, &limits, 1.0)?;
    Style::of(&args.out)?;
    refuse(&args.out, [&args.source].into_iter().chain(&args.nominal), args.force)?;
    let given = args.nominal.as_deref().map(part).transpose()?;
    let name = args.source.display().to_string();
    let progress = Progress::start("reduce");
    let source = Source::open(&args.source, &args.text, &progress)?;
    source.say_reading();
    let part = source.part(given);
    let along = source.along(args.along);
    if along == Along::NONE {
        return space::run(args, &source, part.as_ref(), &limits, progress);
    }
    let mesh = meshed(&source, &progress);
    refuse_line(&mesh, &name)?;
    match folded(&mesh, &mesh.triangles(), &Plane::XY) {
        None => in_plane(args, &limits, &source, part.as_ref(), &mesh, progress),
        Some(_) if along == Along::AUTO => {
            space::run(args, &source, part.as_ref(), &limits, progress)
        }
        Some(why) => Err(format!("{name}: {why}").into()),
    }
}

/// Reduces the points of a mesh in the plane, writes those that are kept, and tells of it.
fn in_plane(
    args: &ReduceArgs,
    limits: &Limits,
    source: &Source,
    part: Option<&Part>,
    mesh: &Mesh,
    progress: Progress,
) -> Result<Exit, Failure> {
    let style = Style::of(&args.out)?;
    let name = args.source.display().to_string();
    let (points, triangles) = (mesh.points(), mesh.triangles());
    progress.stage("estimating the noise");
    let (deviation, noise) = noise::noise(points, &triangles, args.noise, &name)?;
    let sigma_mm = deviation.sigma_mm();
    if args.average {
        refuse_exact(sigma_mm, &name)?;
    }
    let readings = Readings { noise: deviation, wrong_share: noise.outlier_share.unwrap_or(0.0) };
    let laid = laid(part, points, &name)?;
    let sampled = Sampled { mesh, triangles: &triangles, plane: &Plane::XY };
    let at = laid.as_ref().map(|laid| (laid.part, &laid.pose));
    progress.stage("local feature size");
    let (known, lfs_source) = feature_size(sampled, at, readings)
        .map_err(|error| format!("{name}: {error}; give the surface with --nominal"))?;
    let (pose, aperture) = place(laid.as_ref());
    let lfs_mm = known.lfs_mm(&pose);
    // Where nothing bends, points a fifth of the width apart still stay.
    let lfs_max_mm = 0.2 * width_mm(points) / limits.share;
    let target = target(args, limits, lfs_max_mm)?.with_noise(deviation)?;
    let known_mm = |at: PointMm| target.lfs_mm(lfs_mm(at[0], at[1]));
    let range_mm = Range::of(points.iter().filter_map(|&point| known_mm(point)));
    let reach_mm = target.lfs_mm(known.reach_mm(&aperture, points, &pose));
    let limiting_mm = |at: PointMm| limits.limiting_mm(known_mm(at), reach_mm);
    progress.stage("choosing points");
    let reduction = reduce(points, triangles.iter().copied(), &target, limiting_mm);
    if let Some(found) = reduction.shortfall {
        return Err(limits.shortfall(&name, &target, found));
    }
    let kept: Vec<PointMm> =
        reduction.retained.iter().map(|&index| points[index as usize]).collect();
    let height_mm = |point| laid.as_ref().and_then(|laid: &Laid<'_>| laid.height_mm(point));
    let averaged = args.average.then(|| {
        progress.stage("averaging heights");
        average(points, &kept, sigma_mm, height_mm)
    });
    progress.stage("checking the result");
    let mut reduced = Mesh::new();
    reduced.insert(&kept);
    let figures = Figures {
        format: figures::FORMAT,
        source: name,
        losses: source.losses(),
        input: Input::of(mesh, source.missing()),
        epsilon: args.epsilon,
        rho: args.rho,
        tilt_limit_rad: target.criteria().tilt_limit_rad(),
        keep: args.keep.name(),
        lfs: Lfs::new(lfs_source, (range_mm, reach_mm), lfs_max_mm),
        noise,
        kept: reduction.tally.retained(),
        dropped: reduction.tally.dropped(),
        mended: reduction.mended,
        by: reduction.tally.into(),
        sparse: Sparse::of(&reduction),
        spacing: spread(&kept).map(Spacings::from),
        averaged: averaged.as_ref().map(|found| found.averaged),
        averages: averaged.as_ref().map(|found| Averages::of(found, laid.is_some())),
        before: condition(mesh, &target, limits, reach_mm, known_mm),
        after: condition(&reduced, &target, limits, reach_mm, known_mm),
        output: args.out.display().to_string(),
    };
    progress.stage("writing");
    columns::whole(&args.out, |writer| {
        write(writer, style, &figures.remarks(), &kept, averaged.as_ref())
    })?;
    drop(progress);
    show(&figures, args.json)?;
    Ok(Exit::Done)
}

/// z, none or auto.
fn direction(word: &str) -> Result<Along, String> {
    let along = word.parse::<Along>().map_err(|error| error.to_string())?;
    if [Along::Z, Along::NONE, Along::AUTO].contains(&along) {
        Ok(along)
    } else {
        Err(format!(
            "points are reduced along z or in space: expected z, none or auto, found `{word}`"
        ))
    }
}

/// The target where the local feature size is taken as no more than `lfs_max_mm`.
fn target(args: &ReduceArgs, limits: &Limits, lfs_max_mm: f64) -> Result<Target, Failure> {
    let target = Target::new(limits.share, lfs_max_mm)?.keeping(args.keep.into());
    Ok(match args.tilt {
        Some(tilt_rad) => target.with_tilt_limit(tilt_rad)?,
        None => target,
    })
}

/// The design where it lies in the points; `None` without one.
fn laid<'a>(
    part: Option<&'a Part>,
    points: &[PointMm],
    name: &str,
) -> Result<Option<Laid<'a>>, Failure> {
    let designed = part.filter(|part| part.reference.is_none());
    let laid = designed.map(|part| Laid::new(part, points)).transpose();
    Ok(laid
        .map_err(|error| format!("{name}: the nominal cannot be laid into the points: {error}"))?)
}

/// Where the design lies, and its aperture.
fn place(laid: Option<&Laid<'_>>) -> (Pose, Aperture) {
    laid.map_or((Pose::default(), Aperture::None), |laid| (laid.pose, laid.part.aperture.clone()))
}

fn show(figures: &Figures, as_json: bool) -> Result<(), Failure> {
    if as_json {
        print_json(figures)?;
    } else {
        print(&figures.to_string());
    }
    Ok(())
}

/// Fails where there is no noise to average.
fn refuse_exact(sigma_mm: f64, name: &str) -> Result<(), Failure> {
    if sigma_mm == 0.0 {
        return Err(format!(
            "{name}: expected noise above 0 nm to average, found 0: give it with --noise, or leave --average out"
        )
        .into());
    }
    Ok(())
}

/// Fails where points span no area.
fn refuse_line(mesh: &Mesh, name: &str) -> Result<(), Failure> {
    let counts = mesh.counts();
    match (counts.triangles, counts.rejected) {
        (0, 0) => Err(format!(
            "{name}: expected points that span an area, found {} places on a line or a point",
            counts.vertices
        )
        .into()),
        (0, _) => Err(format!("{name}: {}", no_area(mesh)).into()),
        _ => Ok(()),
    }
}

/// Writes the points, each with its uncertainty if it was averaged.
fn write(
    writer: &mut impl Write,
    style: Style,
    remarks: &[String],
    kept: &[PointMm],
    averaged: Option<&Averaged>,
) -> io::Result<()> {
    let Some(averaged) = averaged else {
        columns::head(writer, style, remarks, &["x[mm]", "y[mm]", "z[mm]"])?;
        return kept.iter().try_for_each(|point| columns::row(writer, style, point));
    };
    columns::head(writer, style, remarks, &["x[mm]", "y[mm]", "z[mm]", "u_z[mm]"])?;
    averaged.points.iter().try_for_each(|point| {
        let [x, y, z] = point.point_mm;
        columns::row(writer, style, &[x, y, z, point.u_mm])
    })
}

/// The shorter side of the box about the places of points, in mm: what is kept of a narrow part must
/// still span its width.
fn width_mm(points: &[PointMm]) -> f64 {
    let side = |axis: usize| {
        let along = || points.iter().map(|point| point[axis]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    side(0).min(side(1))
}

/// Whether a mesh is dense enough for ε and ρ, and not too dense for the noise. `lfs_mm` is the local feature size at a
/// place, `reach_mm` its smallest.
fn condition(
    mesh: &Mesh,
    target: &Target,
    limits: &Limits,
    reach_mm: Option<f64>,
    lfs_mm: impl Fn(PointMm) -> Option<f64>,
) -> Condition {
    let points = mesh.points();
    let triangles = mesh.triangles();
    let criteria = Criteria {
        epsilon_limit: limits.epsilon,
        gap_limit_mm: limits.rho.zip(reach_mm).map(|(rho, reach_mm)| rho * reach_mm),
        aperture_area_mm2: None,
    };
    // The height of a place matters to none of the sources.
    let at_place = |x: f64, y: f64| lfs_mm([x, y, 0.0]).unwrap_or(f64::NAN);
    let of_triangles = || triangles.iter().copied();
    let spacing =
        assess_spacing(points, of_triangles(), target.criteria(), |_, _| target.noise(), at_place);
    let survey = assess(points, of_triangles(), &criteria, at_place);
    let sampling = survey.sampling();
    let StateCounts { good, over_gap, over_epsilon } = sampling.triangles;
    Condition {
        triangles: good + over_gap + over_epsilon,
        area_mm2: sampling.projected_area_mm2,
        overdense_fraction: spacing.overdense_fraction,
        outline_area_mm2: spacing.outline_area_mm2,
        tilt_median_rad: spacing.tilt_median_rad,
        epsilon_max: sampling.epsilon_max.filter(|epsilon| epsilon.is_finite()),
        epsilon_p99: sampling.epsilon_p99.filter(|epsilon| epsilon.is_finite()),
        rho_max: sampling.gap_max_mm.zip(reach_mm).map(|(gap_mm, reach_mm)| gap_mm / reach_mm),
        over_epsilon_area_mm2: sampling.undersampled_area_mm2,
    }
}
