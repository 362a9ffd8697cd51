//! Surfaces whose normals and curvatures are known in closed form, and samples of them, for tests.

use std::f64::consts::TAU;

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::Mesh;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::Adjacency;

/// Height in mm, slopes along x and y, and principal curvatures in 1/mm, the larger first.
pub(crate) struct Truth {
    pub(crate) height_mm: f64,
    pub(crate) slope: [f64; 2],
    pub(crate) curvatures_per_mm: [f64; 2],
}

/// A surface of revolution about z by its meridian's height and derivatives at a radius: the
/// curvatures are those of the meridian and of its turning about the axis.
fn revolved(x: f64, y: f64, meridian: impl Fn(f64) -> [f64; 3]) -> Truth {
    let radius = x.hypot(y);
    let [height_mm, rise, bend] = meridian(radius);
    let secant = rise.hypot(1.0);
    let along = bend / secant.powi(3);
    let about = if radius == 0.0 { along } else { rise / (radius * secant) };
    let slope = if radius == 0.0 { [0.0; 2] } else { [rise * x / radius, rise * y / radius] };
    Truth { height_mm, slope, curvatures_per_mm: [along.max(about), along.min(about)] }
}

/// A bowl of radius 20 mm.
pub(crate) fn sphere(x: f64, y: f64) -> Truth {
    revolved(x, y, |r| {
        let depth = (400.0 - r * r).sqrt();
        [20.0 - depth, r / depth, 400.0 / depth.powi(3)]
    })
}

/// z = r²/30.
pub(crate) fn paraboloid(x: f64, y: f64) -> Truth {
    revolved(x, y, |r| [r * r / 30.0, r / 15.0, 1.0 / 15.0])
}

/// The asphere of Thorlabs AL1815-C, first three coefficients: R = 11.65 mm, conic constant -1.1.
pub(crate) fn asphere(x: f64, y: f64) -> Truth {
    const C: f64 = 1.0 / 11.65;
    const A: [f64; 3] = [3.69067205091e-5, -1.285461192617e-8, -1.400167659754e-10];
    revolved(x, y, |r| {
        let root = (1.0 + 0.1 * C * C * r * r).sqrt();
        let r2 = r * r;
        let height = C * r2 / (1.0 + root) + r2 * r2 * (A[0] + r2 * (A[1] + r2 * A[2]));
        let rise = C * r / root + r2 * r * (4.0 * A[0] + r2 * (6.0 * A[1] + r2 * 8.0 * A[2]));
        let bend = C / root.powi(3) + r2 * (12.0 * A[0] + r2 * (30.0 * A[1] + r2 * 56.0 * A[2]));
        [height, rise, bend]
    })
}

/// The upper side of a torus about z: tube of radius 3 mm, its centre 10 mm from the axis.
pub(crate) fn torus(x: f64, y: f64) -> Truth {
    revolved(x, y, |r| {
        let out = r - 10.0;
        let depth = (9.0 - out * out).sqrt();
        [depth, -out / depth, -9.0 / depth.powi(3)]
    })
}

/// A ridge of radius 8 mm along y, turned by 0.3 rad about z.
pub(crate) fn cylinder(x: f64, y: f64) -> Truth {
    let (sin, cos) = 0.3_f64.sin_cos();
    let across = x * cos + y * sin;
    let depth = (64.0 - across * across).sqrt();
    let rise = -across / depth;
    Truth {
        height_mm: depth,
        slope: [rise * cos, rise * sin],
        curvatures_per_mm: [0.0, -1.0 / 8.0],
    }
}

/// A freeform: a saddle with a wave. Curvatures by the formulas of a graph for mean and Gaussian
/// curvature.
pub(crate) fn freeform(x: f64, y: f64) -> Truth {
    let (sin, cos) = (0.4 * x).sin_cos();
    let height_mm = 0.02 * (x * x - y * y) + 0.001 * x * x * y + 0.01 * sin * y;
    let [gx, gy] =
        [0.04 * x + 0.002 * x * y + 0.004 * cos * y, -0.04 * y + 0.001 * x * x + 0.01 * sin];
    let [xx, xy, yy] = [0.04 + 0.002 * y - 0.0016 * sin * y, 0.002 * x + 0.004 * cos, -0.04];
    let squared = 1.0 + gx * gx + gy * gy;
    let gaussian = (xx * yy - xy * xy) / (squared * squared);
    let mean = ((1.0 + gy * gy) * xx - 2.0 * gx * gy * xy + (1.0 + gx * gx) * yy)
        / (2.0 * squared * squared.sqrt());
    let apart = (mean * mean - gaussian).sqrt();
    Truth { height_mm, slope: [gx, gy], curvatures_per_mm: [mean + apart, mean - apart] }
}

/// Seeded random numbers.
pub(crate) struct Random(Pcg64);

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        Random(Pcg64::seed_from_u64(seed))
    }

    /// Evenly distributed from 0 to below 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Normally distributed with deviation 1 (Box and Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (TAU * self.unit()).cos()
    }
}

/// `side`² places of a raster about a centre, each moved by up to `jitter` of the pitch.
pub(crate) fn raster(
    centre: [f64; 2],
    side: usize,
    pitch_mm: f64,
    jitter: f64,
    seed: u64,
) -> Vec<[f64; 2]> {
    let mut random = Random::new(seed);
    let middle = (side - 1) as f64 / 2.0;
    (0..side * side)
        .map(|i| {
            [i % side, i / side].map(|index| {
                pitch_mm * (index as f64 - middle + jitter * (2.0 * random.unit() - 1.0))
            })
        })
        .map(|[x, y]| [centre[0] + x, centre[1] + y])
        .collect()
}

/// Points of a surface over places.
pub(crate) fn over(places: &[[f64; 2]], surface: impl Fn(f64, f64) -> Truth) -> Vec<PointMm> {
    places.iter().map(|&[x, y]| [x, y, surface(x, y).height_mm]).collect()
}

/// Adds white noise along z.
pub(crate) fn roughen(points: &mut [PointMm], sigma_mm: f64, seed: u64) {
    let mut random = Random::new(seed);
    points.iter_mut().for_each(|point| point[2] += sigma_mm * random.normal());
}

/// The points as vertices of a mesh in the same order, and its triangles.
pub(crate) fn triangles(points: &[PointMm]) -> Vec<[VertexId; 3]> {
    let mut mesh = Mesh::new();
    mesh.insert(points);
    assert!(mesh.points() == points, "a point is no vertex of its own");
    mesh.triangles()
}

/// The neighbours in the mesh of points, up to the reach.
pub(crate) fn adjacency(points: &[PointMm], reach_mm: Option<f64>) -> Adjacency {
    Adjacency::new(points, &triangles(points), reach_mm).unwrap()
}
