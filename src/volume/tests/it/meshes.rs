//! Meshes are closed oriented 2-manifolds for every volume.

use asphera_volume::{
    Ambiguity, BALL_RADIUS, Blend, Grey, Histogram, Majority, Method, Middles, Samples, Surface,
    facts, majority, marching_cubes, reconstruct, voxel_surface,
};

use crate::noise::Random;

const RULES: [Ambiguity; 3] = [Ambiguity::Apart, Ambiguity::Joined, Ambiguity::Paired];

pub(crate) fn assert_manifold(surface: &Surface, what: &str) {
    let check = surface.check();
    assert!(check.is_closed && check.is_oriented && check.is_manifold, "{what}: {check:?}");
}

/// A volume of one cell of each code, and the complements of it within a larger block.
#[test]
fn every_code_gives_a_closed_oriented_manifold() {
    for code in 0..=255_u8 {
        let bit = |x: usize, y: usize, z: usize| code >> (x + 2 * y + 4 * z) & 1 == 1;
        let alone = Samples::from_fn([2, 2, 2], bit).unwrap();
        let within = Samples::from_fn([4, 4, 4], |x, y, z| {
            let is_middle = [x, y, z].iter().all(|&at| at == 1 || at == 2);
            !is_middle || bit(x - 1, y - 1, z - 1)
        })
        .unwrap();
        for rule in RULES {
            for samples in [&alone, &within] {
                let surface = marching_cubes(samples, rule, &Middles);
                assert_manifold(&surface, &format!("{code:08b} {rule:?}"));
                assert!(surface.volume() >= 0.0 && surface.is_outward(samples), "{code:08b}");
            }
        }
    }
}

trait Outward {
    fn is_outward(&self, samples: &Samples) -> bool;
}

impl Outward for Surface {
    /// Whether there is volume where there is foreground, and none where there is none.
    fn is_outward(&self, samples: &Samples) -> bool {
        (self.volume() > 0.0) == (samples.foreground() > 0)
    }
}

/// Random volumes of 8³ samples: 10⁶ with `ASPHERA_LONG`.
fn random_volumes(usual: usize) -> usize {
    if std::env::var_os("ASPHERA_LONG").is_some() { 1_000_000 } else { usual }
}

#[test]
fn random_volumes_give_closed_oriented_manifolds() {
    let mut random = Random::new(1);
    for round in 0..random_volumes(400) {
        let share = random.between(0.05, 0.95);
        let samples = random.volume([8, 8, 8], share);
        for rule in RULES {
            assert_manifold(
                &marching_cubes(&samples, rule, &Middles),
                &format!("{round} {rule:?}"),
            );
        }
    }
}

/// Grey values move vertices along their edges and leave the triangles as they are.
#[test]
fn grey_values_move_vertices_only() {
    let mut random = Random::new(2);
    let size = [9, 7, 8];
    let mut values: Vec<f32> = (0..9 * 7 * 8).map(|_| random.unit() as f32).collect();
    values[17] = f32::NAN;
    values[200] = f32::INFINITY;
    let threshold = 0.4;
    let bools: Vec<bool> = values.iter().map(|&value| value >= threshold).collect();
    let samples = Samples::from_bools(size, &bools).unwrap();
    let by_middles = marching_cubes(&samples, Ambiguity::Paired, &Middles);
    let grey = Grey { values: &values, size, threshold };
    let by_grey = marching_cubes(&samples, Ambiguity::Paired, &grey);
    assert_eq!(by_grey.triangles, by_middles.triangles);
    for (a, b) in by_grey.vertices.iter().zip(&by_middles.vertices) {
        let moved: f64 = (0..3).map(|axis| (a[axis] - b[axis]).abs()).sum();
        assert!(moved <= 0.49 + 1e-12);
    }
    assert!(by_grey != by_middles);
    assert_manifold(&by_grey, "grey");
}

/// A plane of grey values is found exactly.
#[test]
fn a_grey_plane_is_found_where_it_lies() {
    let size = [6, 6, 6];
    let at = |x: usize, y: usize, z: usize| 3.3 - 0.31 * x as f32 - 0.17 * y as f32 - z as f32;
    let values: Vec<f32> = (0..216).map(|i| at(i % 6, i / 6 % 6, i / 36)).collect();
    let samples = Samples::from_fn(size, |x, y, z| at(x, y, z) >= 0.0).unwrap();
    let grey = Grey { values: &values, size, threshold: 0.0 };
    let surface = marching_cubes(&samples, Ambiguity::Paired, &grey);
    let is_free = |p: &[f64; 3]| p.iter().all(|&v| v > 0.02 && v < 4.98);
    let mut seen = 0;
    for p in
        surface.vertices.iter().filter(|p| is_free(p) && p[2].fract() > 0.02 && p[2].fract() < 0.98)
    {
        let depth = 3.3 - 0.31 * p[0] - 0.17 * p[1] - p[2];
        assert!(depth.abs() < 1e-5, "{p:?} {depth}");
        seen += 1;
    }
    assert!(seen > 10);
}

/// Every method that is no marching cubes.
const METHODS: [Method; 6] = [
    Method::Voxels,
    Method::Majority(Majority::Foreground),
    Method::Majority(Majority::Complement),
    Method::Trilinear { refine: 2 },
    Method::Smooth { blend: Blend::Cubic, refine: 3 },
    Method::Balls { radius: BALL_RADIUS, refine: 3 },
];

#[test]
fn every_method_gives_a_closed_oriented_manifold() {
    let mut random = Random::new(6);
    let mut volumes: Vec<Samples> = (0..=255_u8)
        .map(|code| {
            Samples::from_fn([2, 2, 2], |x, y, z| code >> (x + 2 * y + 4 * z) & 1 == 1).unwrap()
        })
        .collect();
    for _ in 0..60 {
        let share = random.between(0.05, 0.95);
        volumes.push(random.volume([8, 8, 8], share));
    }
    for (index, samples) in volumes.iter().enumerate() {
        for method in METHODS {
            let surface = reconstruct(samples, &method, &Middles).unwrap();
            assert_manifold(&surface, &format!("volume {index} {method:?}"));
        }
        let voxels = voxel_surface(samples);
        assert!((voxels.volume() - samples.foreground() as f64).abs() < 1e-9);
    }
}

/// Theorem 18, and the theorem 4 that says what it means: neither C1 nor C2.
#[test]
fn majority_interpolation_is_well_composed_for_every_volume() {
    let mut random = Random::new(7);
    for _ in 0..random_volumes(300) {
        let share = random.between(0.05, 0.95);
        let samples = random.volume([8, 8, 8], share);
        for which in [Majority::Foreground, Majority::Complement] {
            let finer = majority(&samples, which).unwrap();
            let histogram = Histogram::new(&finer);
            let critical = |code: u8| {
                let facts = facts()[usize::from(code)];
                facts.c1_faces != 0 || facts.is_c2
            };
            assert_eq!(histogram.count_where(critical), 0);
        }
        let other = majority(&samples.complement(), Majority::Complement).unwrap();
        let own = majority(&samples, Majority::Foreground).unwrap();
        // Within the volume, away from the layer around it, one is the complement of the other.
        for place in [[4, 5, 6], [9, 9, 9], [2, 3, 15], [11, 16, 2], [7, 7, 8]] {
            assert!(own.get(place) != other.get(place));
        }
    }
}

#[test]
fn trilinear_vertices_lie_on_the_zero_set() {
    let samples = Samples::from_fn([3, 3, 3], |x, y, z| [x, y, z] == [1, 1, 1]).unwrap();
    let surface = reconstruct(&samples, &Method::Trilinear { refine: 5 }, &Middles).unwrap();
    for vertex in &surface.vertices {
        let weights: f64 = vertex.iter().map(|place| 1.0 - (place - 1.0).abs()).product();
        assert!((2.0 * weights - 1.0).abs() < 1e-12, "{vertex:?}");
    }
    let surface =
        reconstruct(&samples, &Method::Balls { radius: 0.9, refine: 5 }, &Middles).unwrap();
    for vertex in &surface.vertices {
        let square: f64 = vertex.iter().map(|place| (place - 1.0).powi(2)).sum();
        assert!((square.sqrt() - 0.9).abs() < 1e-12, "{vertex:?}");
    }
}
