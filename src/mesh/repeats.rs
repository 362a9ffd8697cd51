//! Several measurements in one place.

/// Mean and spread of the heights measured in one place, by the method of B. P. Welford,
/// Technometrics 4 (1962) 419-420, doi:10.1080/00401706.1962.10490022.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeats {
    count: u64,
    mean_mm: f64,
    /// Sum of the squared differences from the mean.
    squares_mm2: f64,
    least_mm: f64,
    greatest_mm: f64,
}

impl Repeats {
    pub(crate) fn first(z_mm: f64) -> Repeats {
        Repeats { count: 1, mean_mm: z_mm, squares_mm2: 0.0, least_mm: z_mm, greatest_mm: z_mm }
    }

    pub(crate) fn add(&mut self, z_mm: f64) {
        self.count += 1;
        let before_mm = z_mm - self.mean_mm;
        self.mean_mm += before_mm / self.count as f64;
        self.squares_mm2 += before_mm * (z_mm - self.mean_mm);
        self.least_mm = self.least_mm.min(z_mm);
        self.greatest_mm = self.greatest_mm.max(z_mm);
    }

    /// How many measurements, the vertex's own included: at least two.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean height in mm.
    pub fn mean_mm(&self) -> f64 {
        self.mean_mm
    }

    /// Sample standard deviation of the heights in mm, with n - 1 in the denominator.
    pub fn spread_mm(&self) -> f64 {
        (self.squares_mm2 / (self.count - 1) as f64).sqrt()
    }

    /// Greatest less least height in mm.
    pub fn range_mm(&self) -> f64 {
        self.greatest_mm - self.least_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_spread_of_a_known_sample() {
        let mut repeats = Repeats::first(2.0);
        [4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0].into_iter().for_each(|z| repeats.add(z));
        assert_eq!((repeats.count(), repeats.mean_mm(), repeats.range_mm()), (8, 5.0, 7.0));
        assert!((repeats.spread_mm() - (32.0_f64 / 7.0).sqrt()).abs() < 1e-15);
    }
}
