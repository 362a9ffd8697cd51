//! Even powers of a distance, the aspheric terms of most prescriptions.

use super::argument::{FINITE, coefficient, refused};
use super::taylor::Taylor;
use super::{ShapeError, ShapeParameter};

/// `Σ A_n·s^n`, n even from 2 on, as a polynomial in t = s².
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EvenPowers {
    /// The orders that are parameters, ascending.
    orders: Vec<u8>,
    /// `dense[i]` belongs to t^(i+1); an order that is no parameter is 0.
    dense: Vec<f64>,
}

impl EvenPowers {
    /// From (order, coefficient in mm^(1−order)). Fails on an order that is odd, 0 or given twice, and on a
    /// coefficient that is not finite.
    pub(super) fn new(kind: &'static str, terms: &[(u8, f64)]) -> Result<EvenPowers, ShapeError> {
        let (orders, dense) = dense(kind, terms, 2)?;
        Ok(EvenPowers { orders, dense })
    }

    pub(super) fn at(&self, t: f64) -> Taylor {
        // Horner for p(t) = P(t)/t; its second derivative comes out halved.
        let (mut p, mut p1, mut p2) = (0.0, 0.0, 0.0);
        for a in self.dense.iter().rev() {
            p2 = p2 * t + p1;
            p1 = p1 * t + p;
            p = p * t + a;
        }
        Taylor { value: t * p, first: p + t * p1, second: 2.0 * (p1 + t * p2) }
    }

    pub(super) fn value(&self, t: f64) -> f64 {
        t * self.dense.iter().rev().fold(0.0, |p, a| p * t + a)
    }

    pub(super) fn count(&self) -> usize {
        self.orders.len()
    }

    pub(super) fn parameters(&self) -> impl Iterator<Item = ShapeParameter> {
        self.orders.iter().map(|&n| coefficient(n, self.dense[usize::from(n / 2) - 1]))
    }

    /// Orders kept, with other coefficients.
    pub(super) fn with_values(
        &self,
        kind: &'static str,
        values: &[f64],
    ) -> Result<EvenPowers, ShapeError> {
        let terms: Vec<_> = self.orders.iter().copied().zip(values.iter().copied()).collect();
        EvenPowers::new(kind, &terms)
    }

    /// Writes `t^(n/2)` for every order n that is a parameter.
    pub(super) fn write_derivatives(&self, t: f64, derivatives: &mut [f64]) {
        for (derivative, &order) in derivatives.iter_mut().zip(&self.orders) {
            *derivative = t.powi(i32::from(order / 2));
        }
    }

    /// The sums of the terms with positive and with negative coefficients at t; both are monotonic in t.
    pub(super) fn split(&self, t: f64) -> (f64, f64) {
        let sum = |keep: fn(f64) -> bool| {
            t * self.dense.iter().rev().fold(0.0, |p, &a| p * t + if keep(a) { a } else { 0.0 })
        };
        (sum(|a| a > 0.0), sum(|a| a < 0.0))
    }
}

/// Orders in ascending order and all coefficients from the order `step` on, in steps of `step`.
pub(super) fn dense(
    kind: &'static str,
    terms: &[(u8, f64)],
    step: u8,
) -> Result<(Vec<u8>, Vec<f64>), ShapeError> {
    let expected = match step {
        1 => "an order from 1 on, once",
        _ => "an even order from 2 on, once",
    };
    let mut orders = Vec::with_capacity(terms.len());
    for &(order, value) in terms {
        if order == 0 || !order.is_multiple_of(step) || orders.contains(&order) {
            return Err(refused(kind, "order of a power", f64::from(order), expected));
        }
        if !value.is_finite() {
            return Err(refused(kind, coefficient(order, value).name, value, FINITE));
        }
        orders.push(order);
    }
    orders.sort_unstable();
    let highest = orders.last().map_or(0, |&order| usize::from(order / step));
    let mut dense = vec![0.0; highest];
    for &(order, value) in terms {
        dense[usize::from(order / step) - 1] = value;
    }
    Ok((orders, dense))
}
