//! The profile across a scratch, folded along its length.

use super::measure::Axes;

/// What the profile tells.
pub(super) struct Profile {
    pub(super) depth_mm: f64,
    pub(super) uncertainty_mm: f64,
    /// Full width at half of the depth.
    pub(super) width_mm: f64,
}

/// Fewest samples of a bin.
const SAMPLES_MIN: usize = 8;
/// Share of the length that is left out at either end.
const END: f64 = 0.06;

/// Folds samples (place, depth) along a parabola through the core (place, weight); `None` where they
/// are too few.
///
/// Bins are half a spacing wide. The depth is that of the deepest bin: of a scratch whose depth
/// changes along it, the mean.
pub(super) fn across(
    samples: impl Iterator<Item = ([f64; 2], f64)>,
    core: &[([f64; 2], f64)],
    axes: &Axes,
    spacing_mm: f64,
    sigma_mm: f64,
) -> Option<Profile> {
    let total: f64 = core.iter().map(|(_, weight)| weight).sum();
    let origin = [0, 1].map(|axis| {
        core.iter().map(|(place, weight)| weight * (place[axis] - core[0].0[axis])).sum::<f64>()
            / total
            + core[0].0[axis]
    });
    let half_mm = 0.5 * axes.length_mm;
    let local = |place: [f64; 2]| {
        let [t, d] = super::line::local_mm(origin, axes.direction, place);
        [t / half_mm, d]
    };
    // A parabola by least squares.
    let mut matrix = nalgebra::Matrix3::zeros();
    let mut right = nalgebra::Vector3::zeros();
    for (place, weight) in core {
        let [t, d] = local(*place);
        let terms = nalgebra::Vector3::new(1.0, t, t * t);
        matrix += *weight * terms * terms.transpose();
        right += *weight * d * terms;
    }
    let middle = matrix.cholesky()?.solve(&right);
    let bin_mm = 0.5 * spacing_mm;
    let bins = (2.0 * axes.width_mm / bin_mm).ceil() as usize + 8;
    let mut sums = vec![(0.0, 0_usize); 2 * bins + 1];
    for (place, depth) in samples {
        let [t, d] = local(place);
        let across = d - (middle[0] + t * (middle[1] + t * middle[2]));
        let bin = (across / bin_mm).round() + bins as f64;
        if t.abs() <= 1.0 - 2.0 * END
            && depth.is_finite()
            && (0.0..sums.len() as f64).contains(&bin)
        {
            sums[bin as usize].0 += depth;
            sums[bin as usize].1 += 1;
        }
    }
    let profile: Vec<Option<f64>> = sums
        .iter()
        .map(|&(sum, count)| (count >= SAMPLES_MIN).then(|| sum / count as f64))
        .collect();
    let deepest = (0..profile.len())
        .filter(|&bin| profile[bin].is_some())
        .reduce(|best, bin| if profile[bin] > profile[best] { bin } else { best })?;
    let depth_mm = profile[deepest]?;
    // How far it is to half of the depth, along the bins that are known.
    let side = |bins: &mut dyn Iterator<Item = usize>| {
        let mut last = (deepest, depth_mm);
        for bin in bins {
            let Some(value) = profile[bin] else { continue };
            if value <= 0.5 * depth_mm {
                let share = (last.1 - 0.5 * depth_mm) / (last.1 - value);
                let at = last.0 as f64 + share * (bin as f64 - last.0 as f64);
                return Some((at - deepest as f64).abs());
            }
            last = (bin, value);
        }
        None
    };
    let left = side(&mut (0..deepest).rev())?;
    let right = side(&mut (deepest + 1..profile.len()))?;
    Some(Profile {
        depth_mm,
        uncertainty_mm: sigma_mm / (sums[deepest].1 as f64).sqrt(),
        width_mm: bin_mm * (left + right),
    })
}
