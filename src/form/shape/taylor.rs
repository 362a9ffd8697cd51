//! The jets of surfaces made from a function of one variable.

use super::Jet;
pub(super) use crate::taylor::Taylor;

impl Taylor {
    /// The function of x whose value at x is this function at t = x².
    pub(super) fn of_square(self, x: f64) -> Taylor {
        Taylor {
            value: self.value,
            first: 2.0 * x * self.first,
            second: 2.0 * self.first + 4.0 * x * x * self.second,
        }
    }

    /// The surface of revolution z(x, y) whose height is this function at t = x² + y², in mm².
    ///
    /// In t rather than r nothing is divided by r, so that the vertex is a place as any other.
    pub(super) fn revolved(self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let (slope, bend) = (2.0 * self.first, 4.0 * self.second);
        defined(Jet {
            z_mm: self.value,
            gradient: [slope * x_mm, slope * y_mm],
            hessian_per_mm: [
                slope + bend * x_mm * x_mm,
                bend * x_mm * y_mm,
                slope + bend * y_mm * y_mm,
            ],
        })
    }
}

/// The jet, if all of it is finite: a number that overflowed or came from a NaN is no height.
pub(super) fn defined(jet: Jet) -> Option<Jet> {
    let Jet { z_mm, gradient: [p, q], hessian_per_mm: [r, s, t] } = jet;
    [z_mm, p, q, r, s, t].iter().all(|number| number.is_finite()).then_some(jet)
}

/// The number, if it is finite.
pub(super) fn number(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
