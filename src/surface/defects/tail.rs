//! How far normal noise goes.

/// Standard deviation of a normal distribution over the median of its sizes.
pub(super) const NORMAL: f64 = 1.482_602_218_505_602;

/// By how many standard deviations normal noise is exceeded, to either side, with a probability of
/// 1e-300 to 1, to 5e-4 (M. Abramowitz, I. A. Stegun, Handbook of Mathematical Functions, 1964,
/// formula 26.2.23).
pub(super) fn two_sided(probability: f64) -> f64 {
    let t = (-2.0 * (0.5 * probability).ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    t - above / below
}

/// The standard deviation that half of the sizes of values tell, if they are normal; `None` without
/// values.
pub(super) fn scale(sizes: &mut [f64]) -> Option<f64> {
    if sizes.is_empty() {
        return None;
    }
    let middle = sizes.len() / 2;
    Some(NORMAL * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of the normal distribution.
    #[test]
    fn known_quantiles() {
        for (probability, deviations) in [
            (0.317_310_507_9, 1.0),
            (0.05, 1.959_963_985),
            (2.699_796e-3, 3.0),
            (5.733_031e-7, 5.0),
            (1.973_175e-9, 6.0),
        ] {
            let found = two_sided(probability);
            assert!((found - deviations).abs() < 5e-4, "{found} {deviations}");
        }
    }

    #[test]
    fn the_scale_of_nothing_is_unknown() {
        assert_eq!(scale(&mut []), None);
        assert_eq!(scale(&mut [2.0, 1.0, 100.0]), Some(2.0 * NORMAL));
    }
}
