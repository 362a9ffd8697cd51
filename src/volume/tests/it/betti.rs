//! Euler and Betti numbers against programs that others wrote.

use asphera_volume::{Histogram, Samples, Topology};

/// Seed, share of foreground in percent, and what the programs found: foreground, Euler numbers (6, 26), components, tunnels and
/// cavities.
///
/// Made by scikit-image 0.26.0 (`euler_number` with connectivity 1 and 3, `label`) and gudhi 3.13.0 (Betti numbers of the cubical
/// complex with the samples as vertices); both agree.
const FOUND: [(u64, u64, u64, i64, i64, [i64; 3]); 7] = [
    (1, 10, 80, 61, 19, [61, 0, 0]),
    (2, 25, 210, 72, -37, [73, 1, 0]),
    (3, 40, 327, 33, -74, [41, 8, 0]),
    (4, 50, 394, -17, -43, [14, 31, 0]),
    (5, 60, 465, -54, -24, [9, 63, 0]),
    (6, 75, 585, -69, 20, [1, 70, 0]),
    (7, 90, 717, 2, 24, [1, 4, 5]),
];

/// The generator that the script used, too (Knuth, MMIX).
fn samples(seed: u64, share: u64) -> Samples {
    let mut state = seed;
    Samples::from_fn([11, 9, 8], |_, _, _| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % 100 < share
    })
    .unwrap()
}

#[test]
fn euler_and_betti_numbers_are_those_of_scikit_image_and_gudhi() {
    for (seed, share, foreground, euler_6, euler_26, betti) in FOUND {
        let samples = samples(seed, share);
        assert_eq!(samples.foreground(), foreground);
        let found = Topology::new(&samples, &Histogram::new(&samples));
        assert_eq!((found.euler_6, found.euler_26), (euler_6, euler_26), "{seed}");
        let numbers = [found.components as i64, found.tunnels, found.cavities as i64];
        assert_eq!(numbers, betti, "{seed}");
    }
}

#[test]
fn degenerate_volumes_have_a_topology() {
    let of = |size, is_inside: fn(usize, usize, usize) -> bool| {
        let samples = Samples::from_fn(size, is_inside).unwrap();
        let found = Topology::new(&samples, &Histogram::new(&samples));
        (
            found.euler_6,
            found.euler_26,
            [found.components as i64, found.tunnels, found.cavities as i64],
        )
    };
    assert_eq!(of([3, 3, 3], |_, _, _| false), (0, 0, [0, 0, 0]));
    assert_eq!(of([64, 1, 1], |_, _, _| true), (1, 1, [1, 0, 0]));
    assert_eq!(of([1, 1, 1], |_, _, _| true), (1, 1, [1, 0, 0]));
    assert_eq!(of([3, 3, 3], |x, y, z| [x, y, z] != [1, 1, 1]), (2, 2, [1, 0, 1]));
    assert_eq!(of([3, 3, 1], |x, y, _| [x, y] != [1, 1]), (0, 0, [1, 1, 0]));
    assert_eq!(of([2, 2, 1], |x, y, _| x == y), (2, 1, [2, 0, 0]));
}
