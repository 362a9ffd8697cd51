//! The same figures however a volume is turned, mirrored, shifted, handed over or shared among threads.

use asphera_volume::{
    Ambiguity, GridCheck, Histogram, Middles, Samples, Surface, Topology, marching_cubes,
};

use crate::noise::Random;

/// What must not depend on the pose: areas and volumes are summed in another order and compared apart.
#[derive(Debug, PartialEq)]
struct Figures {
    topology: Topology,
    check: [u64; 5],
    triangles: [usize; 3],
    euler: [i64; 3],
}

fn meshes(samples: &Samples) -> [Surface; 3] {
    [Ambiguity::Apart, Ambiguity::Joined, Ambiguity::Paired]
        .map(|rule| marching_cubes(samples, rule, &Middles))
}

fn figures(samples: &Samples) -> (Figures, [f64; 6]) {
    let histogram = Histogram::new(samples);
    let check = GridCheck::new(samples, &histogram);
    let meshes = meshes(samples);
    let figures = Figures {
        topology: Topology::new(samples, &histogram),
        check: [check.case8, check.case8_unpaired, check.forbidden, check.c1, check.c2],
        triangles: meshes.each_ref().map(|mesh| mesh.triangles.len()),
        euler: meshes.each_ref().map(Surface::euler),
    };
    let mut sums = [0.0; 6];
    for (index, mesh) in meshes.iter().enumerate() {
        sums[2 * index] = mesh.area();
        sums[2 * index + 1] = mesh.volume();
    }
    (figures, sums)
}

fn assert_same(a: &Samples, b: &Samples, what: &str) {
    let ((one, sums_of_one), (other, sums_of_other)) = (figures(a), figures(b));
    assert_eq!(one, other, "{what}");
    for (x, y) in sums_of_one.iter().zip(sums_of_other) {
        assert!((x - y).abs() < 1e-9 * x.abs().max(1.0), "{what}: {x} {y}");
    }
}

#[test]
fn turned_mirrored_and_shifted_volumes_have_the_same_figures() {
    let mut random = Random::new(3);
    for share in [0.1, 0.5, 0.8] {
        let size = [66, 7, 9];
        let samples = random.volume(size, share);
        let at = |x: usize, y: usize, z: usize| samples.get([x as i64, y as i64, z as i64]);
        let [nx, ny, nz] = size;
        let turned = Samples::from_fn([ny, nx, nz], |x, y, z| at(y, ny - 1 - x, z)).unwrap();
        assert_same(&samples, &turned, "turned about z");
        let turned = Samples::from_fn([nz, ny, nx], |x, y, z| at(nx - 1 - z, y, x)).unwrap();
        assert_same(&samples, &turned, "turned about y");
        let turned = Samples::from_fn([ny, nz, nx], |x, y, z| at(z, x, y)).unwrap();
        assert_same(&samples, &turned, "turned about the space diagonal");
        let mirrored = Samples::from_fn(size, |x, y, z| at(nx - 1 - x, y, z)).unwrap();
        assert_same(&samples, &mirrored, "mirrored");
        for shift in [[1, 0, 0], [63, 2, 1], [64, 0, 5]] {
            let size: [usize; 3] = std::array::from_fn(|axis| size[axis] + shift[axis] + axis);
            let moved = Samples::from_fn(size, |x, y, z| {
                let [x, y, z]: [i64; 3] =
                    [(x, 0), (y, 1), (z, 2)].map(|(at, axis)| at as i64 - shift[axis] as i64);
                samples.get([x, y, z])
            })
            .unwrap();
            assert_same(&samples, &moved, "shifted");
        }
    }
}

/// Foreground (6) and background (26) change places with the Euler numbers, less the outside of the box.
#[test]
fn the_complement_has_the_other_euler_number() {
    let mut random = Random::new(4);
    for _ in 0..20 {
        let inner = random.volume([6, 7, 8], 0.5);
        // A wall of background lets the complement in a larger box have the same surface.
        let at =
            |x: usize, y: usize, z: usize| inner.get([x as i64 - 1, y as i64 - 1, z as i64 - 1]);
        let walled = Samples::from_fn([8, 9, 10], at).unwrap();
        let block = walled.complement();
        let (here, there) = (Histogram::new(&walled), Histogram::new(&block));
        let (here, there) = (Topology::new(&walled, &here), Topology::new(&block, &there));
        // A solid has half the Euler number of its surface; that of the block is a sphere and the surface of what is cut out.
        assert_eq!(there.euler_6, 1 + here.euler_26);
        assert_eq!(there.euler_26, 1 + here.euler_6);
        // Apart and joined exchange: the same surface seen from the other side, and that of the block about it.
        let own = marching_cubes(&walled, Ambiguity::Apart, &Middles);
        let other = marching_cubes(&block, Ambiguity::Joined, &Middles);
        assert_eq!(other.euler(), own.euler() + 2);
    }
}

#[test]
fn threads_change_no_bit() {
    let mut random = Random::new(5);
    let samples = random.volume([70, 30, 90], 0.4);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let histogram = Histogram::new(&samples);
            (GridCheck::new(&samples, &histogram), histogram, meshes(&samples))
        })
    };
    let alone = on(1);
    for threads in [2, 3, 7] {
        assert!(on(threads) == alone, "{threads}");
    }
}
