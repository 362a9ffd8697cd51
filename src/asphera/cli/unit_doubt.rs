//! Whether points that were taken to be in mm for want of a unit are more likely in another one.

use asphera_form::{Aperture, FitSettings, PointMm, Units, suspected_units};
use asphera_formats::Topography;
use asphera_formats::xyz::{By, Taken, Unit};

use asphera_measure::Part;
use asphera_measure::{Measurement, doubt};

/// What is asked of points whose unit is an assumption, or a word of the command line.
pub(super) struct UnitCheck {
    part: Part,
    read: ReadAs,
}

/// The units that points were read in.
#[derive(Clone, Copy)]
enum ReadAs {
    /// In mm, for want of a unit.
    Assumed,
    /// In what `--unit` says.
    Given {
        /// Of all columns, if they have one unit.
        all: Option<Unit>,
        /// Of the heights.
        heights: Unit,
    },
}

impl UnitCheck {
    /// For the points of a file whose unit is assumed or given by an option; `None` for others, and for surfaces without a design.
    pub(super) fn of(topography: &Topography, part: &Part) -> Option<UnitCheck> {
        let taken = topography.source().taken.as_ref()?;
        let read = ReadAs::of(taken)?;
        part.reference.is_none().then(|| UnitCheck { part: part.clone(), read })
    }

    /// Takes the verdict back where another unit fits the nominal and that of the points does not, and names the cure.
    pub(super) fn add(&self, points_mm: &[PointMm], measurement: &mut Measurement) {
        let rms_mm = measurement.report.form.as_ref().map(|form| form.deviation.rms_nm * 1e-6);
        let Part { nominal, aperture, free, .. } = &self.part;
        let settings = FitSettings {
            free: free.clone(),
            aperture: aperture.clone(),
            ..FitSettings::default()
        };
        let reason = by_size(points_mm, aperture, self.read).or_else(|| {
            suspected_units(points_mm, nominal, &settings, rms_mm)
                .map(|found| by_form(&found, self.read))
        });
        if let Some(reason) = reason {
            doubt(&mut measurement.report.verdict, reason);
        }
    }
}

impl ReadAs {
    fn of(taken: &Taken) -> Option<ReadAs> {
        let lengths = || taken.columns.iter().filter(|column| !column.unit.is_slope());
        match taken.units_by {
            By::Default => Some(ReadAs::Assumed),
            By::Head => None,
            By::Options => {
                let heights = lengths().find(|column| column.name == "z")?.unit;
                let is_one = lengths().all(|column| column.unit == heights);
                Some(ReadAs::Given { all: is_one.then_some(heights), heights })
            }
        }
    }
}

/// What the fit in another unit says.
fn by_form(units: &Units, read: ReadAs) -> String {
    let words = scaling(units.factor);
    let (what, given) = match (units.heights_only, read) {
        (true, ReadAs::Assumed) => ("heights", None),
        (false, ReadAs::Assumed) => ("points", None),
        (true, ReadAs::Given { heights, .. }) => ("heights", Some(Some(heights))),
        (false, ReadAs::Given { all, .. }) => ("points", Some(all)),
    };
    let Some(given) = given else {
        let (unit, option) = named(units.factor);
        let option = if units.heights_only { format!("mm,mm,{option}") } else { option.to_owned() };
        return format!(
            "The {what} seem to be in {unit}, not mm. {words} they fit the nominal. Add `--unit {option}`."
        );
    };
    let (as_read, cure) = as_given(given, units.factor, units.heights_only);
    format!("The {what} were read {as_read}. {words} they fit the nominal. {cure}")
}

/// Points far wider or narrower than the aperture, which another unit fits.
fn by_size(points_mm: &[PointMm], aperture: &Aperture, read: ReadAs) -> Option<String> {
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
    let share = if share > 1.0 { format!("{share:.0}") } else { format!("{share:.1e}") };
    let words = scaling(factor);
    Some(match read {
        ReadAs::Assumed => {
            let (unit, option) = named(factor);
            format!(
                "The points seem to be in {unit}, not mm: they are {share} times as wide as the aperture. {words} they fit it. Add \
                 `--unit {option}`."
            )
        }
        ReadAs::Given { all, .. } => {
            let (as_read, cure) = as_given(all, factor, false);
            format!(
                "The points were read {as_read}, and are {share} times as wide as the aperture. {words} they fit it. {cure}"
            )
        }
    })
}

/// How points were read whose unit the command line gives, and what to give instead.
fn as_given(unit: Option<Unit>, factor: f64, heights_only: bool) -> (String, String) {
    let Some(unit) = unit else {
        return ("in the units of `--unit`".to_owned(), "Correct `--unit`.".to_owned());
    };
    let length_mm = unit.scaled(1.0) * factor;
    let fits = |other: &Unit| (other.scaled(1.0) / length_mm - 1.0).abs() < 1e-9;
    let fitting = [Unit::Nm, Unit::Um, Unit::Mm, Unit::M].into_iter().find(fits);
    let cure = match fitting {
        Some(fitting) if heights_only => {
            format!("Correct `--unit`: {fitting} for the heights, not {unit}.")
        }
        Some(fitting) => format!("Give `--unit {fitting}` instead."),
        None => "Correct `--unit`.".to_owned(),
    };
    (format!("in {unit}, as `--unit` says"), cure)
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
        let said = by_size(&points, &circle(10.0), ReadAs::Assumed).unwrap();
        assert!(said.contains("in µm, not mm") && said.contains("Add `--unit um`."), "{said}");
        let said = |aperture| by_size(&points, &aperture, ReadAs::Assumed);
        assert!(said(circle(1e4)).is_none() && said(Aperture::None).is_none());
        assert!(said(circle(9.5e6)).unwrap().contains("Add `--unit m`."));
    }

    #[test]
    fn units_that_are_given_are_never_to_be_added() {
        let given = |unit, factor| {
            let units = Units { factor, heights_only: false, now: None, then: 0.0 };
            by_form(&units, ReadAs::Given { all: unit, heights: Unit::Um })
        };
        assert_eq!(
            given(Some(Unit::Um), 1e3),
            "The points were read in um, as `--unit` says. Multiplied by 1000 they fit the nominal. Give `--unit mm` instead."
        );
        assert!(given(Some(Unit::In), 1e3).ends_with("Correct `--unit`."));
        assert!(given(None, 1e3).contains("in the units of `--unit`"));
        let heights = Units { factor: 1e-6, heights_only: true, now: None, then: 0.0 };
        let said = by_form(&heights, ReadAs::Given { all: None, heights: Unit::Mm });
        assert!(said.ends_with("Correct `--unit`: nm for the heights, not mm."), "{said}");
    }
}
