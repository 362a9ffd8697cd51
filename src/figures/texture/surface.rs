//! What the parameters are asked of: a grid or a mesh, and the nodes of either that count.

use super::{Datum, Grid, Mesh, Unknown};

/// A surface of either kind.
#[derive(Clone, Copy, Debug)]
pub enum Surface<'a> {
    /// Heights on a regular grid.
    Grid(&'a Grid),
    /// Heights at the vertices of triangles.
    Mesh(&'a Mesh),
}

impl<'a> From<&'a Grid> for Surface<'a> {
    fn from(grid: &'a Grid) -> Surface<'a> {
        Surface::Grid(grid)
    }
}

impl<'a> From<&'a Mesh> for Surface<'a> {
    fn from(mesh: &'a Mesh) -> Surface<'a> {
        Surface::Mesh(mesh)
    }
}

impl Surface<'_> {
    pub(super) fn nodes(&self) -> Result<Nodes, Unknown> {
        match self {
            Surface::Grid(grid) => grid.nodes(),
            Surface::Mesh(mesh) => mesh.nodes(),
        }
    }
}

/// Samples that a result rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// Nodes that count: measured ones of a grid, those that stand for an area of a mesh.
    pub points: usize,
    /// Share of the area that was measured, above 0 and at most 1: of the nodes of a grid, of the projected
    /// area of the triangles of a mesh. Where the result is a sum over triangles, of theirs.
    pub measured: f64,
    /// Height that the heights are about.
    pub datum: Datum,
}

/// The nodes of a surface that count. Invariants: not empty, lists of one length, shares positive or 0 by
/// underflow and of sum 1 up to rounding.
pub(super) struct Nodes {
    pub(super) places_mm: Vec<[f64; 2]>,
    pub(super) heights_nm: Vec<f64>,
    /// Share of the measured area each stands for.
    pub(super) shares: Vec<f64>,
    pub(super) support: Support,
}

impl Nodes {
    /// Area-weighted mean of a quantity of the nodes, by index.
    pub(super) fn mean(&self, quantity: impl Fn(usize) -> f64) -> f64 {
        self.shares.iter().enumerate().map(|(i, share)| share * quantity(i)).sum()
    }

    /// Smallest and largest height.
    pub(super) fn range_nm(&self) -> [f64; 2] {
        let first = self.heights_nm[0];
        let heights = self.heights_nm.iter();
        heights.fold([first; 2], |[low, high], &z| [low.min(z), high.max(z)])
    }
}

/// Heights up to this, in nm, have fourth powers that do not overflow.
pub(super) const LARGEST: f64 = 1e60;
