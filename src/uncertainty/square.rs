//! A mean square behind noise: what noise leaves of it, and how sure that is.
//!
//! A mean square m² of the form and of noise is the mean square E of the form and N by noise, with a variance of
//!
//! ```text
//! 2·λ·N + 4·λ·E + v
//!
//! λ   variance of the noise, over how many values it averages
//! v   variance by all else, such as the choice of places
//! ```
//!
//! (Searle & Gruber, Linear Models, 2nd ed., 2.4, for noise that is as large in any direction). The variance grows with the
//! truth: where E was found too small by chance, so would its variance be, and an interval of it would hold the truth too seldom.
//! So the limits are those E at which what was found is k standard deviations away (Wilson's interval: Brown, Cai & DasGupta,
//! Statist. Sci. 16 (2001) 101).

/// What is known of it, in the square of the figure's unit and powers of that.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanSquare {
    /// m² − N, below 0 where noise explains more than there is.
    pub(crate) left: f64,
    /// N.
    pub(crate) noise: f64,
    /// λ.
    pub(crate) rate: f64,
    /// v.
    pub(crate) apart: f64,
}

impl MeanSquare {
    /// The root of what is left, 0 where that is negative.
    pub(crate) fn root(&self) -> f64 {
        self.left.max(0.0).sqrt()
    }

    /// How far its interval of one standard deviation reaches, as the root mean square of the two sides.
    pub(crate) fn u(&self) -> f64 {
        let sides = self.interval(1.0).map(|end| end - self.root());
        (0.5 * (sides[0] * sides[0] + sides[1] * sides[1])).sqrt()
    }

    /// The same with one error that all values have together, of standard uncertainty `u`: 4·E·u² + 2·u⁴ more of variance, as of noise
    /// along one direction.
    pub(crate) fn with_systematic(self, u: f64) -> MeanSquare {
        let variance = u * u * (4.0 * self.left.max(0.0) + 2.0 * u * u);
        MeanSquare { apart: self.apart + variance, ..self }
    }

    /// Roots of the form's mean squares from which what was found is no farther than `k` standard deviations. Where noise
    /// explains more than there is the upper one is that of nothing left.
    pub(crate) fn interval(&self, k: f64) -> [f64; 2] {
        let MeanSquare { left, noise, rate, apart } = *self;
        let shift = 2.0 * rate * k * k;
        let of = |left: f64, sign: f64| {
            let around = shift * (2.0 * left + shift) + k * k * (2.0 * rate * noise + apart);
            (left + shift + sign * around.max(0.0).sqrt()).max(0.0).sqrt()
        };
        [of(left, -1.0), of(left.max(0.0), 1.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_as_far_from_what_was_found_as_asked() {
        let found = MeanSquare { left: 30.0, noise: 4.0, rate: 0.1, apart: 2.0 };
        for (end, sign) in found.interval(1.96).into_iter().zip([1.0, -1.0]) {
            let form = end * end;
            let deviation = (2.0 * 0.1 * 4.0 + 4.0 * 0.1 * form + 2.0_f64).sqrt();
            assert!((30.0 - form - sign * 1.96 * deviation).abs() < 1e-12, "{end}");
        }
    }

    #[test]
    fn without_noise_nothing_is_open() {
        let known = MeanSquare { left: 4.0, ..MeanSquare::default() };
        assert_eq!((known.root(), known.u(), known.interval(3.0)), (2.0, 0.0, [2.0, 2.0]));
    }

    #[test]
    fn noise_that_explains_more_than_there_is_leaves_the_interval_of_nothing() {
        let none = MeanSquare { left: 0.0, noise: 4.0, rate: 0.01, apart: 0.0 };
        let less = MeanSquare { left: -1.0, ..none };
        assert_eq!((less.root(), less.interval(1.96)), (0.0, none.interval(1.96)));
        assert!(none.u() > 0.0);
    }
}
