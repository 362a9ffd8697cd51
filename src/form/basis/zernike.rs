//! Zernike polynomials of any order.
//!
//! `R_n^|m|(ρ)·cos mφ` for m ≥ 0 and `R_n^|m|(ρ)·sin |m|φ` for m < 0, φ counted from x towards y. The radial
//! polynomial is R = ρ^m·P_k^(0,m)(2ρ² − 1) with Jacobi's P and k = (n − m)/2 (Born & Wolf, Principles of
//! Optics, 7th ed., 9.2.1; Abramowitz & Stegun 22.7.1 for the recurrence in k).

use thiserror::Error;

use super::disc::{Column, Disc, Slot};
use super::indices::Counting;
use super::recurrence::{Family, Step};
use super::{Basis, LANES, NormalisedJet};

/// Size of a term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Normalisation {
    /// Largest value 1, at the rim. A coefficient is a peak (half of peak to valley, for m ≠ 0).
    UnitHeight,
    /// Root mean square over the disc 1: a factor √(n + 1), for m ≠ 0 times √2. A coefficient is an RMS.
    UnitRms,
}

impl Normalisation {
    /// The factor of the term (n, m) against unit height.
    pub fn factor(self, n: u32, m: i32) -> f64 {
        match self {
            Normalisation::UnitHeight => 1.0,
            Normalisation::UnitRms if m == 0 => f64::from(n + 1).sqrt(),
            Normalisation::UnitRms => f64::from(2 * (n + 1)).sqrt(),
        }
    }
}

/// A sequence of Zernike polynomials.
#[derive(Clone, Debug, PartialEq)]
pub struct Zernike {
    kind: &'static str,
    normalisation: Normalisation,
    orders: Vec<(u32, i32)>,
    /// The single index of the first term, where terms are named by it.
    first: Option<u32>,
    disc: Disc,
}

/// Why there is no such sequence.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum ZernikeError {
    /// |m| above n, or n − m odd, or n above [`LARGEST_ORDER`].
    #[error(
        "there is no Zernike term ({n}, {m}): |m| must be n, n - 2, …, and n at most {LARGEST_ORDER}"
    )]
    NoSuchTerm {
        /// Radial order.
        n: u32,
        /// Azimuthal order.
        m: i32,
    },
    /// A term that occurs twice.
    #[error("the Zernike term ({n}, {m}) is given twice")]
    Twice {
        /// Radial order.
        n: u32,
        /// Azimuthal order.
        m: i32,
    },
    /// No term at all.
    #[error("no Zernike term is given, expected at least one")]
    Empty,
}

impl Zernike {
    /// The first `count` terms in a way of counting.
    pub fn first(
        counting: Counting,
        count: u32,
        normalisation: Normalisation,
    ) -> Result<Zernike, ZernikeError> {
        let first = counting.first();
        // Beyond the largest index the orders stay above the largest order: the check below refuses them.
        let orders = (first..first.saturating_add(count).min(INDICES))
            .map_while(|index| counting.orders(index))
            .collect();
        let kind = match counting {
            Counting::Fringe => "Fringe Zernike series",
            Counting::Noll => "Noll Zernike series",
            Counting::Ansi => "ANSI Zernike series",
        };
        Zernike::build(kind, orders, Some(first), normalisation)
    }

    /// The University of Arizona's set: the first 36 Fringe terms and, as Z37, (n, m) = (12, 0).
    pub fn fringe_37(normalisation: Normalisation) -> Zernike {
        let orders = (1..37).filter_map(|index| Counting::Fringe.orders(index)).chain([(12, 0)]);
        Zernike::build("Fringe Zernike series", orders.collect(), Some(1), normalisation)
            .expect("the orders of the set are valid")
    }

    /// Terms by their orders (n, m), named `Z(n,m)`.
    pub fn of_orders(
        orders: &[(u32, i32)],
        normalisation: Normalisation,
    ) -> Result<Zernike, ZernikeError> {
        Zernike::build("Zernike series", orders.to_vec(), None, normalisation)
    }

    fn build(
        kind: &'static str,
        orders: Vec<(u32, i32)>,
        first: Option<u32>,
        normalisation: Normalisation,
    ) -> Result<Zernike, ZernikeError> {
        if orders.is_empty() {
            return Err(ZernikeError::Empty);
        }
        let mut sorted = Vec::with_capacity(orders.len());
        for (term, &(n, m)) in orders.iter().enumerate() {
            let a = m.unsigned_abs();
            if n > LARGEST_ORDER || a > n || !(n - a).is_multiple_of(2) {
                return Err(ZernikeError::NoSuchTerm { n, m });
            }
            sorted.push((a, (n - a) / 2, m < 0, term));
        }
        sorted.sort_unstable();
        let mut columns: Vec<Column> = Vec::new();
        for of_order in sorted.chunk_by(|left, right| left.0 == right.0) {
            let order = of_order[0].0;
            let degree = of_order.iter().map(|&(_, k, ..)| k).max().unwrap_or(0);
            let mut slots = vec![[None; 2]; degree as usize + 1];
            for &(_, k, sine, term) in of_order {
                let (n, m) = orders[term];
                let slot = &mut slots[k as usize][usize::from(sine)];
                if slot.replace(Slot { term, scale: normalisation.factor(n, m) }).is_some() {
                    return Err(ZernikeError::Twice { n, m });
                }
            }
            let radial = Family::new((0..degree).map(|k| jacobi_step(k, order)).collect());
            columns.push(Column { order, radial, vanishes_at_rim: false, slots });
        }
        Ok(Zernike { kind, normalisation, orders, first, disc: Disc::new(columns, 0.0) })
    }

    /// Radial and azimuthal order of every term.
    pub fn orders(&self) -> &[(u32, i32)] {
        &self.orders
    }

    /// The size of the terms.
    pub fn normalisation(&self) -> Normalisation {
        self.normalisation
    }
}

impl Basis for Zernike {
    fn kind(&self) -> &'static str {
        self.kind
    }

    fn terms(&self) -> usize {
        self.disc.terms()
    }

    fn name(&self, term: usize) -> String {
        let (n, m) = self.orders[term];
        match self.first {
            Some(first) => format!("Z{}", first as usize + term),
            None => format!("Z({n},{m})"),
        }
    }

    fn contains(&self, u: f64, v: f64) -> bool {
        u * u + v * v <= RIM_SQUARE
    }

    fn reach(&self) -> f64 {
        1.0
    }

    fn each_value(&self, u: f64, v: f64, visit: &mut dyn FnMut(usize, f64)) {
        self.disc.each_value(u, v, visit);
    }

    fn each_jet(&self, u: f64, v: f64, visit: &mut dyn FnMut(usize, NormalisedJet)) {
        self.disc.each_jet(u, v, visit);
    }

    fn block(&self, u: &[f64; LANES], v: &[f64; LANES], rows: &mut [[f64; LANES]]) {
        self.disc.block(u, v, rows);
    }

    fn on_disc(&self) -> Option<&Disc> {
        Some(&self.disc)
    }
}

/// Value of the one term (n, m) at a normalised place; it goes on smoothly beyond the rim. `None` where
/// there is no such term. `O(n)`.
pub fn zernike_value(n: u32, m: i32, normalisation: Normalisation, u: f64, v: f64) -> Option<f64> {
    let order = m.unsigned_abs();
    if n > LARGEST_ORDER || order > n || !(n - order).is_multiple_of(2) {
        return None;
    }
    let (mut re, mut im) = (1.0, 0.0);
    for _ in 0..order {
        (re, im) = (re * u - im * v, re * v + im * u);
    }
    let square = u * u + v * v;
    let (mut now, mut before) = (1.0, 0.0);
    for k in 0..(n - order) / 2 {
        let step = jacobi_step(k, order);
        (now, before) = ((step.a + step.b * square) * now - step.c * before, now);
    }
    Some(normalisation.factor(n, m) * now * if m < 0 { im } else { re })
}

/// From P_k^(0,m)(2s − 1) to that of k + 1, in s (Abramowitz & Stegun 22.7.1 with α = 0, β = m).
fn jacobi_step(k: u32, order: u32) -> Step {
    let (k, m) = (f64::from(k), f64::from(order));
    if k == 0.0 {
        return Step { a: -(m + 1.0), b: m + 2.0, c: 0.0, d: 0.0 };
    }
    let sum = 2.0 * k + m;
    let divisor = 2.0 * (k + 1.0) * (k + m + 1.0) * sum;
    let slope = (sum + 1.0) * (sum + 2.0) * sum / divisor;
    let shift = (sum + 1.0) * m * m / divisor;
    let c = 2.0 * k * (k + m) * (sum + 2.0) / divisor;
    Step { a: -slope - shift, b: 2.0 * slope, c, d: 0.0 }
}

/// The largest radial order. Recurrences are tested to 60; above this, powers of the radius underflow.
pub const LARGEST_ORDER: u32 = 200;
/// More terms than any sequence to [`LARGEST_ORDER`] has, in any counting.
const INDICES: u32 = 50_000;
/// A point of the rim that rounding has put outside belongs to the disc.
pub(super) const RIM_SQUARE: f64 = 1.0 + 1e-12;
