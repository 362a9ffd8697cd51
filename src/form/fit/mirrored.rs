//! Points that fit the mirror image of the nominal: heights with the other sign.

use crate::fit::plane::BestPlane;
use crate::fit::solve;
use crate::fit::start::sample;
use crate::{Caution, FitSettings, Loss, Nominal, Parameter, PointMm, Pose};

/// Whether a nominal that explains next to nothing of the points' height over their best plane explains
/// nearly all of it once z is −z. `rms_mm` is that of the fit as they are.
///
/// Where the search may turn the part upside down, it has found such points of most parts already; what is
/// left are parts without a plane of symmetry, and fits whose pose is held.
pub(crate) fn suspected(
    points: &[PointMm],
    nominal: &Nominal,
    settings: &FitSettings,
    rms_mm: f64,
) -> Option<Caution> {
    if *nominal == Nominal::Plane {
        return None;
    }
    let sample = sample(points, SAMPLE);
    let relief_mm = BestPlane::of(&sample).filter(BestPlane::has_relief)?.rms_mm;
    if rms_mm < UNEXPLAINED * relief_mm {
        return None;
    }
    let reflected: Vec<PointMm> = sample.iter().map(|&[x, y, z]| [x, y, -z]).collect();
    let free = settings.free.iter().copied().filter(|free| Parameter::POSE.contains(free));
    // A reflection in z turns the sense of turns about x and y.
    let start = Pose {
        tz_mm: -settings.start.tz_mm,
        rx_rad: -settings.start.rx_rad,
        ry_rad: -settings.start.ry_rad,
        ..settings.start
    };
    let settings =
        FitSettings { free: free.collect(), loss: Loss::Squares, start, ..settings.clone() };
    let fit = solve(&reflected, None, nominal, &settings).ok()?;
    let mirrored_rms_mm = fit.residuals.rms_mm;
    let holds = mirrored_rms_mm < EXPLAINED * relief_mm
        && 2 * fit.used >= sample.len()
        && fit.used >= POINTS_A_PARAMETER * fit.estimates.len().max(1);
    holds.then_some(Caution::Mirrored { rms_mm, mirrored_rms_mm })
}

/// Share of the height over the best plane that the wrong sign leaves at least.
const UNEXPLAINED: f64 = 0.3;
/// Share that the right sign leaves at most.
const EXPLAINED: f64 = 0.03;
/// Points looked at.
const SAMPLE: usize = 512;
/// Fewer points fit by chance.
const POINTS_A_PARAMETER: usize = 4;
