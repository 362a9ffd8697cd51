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

use super::argument::count;
use super::at_first_use::AtFirstUse;
use super::raster::Raster;
use super::{Jet, Shape, ShapeError, ShapeParameter};

/// Heights at the nodes of a regular grid, interpolated smoothly. It has no parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct SagGrid {
    nodes: Nodes,
    /// Row after row, x runs faster; NaN where a node is missing.
    sag_mm: Arc<[f64]>,
    /// Whether all nodes that a cell depends on are there; row after row of (nx − 1)·(ny − 1) cells.
    whole: Arc<[bool]>,
    domain: AtFirstUse,
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
        if let Some((name, value_mm)) = nodes.raster().fault() {
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
        Ok(SagGrid { nodes, sag_mm: sag_mm.into(), whole, domain: AtFirstUse::default() })
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
        let Nodes { nx, ny, .. } = self.nodes;
        let raster = self.nodes.raster();
        let ([i, j], [u, v]) = raster.find(x_mm, y_mm)?;
        if !self.whole[j * (nx - 1) + i] {
            return None;
        }
        let (x, y) = (Weights::new(i, u, nx), Weights::new(j, v, ny));
        let rows = y.window.clone().enumerate().map(|(row, j)| {
            let heights = &self.sag_mm[j * nx..][x.window.clone()];
            (heights, [y.value[row], y.first[row], y.second[row]])
        });
        Some(raster.jet([&x.value, &x.first, &x.second], rows))
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        Vec::new()
    }

    fn by_parameters(&self, x_mm: f64, y_mm: f64, _derivatives: &mut [f64]) -> Option<()> {
        self.jet(x_mm, y_mm).map(|_| ())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        count(self.kind(), values, 0)?;
        Ok(Arc::new(self.clone()))
    }

    /// 0 if a cell about the origin is not defined.
    fn domain_mm(&self) -> f64 {
        self.domain.or_find(|| self.nodes.raster().reach_mm(&self.whole))
    }
}

impl Nodes {
    /// The cells between them.
    fn raster(&self) -> Raster {
        Raster {
            min_mm: [self.x_min_mm, self.y_min_mm],
            step_mm: [self.step_x_mm, self.step_y_mm],
            cells: [self.nx.saturating_sub(1), self.ny.saturating_sub(1)],
        }
    }
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
