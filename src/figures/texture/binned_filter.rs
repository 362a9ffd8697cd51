//! Regression with Gaussian weights on a mesh by way of a regular grid, for windows with very many vertices.

use super::cells::box_of;
use super::grid_filter::GridFilter;
use super::regression::{FittedNode, terms_of};
use super::{Grid, Mesh, Order};

/// A filter over the vertices of a mesh, worked out on a grid.
///
/// Weight and weighted height of each vertex are shared among the four nodes around it, linearly (Wand, J. Comput.
/// Graph. Stat. 3 (1994) 433); the filter of the grid runs over these, and each vertex gets the value between its
/// four nodes. Both steps let less pass, of a wave of wavelength λ the share 1 − (2πh/λ)²/6 for nodes h apart.
pub(super) struct BinnedFilter<'a> {
    mesh: &'a Mesh,
    /// Of each vertex the node below and left of it and how far it is from there, in nodes; `None` at gaps.
    places: Vec<Option<(usize, [f64; 2])>>,
    rows: usize,
    columns: usize,
    spacing_mm: f64,
    unit_mm: f64,
    window_mm: f64,
    order: Order,
}

impl BinnedFilter<'_> {
    /// A filter on nodes `spacing_mm` apart; `None` where that takes more nodes than can be held.
    pub(super) fn new(
        mesh: &Mesh,
        unit_mm: f64,
        window_mm: f64,
        order: Order,
        spacing_mm: f64,
    ) -> Option<BinnedFilter<'_>> {
        let [low_mm, high_mm] = box_of((0..mesh.len()).filter_map(|i| {
            mesh.at(i)?;
            Some(mesh.places_mm()[i])
        }))?;
        let nodes = [0, 1].map(|axis| ((high_mm[axis] - low_mm[axis]) / spacing_mm).floor() + 2.0);
        if nodes[0] * nodes[1] > MOST_NODES {
            return None;
        }
        let [columns, rows] = nodes.map(|nodes| nodes as usize);
        let place = |i: usize| {
            mesh.at(i)?;
            let place = mesh.places_mm()[i];
            let off = [0, 1].map(|axis| (place[axis] - low_mm[axis]) / spacing_mm);
            let [x, y] = [off[0].floor(), off[1].floor()];
            Some((y as usize * columns + x as usize, [off[0] - x, off[1] - y]))
        };
        let places = (0..mesh.len()).map(place).collect();
        Some(BinnedFilter { mesh, places, rows, columns, spacing_mm, unit_mm, window_mm, order })
    }

    /// How many terms a full neighbourhood determines.
    pub(super) fn terms(&self) -> u8 {
        terms_of(self.order, true, true).len() as u8
    }

    /// The polynomial about each vertex, for weights of the vertices, which are 0 at gaps.
    pub(super) fn fit(&self, weights: &[f64]) -> Vec<FittedNode> {
        let count = self.rows * self.columns;
        let (mut areas, mut sums) = (vec![0.0; count], vec![0.0; count]);
        let mut touched = vec![false; count];
        let first_nm = (0..self.mesh.len()).find_map(|i| self.mesh.at(i)).unwrap_or(0.0);
        for (i, place) in self.places.iter().enumerate() {
            let (Some(place), Some(height_nm)) = (place, self.mesh.at(i)) else { continue };
            for (node, share) in self.around(place) {
                touched[node] = true;
                areas[node] += share * weights[i];
                sums[node] += share * weights[i] * (height_nm - first_nm);
            }
        }
        let height = |node: usize| match (touched[node], areas[node] > 0.0) {
            (true, true) => first_nm + sums[node] / areas[node],
            // Of no weight: the filter says what is there.
            (true, false) => first_nm,
            (false, _) => f64::NAN,
        };
        let heights_nm: Vec<f64> = (0..count).map(height).collect();
        let grid = Grid::new(&heights_nm, self.rows, self.columns, [self.spacing_mm; 2])
            .expect("rows times columns heights at a positive distance");
        let nodes = GridFilter::new(&grid, self.unit_mm, self.window_mm, self.order).fit(&areas);
        let between = |place: &Option<(usize, [f64; 2])>| {
            let Some(place) = place else { return FittedNode::default() };
            let (mut share_sum, mut sum, mut terms) = (0.0, 0.0, u8::MAX);
            for (node, share) in self.around(place).filter(|(_, share)| *share > 0.0) {
                let FittedNode { value_nm, terms: own } = nodes[node];
                if own > 0 {
                    share_sum += share;
                    sum += share * (value_nm - first_nm);
                    terms = terms.min(own);
                }
            }
            if share_sum > 0.0 {
                FittedNode { value_nm: first_nm + sum / share_sum, terms }
            } else {
                FittedNode::default()
            }
        };
        self.places.iter().map(between).collect()
    }

    /// The four nodes around a place, each with its share; they add up to 1.
    fn around(&self, &(node, [x, y]): &(usize, [f64; 2])) -> impl Iterator<Item = (usize, f64)> {
        let above = node + self.columns;
        [
            (node, (1.0 - x) * (1.0 - y)),
            (node + 1, x * (1.0 - y)),
            (above, (1.0 - x) * y),
            (above + 1, x * y),
        ]
        .into_iter()
    }
}

/// Some 700 MB for order 2.
const MOST_NODES: f64 = 8e6;
