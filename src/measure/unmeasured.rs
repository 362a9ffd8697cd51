//! What the part of the aperture that was not measured may add to figures: of the whole, over zones, and of what terms
//! leave.

use asphera_figures::{
    Definition, Reference, Sample, Statistic, Subject, Terms, Unit, peak_to_valley, remove, rms,
};
use asphera_form::Aperture;
use asphera_geometry::BoundsMm;
use asphera_report::{SamplingFigures, UnmeasuredFigures};
use asphera_uncertainty::verdict::{Forecast, Guard, Limit, Over, rms_of_whole_nm};
use asphera_uncertainty::{Hidden, largest_bend_of_windows, unmeasured};
use rayon::prelude::*;

use super::prospects::{P, patches_nm2};
use super::sampling::ZoneSampling;
use crate::Part;

/// Amounts that may hide.
#[derive(Clone, Debug, Default)]
pub(super) struct Unmeasured {
    /// The whole comes first.
    extents: Vec<Extent>,
    /// Amounts that the rest may add to limited RMS slopes, in µrad.
    slopes: Vec<(Limit, f64)>,
    /// Whether a pass needs a probability. Otherwise the coverage that is wanted says how much may be missing.
    by_probability: bool,
}

/// A zone, or what terms leave, and what may hide there.
#[derive(Clone, Debug)]
struct Extent {
    zone: Aperture,
    less: Terms,
    figures: UnmeasuredFigures,
    /// PV and RMS of what is measured there, nm; `None` where nothing is, and of the whole, where the fit tells them.
    values_nm: Option<[f64; 2]>,
}

/// Deviations in mm at places of the part frame, NaN where a point does not count, and how densely they lie.
#[derive(Clone, Copy)]
pub(super) struct Laid<'a> {
    pub(super) places_mm: &'a [[f64; 2]],
    pub(super) deviations_mm: &'a [f64],
    pub(super) sampling: &'a SamplingFigures,
    pub(super) zones: &'a [ZoneSampling],
    /// How many points at most tell how the deviation bends.
    pub(super) most_bent: usize,
}

impl Unmeasured {
    /// Of a part whose deviations have this RMS in nm. Where there is a `forecast` of them, the rest may add as much to an RMS as
    /// that says, if it is more than independent patches say. Takes time in proportion to the points, once for the whole
    /// and once for each zone and set of terms of these `limits`.
    pub(super) fn of(
        part: &Part,
        limits: &[&Limit],
        laid: &Laid<'_>,
        rms_nm: f64,
        forecast: Option<&Forecast>,
    ) -> Unmeasured {
        let p = match part.judging.guard {
            Some(Guard::Probability(p)) => p,
            _ => P,
        };
        let share = laid.sampling.coverage.map(|coverage| 1.0 - coverage);
        let whole = Extent {
            zone: Aperture::None,
            less: Terms::NONE,
            values_nm: None,
            figures: UnmeasuredFigures {
                area_mm2: laid
                    .sampling
                    .undersampled_area_mm2
                    .zip(laid.sampling.uncovered_area_mm2)
                    .map(|(coarse, none)| coarse + none),
                ..figures(laid, laid.sampling.gap_max_mm, share, rms_nm, p)
            },
        };
        let whole = whole.foreseen(laid, rms_nm, forecast);
        let mut further: Vec<&Limit> = Vec::new();
        for limit in limits {
            let same = |other: &&Limit| other.zone == limit.zone && other.less == limit.less;
            let is_whole = limit.zone == Aperture::None && limit.less == Terms::NONE;
            if !is_whole && !further.iter().any(same) {
                further.push(limit);
            }
        }
        let further = further.par_iter().map(|limit| extent(laid, limit, p, forecast));
        let extents: Vec<Extent> =
            std::iter::once(whole).chain(further.collect::<Vec<_>>()).collect();
        let by_probability = matches!(part.judging.guard, Some(Guard::Probability(_)));
        let mut found = Unmeasured { extents, slopes: Vec::new(), by_probability };
        let of_slope = |limit: &&&Limit| steepest(limit).is_some();
        for limit in limits.iter().filter(of_slope) {
            let beyond = found.of_limit(limit).share.and_then(|share| {
                let figure = |limit: &Limit| {
                    let found =
                        limit.figure_of(laid.places_mm, laid.deviations_mm, ALIKE, &part.nominal);
                    found.ok()?.ok().map(|figure| figure.value)
                };
                let (rms, most) = (figure(limit)?, figure(&steepest(limit)?)?);
                Some((rms * rms + share * (most * most - rms * rms)).sqrt() - rms)
            });
            found.slopes.extend(beyond.map(|beyond| ((*limit).clone(), beyond)));
        }
        found
    }

    /// Of a profile, of which `share` of the line was not sampled densely enough, and the rest with a largest gap. That share
    /// is taken to be no farther off than the PV.
    pub(super) fn along_line(
        part: &Part,
        share: Option<f64>,
        gap_mm: Option<f64>,
        bend_per_mm: Option<f64>,
        pv_and_rms_nm: Option<(f64, f64)>,
    ) -> Unmeasured {
        let p = match part.judging.guard {
            Some(Guard::Probability(p)) => p,
            _ => P,
        };
        let share = share.map(|share| if share < ROUNDING { 0.0 } else { share });
        let between_nm = match unmeasured(gap_mm, bend_per_mm) {
            Ok(Hidden::AtMost { each_end_nm }) => Some(each_end_nm),
            Ok(Hidden::Unbounded) | Err(_) => None,
        };
        let beyond_nm = share.zip(pv_and_rms_nm).map(|(share, (pv_nm, rms_nm))| {
            ((1.0 - share) * rms_nm * rms_nm + share * pv_nm * pv_nm).sqrt() - rms_nm
        });
        let why = "too few points to know how the deviation bends between them";
        let unknown = if between_nm.is_none() { vec![why.to_owned()] } else { Vec::new() };
        let figures = UnmeasuredFigures {
            share,
            gap_mm,
            bend_nm_per_mm2: bend_per_mm.map(|bend| 1e6 * bend),
            between_nm,
            pv_hidden_nm: between_nm.map(|nm| 2.0 * nm),
            extreme_missed_p: share.map(|share| (2.0 * share).min(1.0)),
            rms_hidden_nm: between_nm
                .zip(beyond_nm)
                .map(|(between, beyond)| between + beyond.max(0.0)),
            p,
            unknown,
            ..UnmeasuredFigures::default()
        };
        let whole = Extent { zone: Aperture::None, less: Terms::NONE, figures, values_nm: None };
        let by_probability = matches!(part.judging.guard, Some(Guard::Probability(_)));
        Unmeasured { extents: vec![whole], slopes: Vec::new(), by_probability }
    }

    /// Of the whole, as reports write it.
    pub(super) fn figures(&self) -> UnmeasuredFigures {
        self.extents.first().map_or_else(UnmeasuredFigures::default, |whole| whole.figures.clone())
    }

    fn extent(&self, limit: &Limit) -> Option<&Extent> {
        self.extents.iter().find(|extent| extent.zone == limit.zone && extent.less == limit.less)
    }

    fn of_limit(&self, limit: &Limit) -> UnmeasuredFigures {
        let found = self.extent(limit);
        found.map_or_else(UnmeasuredFigures::default, |extent| extent.figures.clone())
    }

    /// PV, or else RMS, of what is measured over the zone of a limit, its terms removed, every point counted alike, in nm; `None`
    /// where nothing is, and of the whole.
    pub(super) fn value_nm(&self, limit: &Limit) -> Option<f64> {
        let [pv_nm, rms_nm] = self.extent(limit)?.values_nm?;
        Some(if limit.definition == Definition::PeakToValley { pv_nm } else { rms_nm })
    }

    /// Amount that may be added to the figure of a limit, in its unit; `None` where that is not known, or larger than the
    /// probability asked for allows. Slopes are those of stations, so that nothing is between them; where none can be formed
    /// they are taken for no steeper than the steepest, or as likely as anywhere to be it. Of surfaces that filters leave nothing is
    /// known to be missing.
    pub(super) fn hidden(&self, limit: &Limit) -> Option<f64> {
        if limit.definition.subject() == Subject::Filtered {
            return Some(0.0);
        }
        let found = self.of_limit(limit);
        if limit.definition.unit() == Unit::Microradians {
            let share = found.share?;
            if steepest(limit).is_none() {
                return Some(0.0).filter(|_| self.is_enough(share, found.p));
            }
            return self.slopes.iter().find(|(own, _)| own == limit).map(|(_, beyond)| *beyond);
        }
        if is_rms(limit.definition) {
            return found.rms_hidden_nm;
        }
        // A range, of which either end may lie where nothing was measured.
        let missed = found.extreme_missed_p?;
        found.pv_hidden_nm.filter(|_| self.is_enough(missed, found.p))
    }

    /// Whether so small a chance to have missed an extreme is allowed.
    fn is_enough(&self, missed: f64, p: f64) -> bool {
        !self.by_probability || missed <= 1.0 - p + ROUNDING
    }

    /// Height that may stand out between the points that lie densely enough, in nm; `None` where that is not known.
    pub(super) fn between_nm(&self, limit: &Limit) -> Option<f64> {
        let found = self.of_limit(limit);
        if is_rms(limit.definition) { found.between_nm } else { found.pv_hidden_nm }
    }

    /// Amount that the rest may add to an RMS, in nm; nothing to a range, of which it is told by a probability. `None` where that
    /// is not known.
    pub(super) fn beyond_nm(&self, limit: &Limit) -> Option<f64> {
        let found = self.of_limit(limit);
        if !is_rms(limit.definition) {
            return Some(0.0);
        }
        found.rms_hidden_nm.zip(found.between_nm).map(|(hidden, between)| hidden - between)
    }

    /// In words.
    pub(super) fn why(&self, limit: &Limit) -> String {
        let found = self.of_limit(limit);
        if let Some(unknown) = found.unknown.first() {
            return unknown.clone();
        }
        let share = 100.0 * found.share.unwrap_or(1.0);
        let of = if limit.zone == Aperture::None { "aperture" } else { "zone" };
        if limit.definition.unit() == Unit::Microradians {
            let allowed = 100.0 * (1.0 - found.p);
            return match self.hidden(limit) {
                Some(more) => format!(
                    "the {share:.1} % of the {of} not sampled densely enough may add up to {more:.2} µrad"
                ),
                None => format!(
                    "{share:.1} % of the {of} are not sampled densely enough, and hold the steepest place with a probability up to {share:.1} %; {allowed:.1} % are allowed"
                ),
            };
        }
        let between = found.between_nm.unwrap_or(f64::NAN);
        let gap_mm = found.gap_mm.unwrap_or(f64::NAN);
        let mut parts = vec![format!(
            "{between:.2} nm may stand out between points with a gap of {gap_mm:.3} mm"
        )];
        if is_rms(limit.definition) {
            parts.extend(found.rms_hidden_nm.map(|nm| {
                format!("with the {share:.1} % not sampled densely enough up to {nm:.2} nm more")
            }));
        } else if share > 0.0 && self.by_probability {
            let missed = 100.0 * found.extreme_missed_p.unwrap_or(1.0);
            parts.push(format!(
                "{share:.1} % of the {of} are not sampled densely enough, and hold an extreme with a probability up to {missed:.1} %; {:.1} % are allowed",
                100.0 * (1.0 - found.p)
            ));
        }
        parts.join("; ")
    }
}

/// Of the zone and the terms of a limit.
fn extent(laid: &Laid<'_>, limit: &Limit, p: f64, forecast: Option<&Forecast>) -> Extent {
    let (zone, less) = (&limit.zone, limit.less);
    let unknown = |why: String| UnmeasuredFigures { p, unknown: vec![why], ..Default::default() };
    let sampled = match zone {
        Aperture::None => Some((laid.sampling.coverage, laid.sampling.gap_max_mm)),
        _ => {
            let own = laid.zones.iter().find(|own| own.zone == *zone);
            own.map(|own| (own.coverage, own.gap_max_mm))
        }
    };
    let left = Sample::new(laid.places_mm, laid.deviations_mm, None, zone)
        .map_err(|error| error.to_string())
        .and_then(|sample| {
            let removed = remove(&sample, &less.list()).map_err(|why| why.to_string())?;
            let range = peak_to_valley(&removed.sample).map_err(|why| why.to_string())?;
            let value = rms(&removed.sample, Reference::Zero).map_err(|why| why.to_string())?;
            Ok((removed.sample, [range.value, value.value]))
        });
    let values_nm = left.as_ref().ok().map(|(_, values_nm)| *values_nm);
    let figures = match (sampled, left) {
        (Some((coverage, gap_mm)), Ok((sample, [_, rms_nm]))) => {
            let deviations_mm: Vec<f64> = sample.values_nm().iter().map(|nm| nm * 1e-6).collect();
            let own =
                Laid { places_mm: sample.places_mm(), deviations_mm: &deviations_mm, ..*laid };
            figures(&own, gap_mm, coverage.map(|coverage| 1.0 - coverage), rms_nm, p)
        }
        (None, _) => unknown("the coverage of the zone is not known".to_owned()),
        (_, Err(why)) => unknown(why),
    };
    let found = Extent { zone: zone.clone(), less, figures, values_nm };
    match values_nm {
        Some([_, rms_nm]) => found.foreseen(laid, rms_nm, forecast),
        None => found,
    }
}

impl Extent {
    /// The same with what a forecast says of the rest.
    fn foreseen(mut self, laid: &Laid<'_>, rms_nm: f64, forecast: Option<&Forecast>) -> Extent {
        let (Some(forecast), Some(share)) = (forecast, self.figures.share) else { return self };
        let laid = (laid.places_mm, laid.deviations_mm);
        let predicted = (share > 0.0)
            .then(|| {
                forecast.predict(Definition::RmsOverPoints, &self.zone, &self.less, rms_nm, laid)
            })
            .flatten();
        let beyond_nm = predicted.map(|found| found.quantile_nm(self.figures.p) - rms_nm);
        let hidden =
            self.figures.between_nm.zip(beyond_nm).map(|(between, beyond)| between + beyond);
        if let (Some(most), Some(hidden)) = (&mut self.figures.rms_hidden_nm, hidden) {
            *most = most.max(hidden);
        }
        self
    }
}

/// Of deviations with a largest gap and a share that was not measured, at the probability `p`.
fn figures(
    laid: &Laid<'_>,
    gap_max_mm: Option<f64>,
    share: Option<f64>,
    rms_nm: f64,
    p: f64,
) -> UnmeasuredFigures {
    let Laid { places_mm, deviations_mm, sampling, .. } = *laid;
    let mut unknown = Vec::new();
    let share = share.map(|share| if share < ROUNDING { 0.0 } else { share });
    if share.is_none() {
        unknown.push("the coverage of the aperture is not known".to_owned());
    }
    let bend_per_mm = largest_bend_of_windows(places_mm, deviations_mm, laid.most_bent);
    if bend_per_mm.is_none() {
        unknown.push("too few points to know how the deviation bends between them".to_owned());
    }
    let gap_mm = match (gap_max_mm, sampling.gap_limit_mm) {
        (Some(largest), Some(limit)) => Some(largest.min(limit)),
        (largest, _) => largest,
    };
    if gap_mm.is_none() {
        unknown.push("the largest gap is not known".to_owned());
    }
    let between_nm = match unmeasured(gap_mm, bend_per_mm) {
        Ok(Hidden::AtMost { each_end_nm }) => Some(each_end_nm),
        Ok(Hidden::Unbounded) | Err(_) => None,
    };
    let whole_nm = share.and_then(|share| {
        let patches = patches_nm2(&blocks(places_mm, deviations_mm));
        rms_of_whole_nm(rms_nm, &patches, 1.0 - share, p)
    });
    if share.is_some() && whole_nm.is_none() {
        unknown
            .push("too few places to know how the deviation varies over the aperture".to_owned());
    }
    let beyond_nm = whole_nm.map(|whole_nm| (whole_nm - rms_nm).max(0.0));
    UnmeasuredFigures {
        share,
        area_mm2: None,
        gap_mm,
        bend_nm_per_mm2: bend_per_mm.map(|bend| 1e6 * bend),
        between_nm,
        pv_hidden_nm: between_nm.map(|nm| 2.0 * nm),
        extreme_missed_p: share.map(|share| (2.0 * share).min(1.0)),
        rms_hidden_nm: between_nm.zip(beyond_nm).map(|(between, beyond)| between + beyond),
        p,
        unknown,
    }
}

/// Of a limit of an RMS slope, that of the largest; `None` of any other.
fn steepest(limit: &Limit) -> Option<Limit> {
    let definition = match limit.definition {
        Definition::MeridionalSlopeRms => Definition::MeridionalSlopeMax,
        Definition::GradientRms => Definition::GradientMax,
        _ => return None,
    };
    Some(Limit { definition, ..limit.clone() })
}

fn is_rms(definition: Definition) -> bool {
    definition.statistic() == Statistic::MeanSquare
}

/// Points and sums of squares in nm² of blocks over the extent of the places.
fn blocks(places_mm: &[[f64; 2]], deviations_mm: &[f64]) -> Vec<(f64, f64)> {
    let counts = || places_mm.iter().zip(deviations_mm).filter(|(_, mm)| mm.is_finite());
    let BoundsMm { low, high } = BoundsMm::about(counts().map(|(&place, _)| place));
    let mut blocks = vec![(0.0, 0.0); SIDE * SIDE];
    for (place, deviation_mm) in counts() {
        let [column, row] = [0, 1].map(|axis| {
            let share = (place[axis] - low[axis]) / (high[axis] - low[axis]).max(f64::MIN_POSITIVE);
            ((share * SIDE as f64) as usize).min(SIDE - 1)
        });
        let block = &mut blocks[row * SIDE + column];
        block.0 += 1.0;
        block.1 += (1e6 * deviation_mm).powi(2);
    }
    blocks
}

/// Blocks along either side.
const SIDE: usize = 12;
/// All points, each counted alike.
const ALIKE: Over<'static> = Over { aperture: &Aperture::None, areas_mm2: None };
/// A share of the aperture that is rounding.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use crate::nominal::parse;
    use asphera_report::{Check, Verdict};

    use crate::Pipeline;

    /// A disc of 20 mm scanned line by line up to `end_mm`, with slopes of some 30 µrad.
    fn verdict(end_mm: f64, guard: &str) -> Verdict {
        let text = format!(
            "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 20\n\
             [sampling]\ngap_limit_mm = 0.5\ncoverage_min = 0.5\n\
             [tolerance]\nslope_over_mm = 2\nslope_step_mm = 1\ngradient_max_urad = 200\ngradient_rms_urad = 200\n{guard}"
        );
        let mut pipeline = Pipeline::new(parse("p.toml", &text).unwrap());
        for line in 0..82_u32 {
            for column in 0..82_u32 {
                let [x, y] = [column, line].map(|at| 0.5 * f64::from(at) - 20.25);
                if x.hypot(y) <= 20.5 && y <= end_mm {
                    let rough = f64::from((column * 7919 + line * 104_729) % 101) / 50.0 - 1.0;
                    let nm = 50.0 * (0.6 * x).sin() * (0.5 * y).cos() + rough;
                    pipeline.take_position([x, y, 1e-6 * nm]);
                }
            }
        }
        pipeline.finish().report.verdict
    }

    fn check<'a>(verdict: &'a Verdict, name: &str) -> &'a Check {
        verdict.checks.iter().find(|check| check.figure.name == name).unwrap()
    }

    #[test]
    fn slopes_of_what_is_not_measured_count() {
        let guard = "guard_probability = 0.95\n";
        let all = verdict(30.0, guard);
        for name in ["gradient_max_urad", "gradient_rms_urad"] {
            assert!(check(&all, name).ok, "{all:?}");
        }
        // A fifth of the disc is missing, which may hold the steepest place.
        let some = verdict(9.0, guard);
        let [most, rms] = ["gradient_max_urad", "gradient_rms_urad"].map(|name| check(&some, name));
        assert!(!most.ok && most.hidden.is_none() && most.doubt.is_some(), "{most:?}");
        let said = some
            .reasons
            .iter()
            .find(|why| why.contains("the steepest place with a probability up to"));
        assert!(said.is_some(), "{:?}", some.reasons);
        // All of it is taken for as steep as the steepest.
        let hidden = rms.hidden.unwrap();
        let share = ((rms.value + hidden).powi(2) - rms.value.powi(2))
            / (most.value.powi(2) - rms.value.powi(2));
        assert!(rms.ok && (0.15..0.4).contains(&share), "{share} {rms:?} {most:?}");
        // Where no probability is asked for, the coverage that is wanted says how much may be missing.
        assert!(check(&verdict(9.0, ""), "gradient_max_urad").ok);
    }
}
