//! Range and root mean square, with their robust variants.

use super::expansion::{FringeCount, FringeFit, fringe_fit};
use super::{Definition, Figure, Sample, SettingError, Unknown};

/// Middle that a root mean square is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The nominal.
    Zero,
    /// The area-weighted mean of the deviations.
    Mean,
}

/// A share above 0 and at most 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share(f64);

impl Share {
    /// 99 %.
    pub const NINETY_NINE: Share = Share(0.99);

    /// Fails unless `value` is above 0 and at most 1.
    pub fn new(value: f64) -> Result<Share, SettingError> {
        if value > 0.0 && value <= 1.0 {
            Ok(Share(value))
        } else {
            Err(SettingError::Share { value })
        }
    }

    /// The share, as a number above 0 and at most 1.
    pub fn value(self) -> f64 {
        self.0
    }
}

/// Largest minus smallest deviation. `O(n)`.
pub fn peak_to_valley(sample: &Sample) -> Result<Figure, Unknown> {
    let [low, high] = Sample::range(sample.values_nm()).ok_or(Unknown::NoPoints)?;
    Ok(Figure::new(Definition::PeakToValley, high - low))
}

/// Root of the area-weighted mean square. `O(n)`.
pub fn rms(sample: &Sample, about: Reference) -> Result<Figure, Unknown> {
    if sample.is_empty() {
        return Err(Unknown::NoPoints);
    }
    let values = sample.values_nm();
    let (definition, reference) = match about {
        Reference::Zero => (Definition::RmsAboutZero, 0.0),
        Reference::Mean => (Definition::RmsAboutMean, sample.mean(|i| values[i])),
    };
    let square = sample.mean(|i| (values[i] - reference) * (values[i] - reference));
    Ok(Figure::new(definition, square.sqrt()))
}

/// The range or mean square of a sample; `None` of a variant that does not exist, and of other figures.
pub(super) fn form(definition: &Definition, sample: &Sample) -> Option<Result<Figure, Unknown>> {
    Some(match *definition {
        Definition::PeakToValley => peak_to_valley(sample),
        Definition::RmsOverPoints => {
            let definition = Definition::RmsOverPoints;
            rms(sample, Reference::Zero).map(|found| Figure { definition, ..found })
        }
        Definition::RmsAboutZero => rms(sample, Reference::Zero),
        Definition::RmsAboutMean => rms(sample, Reference::Mean),
        Definition::RobustPeakToValley { share } => {
            robust_peak_to_valley(sample, Share::new(share).ok()?)
        }
        Definition::Pvr { terms } => pvr(sample, FringeCount::new(terms)?),
        _ => return None,
    })
}

/// Heights whose mean square is that of the figure; `None` of figures that are none.
pub(super) fn averaged_nm(definition: &Definition, sample: &Sample) -> Option<Vec<f64>> {
    let values = sample.values_nm();
    match definition {
        Definition::RmsOverPoints | Definition::RmsAboutZero => Some(values.to_vec()),
        Definition::RmsAboutMean => {
            let mean = sample.mean(|place| values[place]);
            Some(values.iter().map(|value| value - mean).collect())
        }
        _ => None,
    }
}

/// Range of the middle `share` of the area.
///
/// The lower end is the smallest deviation such that at least (1 − share)/2 of the area lies at or below
/// it, the upper end the largest such that as much lies at or above it. Both are measured deviations, none
/// is interpolated: the inverse of the distribution function (Hyndman & Fan, Am. Stat. 50 (1996) 361, type
/// 1), the upper end as that of the negative deviations. A share of 1 gives the peak to valley.
/// `O(n log n)`.
pub fn robust_peak_to_valley(sample: &Sample, share: Share) -> Result<Figure, Unknown> {
    if sample.is_empty() {
        return Err(Unknown::NoPoints);
    }
    let mut sorted: Vec<(f64, f64)> =
        sample.values_nm().iter().copied().zip(sample.areas().iter().copied()).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let outside = 0.5 * (1.0 - share.value()) * sample.total_area();
    // Rounding of the sums must not push an end by one point.
    let outside = outside * (1.0 - SUM_TOLERANCE);
    let low = end(sorted.iter(), outside);
    let high = end(sorted.iter().rev(), outside);
    // With a share near 0 both ends are the median, which two points may lie at either side of.
    let range = (high - low).max(0.0);
    Ok(Figure::new(Definition::RobustPeakToValley { share: share.value() }, range))
}

/// The first deviation at which the area summed so far is at least `outside`.
fn end<'a>(sorted: impl Iterator<Item = &'a (f64, f64)>, outside: f64) -> f64 {
    let (mut area, mut last) = (0.0, f64::NAN);
    for &(value, own) in sorted {
        area += own;
        last = value;
        if area >= outside {
            break;
        }
    }
    last
}

/// PVr: the range of a Fringe fit, over the measured places, plus three times the RMS of its residual.
///
/// C. Evans, "Robust estimation of PV for optical surface specification and testing", Optical Fabrication
/// and Testing 2008, OWA4. A point that is no part of the form, such as a spike, enters by its share in the
/// RMS. The terms refer to the disc of [`Sample::radius_mm`] and include the piston. `O(n·p²)` for p terms.
///
/// Unknown where the places do not determine every term.
pub fn pvr(sample: &Sample, count: FringeCount) -> Result<Figure, Unknown> {
    let (used, needed) = (sample.weighted(), usize::from(count.last()) + 1);
    if !sample.is_empty() && used < needed {
        return Err(Unknown::TooFewPoints { used, needed });
    }
    fringe_fit(sample, count)?.pvr()
}

impl FringeFit {
    /// [`pvr`] of the sample the fit was made of, without another fit.
    pub fn pvr(&self) -> Result<Figure, Unknown> {
        let (used, terms) = (self.used, self.coefficients_nm.len());
        if used <= terms {
            return Err(Unknown::TooFewPoints { used, needed: terms + 1 });
        }
        let indeterminate = self.indeterminate();
        if !indeterminate.is_empty() {
            return Err(Unknown::Indeterminate { terms: indeterminate });
        }
        let definition = Definition::Pvr { terms: terms as u8 };
        Ok(Figure::new(definition, self.range_nm + 3.0 * self.residual_rms_nm))
    }
}

/// Relative rounding of a sum over any realistic number of points.
const SUM_TOLERANCE: f64 = 1e-11;
