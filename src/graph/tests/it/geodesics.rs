//! Geodesic distances and principal axes against their truth.

use asphera_graph::{Cloud, functions};

use crate::bodies::{Body, Random, norm};

/// The largest error over the largest distance.
fn worst(cloud: &Cloud<3>, source: u32, truth: impl Fn([f64; 3], [f64; 3]) -> f64) -> f64 {
    let nearest = cloud.nearest(12).unwrap();
    let found = functions::geodesic(cloud, &nearest, &[source]).unwrap();
    let from = cloud.places()[source as usize];
    let truths: Vec<f64> = cloud.places().iter().map(|place| truth(from, *place)).collect();
    let largest = truths.iter().copied().fold(0.0, f64::max);
    let errors = found.values.iter().zip(&truths).map(|(found, truth)| (found - truth).abs());
    errors.fold(0.0, f64::max) / largest
}

#[test]
fn distances_on_a_plane_a_sphere_and_a_cone() {
    let mut random = Random::new(8);
    let sphere = Cloud::new(&Body::sphere().sample(30_000, &mut random)).unwrap();
    let chord = |p: [f64; 3], q: [f64; 3]| norm(std::array::from_fn(|axis| p[axis] - q[axis]));
    let on_sphere = worst(&sphere, 77, |p, q| 2.0 * (chord(p, q) / 2.0).min(1.0).asin());
    let plane: Vec<_> = (0..30_000).map(|_| [random.unit(), random.unit(), 0.0]).collect();
    let on_plane = worst(&Cloud::new(&plane).unwrap(), 4_000, chord);
    // A cone of half angle 30°: unrolled it is half a disc.
    let cone: Vec<_> = (0..30_000)
        .map(|_| {
            let (radius, angle) = (random.unit().sqrt(), std::f64::consts::TAU * random.unit());
            [0.5 * radius * angle.cos(), 0.5 * radius * angle.sin(), 0.75_f64.sqrt() * radius]
        })
        .collect();
    let on_cone = worst(&Cloud::new(&cone).unwrap(), 12_345, |p, q| {
        let mut turn = (p[1].atan2(p[0]) - q[1].atan2(q[0])).abs();
        turn = turn.min(std::f64::consts::TAU - turn) / 2.0;
        let (a, b) = (norm(p), norm(q));
        (a * a + b * b - 2.0 * a * b * turn.cos()).sqrt()
    });
    println!("largest errors: plane {on_plane:.5}, sphere {on_sphere:.5}, cone {on_cone:.5}");
    assert!(
        on_plane < 0.02 && on_sphere < 0.02 && on_cone < 0.02,
        "{on_plane} {on_sphere} {on_cone}"
    );
}

#[test]
fn the_ends_of_a_rod_are_its_farthest_pair_and_parts_have_sources_of_their_own() {
    let mut random = Random::new(9);
    let mut points = Vec::new();
    for _ in 0..4000 {
        points.push([10.0 * random.unit(), 0.1 * random.unit(), 0.0]);
        points.push([10.0 * random.unit(), 50.0 + 0.1 * random.unit(), 0.0]);
    }
    let cloud = Cloud::new(&points).unwrap();
    let nearest = cloud.nearest(12).unwrap();
    let field = functions::geodesic_from_ends(&cloud, &nearest).unwrap();
    let [low, high] = field.range().unwrap();
    assert!(low == 0.0 && (9.8..10.3).contains(&high), "{low} {high}");
    let mean = functions::geodesic_mean(&cloud, &nearest, 3).unwrap();
    assert!(mean.range().is_some());
}

#[test]
fn principal_heights_move_with_the_body() {
    let mut random = Random::new(10);
    // An egg: three different axes, each with a blunt end.
    let egg: Vec<_> = (0..5000)
        .map(|_| {
            let [x, y, z] = random.direction();
            [3.0 * x + 0.5 * x * x, 2.0 * y + 0.4 * y * y, z + 0.2 * z * z]
        })
        .collect();
    // Turned about (1, 1, 1) by 120°, and moved.
    let moved: Vec<_> = egg.iter().map(|[x, y, z]| [z + 10.0, x - 20.0, y + 5.0]).collect();
    let [still, moved] = [&egg, &moved].map(|points| Cloud::new(points).unwrap());
    for axis in 1..=3 {
        let [a, b] =
            [&still, &moved].map(|cloud| functions::principal_height(cloud, axis).unwrap());
        assert!(!a.is_multiple);
        for row in 0..egg.len() {
            let a = a.values[still.places_of_rows()[row] as usize];
            let b = b.values[moved.places_of_rows()[row] as usize];
            assert!((a - b).abs() < 1e-9, "{axis} {a} {b}");
        }
    }
    let ball = Cloud::new(&Body::sphere().sample(20_000, &mut random)).unwrap();
    let is_multiple = functions::principal_axes(&ball).unwrap().is_multiple;
    println!("axes of a sampled ball: {is_multiple:?}");
    let lattice: Vec<_> = (0..64).map(|at| [at % 4, at / 4 % 4, at / 16].map(f64::from)).collect();
    let axes = functions::principal_axes(&Cloud::new(&lattice).unwrap()).unwrap();
    assert_eq!(axes.is_multiple, [true; 3]);
}
