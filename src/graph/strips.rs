//! Strips: a partition of the range of a function into half-open intervals, of which the last is closed.

use thiserror::Error;

/// Intervals J₁ … J_n of the range of a function. Interval i holds the values from bound i up to, but without, bound
/// i + 1; the last one holds its upper bound, too.
#[derive(Clone, Debug, PartialEq)]
pub struct Strips {
    /// Ascending, one more than strips.
    bounds: Vec<f64>,
}

impl Strips {
    /// `count` strips of equal width from `low` to `high`; one where `low` is `high`.
    ///
    /// # Errors
    ///
    /// No strip, or more than [`MOST_STRIPS`]; bounds that are not finite or out of order.
    pub fn uniform(low: f64, high: f64, count: usize) -> Result<Strips, StripsError> {
        if count == 0 || count > MOST_STRIPS {
            return Err(StripsError::Count { found: count });
        }
        if !(low <= high && (high - low).is_finite()) {
            return Err(StripsError::Range { low, high });
        }
        let share = |at: usize| low + (high - low) * (at as f64 / count as f64);
        let mut bounds: Vec<f64> = (0..count).map(share).collect();
        bounds.push(high);
        Ok(Strips::of_bounds(bounds))
    }

    /// Strips between given values, from `low` to `high`: values beyond these are passed over.
    ///
    /// # Errors
    ///
    /// Values that are not finite; more than [`MOST_STRIPS`] strips; bounds as in [`Strips::uniform`].
    pub fn between(low: f64, high: f64, values: &[f64]) -> Result<Strips, StripsError> {
        let mut bounds = Strips::uniform(low, high, 1)?.bounds;
        if values.len() >= MOST_STRIPS {
            return Err(StripsError::Count { found: values.len() + 1 });
        }
        if let Some(&value) = values.iter().find(|value| !value.is_finite()) {
            return Err(StripsError::Value { value });
        }
        bounds.extend(values.iter().filter(|&&value| low < value && value < high));
        bounds.sort_by(f64::total_cmp);
        Ok(Strips::of_bounds(bounds))
    }

    /// `count` strips that hold equally many of `values`, as far as equal values allow; n·log n time.
    ///
    /// # Errors
    ///
    /// No values; values that are not finite; a count as in [`Strips::uniform`].
    pub fn equal_count(values: &[f64], count: usize) -> Result<Strips, StripsError> {
        let mut sorted = values.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let (Some(&low), Some(&high)) = (sorted.first(), sorted.last()) else {
            return Err(StripsError::Range { low: f64::NAN, high: f64::NAN });
        };
        let mut bounds = Strips::uniform(low, high, 1)?.bounds;
        Strips::uniform(low, high, count)?;
        let quantile = |at: usize| sorted[(at * sorted.len()) / count];
        bounds.extend((1..count).map(quantile).filter(|&value| low < value && value < high));
        bounds.sort_by(f64::total_cmp);
        Ok(Strips::of_bounds(bounds))
    }

    /// Every strip divided into `parts` of equal width, as far as numbers allow.
    ///
    /// # Errors
    ///
    /// No part; more than [`MOST_STRIPS`] strips.
    pub fn divided(&self, parts: usize) -> Result<Strips, StripsError> {
        let found = self.count().saturating_mul(parts);
        if found == 0 || found > MOST_STRIPS {
            return Err(StripsError::Count { found });
        }
        let mut bounds = Vec::with_capacity(found + 1);
        for ends in self.bounds.windows(2) {
            let share = |part: usize| ends[0] + (ends[1] - ends[0]) * (part as f64 / parts as f64);
            bounds.extend((0..parts).map(share));
        }
        bounds.push(self.bounds[self.count()]);
        Ok(Strips::of_bounds(bounds))
    }

    /// Strips of ascending bounds, of which equal ones count once.
    fn of_bounds(mut bounds: Vec<f64>) -> Strips {
        let high = bounds[bounds.len() - 1];
        bounds.dedup();
        if bounds.len() == 1 {
            bounds.push(high);
        }
        Strips { bounds }
    }

    /// The bounds, ascending, one more than strips.
    pub fn bounds(&self) -> &[f64] {
        &self.bounds
    }

    /// How many strips there are: 1 or more.
    pub fn count(&self) -> usize {
        self.bounds.len() - 1
    }

    /// The strip of a value; of values beyond the range the first or the last. Constant time for equal widths.
    pub fn strip_of(&self, value: f64) -> usize {
        let last = self.count() - 1;
        let (low, high) = (self.bounds[0], self.bounds[last + 1]);
        let guess = (value - low) / (high - low) * (last + 1) as f64;
        // NaN, of a range of length 0, becomes 0.
        let guess = (guess as usize).min(last);
        let holds = |strip: usize| {
            (strip == 0 || self.bounds[strip] <= value)
                && (strip == last || value < self.bounds[strip + 1])
        };
        let near = [guess, guess.saturating_sub(1), (guess + 1).min(last)];
        near.into_iter()
            .find(|&strip| holds(strip))
            .unwrap_or_else(|| self.bounds[1..=last].partition_point(|&bound| bound <= value))
    }
}

/// Reason why strips cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum StripsError {
    /// Too few or too many.
    #[error("{found} strips: expected 1 to {MOST_STRIPS}; take fewer, or a larger tau")]
    Count {
        /// How many were asked for.
        found: usize,
    },
    /// A range that is none.
    #[error("strips from {low} to {high}: expected a finite range; check the function's values")]
    Range {
        /// The lower bound.
        low: f64,
        /// The upper bound.
        high: f64,
    },
    /// A bound that is not finite.
    #[error("a strip begins at {value}: expected a finite number")]
    Value {
        /// The bound.
        value: f64,
    },
}

/// So many strips are made at most.
pub const MOST_STRIPS: usize = 1_000_000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_lies_between_the_bounds_of_its_strip() {
        for count in [1, 2, 3, 7, 1000] {
            let strips = Strips::uniform(-0.1, 0.7, count).unwrap();
            assert_eq!(strips.count(), count);
            for at in 0..=4000 {
                let value = -0.1 + 0.8 * f64::from(at) / 4000.0;
                let strip = strips.strip_of(value);
                let is_last = strip + 1 == count;
                assert!(strips.bounds()[strip] <= value);
                assert!(value < strips.bounds()[strip + 1] || is_last);
            }
            let bounds = strips.bounds().to_vec();
            for (at, bound) in bounds.iter().enumerate() {
                assert_eq!(strips.strip_of(*bound), at.min(count - 1));
            }
        }
    }

    #[test]
    fn given_values_part_the_range_and_equal_counts_hold_equally_many() {
        let strips = Strips::between(0.0, 10.0, &[7.0, -3.0, 1.0, 1.0, 11.0]).unwrap();
        assert_eq!(strips.bounds(), [0.0, 1.0, 7.0, 10.0]);
        assert_eq!([0.5, 1.0, 6.9, 7.0, 10.0].map(|v| strips.strip_of(v)), [0, 1, 1, 2, 2]);
        let squares: Vec<f64> = (0..1000).map(|at| f64::from(at * at)).collect();
        let strips = Strips::equal_count(&squares, 8).unwrap();
        let mut held = [0; 8];
        squares.iter().for_each(|&value| held[strips.strip_of(value)] += 1);
        assert_eq!(held, [125; 8]);
    }

    #[test]
    fn divided_strips_keep_their_bounds() {
        let coarse = Strips::between(0.0, 10.0, &[7.0, 1.0]).unwrap();
        let fine = coarse.divided(2).unwrap();
        assert_eq!(fine.bounds(), [0.0, 0.5, 1.0, 4.0, 7.0, 8.5, 10.0]);
        assert!(coarse.divided(0).is_err() && coarse.divided(MOST_STRIPS).is_err());
    }

    #[test]
    fn what_makes_no_strips_is_refused_and_a_constant_makes_one() {
        assert_eq!(Strips::uniform(2.0, 2.0, 50).unwrap().count(), 1);
        assert_eq!(Strips::equal_count(&[3.0; 9], 4).unwrap().count(), 1);
        assert!(Strips::uniform(0.0, 1.0, 0).is_err());
        assert!(Strips::uniform(1.0, 0.0, 3).is_err());
        assert!(Strips::uniform(f64::NAN, 0.0, 3).is_err());
        assert!(Strips::uniform(-1e308, 1e308, 3).is_err());
        assert!(Strips::between(0.0, 1.0, &[f64::NAN]).is_err());
        assert!(Strips::equal_count(&[], 3).is_err());
    }
}
