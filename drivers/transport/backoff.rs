//! How long to wait before a link is opened again.

use std::time::Duration;

use thiserror::Error;

/// Exponential backoff with jitter: `first, 2·first, 4·first … max`, each drawn from the upper half of
/// its span, so that links that failed together do not come back together.
///
/// The draw follows from the seed alone.
#[derive(Clone, Debug)]
pub struct Backoff {
    first: Duration,
    max: Duration,
    failures: u32,
    random: u64,
}

/// Why a backoff cannot be.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum BackoffError {
    /// A zero wait would spin.
    #[error("first wait is zero, expected at least 1 ms")]
    Zero,
    /// The longest wait is shorter than the first.
    #[error("longest wait {max:?} is shorter than the first {first:?}")]
    Order {
        /// The first wait.
        first: Duration,
        /// The longest wait.
        max: Duration,
    },
}

impl Backoff {
    /// Waits from `first` to `max`; the jitter follows from `seed`.
    pub fn try_new(first: Duration, max: Duration, seed: u64) -> Result<Backoff, BackoffError> {
        if first.is_zero() {
            return Err(BackoffError::Zero);
        }
        if max < first {
            return Err(BackoffError::Order { first, max });
        }
        // An xorshift state must not be zero.
        Ok(Backoff { first, max, failures: 0, random: seed ^ 0x9E37_79B9_7F4A_7C15 | 1 })
    }

    /// The next wait, longer than the last until [`Backoff::reset`].
    pub fn next_wait(&mut self) -> Duration {
        let span = self.first.saturating_mul(1 << self.failures.min(20)).min(self.max);
        self.failures = self.failures.saturating_add(1);
        span.mul_f64(0.5 + 0.5 * self.draw())
    }

    /// The connection proved good: the next wait is the first again.
    pub fn reset(&mut self) {
        self.failures = 0;
    }

    /// Uniform in 0 to 1, by xorshift64*.
    fn draw(&mut self) -> f64 {
        self.random ^= self.random >> 12;
        self.random ^= self.random << 25;
        self.random ^= self.random >> 27;
        (self.random.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn impossible_backoffs_are_refused() {
        let ms = Duration::from_millis;
        assert_eq!(Backoff::try_new(ms(0), ms(1), 0).unwrap_err(), BackoffError::Zero);
        assert!(matches!(Backoff::try_new(ms(2), ms(1), 0), Err(BackoffError::Order { .. })));
    }

    proptest! {
        #[test]
        fn waits_grow_to_the_longest_and_start_over(first_ms in 1u64..1000, factor in 1u64..100, seed: u64) {
            let (first, max) = (Duration::from_millis(first_ms), Duration::from_millis(first_ms * factor));
            let mut backoff = Backoff::try_new(first, max, seed).unwrap();
            let mut span = first;
            for _ in 0..40 {
                let wait = backoff.next_wait();
                prop_assert!(wait >= span.mul_f64(0.5) && wait <= span);
                span = (span * 2).min(max);
            }
            backoff.reset();
            prop_assert!(backoff.next_wait() <= first);
        }
    }
}
