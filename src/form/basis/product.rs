//! Products of polynomials of x and of y: Chebyshev, Legendre, and powers.

use thiserror::Error;

use super::recurrence::{Family, Step, scaled};
use super::{Basis, LANES, NormalisedJet};
use crate::taylor::Taylor;

/// Products `f_i(u)·f_j(v)` of one family.
#[derive(Clone, Debug, PartialEq)]
pub struct Product {
    univariate: Univariate,
    /// The family to the largest order along u and along v.
    along: [Family; 2],
    orders: Vec<(u32, u32)>,
    /// For i: the terms with f_i(u), as (j, term), ascending in j.
    by_first: Vec<Vec<(usize, usize)>>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Univariate {
    Chebyshev,
    Legendre,
    Power,
}

/// Why there is no such basis.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum ProductError {
    /// An order above 63.
    #[error("order {order} of a product basis, expected at most {LARGEST}")]
    Order {
        /// The order.
        order: u32,
    },
    /// A term that occurs twice.
    #[error("the term of order {i} along x and {j} along y is given twice")]
    Twice {
        /// Order along x.
        i: u32,
        /// Order along y.
        j: u32,
    },
    /// No term at all.
    #[error("no term of the product basis is given, expected at least one")]
    Empty,
}

impl Product {
    /// Chebyshev polynomials of the first kind, T_i(u)·T_j(v), named `Ti,j`, for the given (i, j). Defined on
    /// the square |u|, |v| ≤ 1 (Abramowitz & Stegun 22.7.4).
    pub fn chebyshev(orders: &[(u32, u32)]) -> Result<Product, ProductError> {
        Product::new(Univariate::Chebyshev, orders)
    }

    /// Legendre polynomials with P(1) = 1, P_i(u)·P_j(v), named `Li,j`, for the given (i, j). Defined on the
    /// square, where they are orthogonal; the mean square is 1/((2i + 1)(2j + 1)) (Abramowitz & Stegun
    /// 22.7.10).
    pub fn legendre(orders: &[(u32, u32)]) -> Result<Product, ProductError> {
        Product::new(Univariate::Legendre, orders)
    }

    /// Powers u^i·v^j, named `XiYj`, for the given (i, j). Defined everywhere.
    pub fn powers(orders: &[(u32, u32)]) -> Result<Product, ProductError> {
        Product::new(Univariate::Power, orders)
    }

    /// The orders (i, j) of every product to a largest order along x and along y; j runs faster.
    pub fn tensor_orders(largest_i: u32, largest_j: u32) -> Vec<(u32, u32)> {
        (0..=largest_i).flat_map(|i| (0..=largest_j).map(move |j| (i, j))).collect()
    }

    /// The orders (i, j) of total degree `from` to `to`: by degree, then falling i. With `from` = 1 the
    /// sequence of the extended polynomial of lens design programs (x, y, x², xy, y², …); with 0 the
    /// constant leads, and prysm's index j from 1.
    pub fn degree_orders(from: u32, to: u32) -> Vec<(u32, u32)> {
        (from..=to).flat_map(|degree| (0..=degree).map(move |j| (degree - j, j))).collect()
    }

    fn new(univariate: Univariate, orders: &[(u32, u32)]) -> Result<Product, ProductError> {
        if orders.is_empty() {
            return Err(ProductError::Empty);
        }
        let (mut largest_i, mut largest_j) = (0, 0);
        for &(i, j) in orders {
            if i.max(j) > LARGEST {
                return Err(ProductError::Order { order: i.max(j) });
            }
            (largest_i, largest_j) = (largest_i.max(i), largest_j.max(j));
        }
        let mut by_first = vec![Vec::new(); largest_i as usize + 1];
        for (term, &(i, j)) in orders.iter().enumerate() {
            by_first[i as usize].push((j as usize, term));
        }
        for (i, terms) in (0..).zip(&mut by_first) {
            terms.sort_unstable();
            if let Some(pair) = terms.windows(2).find(|pair| pair[0].0 == pair[1].0) {
                return Err(ProductError::Twice { i, j: pair[0].0 as u32 });
            }
        }
        let along = [largest_i, largest_j].map(|largest| univariate.family(largest));
        Ok(Product { univariate, along, orders: orders.to_vec(), by_first })
    }

    /// Orders along x and y of every term.
    pub fn orders(&self) -> &[(u32, u32)] {
        &self.orders
    }
}

impl Univariate {
    /// p_0 to p_`largest`.
    fn family(self, largest: u32) -> Family {
        let step = |k: u32| {
            let n = f64::from(k);
            let (b, c) = match self {
                Univariate::Chebyshev if k == 0 => (1.0, 0.0),
                Univariate::Chebyshev => (2.0, 1.0),
                Univariate::Legendre => ((2.0 * n + 1.0) / (n + 1.0), n / (n + 1.0)),
                Univariate::Power => (1.0, 0.0),
            };
            Step { a: 0.0, b, c, d: 0.0 }
        };
        Family::new((0..largest).map(step).collect())
    }
}

impl Basis for Product {
    fn kind(&self) -> &'static str {
        match self.univariate {
            Univariate::Chebyshev => "Chebyshev series",
            Univariate::Legendre => "Legendre series",
            Univariate::Power => "XY polynomial",
        }
    }

    fn terms(&self) -> usize {
        self.orders.len()
    }

    fn name(&self, term: usize) -> String {
        let (i, j) = self.orders[term];
        match self.univariate {
            Univariate::Chebyshev => format!("T{i},{j}"),
            Univariate::Legendre => format!("L{i},{j}"),
            Univariate::Power => format!("X{i}Y{j}"),
        }
    }

    fn contains(&self, u: f64, v: f64) -> bool {
        match self.univariate {
            Univariate::Power => u.is_finite() && v.is_finite(),
            Univariate::Chebyshev | Univariate::Legendre => {
                u.abs().max(v.abs()) <= EDGE && !v.is_nan()
            }
        }
    }

    fn reach(&self) -> f64 {
        match self.univariate {
            Univariate::Power => f64::INFINITY,
            Univariate::Chebyshev | Univariate::Legendre => 1.0,
        }
    }

    fn each_value(&self, u: f64, v: f64, visit: &mut dyn FnMut(usize, f64)) {
        let mut second = [0.0; LARGEST as usize + 1];
        self.along[1].each(&[v], |j, value| second[j] = value[0]);
        self.along[0].each(&[u], |i, first| {
            for &(j, term) in &self.by_first[i] {
                visit(term, first[0] * second[j]);
            }
        });
    }

    fn each_jet(&self, u: f64, v: f64, visit: &mut dyn FnMut(usize, NormalisedJet)) {
        let mut second = [Taylor::default(); LARGEST as usize + 1];
        self.along[1].each_taylor(v, |j, taylor| second[j] = taylor);
        self.along[0].each_taylor(u, |i, f| {
            for &(j, term) in &self.by_first[i] {
                let g = second[j];
                let jet = NormalisedJet {
                    value: f.value * g.value,
                    gradient: [f.first * g.value, f.value * g.first],
                    hessian: [f.second * g.value, f.first * g.first, f.value * g.second],
                };
                visit(term, jet);
            }
        });
    }

    fn block(&self, u: &[f64; LANES], v: &[f64; LANES], rows: &mut [[f64; LANES]]) {
        let mut second = [[0.0; LANES]; LARGEST as usize + 1];
        self.along[1].each(v, |j, values| second[j] = *values);
        self.along[0].each(u, |i, first| {
            for &(j, term) in &self.by_first[i] {
                scaled(first, &second[j], 1.0, &mut rows[term]);
            }
        });
    }
}

/// The largest order along x or y: room for it lies on the stack.
const LARGEST: u32 = 63;
/// A point of the edge that rounding has put outside belongs to the square.
const EDGE: f64 = 1.0 + 1e-12;
