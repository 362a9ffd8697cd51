//! Slopes at stations: what noise adds to them, and whether they are those of the whole aperture.

use asphera_figures::{Sample, SlopeFigure, Slopes};
use asphera_form::Aperture;

/// Says that slopes are not those of the whole aperture, where more stations have none than its border leaves out. Without an
/// aperture nothing is known of the border.
pub(super) fn missing(found: &Slopes, sample: &Sample) -> Option<String> {
    if *sample.aperture() == Aperture::None {
        return None;
    }
    let all = found.stations + found.unmeasured;
    let length_mm = found.settings.integration_mm();
    let within = (1.0 - 0.5 * length_mm / sample.radius_mm()).clamp(0.0, 1.0).powi(2);
    let is_missing = (found.stations as f64) < LEAST * within * all as f64;
    is_missing.then(|| {
        let length_mm = (length_mm * 1e4).round() / 1e4;
        format!(
            "slopes at {} of {all} stations: too few points lie about them within {length_mm} mm. The slopes given are those at the \
             others. Measure more densely, or form slopes over more",
            found.unmeasured
        )
    })
}

/// Rise of slopes by noise of a point in nm, in the order of their figures, and what is left without it.
pub(super) fn noise_of(found: &Slopes, noise_nm: f64) -> [(Option<f64>, Option<f64>); 4] {
    let of_kind = |figure: &SlopeFigure| {
        let on_max = figure.noise_on_max_urad(noise_nm, found.stations).min(figure.max_urad);
        let without = figure.rms_without_noise_urad(noise_nm);
        [(Some(on_max), None), (Some(figure.rms_urad - without), Some(without))]
    };
    let [[a, b], [c, d]] = [&found.meridional, &found.gradient].map(of_kind);
    [a, b, c, d]
}

/// Share of the stations off the border that must have a slope.
const LEAST: f64 = 0.9;
