//! Functions of the disc: powers of the radius times cosines and sines, times polynomials of its square.
//!
//! With s = u² + v², a term is `P(s)·Re (u + iv)^m` or `P(s)·Im (u + iv)^m`. The powers are polynomials of u
//! and v, so no angle occurs and nothing is undefined at the centre:
//! ∂(u + iv)^m/∂u = m·(u + iv)^{m−1} and ∂(u + iv)^m/∂v = i·m·(u + iv)^{m−1}.

use super::recurrence::{Family, scaled};
use super::{LANES, NormalisedJet};
use crate::taylor::Taylor;

/// All terms of a basis of the disc, as polynomials of the square of the radius with their azimuthal orders.
///
/// What a basis that has one shows by [`Basis::on_disc`](super::Basis::on_disc), for [`expand`](super::expand) to
/// use the structure.
#[derive(Clone, Debug, PartialEq)]
pub struct Disc {
    /// Invariant: ascending in `order`, each once.
    columns: Vec<Column>,
    /// Every term is divided by √(1 − bend²·s).
    bend: f64,
    terms: usize,
}

/// The terms of one azimuthal order.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Column {
    /// m ≥ 0.
    pub(super) order: u32,
    /// Polynomials of s.
    pub(super) radial: Family,
    /// Whether they are multiplied by s·(1 − s).
    pub(super) vanishes_at_rim: bool,
    /// The terms with the polynomial k: that of the cosine and that of the sine.
    pub(super) slots: Vec<[Option<Slot>; 2]>,
}

/// Where a function stands in the basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slot {
    pub(super) term: usize,
    pub(super) scale: f64,
}

impl Disc {
    pub(super) fn new(columns: Vec<Column>, bend: f64) -> Disc {
        debug_assert!(columns.is_sorted_by(|a, b| a.order < b.order));
        let slots = columns.iter().flat_map(|column| column.slots.iter().flatten());
        let terms = slots.filter(|slot| slot.is_some()).count();
        Disc { columns, bend, terms }
    }

    pub(super) fn terms(&self) -> usize {
        self.terms
    }

    /// The terms by azimuthal order, ascending.
    pub(super) fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Every term is divided by √(1 − bend²·s).
    pub(super) fn bend(&self) -> f64 {
        self.bend
    }

    pub(super) fn each_value(&self, u: f64, v: f64, visit: &mut dyn FnMut(usize, f64)) {
        self.each(&[u], &[v], |slot, radial, angular| {
            visit(slot.term, radial[0] * angular[0] * slot.scale);
        });
    }

    pub(super) fn block(&self, u: &[f64; LANES], v: &[f64; LANES], rows: &mut [[f64; LANES]]) {
        self.each(u, v, |slot, radial, angular| {
            scaled(radial, angular, slot.scale, &mut rows[slot.term]);
        });
    }

    /// Shows every term's polynomial, and its angular function with all common factors, to `visit`.
    fn each<const N: usize>(
        &self,
        u: &[f64; N],
        v: &[f64; N],
        mut visit: impl FnMut(Slot, &[f64; N], &[f64; N]),
    ) {
        let mut square = [0.0; N];
        let (mut re, mut im) = ([1.0; N], [0.0; N]);
        for i in 0..N {
            square[i] = u[i] * u[i] + v[i] * v[i];
        }
        if self.bend != 0.0 {
            for i in 0..N {
                re[i] = (1.0 - self.bend * self.bend * square[i]).sqrt().recip();
            }
        }
        let mut order = 0;
        for column in &self.columns {
            while order < column.order {
                for i in 0..N {
                    let turned = re[i] * v[i] + im[i] * u[i];
                    re[i] = re[i] * u[i] - im[i] * v[i];
                    im[i] = turned;
                }
                order += 1;
            }
            let mut angular = [re, im];
            if column.vanishes_at_rim {
                for i in 0..N {
                    let factor = square[i] * (1.0 - square[i]);
                    angular[0][i] *= factor;
                    angular[1][i] *= factor;
                }
            }
            column.radial.each(&square, |k, values| {
                for (slot, angular) in column.slots[k].iter().zip(&angular) {
                    if let Some(slot) = slot {
                        visit(*slot, values, angular);
                    }
                }
            });
        }
    }

    pub(super) fn each_jet(&self, u: f64, v: f64, visit: &mut dyn FnMut(usize, NormalisedJet)) {
        let square = u * u + v * v;
        let common = self.common(square);
        let rim =
            Taylor { value: square * (1.0 - square), first: 1.0 - 2.0 * square, second: -2.0 };
        // (u + iv) to the powers m, m − 1 and m − 2.
        let mut powers = [[1.0, 0.0], [0.0; 2], [0.0; 2]];
        let mut order = 0;
        for column in &self.columns {
            while order < column.order {
                let [re, im] = powers[0];
                powers = [[re * u - im * v, re * v + im * u], powers[0], powers[1]];
                order += 1;
            }
            let angular = angular_jets(order, &powers);
            let factor = if column.vanishes_at_rim { rim.times(common) } else { common };
            let plain = factor == Taylor::constant(1.0);
            column.radial.each_taylor(square, |k, radial| {
                let radial = if plain { radial } else { radial.times(factor) };
                for (slot, angular) in column.slots[k].iter().zip(&angular) {
                    if let Some(slot) = slot {
                        visit(slot.term, product(u, v, radial, angular, slot.scale));
                    }
                }
            });
        }
    }

    /// (1 − bend²·s)^(−1/2).
    fn common(&self, square: f64) -> Taylor {
        let bend = self.bend * self.bend;
        let value = (1.0 - bend * square).sqrt().recip();
        let first = 0.5 * bend * value * value * value;
        Taylor { value, first, second: 1.5 * bend * value * value * first }
    }
}

impl Column {
    /// Degree in s of its polynomials.
    pub(super) fn degree(&self) -> usize {
        self.slots.len() - 1 + if self.vanishes_at_rim { 2 } else { 0 }
    }

    /// Shows each term with its polynomial at s, and whether it goes with the sine, to `visit`.
    pub(super) fn each_radial(&self, square: f64, mut visit: impl FnMut(Slot, bool, f64)) {
        let factor = if self.vanishes_at_rim { square * (1.0 - square) } else { 1.0 };
        self.radial.each(&[square], |k, value| {
            for (slot, sine) in self.slots[k].iter().zip([false, true]) {
                if let Some(slot) = slot {
                    visit(*slot, sine, factor * value[0] * slot.scale);
                }
            }
        });
    }
}

/// Re and Im of (u + iv)^m with derivatives.
fn angular_jets(order: u32, powers: &[[f64; 2]; 3]) -> [NormalisedJet; 2] {
    let m = f64::from(order);
    let (once, twice) = (m, m * (m - 1.0));
    let [now, before, earlier] = *powers;
    [
        NormalisedJet {
            value: now[0],
            gradient: [once * before[0], -once * before[1]],
            hessian: [twice * earlier[0], -twice * earlier[1], -twice * earlier[0]],
        },
        NormalisedJet {
            value: now[1],
            gradient: [once * before[1], once * before[0]],
            hessian: [twice * earlier[1], twice * earlier[0], -twice * earlier[1]],
        },
    ]
}

/// `scale · P(s) · h(u, v)` with derivatives, by ∂s/∂u = 2u.
fn product(u: f64, v: f64, radial: Taylor, h: &NormalisedJet, scale: f64) -> NormalisedJet {
    let Taylor { value: p, first, second } = radial;
    let (du, dv) = (2.0 * u * first, 2.0 * v * first);
    let [h_u, h_v] = h.gradient;
    let [h_uu, h_uv, h_vv] = h.hessian;
    let hessian = [
        (2.0 * first + 4.0 * u * u * second) * h.value + 2.0 * du * h_u + p * h_uu,
        4.0 * u * v * second * h.value + du * h_v + dv * h_u + p * h_uv,
        (2.0 * first + 4.0 * v * v * second) * h.value + 2.0 * dv * h_v + p * h_vv,
    ];
    NormalisedJet {
        value: scale * (p * h.value),
        gradient: [scale * (du * h.value + p * h_u), scale * (dv * h.value + p * h_v)],
        hessian: hessian.map(|entry| scale * entry),
    }
}
