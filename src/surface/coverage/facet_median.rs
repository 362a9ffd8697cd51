//! The median of the areas of facets, by area.
//!
//! It is found without keeping or sorting them: a sample tells between which values it surely lies, and a pass over
//! all sums up the area of what is below and keeps the few values within. The
//! result is exact: should it lie outside after all, another pass looks there. Sums are made over fixed chunks
//! and joined in their order: the result does not depend on how many threads there are.

use asphera_geometry::quantile::{value_holding, weight_of};

use super::block::{Block, Row, total};

/// From one value to another, both included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window {
    low: f64,
    high: f64,
}

impl Window {
    pub(super) const ALL: Window = Window { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// Where the median surely lies, but for a chance of one in thousands, as the areas of a sample of facets tell.
    pub(super) fn about(mut sample_mm2: Vec<f64>) -> Window {
        sample_mm2.sort_unstable_by(f64::total_cmp);
        let entries: Vec<(f64, f64)> = sample_mm2.into_iter().map(|area| (area, area)).collect();
        window(&entries, HALF)
    }

    #[inline(always)]
    fn holds(&self, value: f64) -> bool {
        // Not a range's `contains`, of which the compiler makes branches.
        (self.low <= value) & (value <= self.high)
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

/// Data known of all facets about a window.
pub(super) struct Distribution {
    window: Window,
    area_mm2: f64,
    /// The area below the window.
    below_mm2: f64,
    within: Within,
}

impl Distribution {
    pub(super) fn new(window: Window) -> Distribution {
        Distribution { window, area_mm2: 0.0, below_mm2: 0.0, within: Within::default() }
    }

    /// Takes in a facet. One without area does not count.
    pub(super) fn add(&mut self, area_mm2: f64) {
        if area_mm2 <= 0.0 {
            return;
        }
        self.area_mm2 += area_mm2;
        if area_mm2 < self.window.low {
            self.below_mm2 += area_mm2;
        } else if self.window.holds(area_mm2) {
            self.within.push(area_mm2, area_mm2);
        }
    }

    /// Takes in all triangles of a block that count, which are facets; `area_mm2` is the sum of theirs.
    pub(super) fn add_block(&mut self, block: &Block, area_mm2: f64) {
        self.area_mm2 += area_mm2;
        let (areas, window): (&Row, Window) = (&block.area_mm2, self.window);
        self.below_mm2 += total(|row| if areas[row] < window.low { areas[row] } else { 0.0 });
        let within = total(|row| if window.holds(areas[row]) { 1.0 } else { 0.0 });
        if within > 0.0 {
            for &area in areas.iter().filter(|&&area| window.holds(area) && area > 0.0) {
                self.within.push(area, area);
            }
        }
    }

    /// Takes in the facets of another one, which come after these.
    pub(super) fn join(&mut self, after: Distribution) {
        self.area_mm2 += after.area_mm2;
        self.below_mm2 += after.below_mm2;
        self.within.entries.extend(after.within.entries);
    }

    /// The median; `None` without facets.
    ///
    /// # Errors
    ///
    /// Where to look for it if it does not lie in the window.
    pub(super) fn median(&mut self) -> Result<Option<f64>, Window> {
        let wanted = HALF * self.area_mm2;
        if wanted <= 0.0 {
            return Ok(None);
        }
        let Window { low, high } = self.window;
        let entries = &mut self.within.entries[..];
        let (below, within) = (self.below_mm2, weight_of(entries));
        if wanted <= below {
            Err(Window { low: f64::NEG_INFINITY, high: low })
        } else if wanted > below + within && high < f64::INFINITY {
            Err(Window { low: high, high: f64::INFINITY })
        } else {
            Ok(value_holding(entries, wanted - below))
        }
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

/// Half of the area.
const HALF: f64 = 0.5;

/// A quantile lies within so many standard deviations of where a sample puts it.
const DEVIATIONS: f64 = 4.0;

/// So many values more are not looked through for equal ones.
const MANY: usize = 1 << 12;

#[cfg(test)]
mod tests {
    use asphera_geometry::quantile::weighted_quantile;
    use proptest::prelude::*;

    use super::*;
    use crate::regressions::beside_source;

    /// The median looked for within a window first; and how many passes that took.
    fn found(areas: &[f64], mut window: Window) -> (Option<f64>, usize) {
        for pass in 1.. {
            let mut distribution = Distribution::new(window);
            areas.iter().for_each(|&area| distribution.add(area));
            match distribution.median() {
                Ok(median) => return (median, pass),
                Err(elsewhere) => window = elsewhere,
            }
        }
        unreachable!("a window without ends holds all")
    }

    #[test]
    fn a_sample_spares_what_is_far_from_the_median() {
        // Multiples of the golden ratio, modulo 1.
        let value = |i: u32| (f64::from(i) * 0.618_033_988_749_894_9).fract();
        let areas: Vec<f64> = (0..200_000).map(|i| 1.0 + value(i)).collect();
        let window = Window::about(areas.iter().copied().step_by(31).collect());
        let mut distribution = Distribution::new(window);
        areas.iter().for_each(|&area| distribution.add(area));
        let kept = distribution.within.entries.len();
        assert!(kept < 14_000, "{kept} for {window:?}");
        let (median, passes) = found(&areas, window);
        assert_eq!((median, passes), (found(&areas, Window::ALL).0, 1));
    }

    #[test]
    fn a_sample_of_something_else_costs_a_pass() {
        let areas: Vec<f64> = (1..=1000).map(f64::from).collect();
        for factor in [0.01, 100.0] {
            let window = Window::about(areas.iter().map(|area| factor * area).collect());
            assert_eq!(found(&areas, window), (Some(707.0), 2));
        }
    }

    #[test]
    fn equal_values_are_joined() {
        let mut within = Within::default();
        (0..100_000).for_each(|i| within.push(f64::from(i % 7), 1.0));
        assert!(within.entries.len() < 2 * MANY);
        assert_eq!(weight_of(&within.entries), 100_000.0);
        assert_eq!(found(&[], Window::ALL), (None, 1));
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn agrees_with_selection_whatever_the_sample(
            areas in prop::collection::vec(0_u8..20, 1..200),
            step in 1_usize..60,
        ) {
            let areas: Vec<f64> = areas.into_iter().map(f64::from).collect();
            let mut sound: Vec<(f64, f64)> =
                areas.iter().filter(|area| **area > 0.0).map(|&area| (area, area)).collect();
            let window = Window::about(areas.iter().copied().step_by(step).collect());
            let (median, passes) = found(&areas, window);
            prop_assert!(passes <= 2);
            prop_assert_eq!(median, weighted_quantile(&mut sound, 0.5));
        }
    }
}
