//! Surfaces with folds, walls and spikes, sampled on rasters and at random with a fixed seed.

use std::f64::consts::TAU;

use asphera_surface::{Relief, Topography, topography};

use crate::random::Random;
use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::Mesh;

/// How a surface is sampled over its two parameters.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Sampled {
    /// `along` × `across` nodes, the first ones half a step inside.
    Raster { along: usize, across: usize },
    /// The same number of places, evenly scattered.
    Scattered { count: usize, seed: u64 },
}

impl Sampled {
    /// Places in the unit square.
    pub(crate) fn places(self) -> Vec<[f64; 2]> {
        match self {
            Sampled::Raster { along, across } => (0..across)
                .flat_map(|j| (0..along).map(move |i| [i, j]))
                .map(|[i, j]| [(i as f64 + 0.5) / along as f64, (j as f64 + 0.5) / across as f64])
                .collect(),
            Sampled::Scattered { count, seed } => {
                let mut random = Random::new(seed);
                (0..count).map(|_| [random.unit(), random.unit()]).collect()
            }
        }
    }
}

/// A height over a square of `side_mm`.
pub(crate) fn over_square(
    sampled: Sampled,
    side_mm: f64,
    mut height_mm: impl FnMut(f64, f64) -> f64,
) -> Vec<PointMm> {
    let places = sampled.places().into_iter();
    places.map(|[u, v]| (side_mm * u, side_mm * v)).map(|(x, y)| [x, y, height_mm(x, y)]).collect()
}

/// A sphere of radius 10 mm from its north pole to `colatitude_rad`, evenly over its area.
pub(crate) fn sphere(sampled: Sampled, colatitude_rad: f64) -> Vec<PointMm> {
    let places = sampled.places().into_iter();
    places
        .map(|[u, v]| {
            let z = 1.0 - v * (1.0 - colatitude_rad.cos());
            let radius = (1.0 - z * z).max(0.0).sqrt();
            [10.0 * radius * (TAU * u).cos(), 10.0 * radius * (TAU * u).sin(), 10.0 * z]
        })
        .collect()
}

/// A cylinder of radius 5 mm and length 20 mm whose axis is the y axis, from one angle about it to
/// another; 0 is its upper line.
pub(crate) fn cylinder(sampled: Sampled, from_rad: f64, to_rad: f64) -> Vec<PointMm> {
    let places = sampled.places().into_iter();
    places
        .map(|[u, v]| {
            let angle = from_rad + u * (to_rad - from_rad);
            [5.0 * angle.sin(), 20.0 * v, 5.0 * angle.cos()]
        })
        .collect()
}

/// A sheet 20 mm wide that leans back over itself like a Z, of height `height_mm`.
pub(crate) fn leaning_sheet(sampled: Sampled, height_mm: f64) -> Vec<PointMm> {
    let places = sampled.places().into_iter();
    places.map(|[u, v]| [20.0 * (u + 0.35 * (TAU * u).sin()), 20.0 * v, height_mm * u]).collect()
}

/// The triangulation of the projection of points, as vertices and triangles.
pub(crate) fn meshed(points: &[PointMm]) -> (Vec<PointMm>, Vec<[VertexId; 3]>) {
    let mut mesh = Mesh::new();
    mesh.extend(points.iter().copied());
    mesh.flush();
    (mesh.points().to_vec(), mesh.triangles())
}

/// The regions of the mesh of points with the default limits.
pub(crate) fn surveyed(points: &[PointMm]) -> Topography {
    let (points, triangles) = meshed(points);
    topography(&points, &triangles, &Relief::default())
}
