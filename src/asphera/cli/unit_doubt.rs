//! Whether points that were taken to be in mm for want of a unit are more likely in another one.

use asphera_form::{Aperture, FitSettings, PointMm, Units, suspected_units};
use asphera_formats::Topography;
use asphera_formats::xyz::By;

use asphera_measure::Part;
use asphera_measure::{Measurement, doubt};

/// What is asked of points whose unit is an assumption.
pub(super) struct UnitCheck {
    part: Part,
}

impl UnitCheck {
    /// For the points of a file that states no unit; `None` for others, and for surfaces without a design.
    pub(super) fn of(topography: &Topography, part: &Part) -> Option<UnitCheck> {
        let is_assumed =
            topography.source().taken.as_ref().is_some_and(|taken| taken.units_by == By::Default);
        (is_assumed && part.reference.is_none()).then(|| UnitCheck { part: part.clone() })
    }

    /// Takes the verdict back where another unit fits the nominal and mm does not, and names the cure.
    pub(super) fn add(&self, points_mm: &[PointMm], measurement: &mut Measurement) {
        let rms_mm = measurement.report.form.as_ref().map(|form| form.deviation.rms_nm * 1e-6);
        let Part { nominal, aperture, free, .. } = &self.part;
        let settings = FitSettings {
            free: free.clone(),
            aperture: aperture.clone(),
            ..FitSettings::default()
        };
        let reason = by_size(points_mm, aperture).or_else(|| {
            suspected_units(points_mm, nominal, &settings, rms_mm).map(|found| by_form(&found))
        });
        if let Some(reason) = reason {
            doubt(&mut measurement.report.verdict, reason);
        }
    }
}

/// What the fit in another unit says.
fn by_form(units: &Units) -> String {
    let (unit, option) = named(units.factor);
    let words = scaling(units.factor);
    match units.heights_only {
        true => format!(
            "The heights seem to be in {unit}, not mm. {words} they fit the nominal. Add `--unit mm,mm,{option}`."
        ),
        false => format!(
            "The points seem to be in {unit}, not mm. {words} they fit the nominal. Add `--unit {option}`."
        ),
    }
}

/// Points far wider or narrower than the aperture, which another unit fits.
fn by_size(points_mm: &[PointMm], aperture: &Aperture) -> Option<String> {
    let [half_x_mm, half_y_mm] = aperture.half_extents_mm()?;
    let aperture_mm = 2.0 * half_x_mm.max(half_y_mm);
    let extent = |axis: usize| {
        let along = || points_mm.iter().map(|point| point[axis]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    let share = extent(0).max(extent(1)) / aperture_mm;
    if !share.is_finite() || (SMALLEST..=LARGEST).contains(&share) {
        return None;
    }
    let factor =
        [1e-3, 1e3, 1e-6].into_iter().find(|factor| FITTING.contains(&(share * factor)))?;
    let (unit, option) = named(factor);
    let share = if share > 1.0 { format!("{share:.0}") } else { format!("{share:.1e}") };
    Some(format!(
        "The points seem to be in {unit}, not mm: they are {share} times as wide as the aperture. {} they fit it. Add \
         `--unit {option}`.",
        scaling(factor)
    ))
}

fn named(factor: f64) -> (&'static str, &'static str) {
    match factor {
        factor if factor > 1.0 => ("m", "m"),
        factor if factor < 1e-4 => ("nm", "nm"),
        _ => ("µm", "um"),
    }
}

fn scaling(factor: f64) -> String {
    match factor {
        factor if factor > 1.0 => format!("Multiplied by {factor:.0}"),
        factor => format!("Divided by {:.0}", 1.0 / factor),
    }
}

/// Points this much narrower or wider than the aperture are in doubt.
const SMALLEST: f64 = 0.02;
const LARGEST: f64 = 20.0;
/// Points that fit the aperture.
const FITTING: std::ops::RangeInclusive<f64> = 0.2..=2.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_far_wider_than_the_aperture_are_in_another_unit() {
        let points: Vec<PointMm> = (0..=20).map(|i| [f64::from(i) * 1e3, 0.0, 0.0]).collect();
        let circle = |radius_mm| Aperture::Circle { radius_mm };
        let said = by_size(&points, &circle(10.0)).unwrap();
        assert!(said.contains("in µm, not mm") && said.contains("Add `--unit um`."), "{said}");
        assert!(by_size(&points, &circle(1e4)).is_none());
        assert!(by_size(&points, &circle(9.5e6)).unwrap().contains("Add `--unit m`."));
        assert!(by_size(&points, &Aperture::None).is_none());
    }
}
