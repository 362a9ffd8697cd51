//! How far noise goes: normal noise, and noise whose tails were measured to be longer.

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

/// The tails of the noise of single samples: between those of a normal distribution and those of Laplace's.
///
/// The size t that is exceeded with a probability p is taken as (1 - s)·z(p) + s·l(p), in units of the standard
/// deviation that half of the sizes tell, where z is that of a normal distribution and l that of Laplace's. Both are 0.6745
/// at the median. The share s comes from the sizes that one in 20 to one in 1000 samples exceed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tail {
    share: f64,
    /// The same by the fourth cumulant, which means go by.
    of_means: f64,
}

impl Tail {
    /// Normal noise.
    pub(super) const NORMAL: Tail = Tail { share: 0.0, of_means: 0.0 };

    /// Measures the tails of sizes. They come by pieces of the surface, whose middle one counts, so that defects of some
    /// of them do not.
    pub(super) fn of(mut pieces: Vec<Vec<f64>>) -> Tail {
        let most = pieces.iter().map(Vec::len).max().unwrap_or(0);
        pieces.retain(|sizes| !sizes.is_empty() && 4 * sizes.len() >= most);
        pieces.iter_mut().for_each(|sizes| sizes.sort_unstable_by(f64::total_cmp));
        let all: usize = pieces.iter().map(Vec::len).sum();
        let middle = |probability: f64| {
            let mut at: Vec<f64> =
                pieces.iter().map(|sizes| quantile(sizes, 1.0 - probability)).collect();
            let middle = at.len() / 2;
            *at.select_nth_unstable_by(middle, f64::total_cmp).1
        };
        let least = pieces.iter().map(Vec::len).min().unwrap_or(0) as f64;
        let mut share = 0.0_f64;
        if all < SAMPLES_MIN {
            return Tail::NORMAL;
        }
        let unit = NORMAL * middle(0.5);
        if unit <= 0.0 {
            return Tail::NORMAL;
        }
        for probability in TAILS.into_iter().filter(|probability| probability * least >= BEYOND) {
            let (normal, laplace) = (two_sided(probability), laplace(probability));
            let found = (middle(probability) / unit - normal) / (laplace - normal);
            // The deviation of the quantile and of the unit, as normal noise has them.
            let density = 2.0 * (-0.5 * normal * normal).exp() / std::f64::consts::TAU.sqrt();
            let by_count = (probability * (1.0 - probability)).sqrt() / density;
            let deviation = MEDIAN_LOSS * by_count.hypot(1.17 * normal)
                / (all as f64).sqrt()
                / (laplace - normal);
            if found > SURE * deviation {
                share = share.max(found + SURE * deviation);
            }
        }
        Tail { share, of_means: share }
    }

    /// The same of samples that had the mean of their cell of six taken off. That leaves 0.7 of their fourth cumulant, and
    /// brings those that are far out by 0.91 of the way.
    pub(super) fn of_cells(pieces: Vec<Vec<f64>>) -> Tail {
        let Tail { share, .. } = Tail::of(pieces);
        Tail { share: share / FAR_LEFT, of_means: share / EXCESS_LEFT }
    }

    /// The size of a mean of so many samples, in its standard deviations, that noise exceeds with a probability of 1e-300
    /// to 1. Of more than one sample by the fourth cumulant (E. A. Cornish, R. A. Fisher, Rev. Inst. Int. Stat. 5 (1938)
    /// 307-320), which is 3 of Laplace's distribution.
    pub(super) fn threshold(&self, probability: f64, samples: f64) -> f64 {
        let normal = two_sided(probability);
        if samples > 1.0 {
            return normal + self.of_means * (normal.powi(3) - 3.0 * normal) / (8.0 * samples);
        }
        normal + self.share * (laplace(probability) - normal)
    }
}

/// Room for the sizes in each piece of a surface by which tails are measured.
pub(super) fn pieces() -> Vec<Vec<f64>> {
    vec![Vec::new(); PIECES * PIECES]
}

/// The piece that a cell of a grid lies in.
pub(super) fn piece_of([column, row]: [usize; 2], [columns, rows]: [usize; 2]) -> usize {
    row * PIECES / rows * PIECES + column * PIECES / columns
}

/// By how many standard deviations, as its median tells them, Laplace's distribution is exceeded.
fn laplace(probability: f64) -> f64 {
    -probability.ln() / (NORMAL * std::f64::consts::LN_2)
}

/// A quantile of ascending sizes.
fn quantile(sizes: &[f64], share: f64) -> f64 {
    let at = share * (sizes.len() - 1) as f64;
    let below = at as usize;
    let above = (below + 1).min(sizes.len() - 1);
    sizes[below] + (at - below as f64) * (sizes[above] - sizes[below])
}

/// Pieces along a side of the surface.
const PIECES: usize = 4;
/// Probabilities at which tails are measured.
const TAILS: [f64; 3] = [0.05, 0.01, 0.001];
/// With n = 6: (1 - 1/n) / √(1 - 1/n).
const FAR_LEFT: f64 = 0.913;
/// With n = 6: ((1 - 1/n)⁴ + (n - 1)/n⁴) / (1 - 1/n)².
const EXCESS_LEFT: f64 = 0.7;
/// Sizes beyond a quantile that each piece needs.
const BEYOND: f64 = 3.0;
/// Fewer sizes tell nothing of tails.
const SAMPLES_MIN: usize = 2000;
/// Deviations from which on a tail is longer than normal.
const SURE: f64 = 3.0;
/// Deviation of a median of pieces over that of their mean.
const MEDIAN_LOSS: f64 = 1.25;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curvature::truth::Random;

    fn pieces(of: impl Fn(&mut Random) -> f64) -> Vec<Vec<f64>> {
        let mut random = Random::new(5);
        (0..16).map(|_| (0..2000).map(|_| of(&mut random).abs()).collect()).collect()
    }

    #[test]
    fn tails_are_measured() {
        let normal = Tail::of(pieces(Random::normal));
        assert_eq!(normal.threshold(1e-8, 1.0), two_sided(1e-8));
        let long = Tail::of(pieces(|random| -random.unit().max(1e-12).ln()));
        // Laplace's distribution has ln 1e8 scales, of which its median is ln 2.
        let truth = 1e8_f64.ln() / (NORMAL * std::f64::consts::LN_2);
        assert!((long.threshold(1e-8, 1.0) / truth - 1.0).abs() < 0.08);
        // The mean of 7: by the saddle point of its cumulants e-8 lies between 7.5 and 8.5 deviations.
        let mean = long.threshold(2e-8, 7.0);
        assert!((7.5..8.7).contains(&mean), "{mean}");
    }

    /// Cells of six samples of Laplace's noise less their mean. Of means of 7 the truth is 5.98 deviations, by the saddle point of
    /// their cumulants; of single samples it is 9.41 deviations, which are 1.21 times what the sizes tell.
    #[test]
    fn tails_of_cells_are_those_of_samples() {
        let mut random = Random::new(6);
        let mut laplace = || {
            let unit = random.unit() - 0.5;
            (-(1.0 - 2.0 * unit.abs()).ln() / 2.0_f64.sqrt()).copysign(unit)
        };
        let mut cell = || {
            let samples: [f64; 6] = std::array::from_fn(|_| laplace());
            let mean = samples.iter().sum::<f64>() / 6.0;
            samples.map(|sample| (sample - mean).abs() / (5.0_f64 / 6.0).sqrt())
        };
        let pieces = (0..16).map(|_| (0..2000).flat_map(|_| cell()).collect()).collect();
        let tail = Tail::of_cells(pieces);
        let mean = tail.threshold(1.67e-6, 7.0);
        assert!((5.98..6.6).contains(&mean), "{mean}");
        let single = tail.threshold(1.67e-6, 1.0);
        assert!((9.41..9.41 * 1.21).contains(&single), "{single}");
    }

    /// A third of the pieces has defects.
    #[test]
    fn defects_are_no_tails() {
        let mut pieces = pieces(Random::normal);
        pieces.iter_mut().step_by(3).for_each(|piece| piece[..200].fill(20.0));
        assert!(Tail::of(pieces).threshold(1e-8, 1.0) < 1.03 * two_sided(1e-8));
    }

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
