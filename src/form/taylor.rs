//! A function of one variable with two derivatives.

/// Value and first two derivatives of a function of one variable at one place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Taylor {
    pub(crate) value: f64,
    pub(crate) first: f64,
    pub(crate) second: f64,
}

impl Taylor {
    pub(crate) fn constant(value: f64) -> Taylor {
        Taylor { value, first: 0.0, second: 0.0 }
    }

    pub(crate) fn plus(self, other: Taylor) -> Taylor {
        Taylor {
            value: self.value + other.value,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }

    /// The product, by the rule of Leibniz.
    pub(crate) fn times(self, other: Taylor) -> Taylor {
        Taylor {
            value: self.value * other.value,
            first: self.first * other.value + self.value * other.first,
            second: self.second * other.value
                + 2.0 * self.first * other.first
                + self.value * other.second,
        }
    }
}
