//! Parts with outliers, and the fits that hold them back.

use asphera_form::{FitSettings, Loss, Nominal, PointMm};

use crate::common::{Noise, misaligned, spiral};

/// A part with noise of about the standard deviation 10 nm, and outliers of up to a millimetre on one side
/// for this share of the points.
pub(crate) fn spoilt(nominal: &Nominal, share: f64, seed: u64) -> (Vec<PointMm>, usize) {
    let mut noise = Noise::new(seed);
    let mut outliers = 0;
    let points = spiral(4_000, 8.0)
        .into_iter()
        .map(|[x, y]| {
            // The sum of three uniform numbers is nearly normal, with the variance 1.
            let mut d = 1e-5 * (noise.next() + noise.next() + noise.next());
            if noise.next().abs() < share {
                d += noise.next().abs();
                outliers += 1;
            }
            measured(nominal, [x, y], d)
        })
        .collect();
    (points, outliers)
}

/// A point `d` mm off the nominal over a place, in the measured frame.
pub(crate) fn measured(nominal: &Nominal, [x, y]: [f64; 2], d: f64) -> PointMm {
    let foot = nominal.jet(x, y).unwrap();
    let n_z = (1.0 + foot.gradient[0].powi(2) + foot.gradient[1].powi(2)).sqrt().recip();
    let [p, q] = foot.gradient.map(|slope| slope * n_z * d);
    misaligned().to_measured([x - p, y - q, foot.z_mm + n_z * d])
}

/// The usual fit with a loss.
pub(crate) fn with(loss: Loss) -> FitSettings {
    FitSettings { loss, ..FitSettings::default() }
}
