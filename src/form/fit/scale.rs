//! Points in another unit than mm: found by fitting them a thousand times larger and smaller.

use crate::fit::plane::BestPlane;
use crate::fit::solve;
use crate::fit::start::sample;
use crate::{FitSettings, Loss, Nominal, Parameter, PointMm, Units};

/// Whether a nominal that explains next to nothing of the points' height over their best plane explains
/// nearly all of it when they are scaled by 1000 or 1/1000. `rms_mm` is that of the fit as they are, if there
/// is one. A plane looks the same at every scale.
pub(crate) fn suspected(
    points: &[PointMm],
    nominal: &Nominal,
    settings: &FitSettings,
    rms_mm: Option<f64>,
) -> Option<Units> {
    if *nominal == Nominal::Plane {
        return None;
    }
    let sample = sample(points, SAMPLE);
    let relief_mm = BestPlane::of(&sample)?.rms_mm;
    let now = rms_mm.map(|rms_mm| rms_mm / relief_mm);
    if now.is_some_and(|now| now < UNEXPLAINED) || relief_mm == 0.0 {
        return None;
    }
    let free = settings.free.iter().copied().filter(|free| Parameter::POSE.contains(free));
    let settings = FitSettings { free: free.collect(), loss: Loss::Squares, ..settings.clone() };
    let fitted = |factor: f64| {
        let scaled: Vec<PointMm> =
            sample.iter().map(|point| point.map(|coordinate| coordinate * factor)).collect();
        let fit = solve(&scaled, None, nominal, &settings).ok()?;
        let then = fit.residuals.rms_mm / (relief_mm * factor);
        let holds = then < EXPLAINED
            && 2 * fit.used >= sample.len()
            && fit.used >= POINTS_A_PARAMETER * fit.estimates.len().max(1);
        holds.then_some(Units { factor, now, then })
    };
    [1e-3, 1e3].into_iter().find_map(fitted)
}

/// Share of the height over the best plane that a wrong unit leaves at least.
const UNEXPLAINED: f64 = 0.3;
/// Share that the right unit leaves at most.
const EXPLAINED: f64 = 0.03;
/// Points looked at.
const SAMPLE: usize = 512;
/// Fewer points fit by chance.
const POINTS_A_PARAMETER: usize = 4;
