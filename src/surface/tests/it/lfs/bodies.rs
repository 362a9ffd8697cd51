//! Bodies whose local feature size is known everywhere, sampled at random, with noise.

use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Points of a body, with their true local feature size.
pub(crate) struct Sample {
    pub(crate) points: Vec<PointMm>,
    pub(crate) normals: Vec<Option<[f64; 3]>>,
    pub(crate) lfs_mm: Vec<f64>,
    /// Largest distance of the body from its points, about.
    pub(crate) gap_mm: f64,
}

/// How a body is sampled.
#[derive(Clone, Copy)]
pub(crate) struct Sampled {
    /// About the distance of neighbours.
    pub(crate) spacing_mm: f64,
    /// Standard deviation along the normal.
    pub(crate) noise_mm: f64,
    /// Standard deviation of the tilt of each normal.
    pub(crate) tilt_rad: f64,
}

pub(crate) struct Random(Pcg64);

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        Random(Pcg64::seed_from_u64(seed))
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.uniform()).ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

/// A point of a body, its outer unit normal and the local feature size there.
pub(crate) type Place = (PointMm, [f64; 3], f64);

/// Goes over `rows` × `columns` jittered parameters from 0 to 1; the body says how many columns a row
/// has.
pub(crate) fn sample(
    sampled: Sampled,
    rows_mm: f64,
    columns_mm: impl Fn(f64) -> f64,
    body: impl Fn(f64, f64) -> Place,
) -> Sample {
    let Sampled { spacing_mm, noise_mm, tilt_rad } = sampled;
    let mut random = Random::new(7);
    let mut found = Sample { points: vec![], normals: vec![], lfs_mm: vec![], gap_mm: spacing_mm };
    let rows = (rows_mm / spacing_mm).ceil();
    for row in 0..rows as u32 {
        let v = (f64::from(row) + 0.5) / rows;
        let columns = (columns_mm(v) / spacing_mm).ceil().max(1.0);
        for column in 0..columns as u32 {
            let jitter = [random.uniform() - 0.5, random.uniform() - 0.5].map(|part| 0.4 * part);
            let u = (f64::from(column) + 0.5 + jitter[0]) / columns;
            let v = v + jitter[1] / rows;
            let (at, normal, lfs_mm) = body(u, v);
            let high = noise_mm * random.normal();
            let tilt = [0; 3].map(|_| tilt_rad * random.normal());
            found.points.push([0, 1, 2].map(|axis| at[axis] + high * normal[axis]));
            found.normals.push(Some([0, 1, 2].map(|axis| normal[axis] + tilt[axis])));
            found.lfs_mm.push(lfs_mm);
        }
    }
    found
}

/// A sphere, or the cap of it within `half_angle_rad` of the pole.
pub(crate) fn sphere(sampled: Sampled, radius_mm: f64, half_angle_rad: f64) -> Sample {
    let bottom = half_angle_rad.cos();
    sample(
        sampled,
        radius_mm * half_angle_rad,
        |v| TAU * radius_mm * (half_angle_rad * v).sin(),
        |u, v| {
            let theta = half_angle_rad * v.clamp(0.0, 1.0);
            let z = theta.cos().max(bottom);
            let out = [theta.sin() * (TAU * u).cos(), theta.sin() * (TAU * u).sin(), z];
            (out.map(|part| radius_mm * part), out, radius_mm)
        },
    )
}

/// A part of a cylinder about the y axis: `half_angle_rad` to both sides of the top.
pub(crate) fn cylinder(
    sampled: Sampled,
    radius_mm: f64,
    length_mm: f64,
    half_angle_rad: f64,
) -> Sample {
    sample(
        sampled,
        length_mm,
        |_| 2.0 * half_angle_rad * radius_mm,
        |u, v| {
            let angle = half_angle_rad * (2.0 * u - 1.0);
            let out = [angle.sin(), 0.0, angle.cos()];
            ([radius_mm * out[0], length_mm * v, radius_mm * out[2]], out, radius_mm)
        },
    )
}

/// A torus about the z axis. Its medial axis is the core circle and the z axis.
pub(crate) fn torus(sampled: Sampled, ring_mm: f64, tube_mm: f64) -> Sample {
    sample(
        sampled,
        TAU * tube_mm,
        |v| TAU * (ring_mm + tube_mm * (TAU * v).cos()),
        |u, v| {
            let out_mm = ring_mm + tube_mm * (TAU * v).cos();
            let around = [(TAU * u).cos(), (TAU * u).sin()];
            let at = [out_mm * around[0], out_mm * around[1], tube_mm * (TAU * v).sin()];
            let normal =
                [(TAU * v).cos() * around[0], (TAU * v).cos() * around[1], (TAU * v).sin()];
            (at, normal, tube_mm.min(out_mm))
        },
    )
}

/// A flattened ellipsoid of revolution about z. Its medial axis is the disc of radius (a² - c²)/a.
pub(crate) fn ellipsoid(sampled: Sampled, a_mm: f64, c_mm: f64) -> Sample {
    let disc_mm = (a_mm * a_mm - c_mm * c_mm) / a_mm;
    sample(
        sampled,
        std::f64::consts::PI * a_mm,
        |v| TAU * a_mm * (std::f64::consts::PI * v).sin(),
        |u, v| {
            let theta = std::f64::consts::PI * v.clamp(0.0, 1.0);
            let (r, z) = (a_mm * theta.sin(), c_mm * theta.cos());
            let around = [(TAU * u).cos(), (TAU * u).sin()];
            let gradient = [theta.sin() / a_mm, theta.cos() / c_mm];
            let length = gradient[0].hypot(gradient[1]);
            let normal = [
                gradient[0] / length * around[0],
                gradient[0] / length * around[1],
                gradient[1] / length,
            ];
            ([r * around[0], r * around[1], z], normal, (r - disc_mm).max(0.0).hypot(z))
        },
    )
}

/// z = r²/2R up to the radius a. Its medial axis is the axis of rotation from (0, 0, R) up.
pub(crate) fn paraboloid(sampled: Sampled, vertex_radius_mm: f64, aperture_mm: f64) -> Sample {
    sample(
        sampled,
        aperture_mm,
        |v| TAU * aperture_mm * v,
        |u, v| {
            let (r, around) = (aperture_mm * v.clamp(0.0, 1.0), [(TAU * u).cos(), (TAU * u).sin()]);
            paraboloid_at(vertex_radius_mm, r * around[0], r * around[1])
        },
    )
}

/// The place of such a paraboloid over (x, y).
pub(crate) fn paraboloid_at(vertex_radius_mm: f64, x: f64, y: f64) -> Place {
    let r = x.hypot(y);
    let z = r * r / (2.0 * vertex_radius_mm);
    let length = (1.0 + r * r / (vertex_radius_mm * vertex_radius_mm)).sqrt();
    let normal = [x / vertex_radius_mm / length, y / vertex_radius_mm / length, -1.0 / length];
    ([x, y, z], normal, r.hypot((vertex_radius_mm - z).max(0.0)))
}

/// Two sheets one above the other, their normals outward.
pub(crate) fn sheets(sampled: Sampled, side_mm: f64, apart_mm: f64) -> Sample {
    let mut both = sample(
        sampled,
        side_mm,
        |_| side_mm,
        |u, v| ([side_mm * u, side_mm * v, apart_mm], [0.0, 0.0, 1.0], 0.5 * apart_mm),
    );
    let below = sample(
        Sampled { spacing_mm: 0.97 * sampled.spacing_mm, ..sampled },
        side_mm,
        |_| side_mm,
        |u, v| ([side_mm * u, side_mm * v, 0.0], [0.0, 0.0, -1.0], 0.5 * apart_mm),
    );
    both.points.extend(below.points);
    both.normals.extend(below.normals);
    both.lfs_mm.extend(below.lfs_mm);
    both
}
