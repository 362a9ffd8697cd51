//! The noise region by region.

use asphera_geometry::{BoundsMm, PointMm, VertexId, place};

use super::estimate::{chosen, estimate_noise_about};
use super::{Noise, NoiseEstimate, NoiseSettings, NoiseUnknown};
use crate::curvature::Adjacency;

/// The noise in the cells of a grid over the points.
#[derive(Clone, Debug)]
pub struct NoiseMap {
    bounds_mm: Option<BoundsMm>,
    columns: usize,
    rows: usize,
    /// Row by row from the smallest y on, each from the smallest x on.
    cells: Vec<Result<NoiseEstimate, NoiseUnknown>>,
}

impl NoiseMap {
    /// The smallest rectangle about all vertices that have neighbours; `None` without such.
    pub fn bounds_mm(&self) -> Option<BoundsMm> {
        self.bounds_mm
    }

    /// Cells along x, and along y.
    pub fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    /// The cells, row by row from the smallest y on, each from the smallest x on.
    pub fn cells(&self) -> &[Result<NoiseEstimate, NoiseUnknown>] {
        &self.cells
    }

    /// The noise in the cell where a place lies, the larger cell coordinate's on a line between two;
    /// `None` outside, and where it is not known.
    pub fn at(&self, x_mm: f64, y_mm: f64) -> Option<Noise> {
        let cell = self.cell_of([x_mm, y_mm])?;
        self.cells[cell].as_ref().ok().map(|estimate| estimate.noise)
    }

    /// The cells whose noise is known.
    pub fn known(&self) -> Vec<NoiseEstimate> {
        self.cells.iter().flatten().copied().collect()
    }

    fn cell_of(&self, place: [f64; 2]) -> Option<usize> {
        let BoundsMm { low, high } = self.bounds_mm?;
        let mut index = [0; 2];
        for (axis, count) in [self.columns, self.rows].into_iter().enumerate() {
            // Written so that NaN fails.
            if !(place[axis] >= low[axis] && place[axis] <= high[axis]) {
                return None;
            }
            let share = (place[axis] - low[axis]) / (high[axis] - low[axis]);
            // All in one place along this axis: the share is NaN, and the first cell holds it.
            index[axis] = ((share * count as f64) as usize).min(count - 1);
        }
        Some(index[1] * self.columns + index[0])
    }
}

/// Estimates the noise in every cell of a grid of columns × rows over the points, no side of which
/// is taken as less than one cell.
///
/// The neighbourhoods of the settings are spread over all points and fall into the cell of their
/// vertex, as many as the cell has of the points; a cell with fewer than
/// [`NoiseSettings::NEIGHBOURHOODS_MIN`] is not known. Otherwise as [`crate::noise::estimate_noise`].
///
/// # Panics
///
/// When the adjacency is that of more points than these.
pub fn noise_map(
    points: &[PointMm],
    adjacency: &Adjacency,
    settings: &NoiseSettings,
    [columns, rows]: [usize; 2],
) -> NoiseMap {
    let bounds_mm = bounds_mm(points, adjacency);
    let (columns, rows) = (columns.max(1), rows.max(1));
    let mut map = NoiseMap { bounds_mm, columns, rows, cells: Vec::new() };
    let mut vertices: Vec<Vec<VertexId>> = vec![Vec::new(); columns * rows];
    for vertex in chosen(adjacency.len(), settings.neighbourhoods()) {
        let [x, y, _] = points[vertex as usize];
        if let Some(cell) = map.cell_of([x, y]) {
            vertices[cell].push(vertex);
        }
    }
    map.cells = vertices
        .into_iter()
        .map(|vertices| estimate_noise_about(points, adjacency, &vertices, settings))
        .collect();
    map
}

fn bounds_mm(points: &[PointMm], adjacency: &Adjacency) -> Option<BoundsMm> {
    (0..adjacency.len() as VertexId)
        .filter(|&vertex| !adjacency.neighbours(vertex).is_empty())
        .map(|vertex| points[vertex as usize])
        .filter(|point| point.iter().all(|coordinate| coordinate.is_finite()))
        .fold(None, |bounds: Option<BoundsMm>, point| {
            let mut bounds = bounds.unwrap_or(BoundsMm::EMPTY);
            bounds.add(place(point));
            Some(bounds)
        })
}
