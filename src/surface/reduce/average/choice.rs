//! The window of a kept point: the one with the least uncertainty among those that can be defended.

use super::super::fitted::Fitted;
use super::Heights;
use super::cells::Cells;
use super::ladder::{Degree, Ladder, Reading, Which};

/// The readings and points that windows are chosen from.
pub(super) struct Choosing<'a> {
    pub(super) cells: &'a Cells,
    pub(super) heights: &'a Heights<'a>,
    pub(super) ladders: &'a [Ladder],
    pub(super) sigma_mm: f64,
}

/// The reading taken at a kept point.
pub(super) struct Best {
    pub(super) reading: Reading,
    pub(super) bias_mm: f64,
    /// How many points it comes from.
    pub(super) count: usize,
}

impl Choosing<'_> {
    /// The best reading at a kept point; `None` if none is better than the point itself.
    pub(super) fn best(&self, number: usize) -> Option<Best> {
        let ladder = &self.ladders[number];
        let mut open: Vec<(Which, Reading)> = (0..ladder.steps.len())
            .flat_map(|step| [Degree::Plane, Degree::Quadric].map(|degree| Which { step, degree }))
            .filter_map(|which| Some((which, ladder.reading(which)?)))
            .filter(|(_, reading)| reading.factor < 1.0)
            .collect();
        open.sort_by(|a, b| a.1.factor.total_cmp(&b.1.factor));
        if open.is_empty() {
            return None;
        }
        let about = self.cells.about(self.heights.kept[number], ABOUT);
        let own = self.heights.offsets_mm(number, self.cells.of(number));
        let mut quartics: Vec<Option<Option<Fitted<15>>>> = Vec::new();
        quartics.resize_with(ladder.steps.len(), || None);
        open.into_iter().find_map(|(which, reading)| {
            if !self.agrees(number, which, &reading, &about) {
                return None;
            }
            let count = ladder.steps[which.step].count;
            let window = &own[..count];
            let quartic = quartics[which.step]
                .get_or_insert_with(|| self.quartic(number, window, &about))
                .as_ref()?;
            let [bias_mm, factor] = match which.degree {
                Degree::Plane => quartic.bias_of(&Fitted::<3>::to(window)?, window),
                Degree::Quadric => quartic.bias_of(&Fitted::<6>::to(window)?, window),
            };
            let bias_mm = bias_mm.hypot(self.sigma_mm * factor);
            let defended = bias_mm <= BELOW * self.sigma_mm * reading.factor;
            defended.then_some(Best { reading, bias_mm, count })
        })
    }

    /// Whether the readings over narrower windows agree with one, at its own point and over all about it.
    fn agrees(&self, number: usize, which: Which, reading: &Reading, about: &[u32]) -> bool {
        self.ladders[number].narrower(which).all(|(narrower, other)| {
            let contrast = |ladder: &Ladder| {
                let (wide, narrow) = (ladder.reading(which)?, ladder.reading(narrower)?);
                Some(wide.contrast(&narrow, self.sigma_mm).min(OWN))
            };
            let all = || about.iter().filter_map(|&other| contrast(&self.ladders[other as usize]));
            let count = all().count() as f64;
            // A sum of squared standard normal numbers has the mean `count` and the variance 2·`count`.
            let most = count + SURE * (2.0 * count).sqrt();
            reading.contrast(&other, self.sigma_mm) <= OWN && all().sum::<f64>() <= most
        })
    }

    /// A quartic over the surroundings of a window.
    fn quartic(&self, number: usize, window: &[[f64; 3]], about: &[u32]) -> Option<Fitted<15>> {
        let squared_mm2 = |&[u, v, _]: &[f64; 3]| u * u + v * v;
        let reach_mm2 = WIDER * WIDER * window.last().map(squared_mm2)?;
        let mut near = Vec::new();
        for &other in about {
            let offsets_mm = self.heights.offsets_mm(number, self.cells.of(other as usize));
            near.extend(offsets_mm.into_iter().filter(|offset| squared_mm2(offset) <= reach_mm2));
        }
        let most = QUARTIC_POINTS.max(2 * window.len());
        let step = near.len().div_ceil(most).max(1);
        let chosen: Vec<[f64; 3]> = near.into_iter().step_by(step).collect();
        Fitted::<15>::to(&chosen).filter(|_| chosen.len() >= QUARTIC_FEWEST)
    }
}

/// Kept points that are asked whether they agree, and whose points the quartic is fitted to: three rings of an even
/// cloud.
const ABOUT: usize = 37;
/// The square of the standard deviations by which a narrower reading may differ.
const OWN: f64 = 16.0;
/// The standard deviations by which the sum of those squares about a point may exceed its mean.
const SURE: f64 = 3.0;
/// The largest bias, as a share of the statistical uncertainty.
const BELOW: f64 = 0.25;
/// The radius of the surroundings over that of the window.
const WIDER: f64 = 2.5;
/// Points a quartic is fitted to, about: more where the window holds more than half of them.
const QUARTIC_POINTS: usize = 2000;
/// Twice as many as it has terms.
const QUARTIC_FEWEST: usize = 30;
