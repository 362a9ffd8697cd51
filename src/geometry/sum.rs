//! Sums whose rounding error does not grow with the number of terms.

/// A running sum with the compensation of A. Neumaier, ZAMM 54 (1974) 39-51,
/// doi:10.1002/zamm.19740540106. What each addition loses is found without asking which term is larger
/// (D. E. Knuth, The Art of Computer Programming 2, section 4.2.2, theorem B).
#[derive(Clone, Copy, Debug, Default)]
pub struct Sum {
    rounded: f64,
    lost: f64,
}

impl Sum {
    /// Adds a term.
    #[inline(always)]
    pub fn add(&mut self, term: f64) {
        let sum = self.rounded + term;
        let of_term = sum - self.rounded;
        self.lost += (self.rounded - (sum - of_term)) + (term - of_term);
        self.rounded = sum;
    }

    /// Adds what another sum has come to, with its compensation.
    #[inline]
    pub fn join(&mut self, other: Sum) {
        self.add(other.rounded);
        self.add(other.lost);
    }

    /// Its value.
    #[inline]
    pub fn total(self) -> f64 {
        self.rounded + self.lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_keeps_what_a_plain_one_loses() {
        let mut sum = Sum::default();
        [1.0, 1e100, 1.0, -1e100].into_iter().for_each(|term| sum.add(term));
        assert_eq!(sum.total(), 2.0);
    }
}
