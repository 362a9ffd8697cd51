//! The deviation on a regular grid: as measured where the points lie on a raster, interpolated elsewhere.

use std::fmt;

use asphera_figures::{Interpolation, Lattice};
use asphera_geometry::{BoundsMm, PointMm, VertexId};
use asphera_mesh::Mesh;
use asphera_report::Picture;
use asphera_surface::{Grid, rasterize};

/// A deviation map on a regular grid.
#[derive(Clone, Debug, PartialEq)]
pub struct DeviationMap {
    /// The nodes, u and v of the plane of projection: x and y of the measured frame, where it is projected
    /// along z. They are turned about its origin by `turn_rad`.
    pub grid: Grid,
    /// Angle from u towards v of the rows of the grid; 0 unless a turned raster was measured.
    pub turn_rad: f64,
    /// Deviation at every node, nm, x fastest; NaN where nothing was measured.
    pub values_nm: Vec<f64>,
    /// Where the heights come from.
    pub source: MapSource,
}

/// Where the heights of a map come from.
#[derive(Clone, Debug, PartialEq)]
pub enum MapSource {
    /// The points lie on a raster, whose nodes are those of the map: heights are as measured.
    Raster {
        /// Empty nodes between well-sampled neighbours, with the deviation that these give there, nm.
        bridged_nm: Vec<(usize, f64)>,
        /// Points beside its nodes, which the map leaves out.
        strays: usize,
    },
    /// The points lie on no raster: heights are interpolated linearly between them.
    Scattered {
        /// How much of a wave that leaves.
        interpolation: Interpolation,
    },
}

/// As a file of the map says it.
impl fmt::Display for MapSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            MapSource::Raster { strays, .. } => {
                f.write_str("heights as measured, on the raster of the points")?;
                match strays {
                    0 => Ok(()),
                    1 => f.write_str("; 1 point beside its nodes is left out"),
                    more => write!(f, "; {more} points beside its nodes are left out"),
                }
            }
            MapSource::Scattered { interpolation } => write!(
                f,
                "heights interpolated linearly between scattered points: waves of {:.4} mm lose half of their power, shorter ones more",
                1.0 / interpolation.half_power_per_mm()
            ),
        }
    }
}

impl DeviationMap {
    /// The deviations at the vertices of a mesh. Where these lie on a raster, at its nodes, as they are; else at nodes as
    /// far apart as the points are on average, over well-sampled triangles only: a gap is never bridged. `None` without
    /// an area.
    pub(super) fn of(
        mesh: &Mesh,
        (triangles, covered): (&[[VertexId; 3]], &[bool]),
        deviations_nm: &[f64],
    ) -> Option<DeviationMap> {
        let places_mm: Vec<[f64; 2]> = mesh.points().iter().map(|&[x, y, _]| [x, y]).collect();
        let good = triangles.iter().zip(covered).filter(|(_, good)| **good);
        let good: Vec<[VertexId; 3]> = good.map(|(corners, _)| *corners).collect();
        match Lattice::find(&places_mm, triangles) {
            Some(lattice) => on_raster(mesh.points(), &lattice, good, deviations_nm),
            None => interpolated(mesh.points(), &places_mm, good, deviations_nm),
        }
    }

    /// The map upright and of no more nodes than a picture needs, each of them the nearest of this map.
    pub(super) fn picture(&self) -> Picture {
        let grid = &self.grid;
        if self.turn_rad == 0.0 && grid.nx.max(grid.ny) <= MOST_DRAWN {
            return pictured(grid, self.values_nm.clone());
        }
        let ends = [[0, 0], [grid.nx - 1, 0], [0, grid.ny - 1], [grid.nx - 1, grid.ny - 1]];
        let corners = ends.map(|[i, j]| {
            let at = [grid.x0_mm + i as f64 * grid.dx_mm, grid.y0_mm + j as f64 * grid.dy_mm];
            turned(at, self.turn_rad)
        });
        let end = |axis: usize, pick: fn(f64, f64) -> f64| {
            corners.iter().map(|corner| corner[axis]).reduce(pick).unwrap_or(0.0)
        };
        let low = [end(0, f64::min), end(1, f64::min)];
        let size = [end(0, f64::max) - low[0], end(1, f64::max) - low[1]];
        let pitch = [grid.dx_mm, grid.dy_mm]
            .map(|step| step.max(size[0].max(size[1]) / (MOST_DRAWN - 1) as f64));
        let nodes = |axis: usize| (size[axis] / pitch[axis]).round() as usize + 1;
        let drawn = Grid {
            x0_mm: low[0],
            y0_mm: low[1],
            dx_mm: pitch[0],
            dy_mm: pitch[1],
            nx: nodes(0),
            ny: nodes(1),
        };
        let value = |node: usize| {
            let (i, j) = ((node % drawn.nx) as f64, (node / drawn.nx) as f64);
            let place = [low[0] + i * pitch[0], low[1] + j * pitch[1]];
            self.nearest_nm(turned(place, -self.turn_rad))
        };
        let values_nm = (0..drawn.nx * drawn.ny).map(value).collect();
        pictured(&drawn, values_nm)
    }

    /// At the node nearest to a place of the turned frame; NaN outside.
    fn nearest_nm(&self, place_mm: [f64; 2]) -> f64 {
        let grid = &self.grid;
        let i = ((place_mm[0] - grid.x0_mm) / grid.dx_mm).round();
        let j = ((place_mm[1] - grid.y0_mm) / grid.dy_mm).round();
        let inside = i >= 0.0 && j >= 0.0 && i < grid.nx as f64 && j < grid.ny as f64;
        if inside { self.values_nm[j as usize * grid.nx + i as usize] } else { f64::NAN }
    }
}

fn pictured(grid: &Grid, values_nm: Vec<f64>) -> Picture {
    let Grid { nx, ny, x0_mm, y0_mm, dx_mm, dy_mm } = *grid;
    Picture { nx, ny, x0_mm, y0_mm, dx_mm, dy_mm, values_nm }
}

/// The deviations at the nodes of a raster.
fn on_raster(
    points: &[PointMm],
    lattice: &Lattice,
    good: Vec<[VertexId; 3]>,
    deviations_nm: &[f64],
) -> Option<DeviationMap> {
    let turn_rad = lattice.turn_rad();
    let [x0_mm, y0_mm] = turned(lattice.origin_mm(), -turn_rad);
    let [dx_mm, dy_mm] = lattice.spacing_mm();
    let grid = Grid { x0_mm, y0_mm, dx_mm, dy_mm, nx: lattice.columns(), ny: lattice.rows() };
    let at = |place: Option<usize>| place.map_or(f64::NAN, |place| deviations_nm[place]);
    let values_nm: Vec<f64> = lattice.places().map(at).collect();
    let mut bridged_nm = Vec::new();
    if lattice.places().any(|place| place.is_none()) {
        let upright: Vec<PointMm> = points
            .iter()
            .map(|&[x, y, z]| {
                let [x, y] = turned([x, y], -turn_rad);
                [x, y, z]
            })
            .collect();
        let between = rasterize(&upright, good, deviations_nm, &grid).ok()?;
        let empty = lattice.places().zip(between).enumerate();
        bridged_nm = empty
            .filter(|(_, (place, nm))| place.is_none() && nm.is_finite())
            .map(|(node, (_, nm))| (node, nm))
            .collect();
    }
    let source = MapSource::Raster { bridged_nm, strays: lattice.strays() };
    Some(DeviationMap { grid, turn_rad, values_nm, source })
}

/// The deviations between points, at nodes as far apart as these are on average.
fn interpolated(
    points: &[PointMm],
    places_mm: &[[f64; 2]],
    good: Vec<[VertexId; 3]>,
    deviations_nm: &[f64],
) -> Option<DeviationMap> {
    let bounds = BoundsMm::about(places_mm.iter().copied());
    let (low, size) = (bounds.low, bounds.size_mm());
    let pitch = (size[0] * size[1] / points.len() as f64).sqrt();
    let pitch = pitch.max(size[0] / MOST_STEPS).max(size[1] / MOST_STEPS);
    if !(pitch.is_finite() && pitch > 0.0) {
        return None;
    }
    let nodes = |length: f64| (length / pitch).round() as usize + 1;
    let (nx, ny) = (nodes(size[0]).max(2), nodes(size[1]).max(2));
    let grid = Grid {
        x0_mm: low[0],
        y0_mm: low[1],
        dx_mm: size[0] / (nx - 1) as f64,
        dy_mm: size[1] / (ny - 1) as f64,
        nx,
        ny,
    };
    let interpolation = Interpolation::over(places_mm, &good, 0.5 / grid.dx_mm.max(grid.dy_mm));
    let values_nm = rasterize(points, good, deviations_nm, &grid).ok()?;
    let source = MapSource::Scattered { interpolation };
    Some(DeviationMap { grid, turn_rad: 0.0, values_nm, source })
}

/// Turned about the origin.
fn turned([x, y]: [f64; 2], angle_rad: f64) -> [f64; 2] {
    let (sin, cos) = angle_rad.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// Most steps along one side of an interpolated map.
const MOST_STEPS: f64 = 4095.0;
/// Most nodes along one side of a picture.
const MOST_DRAWN: usize = 1024;
