//! A surface through the heights of a regular grid.
//!
//! Between nodes the surface is a product of quintic Hermite interpolants along x and y, whose first and
//! second derivatives at a node come from five nodes of its row by the usual difference formulas (central,
//! towards an edge one-sided; Fornberg, Math. Comp. 51 (1988) 699). It passes through every node, has
//! continuous second derivatives, is exact for polynomials to degree 4 in x and in y, and depends on no
//! node more than three steps away, four at an edge.

use std::ops::Range;
use std::sync::Arc;

use thiserror::Error;

use super::{Jet, Shape, ShapeError, ShapeParameter};

/// Heights at the nodes of a regular grid, interpolated smoothly. It has no parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct SagGrid {
    nodes: Nodes,
    /// Row after row, x runs faster; NaN where a node is missing.
    sag_mm: Arc<[f64]>,
    /// Whether all nodes that a cell depends on are there; row after row of (nx − 1)·(ny − 1) cells.
    whole: Arc<[bool]>,
}

/// Where the nodes of a grid are: at `(x_min + i·step_x, y_min + j·step_y)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nodes {
    /// x of the first column in mm.
    pub x_min_mm: f64,
    /// y of the first row in mm.
    pub y_min_mm: f64,
    /// Distance of columns in mm.
    pub step_x_mm: f64,
    /// Distance of rows in mm.
    pub step_y_mm: f64,
    /// Number of columns.
    pub nx: usize,
    /// Number of rows.
    pub ny: usize,
}

/// Why heights make no grid.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum SagGridError {
    /// A start that is not finite, or a step that is not a positive finite number.
    #[error("{name} of the grid is {value_mm} mm, expected a finite number, for a step above zero")]
    Place {
        /// Which: `x_min`, `y_min`, `step_x`, `step_y`.
        name: &'static str,
        /// Its value in mm.
        value_mm: f64,
    },
    /// Too few nodes along a side.
    #[error("{nx} by {ny} nodes, expected at least {STENCIL} each way")]
    TooSmall {
        /// Columns.
        nx: usize,
        /// Rows.
        ny: usize,
    },
    /// A number of heights that is not that of the nodes.
    #[error("{found} heights for {nx} by {ny} nodes")]
    Count {
        /// Heights given.
        found: usize,
        /// Columns.
        nx: usize,
        /// Rows.
        ny: usize,
    },
    /// No cell has all the nodes it depends on.
    #[error("no cell has all the nodes around it: {missing} of {nodes} are missing")]
    Empty {
        /// Nodes without a height.
        missing: usize,
        /// Nodes in all.
        nodes: usize,
    },
}

impl SagGrid {
    /// The surface through `sag_mm`, row after row with x running faster. A height that is not finite is a
    /// missing node: the surface is not defined in any cell that depends on it. `O(nodes)`.
    pub fn new(nodes: Nodes, sag_mm: &[f64]) -> Result<SagGrid, SagGridError> {
        let Nodes { nx, ny, .. } = nodes;
        let steps = [("step_x", nodes.step_x_mm), ("step_y", nodes.step_y_mm)];
        let starts = [("x_min", nodes.x_min_mm), ("y_min", nodes.y_min_mm)];
        let bad_start = starts.into_iter().find(|(_, value)| !value.is_finite());
        let bad_step = steps.into_iter().find(|(_, value)| !(value.is_finite() && *value > 0.0));
        if let Some((name, value_mm)) = bad_start.or(bad_step) {
            return Err(SagGridError::Place { name, value_mm });
        }
        if nx.min(ny) < STENCIL {
            return Err(SagGridError::TooSmall { nx, ny });
        }
        if nx.checked_mul(ny) != Some(sag_mm.len()) {
            return Err(SagGridError::Count { found: sag_mm.len(), nx, ny });
        }
        let present = |i: usize, j: usize| sag_mm[j * nx + i].is_finite();
        let complete =
            |i: usize, j: usize| window(j, ny).all(|j| window(i, nx).all(|i| present(i, j)));
        let cells = (0..ny - 1).flat_map(|j| (0..nx - 1).map(move |i| (i, j)));
        let whole: Arc<[bool]> = cells.map(|(i, j)| complete(i, j)).collect();
        if !whole.contains(&true) {
            let missing = sag_mm.iter().filter(|sag| !sag.is_finite()).count();
            return Err(SagGridError::Empty { missing, nodes: sag_mm.len() });
        }
        Ok(SagGrid { nodes, sag_mm: sag_mm.into(), whole })
    }

    /// Where the nodes are.
    pub fn nodes(&self) -> Nodes {
        self.nodes
    }
}

impl Shape for SagGrid {
    fn kind(&self) -> &'static str {
        "sag grid"
    }

    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let nodes = &self.nodes;
        let (i, along) = cell(x_mm, nodes.x_min_mm, nodes.step_x_mm, nodes.nx)?;
        let (j, across) = cell(y_mm, nodes.y_min_mm, nodes.step_y_mm, nodes.ny)?;
        if !self.whole[j * (nodes.nx - 1) + i] {
            return None;
        }
        let (x, y) = (Weights::new(i, along, nodes.nx), Weights::new(j, across, nodes.ny));
        // Value and two derivatives along x of every row, then along y.
        let mut jet = Jet::default();
        for (row, j) in y.window.clone().enumerate() {
            let heights = &self.sag_mm[j * nodes.nx..][x.window.clone()];
            let sum = |weights: &[f64; WINDOW]| -> f64 {
                heights.iter().zip(weights).map(|(height, weight)| height * weight).sum()
            };
            let (value, first, second) = (sum(&x.value), sum(&x.first), sum(&x.second));
            jet.z_mm += y.value[row] * value;
            jet.gradient[0] += y.value[row] * first;
            jet.gradient[1] += y.first[row] * value;
            jet.hessian_per_mm[0] += y.value[row] * second;
            jet.hessian_per_mm[1] += y.first[row] * first;
            jet.hessian_per_mm[2] += y.second[row] * value;
        }
        let (dx, dy) = (nodes.step_x_mm, nodes.step_y_mm);
        jet.gradient = [jet.gradient[0] / dx, jet.gradient[1] / dy];
        let [xx, xy, yy] = jet.hessian_per_mm;
        jet.hessian_per_mm = [xx / (dx * dx), xy / (dx * dy), yy / (dy * dy)];
        Some(jet)
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        Vec::new()
    }

    fn by_parameters(&self, x_mm: f64, y_mm: f64, _derivatives: &mut [f64]) -> Option<()> {
        self.jet(x_mm, y_mm).map(|_| ())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        if values.is_empty() {
            return Ok(Arc::new(self.clone()));
        }
        Err(ShapeError::Count { kind: self.kind(), found: values.len(), expected: 0 })
    }

    /// 0 if a cell about the origin is not defined.
    fn domain_mm(&self) -> f64 {
        let nodes = &self.nodes;
        let x = |i: usize| nodes.x_min_mm + i as f64 * nodes.step_x_mm;
        let y = |j: usize| nodes.y_min_mm + j as f64 * nodes.step_y_mm;
        let (right, top) = (x(nodes.nx - 1), y(nodes.ny - 1));
        let edge = (-nodes.x_min_mm).min(right).min(-nodes.y_min_mm).min(top);
        // The nearest place of every cell that is not defined.
        let cells = (0..nodes.ny - 1).flat_map(|j| (0..nodes.nx - 1).map(move |i| (i, j)));
        let holes = cells
            .zip(&*self.whole)
            .filter(|(_, whole)| !**whole)
            .map(|((i, j), _)| 0_f64.clamp(x(i), x(i + 1)).hypot(0_f64.clamp(y(j), y(j + 1))));
        holes.fold(edge.max(0.0), f64::min)
    }
}

/// The cell of a coordinate and the place within it, from 0 to 1; the last border belongs to the last cell.
pub(super) fn cell(at_mm: f64, min_mm: f64, step_mm: f64, nodes: usize) -> Option<(usize, f64)> {
    let at = (at_mm - min_mm) / step_mm;
    let last = (nodes - 1) as f64;
    if !(-EDGE..=last + EDGE).contains(&at) {
        return None;
    }
    let index = (at.max(0.0) as usize).min(nodes - 2);
    Some((index, (at - index as f64).clamp(0.0, 1.0)))
}

/// The nodes that a cell depends on: those of the difference formulas of its two ends.
fn window(cell: usize, nodes: usize) -> Range<usize> {
    stencil(cell, nodes)..stencil(cell + 1, nodes) + STENCIL
}

/// The first of the nodes whose differences are taken at a node.
fn stencil(node: usize, nodes: usize) -> usize {
    node.saturating_sub(2).min(nodes - STENCIL)
}

/// What each node of a window weighs in the value and in the derivatives by the cell's own coordinate.
struct Weights {
    window: Range<usize>,
    value: [f64; WINDOW],
    first: [f64; WINDOW],
    second: [f64; WINDOW],
}

impl Weights {
    fn new(cell: usize, t: f64, nodes: usize) -> Weights {
        let window = window(cell, nodes);
        let start = window.start;
        let zero = [0.0; WINDOW];
        let mut weights = Weights { window, value: zero, first: zero, second: zero };
        for (node, hermite) in [(cell, hermite(t)), (cell + 1, hermite_of_end(t))] {
            weights.take(node - start, 1.0, hermite[0]);
            let stencil = stencil(node, nodes);
            let (first, second) = (FIRST[node - stencil], SECOND[node - stencil]);
            for k in 0..STENCIL {
                weights.take(stencil + k - start, first[k] / 12.0, hermite[1]);
                weights.take(stencil + k - start, second[k] / 12.0, hermite[2]);
            }
        }
        weights
    }

    fn take(&mut self, node: usize, share: f64, hermite: [f64; 3]) {
        self.value[node] += share * hermite[0];
        self.first[node] += share * hermite[1];
        self.second[node] += share * hermite[2];
    }
}

/// The quintics that have, at t = 0, a value, a slope, or a second derivative of 1 and otherwise 0 at both
/// ends: each with its first and second derivative.
fn hermite(t: f64) -> [[f64; 3]; 3] {
    let (s, u) = (t * t, 1.0 - t);
    [
        [
            1.0 - s * t * (10.0 - t * (15.0 - 6.0 * t)),
            -30.0 * s * u * u,
            -60.0 * t * u * (1.0 - 2.0 * t),
        ],
        [
            t - s * t * (6.0 - t * (8.0 - 3.0 * t)),
            1.0 - s * (18.0 - t * (32.0 - 15.0 * t)),
            -t * (36.0 - t * (96.0 - 60.0 * t)),
        ],
        [0.5 * s * u * u * u, 0.5 * t * u * u * (2.0 - 5.0 * t), u * (1.0 - t * (8.0 - 10.0 * t))],
    ]
}

/// The same for t = 1: mirrored, so that odd derivatives change their sign.
fn hermite_of_end(t: f64) -> [[f64; 3]; 3] {
    let [[a, a1, a2], [b, b1, b2], [c, c1, c2]] = hermite(1.0 - t);
    [[a, -a1, a2], [-b, b1, -b2], [c, -c1, c2]]
}

/// The largest number of nodes that a cell depends on, along a side.
const WINDOW: usize = 6;
/// Nodes of a difference formula.
const STENCIL: usize = 5;
/// A place on the border that rounding has put outside belongs to the grid.
const EDGE: f64 = 1e-9;
/// Twelve times the first derivative at node 0 to 4 of five, at unit distance.
const FIRST: [[f64; STENCIL]; STENCIL] = [
    [-25.0, 48.0, -36.0, 16.0, -3.0],
    [-3.0, -10.0, 18.0, -6.0, 1.0],
    [1.0, -8.0, 0.0, 8.0, -1.0],
    [-1.0, 6.0, -18.0, 10.0, 3.0],
    [3.0, -16.0, 36.0, -48.0, 25.0],
];
/// Twelve times the second derivative.
const SECOND: [[f64; STENCIL]; STENCIL] = [
    [35.0, -104.0, 114.0, -56.0, 11.0],
    [11.0, -20.0, 6.0, 4.0, -1.0],
    [-1.0, 16.0, -30.0, 16.0, -1.0],
    [-1.0, 4.0, 6.0, -20.0, 11.0],
    [11.0, -56.0, 114.0, -104.0, 35.0],
];
