//! Forbes's gradient-orthogonal polynomials for freeforms (2-D-Q).
//!
//! G. W. Forbes, "Characterizing the shape of freeform optics", Opt. Express 20 (2012) 2483. With s = u² + v²
//! the departure along the normal of the base, eq. (2.2), has the terms `s(1 − s)·Q_n^0(s)` and
//! `ρ^m·(cos mφ, sin mφ)·Q_n^m(s)`. They are made so that over the disc, with the weight 1/√(1 − s)/ρ, the
//! mean square of the gradient of a sum is the sum of the squares of the coefficients. Q_n^0 are the
//! polynomials of the best-fit-sphere asphere (Q-bfs; Opt. Express 18 (2010) 19700, appendix A).

use thiserror::Error;

use super::disc::{Column, Disc, Slot};
use super::recurrence::{Family, Mix, Step};
use super::zernike::RIM_SQUARE;
use super::{Basis, LANES, NormalisedJet};

/// A sequence of 2-D-Q terms (n, m): cosines for m ≥ 0, sines for m < 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Q2d {
    orders: Vec<(u32, i32)>,
    bend: f64,
    disc: Disc,
}

/// Why there is no such sequence.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Q2dError {
    /// An order above 40.
    #[error("order {order} of a 2-D-Q term, expected at most {LARGEST}")]
    Order {
        /// The order.
        order: u32,
    },
    /// A term that occurs twice.
    #[error("the 2-D-Q term ({n}, {m}) is given twice")]
    Twice {
        /// Order of the polynomial in s.
        n: u32,
        /// Azimuthal order.
        m: i32,
    },
    /// No term at all.
    #[error("no 2-D-Q term is given, expected at least one")]
    Empty,
    /// A base that is steeper than vertical at the rim.
    #[error(
        "the normalisation radius is {bend} of the radius of the base, expected less than 1 in size"
    )]
    Base {
        /// Normalisation radius over radius of the base.
        bend: f64,
    },
}

impl Q2d {
    /// Terms over a base sphere. `bend` is the normalisation radius over the radius of the base: every term
    /// is divided by the cosine √(1 − bend²·s) of the base's slope, which turns a departure along the normal
    /// into sag, as eq. (2.2) has it. With 0, a plane, the bare polynomials remain (what prysm's `Q2d` gives).
    pub fn new(orders: &[(u32, i32)], bend: f64) -> Result<Q2d, Q2dError> {
        if orders.is_empty() {
            return Err(Q2dError::Empty);
        }
        if bend.is_nan() || bend.abs() >= 1.0 {
            return Err(Q2dError::Base { bend });
        }
        let mut sorted = Vec::with_capacity(orders.len());
        for (term, &(n, m)) in orders.iter().enumerate() {
            let order = n.max(m.unsigned_abs());
            if order > LARGEST {
                return Err(Q2dError::Order { order });
            }
            sorted.push((m.unsigned_abs(), n, m < 0, term));
        }
        sorted.sort_unstable();
        let mut columns = Vec::new();
        for of_order in sorted.chunk_by(|left, right| left.0 == right.0) {
            let order = of_order[0].0;
            let degree = of_order.iter().map(|&(_, n, ..)| n).max().unwrap_or(0);
            let mut slots = vec![[None; 2]; degree as usize + 1];
            for &(_, n, sine, term) in of_order {
                let slot = &mut slots[n as usize][usize::from(sine)];
                if slot.replace(Slot { term, scale: 1.0 }).is_some() {
                    return Err(Q2dError::Twice { n, m: orders[term].1 });
                }
            }
            let radial = if order == 0 { bfs(degree) } else { azimuthal(order, degree) };
            columns.push(Column { order, radial, vanishes_at_rim: order == 0, slots });
        }
        Ok(Q2d { orders: orders.to_vec(), bend, disc: Disc::new(columns, bend) })
    }

    /// The orders (n, m) of every term.
    pub fn orders(&self) -> &[(u32, i32)] {
        &self.orders
    }

    /// Normalisation radius over radius of the base; 0 for a plane.
    pub fn bend(&self) -> f64 {
        self.bend
    }
}

impl Basis for Q2d {
    fn kind(&self) -> &'static str {
        "2-D-Q series"
    }

    fn terms(&self) -> usize {
        self.disc.terms()
    }

    fn name(&self, term: usize) -> String {
        let (n, m) = self.orders[term];
        format!("Q({n},{m})")
    }

    fn contains(&self, u: f64, v: f64) -> bool {
        let square = u * u + v * v;
        square <= RIM_SQUARE && self.bend * self.bend * square < 1.0
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

/// Q_0^0 to Q_`degree`^0 (2010, eqs. A.14 to A.18): mixtures of P_0 = 2, P_1 = 6 − 8s,
/// P_{k+1} = (2 − 4s)·P_k − P_{k−1}.
fn bfs(degree: u32) -> Family {
    let steps = (0..degree).map(|k| match k {
        0 => Step { a: 3.0, b: -4.0, c: 0.0, d: 0.0 },
        _ => Step { a: 2.0, b: -4.0, c: 1.0, d: 0.0 },
    });
    let mut mixes = vec![Mix { f: 2.0, g: 0.0, h: 0.0 }];
    for k in 1..=degree as usize {
        let last = mixes[k - 1];
        let n = k as f64;
        // The mix of k holds g_{k−1} and h_{k−2}; g_0 = −1/2.
        let h = if k == 1 { 0.0 } else { -n * (n - 1.0) / (2.0 * mixes[k - 2].f) };
        let g = if k == 1 { -0.5 } else { -(1.0 + last.g * h) / last.f };
        let f =
            if k == 1 { 19_f64.sqrt() / 2.0 } else { (n * (n + 1.0) + 3.0 - g * g - h * h).sqrt() };
        mixes.push(Mix { f, g, h });
    }
    Family::mixed(2.0, steps.collect(), mixes)
}

/// Q_0^m to Q_`degree`^m for m ≥ 1 (2012, appendix A).
fn azimuthal(order: u32, degree: u32) -> Family {
    let m = f64::from(order);
    let steps = (0..degree).map(|k| match (order, k) {
        // P_0 to P_3 of m = 1 are given one by one, eq. (A.6); the third step reaches back to P_0.
        (1, 0) => Step { a: 2.0, b: -1.0, c: 0.0, d: 0.0 },
        (1, 1) => Step { a: -4.0 / 3.0, b: -8.0 / 3.0, c: -11.0 / 3.0, d: 0.0 },
        (1, 2) => Step { a: 9.0 / 5.0, b: -24.0 / 5.0, c: 0.0, d: 4.0 / 5.0 },
        (_, 0) => Step { a: 2.0 * m - 1.0, b: 2.0 - 2.0 * m, c: 0.0, d: 0.0 },
        _ => azimuthal_step(f64::from(k), m),
    });
    // f_n² = F_n − g_{n−1}² and g_n = G_n/f_n, eq. (A.18); γ as in eq. (A.14).
    let mut f = square_of_first(order).sqrt();
    let mut mixes = vec![Mix { f, g: 0.0, h: 0.0 }];
    let mut coupling = (2.0 * m - 1.0) * square_of_first(order) / (m * m);
    let mut gamma = first_gamma(order);
    for n in 1..=degree {
        let g = coupling / f;
        let (square, next) = if order == 1 {
            squares_of_first_order(f64::from(n))
        } else {
            if n > 1 {
                let n = f64::from(n);
                gamma *= n * (2.0 * m + 2.0 * n - 3.0) / ((m + n - 3.0) * (2.0 * n - 1.0));
            }
            squares(f64::from(n), m, gamma)
        };
        f = (square - g * g).sqrt();
        coupling = next;
        mixes.push(Mix { f, g, h: 0.0 });
    }
    Family::mixed(0.5, steps.collect(), mixes)
}

/// From P_n to P_{n+1}, eq. (A.3).
fn azimuthal_step(n: f64, m: f64) -> Step {
    let divisor = (4.0 * n * n - 1.0) * (m + n - 2.0) * (m + 2.0 * n - 3.0);
    let a = (2.0 * n - 1.0)
        * (m + 2.0 * n - 2.0)
        * (4.0 * n * (m + n - 2.0) + (m - 3.0) * (2.0 * m - 1.0));
    let b =
        -2.0 * (2.0 * n - 1.0) * (m + 2.0 * n - 3.0) * (m + 2.0 * n - 2.0) * (m + 2.0 * n - 1.0);
    let c = n * (2.0 * n - 3.0) * (m + 2.0 * n - 1.0) * (2.0 * m + 2.0 * n - 3.0);
    Step { a: a / divisor, b: b / divisor, c: c / divisor, d: 0.0 }
}

/// F_0 = m²·(2m − 3)!! / (2^{m+1}·(m − 1)!), eq. (A.13), as a product.
fn square_of_first(order: u32) -> f64 {
    let ratio = (1..order).map(f64::from).fold(0.25, |r, m| r * (2.0 * m - 1.0) / (2.0 * m));
    ratio * f64::from(order) * f64::from(order)
}

/// γ of n = 1 for m ≥ 2, by its recurrence in m from γ = 3/8 at m = 2.
fn first_gamma(order: u32) -> f64 {
    (2..order).map(f64::from).fold(0.375, |gamma, m| gamma * (2.0 * m + 1.0) / (2.0 * (m - 1.0)))
}

/// F_n and G_n for m = 1 and n ≥ 1, eqs. (A.13) and (A.15).
fn squares_of_first_order(n: f64) -> (f64, f64) {
    let square = n * n;
    let (f_first, g_first) = if n == 1.0 { (11.0 / 32.0, 1.0 / 24.0) } else { (0.0, 0.0) };
    let f = (4.0 * (n - 1.0) * (n - 1.0) * square + 1.0) / (8.0 * (2.0 * n - 1.0).powi(2));
    let g = -(2.0 * square - 1.0) * (square - 1.0) / (8.0 * (4.0 * square - 1.0));
    (f + f_first, g - g_first)
}

/// F_n and G_n for m ≥ 2 and n ≥ 1, eqs. (A.13) and (A.15).
fn squares(n: f64, m: f64, gamma: f64) -> (f64, f64) {
    let chi = m + n - 2.0;
    let two_n = m + 2.0 * n;
    let f = (2.0 * n * chi * (3.0 - 5.0 * m + 4.0 * n * chi) + m * m * (3.0 - m + 4.0 * n * chi))
        / ((two_n - 3.0) * (two_n - 2.0) * (two_n - 1.0) * (2.0 * n - 1.0));
    let g = -(2.0 * n * (m + n - 1.0) - m) * (n + 1.0) * (2.0 * m + 2.0 * n - 1.0)
        / ((two_n - 2.0) * (two_n - 1.0) * two_n * (2.0 * n + 1.0));
    (f * gamma, g * gamma)
}

/// The largest order of a term: recurrences are tested to it.
const LARGEST: u32 = 40;
