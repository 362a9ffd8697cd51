//! Median and median absolute deviation of distances that are known by classes.

/// Points that lie evenly over a short interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Evenly {
    pub(crate) middle: f64,
    pub(crate) half: f64,
    pub(crate) count: f64,
}

/// The median of the absolute deviations from the median. 0 without points.
///
/// The points are laid on a net of [`STEPS`] steps, which is made wider or finer until it suits them: to about a
/// thousandth of what is found, if the intervals are short beside it. `O(intervals + STEPS)`.
pub(crate) fn median_deviation(all: &[Evenly]) -> f64 {
    let total: f64 = all.iter().map(|one| one.count).sum();
    if total <= 0.0 {
        return 0.0;
    }
    let mut reach = FIRST_REACH;
    let mut found = 0.0;
    for _ in 0..TRIES {
        let shares = Shares::of(all, reach);
        let Some(median) = shares.place_of(total / 2.0) else {
            reach *= WIDER;
            continue;
        };
        let Some(deviation) = shares.deviation(median, total / 2.0) else {
            reach *= WIDER;
            continue;
        };
        found = deviation;
        let step = 2.0 * reach / STEPS as f64;
        if deviation > COARSE * step {
            break;
        }
        // A net that is moved to the median would be finer yet; distances of a fit lie about none.
        if median.abs() > reach / WIDER {
            break;
        }
        reach /= WIDER;
    }
    found
}

/// How many points lie below each node of a net.
struct Shares {
    reach: f64,
    step: f64,
    below: Vec<f64>,
}

impl Shares {
    fn of(all: &[Evenly], reach: f64) -> Shares {
        let step = 2.0 * reach / STEPS as f64;
        let mut below_all = 0.0;
        // Where the density rises and falls, later its sum.
        let mut rises = vec![0.0; STEPS + 2];
        let mut rise = |at: f64, by: f64| {
            let place = ((at + reach) / step).clamp(0.0, STEPS as f64);
            let node = place as usize;
            let share = place - node as f64;
            rises[node] += by * (1.0 - share);
            rises[node + 1] += by * share;
        };
        for one in all {
            let half = one.half.max(step / 2.0);
            let (low, high) = (one.middle - half, one.middle + half);
            let density = one.count / (high - low);
            below_all += density * (high.min(-reach) - low).max(0.0);
            if high > -reach && low < reach {
                rise(low.max(-reach), density);
                rise(high.min(reach), -density);
            }
        }
        let (mut density, mut below) = (0.0, below_all);
        let sums = rises[..=STEPS].iter().map(|rise| {
            let here = below;
            density += rise;
            below += density * step;
            here
        });
        Shares { reach, step, below: sums.collect() }
    }

    /// Points below a place.
    fn below(&self, place: f64) -> f64 {
        let at = ((place + self.reach) / self.step).clamp(0.0, STEPS as f64);
        let node = (at as usize).min(STEPS - 1);
        let share = at - node as f64;
        self.below[node] * (1.0 - share) + self.below[node + 1] * share
    }

    /// The place below which so many points lie; `None` if it is not on the net.
    fn place_of(&self, count: f64) -> Option<f64> {
        let node = self.below.partition_point(|below| *below < count);
        if node == 0 || node > STEPS {
            return None;
        }
        let (low, high) = (self.below[node - 1], self.below[node]);
        Some((node as f64 - (high - count) / (high - low)) * self.step - self.reach)
    }

    /// The distance from a place within which so many points lie; `None` if that reaches beyond the net.
    fn deviation(&self, from: f64, count: f64) -> Option<f64> {
        let within = |distance: f64| self.below(from + distance) - self.below(from - distance);
        let (mut low, mut high) = (0.0, self.reach - from.abs());
        if within(high) < count {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, high);
            if within(middle) < count { low = middle } else { high = middle }
        }
        Some(high)
    }
}

/// Steps of the net.
const STEPS: usize = 2048;
/// Its first reach in scales.
const FIRST_REACH: f64 = 8.0;
/// By what it is made wider or finer.
const WIDER: f64 = 8.0;
/// What is found must be so many steps.
const COARSE: f64 = 32.0;
/// Nets that are tried.
const TRIES: usize = 24;
/// Halvings of an interval down to rounding.
const HALVINGS: usize = 50;

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the deviations themselves, of scales from far below to far above the first net.
    #[test]
    fn classes_tell_what_the_points_tell() {
        for scale in [1e-4, 0.02, 1.0, 7.0, 3e4] {
            // A sum of three uniform numbers, by quantiles of an even lattice.
            let unit = |i: usize, base: f64| (i as f64 * base).fract() - 0.5;
            let values: Vec<f64> = (0..20_000)
                .map(|i| unit(i, 0.754_877_666) + unit(i, 0.569_840_291) + unit(i, 0.341_640_786))
                .map(|value| scale * (value + 0.1))
                .collect();
            let width = scale / 8.0;
            let mut classes = std::collections::BTreeMap::<i64, Vec<f64>>::new();
            for value in &values {
                classes.entry((value / width).floor() as i64).or_default().push(*value);
            }
            let evenly: Vec<Evenly> = classes
                .values()
                .map(|values| Evenly {
                    middle: values.iter().sum::<f64>() / values.len() as f64,
                    half: width / 2.0,
                    count: values.len() as f64,
                })
                .collect();
            let exact = crate::fit::robust::scale(&values) / 1.482_602_218_505_602;
            let found = median_deviation(&evenly);
            eprintln!("{scale:e}: {found:e}, {exact:e}");
            assert!((found / exact - 1.0).abs() < 4e-3, "{scale:e}: {found:e}, {exact:e}");
        }
    }

    #[test]
    fn few_points_and_none() {
        assert_eq!(median_deviation(&[]), 0.0);
        let at = |middle: f64, count: f64| Evenly { middle, half: 0.0, count };
        // Two thirds at one place: no deviation but the step of the finest net.
        assert!(median_deviation(&[at(0.0, 2.0), at(1.0, 1.0)]) < 1e-12);
        let found = median_deviation(&[at(-1.0, 3.0), at(0.0, 1.0), at(1.0, 3.0)]);
        assert!((found - 1.0).abs() < 0.02, "{found}");
    }
}
