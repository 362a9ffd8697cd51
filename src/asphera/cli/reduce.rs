//! `asphera reduce`: a dense cloud to the points that are enough.

mod figures;
mod file;

use std::path::PathBuf;
use std::str::FromStr;

use asphera_form::{FitSettings, Nominal, Pose, fit};
use asphera_surface::curvature::Adjacency;
use asphera_surface::noise::{
    Along, Noise as Deviation, NoiseEstimate, NoiseSettings, assess_spacing, estimate_noise,
};
use asphera_surface::reduce::{Averaged, Keep, Target, average, curvature_bound, reduce, spread};
use asphera_surface::{Criteria, Mesh, PointMm, StateCounts, VertexId, assess};
use clap::{ArgGroup, Args, ValueEnum};

use super::exit::Exit;
use super::files::{part, refuse, say_reading, topography};
use super::output::{Failure, print, print_json};
use super::text::TextArgs;
use crate::config::Part;
use figures::{Condition, Figures, Input, Lfs, Noise, Range, Spacings, Sparse};

#[derive(Args)]
#[command(group(ArgGroup::new("limit").args(["epsilon", "rho"]).required(true).multiple(true)))]
pub(super) struct ReduceArgs {
    /// The points: .xyz or other text, X3P, Zygo MetroPro .dat, SDF or Zemax grid sag.
    file: PathBuf,
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
    /// The nominal, for the local feature size; without it that follows from the curvature of the points.
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

impl From<KeepWanted> for Keep {
    fn from(wanted: KeepWanted) -> Keep {
        match wanted {
            KeepWanted::Fewest => Keep::Fewest,
            KeepWanted::Truest => Keep::Truest,
            KeepWanted::Most => Keep::Most,
        }
    }
}

/// Where the noise comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum NoiseWanted {
    Auto,
    SigmaNm(f64),
}

impl FromStr for NoiseWanted {
    type Err = String;

    fn from_str(word: &str) -> Result<NoiseWanted, String> {
        if word == "auto" {
            return Ok(NoiseWanted::Auto);
        }
        match word.parse::<f64>() {
            Ok(sigma_nm) if (0.0..=MAX_SIGMA_NM).contains(&sigma_nm) => {
                Ok(NoiseWanted::SigmaNm(sigma_nm))
            }
            _ => Err(format!("expected a number from 0 to 1e9 in nm or `auto`, found `{word}`")),
        }
    }
}

pub(super) fn run(args: &ReduceArgs) -> Result<Exit, Failure> {
    // What can be wrong without the points is told before they are read.
    let limits = Limits::new(args.epsilon, args.rho)?;
    let target = |lfs_max_mm: f64| -> Result<Target, Failure> {
        let target = Target::new(limits.share, lfs_max_mm)?.keeping(args.keep.into());
        Ok(match args.tilt {
            Some(tilt_rad) => target.with_tilt_limit(tilt_rad)?,
            None => target,
        })
    };
    target(1.0)?;
    let style = file::Style::of(&args.out)?;
    refuse(&args.out, &args.file, args.force)?;
    let part = args.nominal.as_deref().map(part).transpose()?;
    let name = args.file.display().to_string();
    let topography = topography(&args.file, &args.text)?;
    say_reading(&topography);

    let mut mesh = Mesh::new();
    mesh.extend(topography.points());
    mesh.flush();
    let counts = mesh.counts();
    if counts.triangles == 0 {
        return Err(format!(
            "{name}: expected points that span an area, found {} places on no more than a line",
            counts.vertices
        )
        .into());
    }
    let points = mesh.points();
    let triangles = mesh.triangles();
    let (deviation, noise) = noise(points, &triangles, args.noise, &name)?;
    let sigma_mm = deviation.sigma_mm();
    let (lfs, lfs_source) = feature_size(points, part.as_ref(), sigma_mm, &name)?;
    // Where nothing bends, points a fifth of the width apart still stay.
    let lfs_max_mm = 0.2 * width_mm(points) / limits.share;
    let target = target(lfs_max_mm)?.with_noise(deviation)?;
    let known_mm = |at: PointMm| target.lfs_mm(lfs(at));
    let range_mm = Range::of(points.iter().filter_map(|&point| known_mm(point)));
    let reach_mm = range_mm.map(|range| range.min_mm);
    let limiting_mm = |at: PointMm| limits.limiting_mm(known_mm(at), reach_mm);
    let reduction = reduce(points, triangles.iter().copied(), &target, limiting_mm);
    let kept: Vec<PointMm> = reduction.kept.iter().map(|&index| points[index as usize]).collect();
    let averaged = args.average.then(|| average(points, &kept, sigma_mm, known_mm));
    let mut reduced = Mesh::new();
    reduced.insert(&kept);
    let figures = Figures {
        format: figures::FORMAT,
        source: name,
        input: Input {
            points: counts.pushed,
            vertices: counts.vertices,
            missing: topography.missing() as u64,
            duplicates: counts.duplicates,
            conflicts: counts.conflicts,
            not_meshable: counts.rejected,
        },
        epsilon: args.epsilon,
        rho: args.rho,
        tilt_limit_rad: target.criteria().tilt_limit_rad(),
        keep: args
            .keep
            .to_possible_value()
            .map_or_else(String::new, |value| value.get_name().to_owned()),
        lfs: Lfs { source: lfs_source, range_mm },
        noise,
        kept: reduction.tally.kept(),
        dropped: reduction.tally.dropped(),
        mended: reduction.mended,
        by: reduction.tally.into(),
        sparse: Sparse {
            triangles: reduction.sparse_triangles,
            area_mm2: reduction.sparse_area_mm2,
        },
        spacing: spread(&kept).map(Spacings::from),
        averaged: averaged.as_ref().map(|found| found.averaged),
        before: condition(&mesh, &target, &limits, reach_mm, known_mm),
        after: condition(&reduced, &target, &limits, reach_mm, known_mm),
        output: args.out.display().to_string(),
    };
    let columns = columns(&kept, averaged.as_ref());
    file::write(&args.out, style, &figures.remarks(), &columns)?;
    if args.json {
        print_json(&figures)?;
    } else {
        print(&figures.to_string());
    }
    Ok(Exit::Done)
}

/// How near to a kept point every place of the surface is to be.
struct Limits {
    /// As a share of the local feature size there.
    epsilon: Option<f64>,
    /// As a share of the reach.
    rho: Option<f64>,
    /// The smaller of both.
    share: f64,
}

impl Limits {
    /// One of both has to be given. Fails where one is no share.
    fn new(epsilon: Option<f64>, rho: Option<f64>) -> Result<Limits, Failure> {
        for (name, value) in [("epsilon", epsilon), ("rho", rho)] {
            if let Some(value) = value.filter(|value| !(*value > 0.0 && *value <= 1.0)) {
                let found = format!("{name} is {value}, expected a number above 0 and up to 1");
                return Err(found.into());
            }
        }
        let share = epsilon.unwrap_or(f64::INFINITY).min(rho.unwrap_or(f64::INFINITY));
        Ok(Limits { epsilon, rho, share })
    }

    /// The local feature size in mm a share of which is the smaller of both limits, at a place where it is `lfs_mm`. It
    /// changes by no more than the way gone, as that does: what ρ asks for is the same everywhere, and where that
    /// is the smaller share, it is the smaller limit everywhere.
    fn limiting_mm(&self, lfs_mm: Option<f64>, reach_mm: Option<f64>) -> Option<f64> {
        let by_rho_mm = match self.rho {
            Some(rho) => rho / self.share * reach_mm?,
            None => f64::INFINITY,
        };
        match self.epsilon {
            Some(epsilon) => Some(by_rho_mm.min(epsilon / self.share * lfs_mm?)),
            None => Some(by_rho_mm),
        }
    }
}

/// The numbers of each line: a point, with its uncertainty if it was averaged.
fn columns(kept: &[PointMm], averaged: Option<&Averaged>) -> file::Columns {
    match averaged {
        None => file::Columns::Points(kept.to_vec()),
        Some(averaged) => {
            let with_u = |point: &asphera_surface::reduce::AveragedPoint| {
                let [x, y, z] = point.point_mm;
                [x, y, z, point.u_mm]
            };
            file::Columns::WithUncertainty(averaged.points.iter().map(with_u).collect())
        }
    }
}

/// The noise asked for, and how it is told.
fn noise(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    wanted: NoiseWanted,
    name: &str,
) -> Result<(Deviation, Noise), Failure> {
    match wanted {
        NoiseWanted::SigmaNm(sigma_nm) => {
            let deviation = Deviation::new(sigma_nm * 1e-6, Along::Z)?;
            let told = Noise {
                sigma_nm,
                source: "given",
                uncertainty_nm: None,
                residuals: None,
                outlier_share: None,
            };
            Ok((deviation, told))
        }
        NoiseWanted::Auto => {
            let reach_mm = REACH * typical_spacing_mm(points, triangles);
            let adjacency = Adjacency::new(points, triangles, Some(reach_mm))?;
            let found = estimate_noise(points, &adjacency, &NoiseSettings::default());
            let found = found.map_err(|unknown| {
                format!("{name}: the noise cannot be taken from the points: {unknown}; give it with --noise")
            })?;
            let NoiseEstimate {
                noise: deviation, uncertainty_mm, residuals, outlier_share, ..
            } = found;
            let told = Noise {
                sigma_nm: deviation.sigma_mm() * 1e6,
                source: "points",
                uncertainty_nm: Some(uncertainty_mm * 1e6),
                residuals: Some(residuals),
                outlier_share: Some(outlier_share),
            };
            Ok((deviation, told))
        }
    }
}

/// The median spacing of the places of a mesh in mm: a wrong height has no part in it, and few
/// triangles that bridge gaps little.
fn typical_spacing_mm(points: &[PointMm], triangles: &[[VertexId; 3]]) -> f64 {
    let mut spacings_mm: Vec<f64> = triangles
        .iter()
        .map(|corners| {
            let [a, b, c] = corners.map(|corner| points[corner as usize]);
            let twice_mm2 = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            twice_mm2.abs().sqrt()
        })
        .collect();
    let middle = spacings_mm.len() / 2;
    *spacings_mm.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Local feature size at a point of the measured frame, in mm.
type FeatureSize = Box<dyn Fn(PointMm) -> Option<f64>>;

/// An upper bound of the local feature size, and where it comes from: the nominal's smallest radius of
/// curvature at each place, or that of the points anywhere.
fn feature_size(
    points: &[PointMm],
    part: Option<&Part>,
    sigma_mm: f64,
    name: &str,
) -> Result<(FeatureSize, &'static str), Failure> {
    let Some(part) = part else {
        let bound = curvature_bound(points, sigma_mm).ok_or_else(|| {
            format!(
                "{name}: expected at least 30 points on an eighth of the extent to take the curvature from, found \
                 fewer; give the surface with --nominal"
            )
        })?;
        return Ok((Box::new(move |_| Some(bound.radius_mm)), "curvature of the points"));
    };
    if part.reference.is_some() {
        return Err("the nominal says that the surface is unknown, and so tells no curvature; leave --nominal out, and it \
                    is taken from the points"
            .into());
    }
    let pose = pose(points, part)
        .map_err(|error| format!("{name}: the nominal cannot be laid into the points: {error}"))?;
    let nominal: Nominal = part.nominal.clone();
    let lfs_mm = move |point: PointMm| {
        let [x, y, _] = pose.to_part(point);
        nominal.lfs_bound_at_mm(x, y)
    };
    Ok((Box::new(lfs_mm), "curvature of the nominal"))
}

/// Where the part lies. A thinned choice of points tells that well enough: sizes change little over a shift.
fn pose(points: &[PointMm], part: &Part) -> Result<Pose, String> {
    let settings =
        FitSettings { free: part.free.clone(), aperture: part.aperture, ..FitSettings::default() };
    let step = points.len().div_ceil(FITTED_POINTS);
    let chosen: Vec<PointMm> = points.iter().copied().step_by(step).collect();
    match fit(&chosen, &part.nominal, &settings) {
        Ok(fit) => Ok(fit.pose),
        Err(error) => Err(crate::error_chain(&error)),
    }
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

/// Points the nominal is laid into.
const FITTED_POINTS: usize = 100_000;
/// How many spacings apart neighbours are at most when the noise is taken from them: lines of a scan
/// may lie farther apart than the points along them, while what bridges a gap is longer.
const REACH: f64 = 8.0;
/// A metre.
const MAX_SIGMA_NM: f64 = 1e9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smaller_limit_is_a_share_of_what_limits() {
        let limiting = |epsilon, rho, lfs_mm| {
            let limits = Limits::new(epsilon, rho).unwrap();
            limits.limiting_mm(lfs_mm, Some(8.0)).map(|mm| limits.share * mm)
        };
        for (lfs_mm, gap_mm) in [(8.0, 1.0), (9.0, 1.125), (16.0, 2.0), (20.0, 2.0)] {
            // 0.125 of the local feature size, 2 mm.
            assert_eq!(limiting(Some(0.125), Some(0.25), Some(lfs_mm)), Some(gap_mm), "{lfs_mm}");
            assert_eq!(limiting(Some(0.5), Some(0.125), Some(lfs_mm)), Some(1.0), "{lfs_mm}");
            assert_eq!(limiting(None, Some(0.125), Some(lfs_mm)), Some(1.0), "{lfs_mm}");
            assert_eq!(limiting(Some(0.125), None, Some(lfs_mm)), Some(0.125 * lfs_mm));
        }
        assert_eq!(limiting(None, Some(0.125), None), Some(1.0));
        assert_eq!(limiting(Some(0.1), Some(0.1), None), None);
        assert_eq!(Limits::new(None, Some(0.1)).unwrap().limiting_mm(Some(9.0), None), None);
    }

    #[test]
    fn shares_are_above_0_and_up_to_1() {
        for value in [0.0, -0.1, 2.0, f64::NAN, f64::INFINITY] {
            for (epsilon, rho, name) in [
                (Some(value), None, "epsilon"),
                (Some(0.1), Some(value), "rho"),
                (None, Some(value), "rho"),
            ] {
                let Err(found) = Limits::new(epsilon, rho) else { panic!("{value}") };
                let found = found.to_string();
                assert!(found.starts_with(name) && found.contains("up to 1"), "{found}");
            }
        }
    }

    #[test]
    fn noise_is_a_length_or_auto() {
        assert_eq!("auto".parse(), Ok(NoiseWanted::Auto));
        assert_eq!("12.5".parse(), Ok(NoiseWanted::SigmaNm(12.5)));
        assert_eq!("0".parse(), Ok(NoiseWanted::SigmaNm(0.0)));
        for word in ["-1", "NaN", "inf", "1e10", "some", ""] {
            assert!(word.parse::<NoiseWanted>().is_err(), "{word}");
        }
    }
}
