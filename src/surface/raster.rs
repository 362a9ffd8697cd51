//! Values given at the vertices of a mesh, interpolated on a regular grid.

use std::cmp::Ordering;

use asphera_geometry::predicates::{Place, orientation};
use asphera_geometry::{PointMm, VertexId, place};
use thiserror::Error;

/// A regular grid of nodes in the x-y plane.
///
/// Node (i, j) is at x = `x0_mm` + i·`dx_mm`, y = `y0_mm` + j·`dy_mm`, and has the index
/// j·`nx` + i: rows of constant y, x fastest, y upwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// x of the first node in mm.
    pub x0_mm: f64,
    /// y of the first node in mm.
    pub y0_mm: f64,
    /// Step along x in mm; positive.
    pub dx_mm: f64,
    /// Step along y in mm; positive.
    pub dy_mm: f64,
    /// Nodes along x.
    pub nx: usize,
    /// Nodes along y.
    pub ny: usize,
}

/// Why nothing was rasterized.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum RasterError {
    /// An origin or a step of the grid is not usable.
    #[error(
        "grid origin ({x0_mm}, {y0_mm}) mm must be finite and steps ({dx_mm}, {dy_mm}) mm finite and positive"
    )]
    Grid {
        /// x of the first node in mm.
        x0_mm: f64,
        /// y of the first node in mm.
        y0_mm: f64,
        /// Step along x in mm.
        dx_mm: f64,
        /// Step along y in mm.
        dy_mm: f64,
    },
    /// The grid has more nodes than can be addressed.
    #[error("a grid of {nx} × {ny} nodes is too large")]
    Nodes {
        /// Nodes along x.
        nx: usize,
        /// Nodes along y.
        ny: usize,
    },
    /// There is not one value a point.
    #[error("{values} values for {points} points")]
    Values {
        /// How many values were given.
        values: usize,
        /// How many points were given.
        points: usize,
    },
}

/// Interpolates `values`, one for each of `points`, linearly over `triangles` at the nodes of `grid`.
///
/// A node outside all triangles is NaN: pass [`crate::Survey::good`] and no gap is bridged. Which
/// nodes a triangle covers, its sides included, is decided exactly: no node is lost between two
/// triangles. A node on a side or a corner takes its value from the first triangle there that has
/// one. No value leaves the range of the three it is interpolated from; a triangle with a NaN value
/// covers nothing.
///
/// Triangles must be counter-clockwise seen from +z, as [`asphera_mesh::Mesh::triangles`] gives them;
/// others cover nothing. Takes time in proportion to the triangles, the grid rows they cross and the
/// nodes they cover.
///
/// # Errors
///
/// When the grid is not usable or there is not one value a point.
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn rasterize(
    points: &[PointMm],
    triangles: impl IntoIterator<Item = [VertexId; 3]>,
    values: &[f64],
    grid: &Grid,
) -> Result<Vec<f64>, RasterError> {
    if values.len() != points.len() {
        return Err(RasterError::Values { values: values.len(), points: points.len() });
    }
    let mut raster = vec![f64::NAN; grid.check()?];
    for corners in triangles {
        let places = corners.map(|corner| place(points[corner as usize]));
        let values = corners.map(|corner| values[corner as usize]);
        for (index, node) in grid.covered_by(places) {
            if raster[index].is_nan() {
                raster[index] = interpolate(places, values, node);
            }
        }
    }
    Ok(raster)
}

impl Grid {
    /// The place of node (i, j).
    fn node(&self, i: usize, j: usize) -> Place {
        [self.x0_mm + i as f64 * self.dx_mm, self.y0_mm + j as f64 * self.dy_mm]
    }

    /// How many nodes there are, if the grid is usable.
    fn check(&self) -> Result<usize, RasterError> {
        let Grid { x0_mm, y0_mm, dx_mm, dy_mm, nx, ny } = *self;
        let step = |step_mm: f64| step_mm > 0.0 && step_mm.is_finite();
        if !(x0_mm.is_finite() && y0_mm.is_finite() && step(dx_mm) && step(dy_mm)) {
            return Err(RasterError::Grid { x0_mm, y0_mm, dx_mm, dy_mm });
        }
        nx.checked_mul(ny)
            .filter(|&nodes| nodes <= isize::MAX as usize / size_of::<f64>())
            .ok_or(RasterError::Nodes { nx, ny })
    }

    /// Index and place of each node in a counter-clockwise triangle or on its boundary.
    fn covered_by(&self, triangle: [Place; 3]) -> impl Iterator<Item = (usize, Place)> {
        let grid = *self;
        let [low_y, high_y] = range(triangle.map(|corner| corner[1]));
        let rows = steps([low_y, high_y], grid.y0_mm, grid.dy_mm, grid.ny);
        rows.filter_map(move |j| {
            let y = grid.node(0, j)[1];
            (low_y <= y && y <= high_y).then(|| (j, chord(triangle, y)))
        })
        .flat_map(move |(j, chord)| {
            steps(chord, grid.x0_mm, grid.dx_mm, grid.nx).map(move |i| (i, j))
        })
        .map(move |(i, j)| (j * grid.nx + i, grid.node(i, j)))
        .filter(move |&(_, node)| contains(triangle, node))
    }
}

/// Smallest and largest of three.
fn range([p, q, r]: [f64; 3]) -> [f64; 2] {
    [p.min(q).min(r), p.max(q).max(r)]
}

/// The grid steps that may lie between `low` and `high`: none is missing, one too many at each end.
fn steps([low, high]: [f64; 2], origin: f64, step: f64, count: usize) -> std::ops::Range<usize> {
    // Casts of doubles to integers saturate, so that what lies outside the grid is clipped.
    let first = ((low - origin) / step).ceil() - 1.0;
    let last = ((high - origin) / step).floor() + 1.0;
    if last < 0.0 {
        return 0..0;
    }
    let end = count.min((last as usize).saturating_add(1));
    (first as usize).min(end)..end
}

/// Where the horizontal line at `y` enters and leaves a triangle it crosses, but for rounding.
fn chord(triangle: [Place; 3], y: f64) -> [f64; 2] {
    let mut chord = [f64::INFINITY, f64::NEG_INFINITY];
    for side in 0..3 {
        let ([px, py], [qx, qy]) = (triangle[side], triangle[(side + 1) % 3]);
        // A horizontal side needs no crossing of its own: its ends are ends of the two others.
        if py != qy && py.min(qy) <= y && y <= py.max(qy) {
            let x = px + (y - py) / (qy - py) * (qx - px);
            chord = [chord[0].min(x), chord[1].max(x)];
        }
    }
    let [low, high] = range(triangle.map(|corner| corner[0]));
    [chord[0].max(low), chord[1].min(high)]
}

/// Whether a counter-clockwise triangle contains the place, its boundary included.
fn contains([a, b, c]: [Place; 3], node: Place) -> bool {
    [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| orientation(p, q, node) != Ordering::Less)
}

/// The linear interpolation at a place in the triangle, kept between its three values.
fn interpolate(triangle: [Place; 3], values: [f64; 3], node: Place) -> f64 {
    if values.iter().any(|value| value.is_nan()) {
        return f64::NAN;
    }
    let [a, b, c] = triangle.map(|corner| [corner[0] - node[0], corner[1] - node[1]]);
    let weights = [(b, c), (c, a), (a, b)].map(|(p, q)| (p[0] * q[1] - p[1] * q[0]).max(0.0));
    let total: f64 = weights.iter().sum();
    if total <= 0.0 {
        // The triangle is flatter than rounding tells: the nearest corner is as good as any.
        let squared = [a, b, c].map(|[x, y]| x * x + y * y);
        let nearest = (0..3).min_by(|&i, &j| squared[i].total_cmp(&squared[j]));
        return values[nearest.unwrap_or(0)];
    }
    let value = (0..3).map(|i| weights[i] / total * values[i]).sum::<f64>();
    let [low, high] = range(values);
    value.clamp(low, high)
}
