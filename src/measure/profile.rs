//! Profiles: points on a straight line in plan, a kind of measurement of its own.
//!
//! A profile feels shifts along its line and z, the turn about the horizontal across it, and shape; all else stays at its
//! start. What is formed of a surface by area (Zernike terms, A, B, C, texture, defects) is not formed of it: coverage is a
//! share of length, slopes are along the line. A line along x or y is fitted as it lies. An oblique one over a surface of
//! revolution is turned about z first, for that surface looks the same from all sides.

mod along;
mod formed;
mod laid;
mod limits;
mod line;
mod sampled;

use along::{Coverage, Station};
use asphera_figures::{Reference, Sample, Share, peak_to_valley, rms, robust_peak_to_valley};
use asphera_form::Fit;
use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_report::{
    FormFigures, MeshFigures, Points, ProfileFigures, Report, SamplingFigures, Verdict,
};
use asphera_surface::Plane;
use asphera_surface::noise::{HeightSteps, step_sigma_mm};
use formed::{Formed, contributions};
use laid::{in_plane, laid};
use limits::{hold_others, is_of_deviation};
pub(super) use line::Line;
use line::Way;
use sampled::sampled;

use super::assessment::with_counts;
use super::correlated::Sources;
use super::cutting::{FinishedMesh, Setting};
use super::defects;
use super::details::FormDetails;
use super::fitting::{Fitted, NoFit, fitted};
use super::judged::{self, Sure};
use super::judgement::{Plain, judge, plainly, undecide};
use super::measurement::{Measurement, deviation, report};
use super::naming::{self, ProfileSlope};
use super::projection::{Projector, measured};
use super::sampling::{HIDDEN, Remembered, in_steps};
use super::systematic::Systematic;
use super::uncertainties::{self, Assessed, assess};
use super::unmeasured::Unmeasured;
use crate::{Judging, Part};

/// Measured slopes dz/dx along x, where a file has these instead of heights.
#[derive(Debug, Default)]
pub(super) struct Slopes {
    /// By x in mm, ascending.
    by_x: Vec<(f64, f64)>,
}

impl Slopes {
    pub(super) fn extend(&mut self, of: impl IntoIterator<Item = (f64, f64)>) {
        self.by_x.extend(of);
        self.by_x.sort_by(|a, b| a.0.total_cmp(&b.0));
    }

    fn at(&self, x_mm: f64) -> Option<f64> {
        let found = self.by_x.binary_search_by(|(x, _)| x.total_cmp(&x_mm)).ok()?;
        self.by_x.get(found).map(|(_, slope)| *slope)
    }
}

/// Measured data, beside the part: the vertices lie on `line`.
pub(super) struct Taken {
    pub(super) mesh: Mesh,
    pub(super) line: Line,
    pub(super) points: Points,
    pub(super) heights_mm: Option<Vec<f64>>,
    pub(super) slopes: Slopes,
    pub(super) remembered: Remembered,
    /// Errors that all points have together.
    pub(super) systematic: Vec<Systematic>,
}

/// The final figures of a profile.
pub(super) fn measure(taken: Taken, mut part: Part, projector: &Projector) -> Measurement {
    let Taken { mesh, line, mut points, heights_mm, slopes, remembered, systematic } = taken;
    let plane = projector.plane();
    let own = Part { free: in_plane(&part.free, line.way()), ..part.clone() };
    let fitted = fit_along(&line, mesh.points(), &own, &plane, heights_mm.as_deref());
    if let Ok(fitted) = &fitted {
        part.aperture = fitted.aperture.clone();
    }
    let fit = fitted.as_ref().ok().map(|fitted| &fitted.fit);
    let (deviations_mm, found) = match fit {
        Some(fit) => deviation(&mesh, &part, fit),
        None => (vec![f64::NAN; mesh.points().len()], None),
    };
    count(&mut points, fit);
    let stations = stations(mesh.points(), &deviations_mm, &line, fit, &slopes);
    let (mut sampling, coverage) = sampled(&mesh, &part, &line, fit, &stations);
    let mut profile = profile_figures(&stations, &line, fit, &slopes, coverage);
    count_steps(mesh.points(), &line, &stations, &mut profile, &mut sampling);
    let held = part.free.iter().filter(|free| !own.free.contains(free));
    profile.held = held.map(|free| free.name(&part.nominal)).collect();
    let unmeasured = Unmeasured::along_line(
        &part,
        coverage.map(|found| (1.0 - found.covered_mm / found.length_mm).max(0.0)),
        coverage.map(|found| found.gap_covered_mm),
        along::largest_bend_per_mm(&stations),
        found.as_ref().map(|found| (found.pv_nm, found.rms_nm)),
    );
    let own_limits = Judging {
        limits: part.limits().iter().filter(|limit| is_of_deviation(limit)).cloned().collect(),
        ..part.judging.clone()
    };
    let judged = Part { judging: own_limits, ..part.clone() };
    // Effects of a machine and covariances are those of the frame of projection.
    let laid_as_is = fitted.as_ref().ok().filter(|_| !profile.turned);
    let step_nm = sampling.height_step_nm;
    let assessed =
        laid_as_is.and_then(|fitted| assess(&judged, mesh.points(), fitted, &plane, None, step_nm));
    let by_budget = assessed.as_ref().and_then(|assessed| assessed.as_ref().ok());
    let systematic = contributions(
        &systematic,
        (&own, &judged, &plane),
        (&fitted, profile.turned),
        mesh.points(),
        &deviations_mm,
    );
    let mut limits = match &assessed {
        None => plainly(&judged, &Plain::of_heights(found.as_ref())),
        Some(Ok(assessed)) => uncertainties::judged(&judged, assessed, None),
        Some(Err(error)) => Err(uncertainties::unknown(error)),
    };
    systematic.count_limits(&mut limits);
    let form = fitted.as_ref().ok().zip(found.as_ref()).map(|(fitted, found)| {
        let of = Formed {
            parts: [&part, &own, &judged],
            points: mesh.points(),
            deviations_mm: &deviations_mm,
            by_budget,
            systematic: &systematic,
            limits: &limits,
            profile: &profile,
        };
        of.form(fitted, found, &unmeasured, &plane)
    });
    let guard = judged.judging.guard.filter(|_| assessed.is_some());
    let mut compared = judged::verdict(&judged, guard, limits, [&unmeasured; 2]);
    hold_others(&mut compared, (&judged, &part), &stations, &unmeasured);
    if part.judging.guard.is_some() && profile.turned {
        let why = "the guard band needs uncertainties, which are worked out of profiles along x or y only";
        undecide(&mut compared, why.to_owned());
    }
    let seen = with_counts(
        &mesh,
        MeshFigures { projection: projector.figures(), ..MeshFigures::default() },
    );
    let mut verdict = judge(compared, &part, &mesh, fitted.as_ref(), &seen, &sampling);
    verdict.reasons.push(BESIDE.to_owned());
    finished(
        mesh,
        part,
        projector,
        Parts { points, fitted, deviations_mm, form, sampling, seen, verdict, profile, remembered },
    )
}

/// The fit of a part to points on a line, with the freedoms that a line feels.
pub(super) fn fit_along(
    line: &Line,
    points: &[PointMm],
    part: &Part,
    plane: &Plane,
    heights_mm: Option<&[f64]>,
) -> Result<Fitted, NoFit> {
    let own = Part { free: in_plane(&part.free, line.way()), ..part.clone() };
    laid(points, &own, line, |points, part| fitted(points, part, plane, heights_mm))
}

/// Counts the points that the fit used, and those it did not, by reason.
fn count(points: &mut Points, fit: Option<&Fit>) {
    let Some(fit) = fit else { return };
    points.used = fit.used as u64;
    let excluded = [
        ("outside_aperture", fit.excluded.outside_aperture),
        ("outside_domain", fit.excluded.outside_domain),
    ];
    for (reason, count) in excluded.into_iter().filter(|(_, count)| *count > 0) {
        *points.flagged.entry(reason.to_owned()).or_default() += count as u64;
    }
}

struct Parts {
    points: Points,
    fitted: Result<Fitted, NoFit>,
    deviations_mm: Vec<f64>,
    form: Option<FormFigures>,
    sampling: SamplingFigures,
    seen: MeshFigures,
    verdict: Verdict,
    profile: ProfileFigures,
    remembered: Remembered,
}

fn finished(mesh: Mesh, part: Part, projector: &Projector, of: Parts) -> Measurement {
    let Parts { points, fitted, deviations_mm, form, sampling, seen, verdict, profile, remembered } =
        of;
    let plane = projector.plane();
    let features = defects::not_looked_for("the points lie on a line");
    let points_mm = measured(&mesh, &plane).into_owned();
    let setting = Setting {
        part,
        plane,
        lies: fitted.ok().map(|fitted| (fitted.fit.nominal, fitted.fit.pose)),
        gap_limit_mm: sampling.gap_limit_mm,
        areas_mm2: vec![0.0; points_mm.len()].into(),
        grid: None,
        maps_version: 0,
        remembered,
        in_space: None,
    };
    Measurement {
        report: Report {
            profile: Some(profile),
            ..report(points, seen, sampling, features, form, verdict)
        },
        surface: FinishedMesh::new(mesh, setting),
        points_mm,
        triangles: Vec::new(),
        deviations_nm: deviations_mm.iter().map(|mm| mm * 1e6).collect(),
        map: None,
        cells: None,
        next: None,
    }
}

/// The points in order along the line.
fn stations(
    points: &[PointMm],
    deviations_mm: &[f64],
    line: &Line,
    fit: Option<&Fit>,
    slopes: &Slopes,
) -> Vec<Station> {
    let nominal_slope = |point: &PointMm| -> Option<f64> {
        let fit = fit?;
        let foot = fit.nominal.foot(fit.pose.to_part(*point))?;
        let turn = fit.pose.rotation();
        let normal = |axis: usize| (0..3).map(|i| turn[axis][i] * foot.normal[i]).sum::<f64>();
        Some(-normal(0) / normal(2))
    };
    let mut stations: Vec<Station> = points
        .iter()
        .zip(deviations_mm)
        .map(|(point, &deviation_mm)| Station {
            s_mm: line.along_mm([point[0], point[1]]),
            deviation_mm,
            slope: slopes.at(point[0]).and_then(|slope| Some(slope - nominal_slope(point)?)),
        })
        .collect();
    stations.sort_by(|a, b| a.s_mm.total_cmp(&b.s_mm));
    stations
}

fn profile_figures(
    stations: &[Station],
    line: &Line,
    fit: Option<&Fit>,
    slopes: &Slopes,
    coverage: Option<Coverage>,
) -> ProfileFigures {
    let of_slopes = !slopes.by_x.is_empty();
    let formed = along::slopes(stations);
    let summed = fit.and_then(|_| along::summed(&formed));
    let urad = |of: &dyn Fn([f64; 3]) -> f64| summed.map(|found| 1e6 * of(found));
    let noise_mm = fit.filter(|_| !of_slopes).and_then(|_| along::noise_mm(stations));
    let slope_of_noise = noise_mm.and_then(|noise_mm| along::slope_of_noise(stations, noise_mm));
    let [x, y] = line.direction;
    ProfileFigures {
        source: if of_slopes { "slopes, integrated by the trapezoidal rule" } else { "heights" }
            .to_owned(),
        // Plus zero makes a negative zero positive.
        direction_deg: (y + 0.0).atan2(x).to_degrees(),
        turned: line.way() == Way::Oblique,
        held: Vec::new(),
        length_mm: coverage.map(|found| found.length_mm),
        covered_mm: coverage.map(|found| found.covered_mm),
        slope_rms_urad: urad(&|[_, rms, _]| rms),
        slope_rms_about_mean_urad: urad(&|[mean, rms, _]| {
            (rms * rms - mean * mean).max(0.0).sqrt()
        }),
        slope_max_urad: urad(&|[.., most]| most),
        noise_sigma_nm: noise_mm.map(|mm| 1e6 * mm),
        slope_noise_urad: slope_of_noise.map(|slope| 1e6 * slope),
        slope_rule: match stations.iter().all(|station| station.slope.is_some()) {
            true => "measured slopes less those of the fitted nominal, every point counted alike"
                .to_owned(),
            false => "differences of neighbouring deviations over their distance, counted by that"
                .to_owned(),
        },
    }
}

/// Takes the noise of heights that come in steps for that of their rounding, and says what they hide.
fn count_steps(
    points: &[PointMm],
    line: &Line,
    stations: &[Station],
    profile: &mut ProfileFigures,
    sampling: &mut SamplingFigures,
) {
    if profile.noise_sigma_nm.is_none() {
        return;
    }
    match along::steps(points, |point| line.along_mm([point[0], point[1]])) {
        HeightSteps::Fine => {}
        HeightSteps::Of { step_mm } => {
            let noise_nm = profile.noise_sigma_nm.unwrap_or(0.0).max(1e6 * step_sigma_mm(step_mm));
            let slope = along::slope_of_noise(stations, 1e-6 * noise_nm);
            profile.noise_sigma_nm = Some(noise_nm);
            profile.slope_noise_urad = slope.map(|slope| 1e6 * slope);
            sampling.height_step_nm = Some(1e6 * step_mm);
            sampling.unknown.push(in_steps(step_mm));
        }
        HeightSteps::Hidden => {
            (profile.noise_sigma_nm, profile.slope_noise_urad) = (None, None);
            sampling.unknown.push(format!("the noise is not known: {HIDDEN}"));
        }
    }
}

/// The figures that a profile has.
fn details(sample: Option<&Sample>, profile: &ProfileFigures, sure: &Sure) -> FormDetails {
    let mut details = FormDetails::default();
    let variant = "as fitted, every point counted alike";
    if let Some(sample) = sample {
        details.take("PV", peak_to_valley(sample), variant, sure);
        details.take("RMS", rms(sample, Reference::Zero), variant, sure);
        details.take("RMS", rms(sample, Reference::Mean), variant, sure);
        details.take("PV99%", robust_peak_to_valley(sample, Share::NINETY_NINE), variant, sure);
    }
    for (kind, value) in [
        (ProfileSlope::Rms, profile.slope_rms_urad),
        (ProfileSlope::RmsAboutMean, profile.slope_rms_about_mean_urad),
        (ProfileSlope::Max, profile.slope_max_urad),
    ] {
        let named = |value| naming::profile_slope(kind, value, &profile.slope_rule);
        details.figures.extend(value.map(named));
    }
    details.unknown.push(WHY.to_owned());
    details
}

/// What the fit says of its uncertainties, and why more is not known; of a profile that was turned little is.
fn sources(
    part: &Part,
    fitted: &Fitted,
    measured: (&[PointMm], &[f64]),
    assessed: Option<&Assessed>,
    turned: bool,
) -> (Sources, Option<&'static str>) {
    if turned {
        let why = "uncertainties: worked out of profiles along x or y only";
        return (Sources::by_residuals(fitted), Some(why));
    }
    let why = "uncertainties of PV and RMS: the noise of a profile is not measured; state noise_nm in the table uncertainty";
    let lacks = assessed.is_none().then_some(why);
    (Sources::new(part, fitted, measured, assessed), lacks)
}

/// Caution to the verdict.
const BESIDE: &str = "judged as a profile, for all points lie on a straight line: nothing is known of the surface beside it";
const WHY: &str =
    "the points lie on a straight line: they are a profile, of which nothing is formed by area";

#[cfg(test)]
mod tests;
