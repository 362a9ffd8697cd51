//! The threshold of grey values: Otsu's, and halfway between the modes of background and material.

/// What the values of a volume are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// The smallest finite value.
    pub low: f32,
    /// The largest finite value.
    pub high: f32,
    /// Whether there are no others.
    pub are_two: bool,
    /// Values that are not finite: nothing was measured there.
    pub missing: u64,
    /// Otsu's threshold (N. Otsu, IEEE Trans. Syst. Man Cybern. 9, 1979): the variance between background and material is largest.
    pub otsu: f64,
    /// The most frequent value below Otsu's threshold, background.
    pub background: f64,
    /// The most frequent value above it, material.
    pub material: f64,
}

impl Levels {
    /// The levels of a volume's values; `None` where no two of them differ.
    ///
    /// Values are counted in [`BINS`] classes of equal width from the smallest to the largest.
    pub fn new(values: &[f32]) -> Option<Levels> {
        let mut range = LevelRange::default();
        range.add(values);
        let mut counts = LevelCounts::new(range)?;
        values.iter().for_each(|&value| counts.add(value, 1));
        Some(counts.finish())
    }

    /// Halfway between background and material (ISO 50).
    pub fn iso_50(&self) -> f64 {
        f64::midpoint(self.background, self.material)
    }
}

/// The smallest and the largest of values that come in portions, such as slices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelRange {
    low: f32,
    high: f32,
    missing: u64,
}

impl Default for LevelRange {
    fn default() -> LevelRange {
        LevelRange { low: f32::INFINITY, high: f32::NEG_INFINITY, missing: 0 }
    }
}

impl LevelRange {
    /// Looks at more values.
    pub fn add(&mut self, values: &[f32]) {
        for &value in values {
            if value.is_finite() {
                (self.low, self.high) = (self.low.min(value), self.high.max(value));
            } else {
                self.missing += 1;
            }
        }
    }

    /// Whether a value was finite.
    pub fn has_finite(&self) -> bool {
        self.low <= self.high
    }
}

/// Levels of values that come in portions, once their range is known: each value is looked at twice.
#[derive(Clone, Debug)]
pub struct LevelCounts {
    range: LevelRange,
    counts: Vec<u64>,
    are_two: bool,
}

impl LevelCounts {
    /// Counts of nothing yet; `None` where no two values of the range differ.
    pub fn new(range: LevelRange) -> Option<LevelCounts> {
        let differ = range.low < range.high;
        differ.then(|| LevelCounts { range, counts: vec![0; BINS], are_two: true })
    }

    /// Counts a value of the range so many times. One that is not finite counts nowhere.
    pub fn add(&mut self, value: f32, times: u64) {
        let LevelRange { low, high, .. } = self.range;
        if !value.is_finite() || times == 0 {
            return;
        }
        let class = ((f64::from(value) - f64::from(low)) / self.width()) as usize;
        self.counts[class.min(BINS - 1)] += times;
        self.are_two &= value == low || value == high;
    }

    fn width(&self) -> f64 {
        (f64::from(self.range.high) - f64::from(self.range.low)) / BINS as f64
    }

    /// The levels of all values counted.
    pub fn finish(self) -> Levels {
        let LevelRange { low, high, missing } = self.range;
        let split = otsu_split(&self.counts);
        let at = |edge: f64| f64::from(low) + self.width() * edge;
        let mode = |classes: std::ops::Range<usize>| {
            // Of equal ones the first.
            let most = classes.max_by_key(|&class| (self.counts[class], std::cmp::Reverse(class)));
            at(most.unwrap_or(0) as f64 + 0.5)
        };
        Levels {
            low,
            high,
            are_two: self.are_two,
            missing,
            otsu: at(split as f64),
            background: mode(0..split),
            material: mode(split..BINS),
        }
    }
}

/// Classes that values are counted in.
pub const BINS: usize = 1024;

/// The first class of the upper part for which the variance between the parts is largest; of equal ones the middle.
fn otsu_split(counts: &[u64]) -> usize {
    let moment = |(class, &count): (usize, &u64)| class as f64 * count as f64;
    let total: f64 = counts.iter().map(|&count| count as f64).sum();
    let sum: f64 = counts.iter().enumerate().map(moment).sum();
    let (mut below, mut sum_below) = (0.0, 0.0);
    let (mut best, mut first, mut last) = (-1.0, 1, 1);
    for (class, &count) in counts.iter().enumerate().take(counts.len() - 1) {
        below += count as f64;
        sum_below += class as f64 * count as f64;
        let above = total - below;
        if below == 0.0 || above == 0.0 {
            continue;
        }
        let difference = sum_below / below - (sum - sum_below) / above;
        let variance = below * above * difference * difference;
        if variance > best * (1.0 + 1e-12) {
            (best, first, last) = (variance, class + 1, class + 1);
        } else if variance >= best * (1.0 - 1e-12) {
            last = class + 1;
        }
    }
    usize::midpoint(first, last)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_values_are_parted_in_the_middle() {
        let levels = Levels::new(&[0.0, 255.0, 255.0, f32::NAN, 0.0]).unwrap();
        assert!(levels.are_two && levels.missing == 1);
        assert!((levels.otsu - 127.5).abs() < 1.0 && (levels.iso_50() - 127.5).abs() < 1.0);
        assert_eq!(Levels::new(&[3.0, 3.0, f32::INFINITY]), None);
        assert_eq!(Levels::new(&[]), None);
    }

    /// Two normal classes around 100 and 200, 3 to 1: both thresholds lie between, ISO 50 in the middle.
    #[test]
    fn two_classes_are_parted_between_them() {
        let bell = |k: i32| (-f64::from(k * k) / 200.0).exp();
        let mut values = Vec::new();
        for k in -40..=40 {
            values.extend(std::iter::repeat_n(100.0 + k as f32, (300.0 * bell(k)) as usize));
            values.extend(std::iter::repeat_n(200.0 + k as f32, (100.0 * bell(k)) as usize));
        }
        let levels = Levels::new(&values).unwrap();
        assert!((levels.iso_50() - 150.0).abs() < 1.0, "{levels:?}");
        assert!(levels.otsu > 135.0 && levels.otsu < 165.0, "{levels:?}");
        assert!(!levels.are_two);
    }
}
