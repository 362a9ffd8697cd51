//! Quantile of weighted values by selection, without sorting them all.

/// The smallest value such that the values up to it hold at least `share` (0 to 1) of the total
/// weight; `None` if there are no values. Reorders `entries` (value, weight).
///
/// Weights must not be negative. Values are ordered by [`f64::total_cmp`]. Halves the entries by
/// selection and goes on with the half the share ends in: linear time on average.
pub fn weighted_quantile(entries: &mut [(f64, f64)], share: f64) -> Option<f64> {
    let wanted = share * weight_of(entries);
    value_holding(entries, wanted)
}

/// The smallest value such that the values up to it hold a weight of at least `wanted`, or the largest if all
/// do not; `None` if there are no values. As [`weighted_quantile`] otherwise.
pub fn value_holding(mut entries: &mut [(f64, f64)], mut wanted: f64) -> Option<f64> {
    while entries.len() > 1 {
        let middle = entries.len() / 2;
        entries.select_nth_unstable_by(middle, |left, right| left.0.total_cmp(&right.0));
        let (lower, upper) = entries.split_at_mut(middle);
        let below = weight_of(lower);
        entries = if below >= wanted {
            lower
        } else {
            wanted -= below;
            upper
        };
    }
    entries.first().map(|&(value, _)| value)
}

/// The sum of all weights.
pub fn weight_of(entries: &[(f64, f64)]) -> f64 {
    entries.iter().map(|&(_, weight)| weight).sum()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::regressions::beside_source;

    /// By sorting; the weights are integers, so that all sums are exact in any order.
    fn by_sorting(entries: &[(f64, f64)], share: f64) -> Option<f64> {
        let mut sorted = entries.to_vec();
        sorted.sort_by(|left, right| left.0.total_cmp(&right.0));
        let wanted = share * weight_of(&sorted);
        let mut held = 0.0;
        sorted.into_iter().find_map(|(value, weight)| {
            held += weight;
            (held >= wanted).then_some(value)
        })
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn agrees_with_sorting(
            entries in prop::collection::vec((0_u8..20, 1_u8..9), 0..200),
            eighths in 1_u8..=8,
        ) {
            let entries: Vec<(f64, f64)> =
                entries.into_iter().map(|(value, weight)| (value.into(), weight.into())).collect();
            let share = f64::from(eighths) / 8.0;
            prop_assert_eq!(
                weighted_quantile(&mut entries.clone(), share),
                by_sorting(&entries, share)
            );
        }
    }

    #[test]
    fn a_heavy_entry_outweighs_many_light_ones() {
        let mut entries: Vec<(f64, f64)> = (0..100).map(|i| (f64::from(i), 0.01)).collect();
        entries.push((-1.0, 999.0));
        assert_eq!(weighted_quantile(&mut entries, 0.99), Some(-1.0));
        assert_eq!(weighted_quantile(&mut [], 0.99), None);
        assert_eq!(weighted_quantile(&mut [(f64::INFINITY, 1.0)], 0.99), Some(f64::INFINITY));
    }
}
