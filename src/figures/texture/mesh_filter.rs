//! Regression with Gaussian weights on a mesh.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::cells::Cells;
use super::regression::{FittedNode, MOMENTS, Sums, TERMS, terms_of};
use super::{Mesh, Order};

/// A filter over the vertices of a mesh.
pub(super) struct MeshFilter<'a> {
    mesh: &'a Mesh,
    cells: Cells<'a>,
    unit_mm: f64,
    window_mm: f64,
    terms: Vec<usize>,
    /// Moments and sums of heights that the terms need, from the first.
    needed: [usize; 2],
}

impl MeshFilter<'_> {
    pub(super) fn new(mesh: &Mesh, unit_mm: f64, window_mm: f64, order: Order) -> MeshFilter<'_> {
        MeshFilter {
            mesh,
            cells: Cells::new(mesh.places_mm(), window_mm),
            unit_mm,
            window_mm,
            terms: terms_of(order, true, true),
            needed: match order {
                Order::Zero => [1, 1],
                Order::Two => [MOMENTS.len(), TERMS.len()],
            },
        }
    }

    /// How many terms a full neighbourhood determines.
    pub(super) fn terms(&self) -> u8 {
        self.terms.len() as u8
    }

    /// The polynomial about each vertex, for weights of the vertices, which are 0 at gaps.
    pub(super) fn fit(&self, weights: &[f64]) -> Vec<FittedNode> {
        (0..weights.len()).into_par_iter().map(|vertex| self.fit_vertex(vertex, weights)).collect()
    }

    fn fit_vertex(&self, vertex: usize, weights: &[f64]) -> FittedNode {
        // About the height of the vertex, so that an offset costs no digits.
        let Some(about_nm) = self.mesh.at(vertex) else { return FittedNode::default() };
        let [x, y] = self.cells.place(vertex);
        let mut sums = Sums::default();
        for other in self.cells.near([x, y]) {
            let weight = weights[other];
            let place = self.cells.place(other);
            let (dx, dy) = (place[0] - x, place[1] - y);
            if weight == 0.0 || dx * dx + dy * dy > self.window_mm * self.window_mm {
                continue;
            }
            let Some(height_nm) = self.mesh.at(other) else { continue };
            let (u, v) = (dx / self.unit_mm, dy / self.unit_mm);
            let weight = weight * (-PI * (u * u + v * v)).exp();
            let us = [1.0, u, u * u, u * u * u, u * u * u * u];
            let vs = [1.0, v, v * v, v * v * v, v * v * v * v];
            for (sum, &(i, j)) in sums.moments[..self.needed[0]].iter_mut().zip(&MOMENTS) {
                *sum += weight * us[i] * vs[j];
            }
            let height = weight * (height_nm - about_nm);
            for (sum, &(i, j)) in sums.heights[..self.needed[1]].iter_mut().zip(&TERMS) {
                *sum += height * us[i] * vs[j];
            }
        }
        let fitted = sums.fit(&self.terms);
        FittedNode { value_nm: fitted.value_nm + about_nm, ..fitted }
    }
}
