//! Local feature size from the points alone, on a grid.
//!
//! A thinned set of points, one a cell, with the normals their neighbours give, is enough for the medial balls
//! (`asphera_surface::lfs`); what they say at each of these points stands for its cell. A local feature size
//! changes by no more than the way gone, so that is off by at most the diagonal of a cell. Where the points are
//! too noisy for that, or too many of them wrong, the smallest radius of curvature over windows of an eighth of the extent stands for all
//! of the surface: an upper bound, so that ε is a lower one.

use asphera_geometry::{BoundsMm, PointMm, VertexId, place};
use asphera_surface::curvature::{Adjacency, LocalShape, ShapeSettings, local_shape};
use asphera_surface::lfs::{Accuracy, LfsError, MeasuredLfs};
use asphera_surface::noise::{Noise, NoiseEstimate};
use asphera_surface::reduce::curvature_bound;
use rayon::prelude::*;

/// Noise of the readings, and the share of wrong ones.
#[derive(Clone, Copy, Debug)]
pub struct Readings {
    /// The noise.
    pub noise: Noise,
    /// The share of readings that stands off by more than noise does, 0 to 1.
    pub wrong_share: f64,
}

impl From<&NoiseEstimate> for Readings {
    fn from(found: &NoiseEstimate) -> Readings {
        Readings { noise: found.noise, wrong_share: found.outlier_share }
    }
}

/// Local feature size by the points.
pub(super) enum Measured {
    /// Values by medial balls.
    Balls(Cells),
    /// Value by curvature: one radius in mm for all, infinite over an exact plane.
    Curvature(f64),
}

/// A grid of values.
#[derive(Clone, Debug)]
pub(super) struct Cells {
    grid: Grid,
    /// Row by row in mm; NaN where it is not known.
    values_mm: Vec<f64>,
}

/// Square cells over an extent.
#[derive(Clone, Copy, Debug)]
struct Grid {
    low: [f64; 2],
    cell_mm: f64,
    size: [usize; 2],
}

impl Cells {
    pub(super) fn at(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let value_mm = self.values_mm[self.grid.cell([x_mm, y_mm])];
        (!value_mm.is_nan()).then_some(value_mm)
    }
}

/// The local feature size of a mesh with this noise. `reach_mm` is the length from which an edge bridges a gap.
///
/// # Errors
///
/// Why it is not known, in words.
pub(super) fn measured(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    Readings { noise, wrong_share }: Readings,
    reach_mm: f64,
) -> Result<Measured, String> {
    // A reading off the surface pierces the balls about it, and tilts the normals.
    let by_balls = if wrong_share > MOST_WRONG {
        None
    } else {
        balls(points, triangles, noise, reach_mm).map_err(|error| error.to_string())?
    };
    if let Some(cells) = by_balls {
        return Ok(Measured::Balls(cells));
    }
    match curvature_bound(points, noise.sigma_mm()) {
        Some(bound) => Ok(Measured::Curvature(bound.radius_mm)),
        None => Err("fewer than 30 points on an eighth of the extent show curvature".to_owned()),
    }
}

/// None where medial balls tell of less than half of the cells with points.
fn balls(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    noise: Noise,
    reach_mm: f64,
) -> Result<Option<Cells>, LfsError> {
    let Some(grid) = Grid::over(points) else { return Ok(None) };
    let Ok(adjacency) = Adjacency::new(points, triangles, Some(reach_mm)) else { return Ok(None) };
    let mut first = vec![None; grid.size[0] * grid.size[1]];
    for (vertex, &[x, y, _]) in (0..).zip(points) {
        let first = &mut first[grid.cell([x, y])];
        if first.is_none() && !adjacency.neighbours(vertex).is_empty() {
            *first = Some(vertex);
        }
    }
    let chosen: Vec<VertexId> = first.iter().copied().flatten().collect();
    let settings = ShapeSettings::default().with_noise(noise);
    let shapes: Vec<Option<LocalShape>> = chosen
        .par_iter()
        .map(|&vertex| local_shape(points, &adjacency, vertex, &settings).ok())
        .collect();
    let tilts = |shape: &LocalShape| {
        let [first, second] = shape.uncertainty?.normal_rad;
        Some(first.max(second)).filter(|tilt| *tilt <= MOST_TILT_RAD)
    };
    let known: Vec<Option<(LocalShape, f64)>> =
        shapes.into_iter().map(|shape| Some((shape?, tilts(&shape?)?))).collect();
    let normal_rad = known.iter().flatten().map(|(_, tilt)| *tilt).fold(0.0, f64::max);
    let accuracy = Accuracy {
        gap_mm: std::f64::consts::SQRT_2 * grid.cell_mm,
        position_mm: noise.sigma_mm(),
        normal_rad,
    };
    let mut lfs = MeasuredLfs::new(accuracy)?;
    let places: Vec<PointMm> = chosen.iter().map(|&vertex| points[vertex as usize]).collect();
    let normals: Vec<Option<[f64; 3]>> =
        known.iter().map(|known| known.map(|(shape, _)| shape.normal)).collect();
    lfs.insert(&places, &normals)?;
    let axis = lfs.refresh();
    let found_mm: Vec<f64> =
        places.par_iter().map(|&place| axis.at(place).mm().unwrap_or(f64::NAN)).collect();
    if 2 * found_mm.iter().filter(|mm| !mm.is_nan()).count() < found_mm.len().max(1) {
        return Ok(None);
    }
    let mut values_mm = vec![f64::NAN; first.len()];
    for (&[x, y, _], found_mm) in places.iter().zip(found_mm) {
        values_mm[grid.cell([x, y])] = found_mm;
    }
    Ok(Some(Cells { grid, values_mm }))
}

impl Grid {
    /// None if the points have no extent.
    fn over(points: &[PointMm]) -> Option<Grid> {
        let bounds = BoundsMm::about(points.iter().map(|&point| place(point)));
        let (low, extent) = (bounds.low, bounds.size_mm());
        let cells = (points.len() / 4).clamp(1, CELLS) as f64;
        let cell_mm = (extent[0] * extent[1] / cells).sqrt();
        if !(cell_mm > 0.0 && cell_mm.is_finite()) {
            return None;
        }
        let size = extent.map(|extent| (extent / cell_mm) as usize + 1);
        Some(Grid { low, cell_mm, size })
    }

    /// The cell of a place, of one outside the nearest.
    fn cell(&self, place: [f64; 2]) -> usize {
        // A cast saturates: what lies before the first cell is in it.
        let [column, row] = [0, 1].map(|axis| {
            let at = ((place[axis] - self.low[axis]) / self.cell_mm) as usize;
            at.min(self.size[axis] - 1)
        });
        row * self.size[0] + column
    }
}

/// The largest share of wrong readings of which a tenth of all neighbourhoods, of some twenty each, holds one.
const MOST_WRONG: f64 = 0.005;
/// Cells of the grid, at most.
const CELLS: usize = 10_000;
/// A normal that noise tilts farther tells nothing.
const MOST_TILT_RAD: f64 = 0.05;
