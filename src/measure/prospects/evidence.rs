//! What a look at all points so far tells of the limits of PV and RMS: of the whole, over zones, and of what terms leave.

use std::collections::BTreeMap;

use asphera_figures::Definition;
use asphera_form::{Aperture, LiveEstimate, Parameter, deviations};
use asphera_geometry::PointMm;
use asphera_report::SamplingFigures;
use asphera_uncertainty::verdict::{
    Deviations, Forecast, Limit, Predicted, forecast, least, least_square_nm2,
};
use rayon::prelude::*;

use super::{figure_nm, is_foreseen};
use crate::Part;
use crate::details::places_mm;
use crate::errors::{Errors, ErrorsOfLimit};
use crate::sampling::ZoneSampling;
use crate::unmeasured::{Laid, Unmeasured};

/// State of a measurement at a look.
pub(crate) struct Evidence<'a> {
    pub(crate) part: &'a Part,
    /// In the frame of the plane of projection, as is the estimate.
    pub(crate) points: &'a [PointMm],
    pub(crate) estimate: &'a LiveEstimate,
    pub(crate) sampling: &'a SamplingFigures,
    pub(crate) zones: &'a [ZoneSampling],
    pub(crate) errors: &'a Errors,
    /// Points yet to come, at most; `None` if nobody knows.
    pub(crate) to_come: Option<u64>,
}

/// Findings about the limits, by name.
#[derive(Clone, Debug, Default)]
pub(super) struct KnownLimits {
    limits: BTreeMap<String, OfLimit>,
}

/// Findings about one limit, as of the look.
#[derive(Clone, Debug)]
pub(super) struct OfLimit {
    pub(super) value_nm: f64,
    /// Coverage of its zone.
    pub(super) coverage: Option<f64>,
    /// Height that may stand out between the points.
    pub(super) between_nm: Option<f64>,
    /// Amount that the rest may add to an RMS.
    pub(super) beyond_nm: Option<f64>,
    pub(super) predicted: Option<Predicted>,
    /// Of a limit that is not of the whole: its figure is at least this in the end.
    pub(super) at_least_nm: Option<f64>,
    /// Of a limit that is not of the whole.
    pub(super) errors: Option<ErrorsOfLimit>,
}

impl KnownLimits {
    /// Takes time in proportion to the points, and some tens of milliseconds; none where there is no limit of PV or
    /// RMS. Of limits whose fail `is_certain` no bound is looked for.
    pub(super) fn of(look: &Evidence<'_>, is_certain: impl Fn(&str) -> bool + Sync) -> KnownLimits {
        let Evidence { part, points, estimate, sampling, zones, .. } = *look;
        let mut foreseen = part.limits().to_vec();
        foreseen.retain(is_foreseen);
        if foreseen.is_empty() {
            return KnownLimits::default();
        }
        let places_mm = places_mm(&estimate.pose, points);
        let mut deviations_mm = deviations(points, &estimate.nominal, &estimate.pose);
        for (&[x, y], deviation_mm) in places_mm.iter().zip(&mut deviations_mm) {
            if !part.aperture.contains(x, y) {
                *deviation_mm = f64::NAN;
            }
        }
        let (places_mm, deviations_mm) = (&places_mm[..], &deviations_mm[..]);
        let laid = Laid { places_mm, deviations_mm, sampling, zones, most_bent: MOST_BENT };
        let free: Vec<Parameter> =
            estimate.estimates.iter().map(|estimate| estimate.parameter).collect();
        // What a reference made from the points will follow of those to come nobody knows: only values are told.
        let follows = part.reference.is_some();
        let to_come = || {
            let missing = sampling.coverage.map(|coverage| 1.0 - coverage);
            let (nominal, pose) = (&estimate.nominal, &estimate.pose);
            let measured = Deviations { places_mm, deviations_mm };
            forecast(measured, &part.aperture, nominal, pose, &free, missing)
        };
        let forecast = if follows { None } else { to_come() };
        let limits: Vec<&Limit> = foreseen.iter().collect();
        let rms_nm = estimate.figures.rms_nm;
        let unmeasured = Unmeasured::of(part, &limits, &laid, rms_nm, forecast.as_ref());
        let told = Told { look, laid, unmeasured, forecast, free };
        let found = foreseen.par_iter().filter_map(|limit| {
            let name = limit.name();
            let found = told.of_limit(&name, limit, follows || is_certain(&name))?;
            Some((name, found))
        });
        KnownLimits { limits: found.collect() }
    }

    pub(super) fn of_limit(&self, name: &str) -> Option<&OfLimit> {
        self.limits.get(name)
    }
}

/// Data shared by all limits.
struct Told<'a> {
    look: &'a Evidence<'a>,
    laid: Laid<'a>,
    unmeasured: Unmeasured,
    forecast: Option<Forecast>,
    free: Vec<Parameter>,
}

impl Told<'_> {
    fn of_limit(&self, name: &str, limit: &Limit, is_certain: bool) -> Option<OfLimit> {
        let Told { look, laid: Laid { places_mm, deviations_mm, .. }, .. } = *self;
        let value_nm = if limit.is_of_whole() {
            figure_nm(limit.definition, look.estimate)
        } else {
            self.unmeasured.value_nm(limit)?
        };
        let coverage = match &limit.zone {
            Aperture::None => look.sampling.coverage,
            zone => look.zones.iter().find(|own| own.zone == *zone)?.coverage,
        };
        let predicted = self.forecast.as_ref().and_then(|forecast| {
            let laid = (places_mm, deviations_mm);
            forecast.predict(limit.definition, &limit.zone, &limit.less, value_nm, laid)
        });
        let mut found = OfLimit {
            value_nm,
            coverage,
            between_nm: self.unmeasured.between_nm(limit),
            beyond_nm: self.unmeasured.beyond_nm(limit),
            predicted,
            at_least_nm: None,
            errors: None,
        };
        if !limit.is_of_whole() {
            let count = self.points_in(&limit.zone).count();
            found.errors = look.errors.of_limit(name, limit.definition, value_nm, count);
            // No bound of a figure that is within its limit can break it.
            if value_nm > limit.value && look.estimate.is_complete() && !is_certain {
                found.at_least_nm = self.at_least_nm(limit);
            }
        }
        Some(found)
    }

    /// The figure is at least this in the end, in nm. A point at the border of a zone may be on its other side
    /// then: a cell's width of it is left out of what is summed, and another taken in where points are counted.
    fn at_least_nm(&self, limit: &Limit) -> Option<f64> {
        let Evidence { estimate, to_come, .. } = *self.look;
        let LiveEstimate { nominal, pose, .. } = estimate;
        let inside = moved(&limit.zone, -1.0);
        if limit.definition == Definition::PeakToValley {
            let outer = self.outer(&inside);
            return Some(least(&outer, nominal, pose, &self.free, &limit.less)?.range_nm);
        }
        let inside = self.points(self.points_in(&inside));
        let square_nm2 = least_square_nm2(&inside, nominal, pose, &self.free, &limit.less)?;
        let most = self.points_in(&moved(&limit.zone, 1.0)).count() as u64 + to_come?;
        Some((square_nm2 / most as f64).sqrt())
    }

    fn points(&self, indices: impl Iterator<Item = usize>) -> Vec<PointMm> {
        indices.map(|index| self.look.points[index]).collect()
    }

    /// The points of a zone, or where these are many the highest and the lowest of each of some blocks: any of them bound a range.
    fn outer(&self, zone: &Aperture) -> Vec<PointMm> {
        let Laid { places_mm, deviations_mm, .. } = self.laid;
        let all: Vec<usize> = self.points_in(zone).collect();
        if all.len() <= MOST_BOUNDING {
            return self.points(all.into_iter());
        }
        let reach_mm = all.iter().flat_map(|&index| places_mm[index]).map(f64::abs);
        let reach_mm = reach_mm.fold(f64::MIN_POSITIVE, f64::max);
        let mut blocks: Vec<Option<[usize; 2]>> = vec![None; BLOCKS * BLOCKS];
        for index in all {
            let [column, row] = places_mm[index]
                .map(|mm| ((0.5 * (mm / reach_mm + 1.0) * BLOCKS as f64) as usize).min(BLOCKS - 1));
            let [low, high] = blocks[row * BLOCKS + column].get_or_insert([index; 2]);
            if deviations_mm[index] < deviations_mm[*low] {
                *low = index;
            }
            if deviations_mm[index] > deviations_mm[*high] {
                *high = index;
            }
        }
        self.points(blocks.into_iter().flatten().flatten())
    }

    /// Indices of the points that count in a zone.
    fn points_in<'a>(&'a self, zone: &'a Aperture) -> impl Iterator<Item = usize> + 'a {
        let Laid { places_mm, deviations_mm, .. } = self.laid;
        (0..places_mm.len()).filter(move |&index| {
            let [x, y] = places_mm[index];
            deviations_mm[index].is_finite() && zone.contains(x, y)
        })
    }
}

/// A ring wider by so many cells of the map on either side, or narrower.
fn moved(zone: &Aperture, cells: f64) -> Aperture {
    match *zone {
        Aperture::Annulus { inner_mm, outer_mm } => {
            let by_mm = cells * outer_mm / CELLS;
            let inner_mm = if inner_mm > 0.0 { (inner_mm - by_mm).max(0.0) } else { 0.0 };
            Aperture::Annulus { inner_mm, outer_mm: outer_mm + by_mm }
        }
        _ => zone.clone(),
    }
}

/// Points at most that tell how the deviation bends between them: what that costs at the end is told by all.
const MOST_BENT: usize = 131_072;
/// Points at most that bound a range as they are, and blocks along either side of which the outermost do where there are more.
const MOST_BOUNDING: usize = 16_384;
const BLOCKS: usize = 64;
/// Cells over a zone.
const CELLS: f64 = 96.0;
