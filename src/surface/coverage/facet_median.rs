//! The distribution of figures over an area.
//!
//! Quantiles of many values are found without keeping or sorting them: a sample tells between which values each
//! one surely lies, and a pass over all sums up the area of what is below and keeps the few values within. The
//! result is exact: should one lie outside after all, another pass looks there. Sums are made over fixed chunks
//! and joined in their order: the result does not depend on how many threads there are.

use std::array;

use rayon::prelude::*;

use super::block::{BLOCK, Block, Row, total};
use crate::quantile::{value_holding, weight_of};

/// How a figure is distributed over an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Half of the area has at most this.
    pub median: f64,
    /// 99 % of the area has at most this.
    pub p99: f64,
    /// The largest value.
    pub max: f64,
}

/// A figure of triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Figure {
    Gap,
    Epsilon,
    /// The area in space of those inside as a whole that bridge nothing.
    Facet,
}

/// How many figures there are.
const FIGURES: usize = 3;

/// What is looked for: of which figure the value up to which there is which share of the area.
const SEARCHES: [(Figure, f64); 5] = [
    (Figure::Gap, 0.5),
    (Figure::Gap, 0.99),
    (Figure::Epsilon, 0.5),
    (Figure::Epsilon, 0.99),
    (Figure::Facet, 0.5),
];

/// The quantiles; `None` where nothing counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Quantiles {
    /// Of half of the area and of 99 %.
    pub(super) gaps_mm: Option<[f64; 2]>,
    pub(super) epsilons: Option<[f64; 2]>,
    /// The median.
    pub(super) facets_mm2: Option<f64>,
}

/// One triangle in a distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) gap_mm: f64,
    /// NaN where it is not known.
    pub(super) epsilon: f64,
    /// In space, inside the aperture.
    pub(super) area_mm2: f64,
    /// Whether it lies inside as a whole and bridges nothing.
    pub(super) is_facet: bool,
}

impl Entry {
    /// The value of a figure, if the triangle has one.
    fn value(&self, figure: Figure) -> Option<f64> {
        match figure {
            Figure::Gap => Some(self.gap_mm),
            Figure::Epsilon => Some(self.epsilon).filter(|epsilon| !epsilon.is_nan()),
            Figure::Facet => Some(self.area_mm2).filter(|_| self.is_facet),
        }
    }
}

/// From one value to another, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Window {
    low: f64,
    high: f64,
}

impl Window {
    const ALL: Window = Window { low: f64::NEG_INFINITY, high: f64::INFINITY };

    #[inline(always)]
    fn holds(&self, value: f64) -> bool {
        // Not a range's `contains`, of which the compiler makes branches.
        (self.low <= value) & (value <= self.high)
    }
}

/// Between which values quantiles are looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Windows([Window; SEARCHES.len()]);

impl Windows {
    /// Everywhere.
    pub(super) const ALL: Windows = Windows([Window::ALL; SEARCHES.len()]);

    /// Where they surely lie, but for a chance of one in thousands, as a sample of triangles tells.
    pub(super) fn about(sample: &[Entry]) -> Windows {
        let sorted: Vec<Vec<(f64, f64)>> = [Figure::Gap, Figure::Epsilon, Figure::Facet]
            .into_par_iter()
            .map(|figure| {
                let entry = |entry: &Entry| Some((entry.value(figure)?, entry.area_mm2));
                let mut entries: Vec<(f64, f64)> = sample.iter().filter_map(entry).collect();
                entries.sort_unstable_by(|left, right| left.0.total_cmp(&right.0));
                entries
            })
            .collect();
        Windows(SEARCHES.map(|(figure, share)| window(&sorted[figure as usize], share)))
    }
}

/// Where the quantile of a share of the area lies, as a sorted sample of values with their areas tells.
///
/// Drawn at random, a sample puts at a value a share of the area that deviates from the true one by
/// √Σaᵢ²(xᵢ - share)² / Σaᵢ, where xᵢ is 1 up to the value and 0 above; [`DEVIATIONS`] of that are surely enough.
fn window(sorted: &[(f64, f64)], share: f64) -> Window {
    let whole = weight_of(sorted);
    let reached = |share: f64| {
        let mut held = 0.0;
        sorted.iter().position(|(_, area)| {
            held += area;
            held >= share * whole
        })
    };
    let Some(at) = reached(share) else { return Window::ALL };
    let squares = |entries: &[(f64, f64)]| entries.iter().map(|(_, area)| area * area).sum::<f64>();
    let (up_to, above) = sorted.split_at(at + 1);
    let variance = (1.0 - share).powi(2) * squares(up_to) + share.powi(2) * squares(above);
    let margin = DEVIATIONS * variance.sqrt() / whole;
    // One more on either side: between two values of the sample there are others.
    let low = Some(share - margin).filter(|share| *share > 0.0).and_then(reached);
    let low = low.and_then(|low| low.checked_sub(1)).map(|low| sorted[low].0);
    let high = reached(share + margin).and_then(|high| sorted.get(high + 1)).map(|&(high, _)| high);
    Window { low: low.unwrap_or(f64::NEG_INFINITY), high: high.unwrap_or(f64::INFINITY) }
}

/// What is known of all triangles about the windows.
pub(super) struct Distribution {
    windows: Windows,
    /// All area, for each figure that of the triangles that have it.
    areas: [f64; FIGURES],
    /// The area below each window.
    below: [f64; SEARCHES.len()],
    within: [Within; SEARCHES.len()],
}

impl Distribution {
    pub(super) fn new(windows: Windows) -> Distribution {
        Distribution {
            windows,
            areas: [0.0; FIGURES],
            below: [0.0; SEARCHES.len()],
            within: array::from_fn(|_| Within::default()),
        }
    }

    /// Takes in a triangle. One without area does not count.
    pub(super) fn add(&mut self, entry: &Entry) {
        if entry.area_mm2 <= 0.0 {
            return;
        }
        for figure in [Figure::Gap, Figure::Epsilon, Figure::Facet] {
            if entry.value(figure).is_some() {
                self.areas[figure as usize] += entry.area_mm2;
            }
        }
        for (search, (figure, _)) in SEARCHES.into_iter().enumerate() {
            let window = self.windows.0[search];
            match entry.value(figure) {
                Some(value) if value < window.low => self.below[search] += entry.area_mm2,
                Some(value) if window.holds(value) => {
                    self.within[search].push(value, entry.area_mm2);
                }
                _ => {}
            }
        }
    }

    /// Takes in all triangles of a block that count, which are facets and whose ε is known; `area_mm2` is the sum
    /// of theirs.
    pub(super) fn add_block(&mut self, block: &Block, area_mm2: f64) {
        self.areas.iter_mut().for_each(|sum| *sum += area_mm2);
        let areas: &Row = &block.area_mm2;
        for (search, (figure, _)) in SEARCHES.into_iter().enumerate() {
            let window = self.windows.0[search];
            let values: &Row = match figure {
                Figure::Gap => &block.gap_mm,
                Figure::Epsilon => &block.epsilon,
                Figure::Facet => areas,
            };
            self.below[search] +=
                total(|row| if values[row] < window.low { areas[row] } else { 0.0 });
            let within = total(|row| if window.holds(values[row]) { 1.0 } else { 0.0 });
            if within > 0.0 {
                for row in 0..BLOCK {
                    if window.holds(values[row]) && areas[row] > 0.0 {
                        self.within[search].push(values[row], areas[row]);
                    }
                }
            }
        }
    }

    /// Takes in the triangles of another one, which come after these.
    pub(super) fn join(&mut self, after: Distribution) {
        self.areas.iter_mut().zip(after.areas).for_each(|(sum, area)| *sum += area);
        self.below.iter_mut().zip(after.below).for_each(|(sum, area)| *sum += area);
        let pairs = self.within.iter_mut().zip(after.within);
        pairs.for_each(|(all, more)| all.entries.extend(more.entries));
    }

    /// The quantiles.
    ///
    /// # Errors
    ///
    /// Where to look for them if one lies in no window.
    pub(super) fn quantiles(&mut self) -> Result<Quantiles, Windows> {
        let mut elsewhere = self.windows;
        let mut ends = [f64::NAN; SEARCHES.len()];
        for (search, (figure, share)) in SEARCHES.into_iter().enumerate() {
            let wanted = share * self.areas[figure as usize];
            if wanted <= 0.0 {
                continue;
            }
            let Window { low, high } = self.windows.0[search];
            let entries = &mut self.within[search].entries[..];
            let (below, within) = (self.below[search], weight_of(entries));
            if wanted <= below {
                elsewhere.0[search] = Window { low: f64::NEG_INFINITY, high: low };
            } else if wanted > below + within && high < f64::INFINITY {
                elsewhere.0[search] = Window { low: high, high: f64::INFINITY };
            } else if let Some(end) = value_holding(entries, wanted - below) {
                ends[search] = end;
            }
        }
        if elsewhere != self.windows {
            return Err(elsewhere);
        }
        let known = |search: usize| Some(ends[search]).filter(|end| !end.is_nan());
        let both = |first: usize| Some([known(first)?, known(first + 1)?]);
        Ok(Quantiles { gaps_mm: both(0), epsilons: both(2), facets_mm2: known(4) })
    }
}

/// Values with their areas, in the order in which they came. Where many are equal, as on a raster, they are
/// joined now and then.
#[derive(Default)]
struct Within {
    entries: Vec<(f64, f64)>,
    /// How many of them were left when equal ones were joined last.
    joined: usize,
}

impl Within {
    fn push(&mut self, value: f64, area: f64) {
        self.entries.push((value, area));
        if self.entries.len() >= 2 * self.joined + MANY {
            self.entries.sort_by(|left, right| left.0.total_cmp(&right.0));
            self.entries.dedup_by(|next, last| {
                let equal = next.0 == last.0;
                if equal {
                    last.1 += next.1;
                }
                equal
            });
            self.joined = self.entries.len();
        }
    }
}

/// A quantile lies within so many standard deviations of where a sample puts it.
const DEVIATIONS: f64 = 4.0;

/// So many values more are not looked through for equal ones.
const MANY: usize = 1 << 12;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::quantile::weighted_quantile;
    use crate::regressions::beside_source;

    fn entry(gap_mm: f64, area_mm2: f64) -> Entry {
        Entry { gap_mm, epsilon: f64::NAN, area_mm2, is_facet: false }
    }

    /// The quantiles of gaps, looked for within windows first; and how many passes that took.
    fn found(entries: &[Entry], mut windows: Windows) -> (Option<[f64; 2]>, usize) {
        for pass in 1.. {
            let mut distribution = Distribution::new(windows);
            entries.iter().for_each(|entry| distribution.add(entry));
            match distribution.quantiles() {
                Ok(quantiles) => {
                    assert_eq!((quantiles.epsilons, quantiles.facets_mm2), (None, None));
                    return (quantiles.gaps_mm, pass);
                }
                Err(elsewhere) => windows = elsewhere,
            }
        }
        unreachable!("a window without ends holds all")
    }

    #[test]
    fn what_has_no_figure_does_not_count_and_figures_do_not_meet() {
        let mut distribution = Distribution::new(Windows::ALL);
        for (gap_mm, epsilon, area_mm2, is_facet) in
            [(1.0, 0.1, 1.0, true), (2.0, f64::NAN, 3.0, true), (3.0, 0.3, 5.0, false)]
        {
            distribution.add(&Entry { gap_mm, epsilon, area_mm2, is_facet });
        }
        distribution.add(&Entry { gap_mm: 9.0, epsilon: 9.0, area_mm2: 0.0, is_facet: true });
        let expected = Quantiles {
            gaps_mm: Some([3.0, 3.0]),
            epsilons: Some([0.3, 0.3]),
            facets_mm2: Some(3.0),
        };
        assert_eq!(distribution.quantiles(), Ok(expected));
        assert_eq!(Distribution::new(Windows::ALL).quantiles(), Ok(Quantiles::default()));
    }

    #[test]
    fn a_sample_spares_what_is_far_from_the_quantiles() {
        // Multiples of the golden ratio, modulo 1.
        let value = |i: u32| (f64::from(i) * 0.618_033_988_749_894_9).fract();
        let entries: Vec<Entry> = (0..200_000).map(|i| entry(value(i), 1.0)).collect();
        let sample: Vec<Entry> = entries.iter().copied().step_by(31).collect();
        let windows = Windows::about(&sample);
        let mut distribution = Distribution::new(windows);
        entries.iter().for_each(|entry| distribution.add(entry));
        let kept: usize = distribution.within.iter().map(|within| within.entries.len()).sum();
        assert!(kept < 14_000, "{kept} for {windows:?}");
        let (gaps_mm, passes) = found(&entries, windows);
        assert_eq!((gaps_mm, passes), (found(&entries, Windows::ALL).0, 1));
        assert!(gaps_mm.is_some_and(|[median, p99]| (median - 0.5).abs() < 1e-5 && p99 > 0.989));
    }

    #[test]
    fn a_sample_of_something_else_costs_a_pass() {
        let entries: Vec<Entry> = (0..1000).map(|i| entry(f64::from(i), 1.0)).collect();
        for factor in [0.01, 100.0] {
            let sample: Vec<Entry> =
                entries.iter().map(|other| entry(factor * other.gap_mm, 1.0)).collect();
            assert_eq!(found(&entries, Windows::about(&sample)), (Some([499.0, 989.0]), 2));
        }
    }

    #[test]
    fn equal_values_are_joined() {
        let mut within = Within::default();
        (0..100_000).for_each(|i| within.push(f64::from(i % 7), 1.0));
        assert!(within.entries.len() < 2 * MANY);
        assert_eq!(weight_of(&within.entries), 100_000.0);
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn agrees_with_selection_whatever_the_sample(
            entries in prop::collection::vec((0_u8..20, 0_u8..9), 1..200),
            step in 1_usize..60,
        ) {
            let all: Vec<Entry> =
                entries.iter().map(|&(gap, area)| entry(gap.into(), area.into())).collect();
            let mut sound: Vec<(f64, f64)> = entries
                .iter()
                .map(|&(value, area)| (f64::from(value), f64::from(area)))
                .filter(|(_, area)| *area > 0.0)
                .collect();
            let sample: Vec<Entry> = all.iter().copied().step_by(step).collect();
            let (gaps_mm, passes) = found(&all, Windows::about(&sample));
            prop_assert!(passes <= 2);
            prop_assert_eq!(gaps_mm.map(|gaps| gaps[0]), weighted_quantile(&mut sound, 0.5));
            prop_assert_eq!(gaps_mm.map(|gaps| gaps[1]), weighted_quantile(&mut sound, 0.99));
        }
    }
}
