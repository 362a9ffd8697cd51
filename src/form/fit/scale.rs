//! Points in another unit than mm: found by fitting them, or their heights alone, a thousand times larger and smaller.

use crate::fit::plane::BestPlane;
use crate::fit::solve;
use crate::fit::start::sample;
use crate::{FitSettings, Loss, Nominal, Parameter, PointMm, Units};

/// Whether a nominal that explains next to nothing of the points' height over their best plane explains
/// nearly all of it when they are scaled by 1000 or 1/1000, or their heights alone by 1/1000, 1e-6 or 1000. `rms_mm` is that of the
/// fit as they are, if there is one. A plane looks the same at every scale.
pub fn suspected(
    points: &[PointMm],
    nominal: &Nominal,
    settings: &FitSettings,
    rms_mm: Option<f64>,
) -> Option<Units> {
    if *nominal == Nominal::Plane {
        return None;
    }
    let sample = sample(points, SAMPLE);
    let plane = BestPlane::of(&sample).filter(BestPlane::has_relief)?;
    let now = rms_mm.map(|rms_mm| rms_mm / plane.rms_mm);
    if now.is_some_and(|now| now < UNEXPLAINED) {
        return None;
    }
    let free = settings.free.iter().copied().filter(|free| Parameter::POSE.contains(free));
    let settings = FitSettings { free: free.collect(), loss: Loss::Squares, ..settings.clone() };
    let fitted = |(factor, heights_only): (f64, bool)| {
        let across = if heights_only { 1.0 } else { factor };
        let scaled: Vec<PointMm> =
            sample.iter().map(|[x, y, z]| [x * across, y * across, z * factor]).collect();
        let relief_mm = BestPlane::of(&scaled).filter(BestPlane::has_relief)?.rms_mm;
        let fit = solve(&scaled, None, nominal, &settings).ok()?;
        let then = fit.residuals.rms_mm / relief_mm;
        let holds = then < EXPLAINED
            && 2 * fit.used >= sample.len()
            && fit.used >= POINTS_A_PARAMETER * fit.estimates.len().max(1);
        holds.then_some(Units { factor, heights_only, now, then })
    };
    SCALES.into_iter().find_map(fitted)
}

/// What coordinates may have to be multiplied by, and whether only the heights. Profilers write places in mm and heights in µm or nm.
const SCALES: [(f64, bool); 5] =
    [(1e-3, false), (1e3, false), (1e-3, true), (1e-6, true), (1e3, true)];
/// Share of the height over the best plane that a wrong unit leaves at least.
const UNEXPLAINED: f64 = 0.3;
/// Share that the right unit leaves at most.
const EXPLAINED: f64 = 0.03;
/// Points looked at.
const SAMPLE: usize = 512;
/// Fewer points fit by chance.
const POINTS_A_PARAMETER: usize = 4;
