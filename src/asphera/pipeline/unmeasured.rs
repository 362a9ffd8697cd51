//! What the part of the aperture that was not measured may add to the final figures.

use asphera_form::figures::{Definition, Unit};
use asphera_form::uncertainty::{Hidden, largest_bend, unmeasured};
use asphera_form::verdict::{Guard, rms_of_whole_nm};
use asphera_form::{Figures, Fit};
use asphera_surface::PointMm;

use super::details::places_mm;
use super::prospects::{P, patches_nm2};
use crate::config::Part;
use crate::report::{SamplingFigures, UnmeasuredFigures};

/// What may hide.
#[derive(Clone, Debug, Default)]
pub(super) struct Unmeasured {
    figures: UnmeasuredFigures,
    /// Whether a pass needs a probability. Otherwise the coverage that is wanted says how much may be missing.
    by_probability: bool,
}

impl Unmeasured {
    /// Of a part with these deviations, NaN where a point does not count. Takes time in proportion to the points.
    pub(super) fn of(
        part: &Part,
        points: &[PointMm],
        deviations_mm: &[f64],
        fit: &Fit,
        figures: &Figures,
        sampling: &SamplingFigures,
    ) -> Unmeasured {
        let mut unknown = Vec::new();
        let p = match part.judging.guard {
            Some(Guard::Probability(p)) => p,
            _ => P,
        };
        let share = sampling.coverage.map(|coverage| (1.0 - coverage).max(0.0));
        let share = share.map(|share| if share < ROUNDING { 0.0 } else { share });
        if share.is_none() {
            unknown.push("the coverage of the aperture is not known".to_owned());
        }
        let places_mm = places_mm(&fit.pose, points);
        let bend_per_mm = largest_bend(&places_mm, deviations_mm);
        if bend_per_mm.is_none() {
            unknown.push("too few points tell how the deviation bends between them".to_owned());
        }
        let gap_mm = match (sampling.gap_max_mm, sampling.gap_limit_mm) {
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
            let patches = patches_nm2(&blocks(&places_mm, deviations_mm));
            rms_of_whole_nm(figures.rms_nm, &patches, 1.0 - share, p)
        });
        if share.is_some() && whole_nm.is_none() {
            unknown
                .push("too few places tell how the deviation varies over the aperture".to_owned());
        }
        let beyond_nm = whole_nm.map(|whole_nm| (whole_nm - figures.rms_nm).max(0.0));
        let figures = UnmeasuredFigures {
            share,
            area_mm2: sampling
                .undersampled_area_mm2
                .zip(sampling.uncovered_area_mm2)
                .map(|(coarse, none)| coarse + none),
            gap_mm,
            bend_nm_per_mm2: bend_per_mm.map(|bend| 1e6 * bend),
            between_nm,
            pv_hidden_nm: between_nm.map(|nm| 2.0 * nm),
            extreme_missed_p: share.map(|share| (2.0 * share).min(1.0)),
            rms_hidden_nm: between_nm.zip(beyond_nm).map(|(between, beyond)| between + beyond),
            p,
            unknown,
        };
        let by_probability = matches!(part.judging.guard, Some(Guard::Probability(_)));
        Unmeasured { figures, by_probability }
    }

    /// As reports write it.
    pub(super) fn figures(&self) -> UnmeasuredFigures {
        self.figures.clone()
    }

    /// What may be added to a figure, in its unit; `None` where that is not known, or larger than the probability asked
    /// for allows. Of slopes it is not told.
    pub(super) fn hidden(&self, definition: Definition) -> Option<f64> {
        let found = &self.figures;
        if definition.unit() != Unit::Nanometres {
            return Some(0.0);
        }
        match definition {
            Definition::RmsAboutZero
            | Definition::RmsAboutMean
            | Definition::RmsTotal
            | Definition::RmsIrregularity
            | Definition::RmsVariant => found.rms_hidden_nm,
            // A range, of which either end may lie where nothing was measured.
            _ => {
                let missed = found.extreme_missed_p?;
                let enough = !self.by_probability || missed <= 1.0 - found.p + ROUNDING;
                found.pv_hidden_nm.filter(|_| enough)
            }
        }
    }

    /// In words, of the limit of this name.
    pub(super) fn why(&self, name: &str) -> String {
        let found = &self.figures;
        if let Some(unknown) = found.unknown.first() {
            return unknown.clone();
        }
        let share = 100.0 * found.share.unwrap_or(1.0);
        let between = found.between_nm.unwrap_or(f64::NAN);
        let gap_mm = found.gap_mm.unwrap_or(f64::NAN);
        let mut parts = vec![format!(
            "{between:.2} nm may stand out between points with a gap of {gap_mm:.3} mm"
        )];
        if name.starts_with("rms") {
            parts.extend(found.rms_hidden_nm.map(|nm| {
                format!("with the {share:.1} % not sampled densely enough up to {nm:.2} nm more")
            }));
        } else if share > 0.0 && self.by_probability {
            let missed = 100.0 * found.extreme_missed_p.unwrap_or(1.0);
            parts.push(format!(
                "{share:.1} % of the aperture are not sampled densely enough and hold an extreme with up to \
                 {missed:.1} %, {:.1} % are allowed",
                100.0 * (1.0 - found.p)
            ));
        }
        parts.join("; ")
    }
}

/// Points and sums of squares in nm² of blocks over the extent of the places.
fn blocks(places_mm: &[[f64; 2]], deviations_mm: &[f64]) -> Vec<(f64, f64)> {
    let counts = || places_mm.iter().zip(deviations_mm).filter(|(_, mm)| mm.is_finite());
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for (place, _) in counts() {
        for axis in 0..2 {
            low[axis] = low[axis].min(place[axis]);
            high[axis] = high[axis].max(place[axis]);
        }
    }
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
/// A share of the aperture that is rounding.
const ROUNDING: f64 = 1e-9;
