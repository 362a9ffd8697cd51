//! Eigenfunctions, harmonic functions and the heat kernel against their truth.

use asphera_graph::Cloud;
use asphera_graph::functions::{
    FunctionError, eigenfunction, eigenfunctions, harmonic, harmonic_between_ends, heat_kernel,
};

use crate::bodies::{Body, Random};

fn cloud(points: &[[f64; 3]]) -> Cloud<3> {
    Cloud::new(points).unwrap()
}

/// A strip 10 mm long and 0.5 mm wide.
fn rod(count: usize, seed: u64) -> Vec<[f64; 3]> {
    let mut random = Random::new(seed);
    (0..count).map(|_| [10.0 * random.unit(), 0.5 * random.unit(), 0.0]).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let (ma, mb) = (mean(a), mean(b));
    let sum = |of: &dyn Fn(f64, f64) -> f64| {
        a.iter().zip(b).map(|(a, b)| of(a - ma, b - mb)).sum::<f64>()
    };
    sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt()
}

/// On a strip they are cosines, on a sphere spherical harmonics with eigenvalues in the ratio of l·(l + 1).
#[test]
fn eigenfunctions_are_those_of_a_strip_and_of_a_sphere() {
    let strip = cloud(&rod(4_000, 1));
    let found = eigenfunctions(&strip, &strip.nearest(12).unwrap(), 3).unwrap();
    assert!(found.residuals.iter().all(|residual| *residual <= 1e-8), "{found:?}");
    for (order, field) in found.fields.iter().enumerate() {
        let wave =
            |place: &[f64; 3]| ((order + 1) as f64 * std::f64::consts::PI * place[0] / 10.0).cos();
        let truth: Vec<f64> = strip.places().iter().map(wave).collect();
        let like = correlation(&field.values, &truth).abs();
        assert!(like > 0.995, "{order}: {like}");
        assert!(!field.is_multiple);
    }
    let ratio = found.eigenvalues[1] / found.eigenvalues[0];
    assert!((ratio - 4.0).abs() < 0.3, "{ratio}");
    let sphere = cloud(&Body::sphere().sample(6_000, &mut Random::new(2)));
    let found = eigenfunctions(&sphere, &sphere.nearest(12).unwrap(), 15).unwrap();
    let mean = |range: std::ops::Range<usize>| {
        let count = range.len() as f64;
        found.eigenvalues[range].iter().sum::<f64>() / count
    };
    let [first, second, third] = [mean(0..3), mean(3..8), mean(8..15)];
    assert!((second / first - 3.0).abs() < 0.2 && (third / first - 6.0).abs() < 0.5, "{found:?}");
    // Gaps between the groups are wide, within them narrow.
    assert!(found.eigenvalues[2] < 0.5 * found.eigenvalues[3], "{:?}", found.eigenvalues);
}

/// Two places of a ring that is regular: every wave has a twin.
#[test]
fn eigenvalues_of_a_regular_ring_are_double_and_said_to_be() {
    let places: Vec<[f64; 3]> = (0..600)
        .map(|at| f64::from(at) * std::f64::consts::TAU / 600.0)
        .map(|angle| [angle.cos(), angle.sin(), 0.0])
        .collect();
    let ring = cloud(&places);
    let found = eigenfunctions(&ring, &ring.nearest(4).unwrap(), 4).unwrap();
    assert!(found.fields.iter().all(|field| field.is_multiple), "{:?}", found.eigenvalues);
    assert!((found.eigenvalues[2] / found.eigenvalues[0] - 4.0).abs() < 0.01);
    // The squares of twins add up to the same everywhere: so does the heat kernel.
    let heat = heat_kernel(&ring, &ring.nearest(4).unwrap(), 1.0).unwrap();
    let [low, high] = heat.range().unwrap();
    assert!(high - low < 1e-3 * high, "{low} {high}");
}

#[test]
fn harmonic_functions_have_their_ends_where_they_are_given() {
    let strip = cloud(&rod(4_000, 3));
    let nearest = strip.nearest(12).unwrap();
    let field = harmonic_between_ends(&strip, &nearest).unwrap();
    assert_eq!(field.range(), Some([0.0, 1.0]));
    let along: Vec<f64> = strip.places().iter().map(|place| place[0]).collect();
    assert!(correlation(&field.values, &along).abs() > 0.995);
    // Two whole ends held: the straight line between them.
    let mut fixed: Vec<(u32, f64)> = Vec::new();
    for (place, at) in (0..).zip(strip.places()) {
        if at[0] < 0.3 || at[0] > 9.7 {
            fixed.push((place, at[0]));
        }
    }
    let field = harmonic(&strip, &nearest, &fixed).unwrap();
    let worst = field.values.iter().zip(&along).map(|(found, x)| (found - x).abs());
    assert!(worst.fold(0.0, f64::max) < 0.3);
    let (low, high) = field
        .values
        .iter()
        .fold((f64::MAX, f64::MIN), |(low, high), &value| (low.min(value), high.max(value)));
    assert!(low >= 0.0 && high <= 10.0, "{low} {high}");
}

/// Each piece of a scene has functions of its own, as if it were alone; dust has none.
#[test]
fn pieces_have_functions_of_their_own() {
    let one = rod(1_000, 8);
    let other: Vec<[f64; 3]> = rod(1_000, 9).iter().map(|&[x, y, z]| [x, y + 70.0, z]).collect();
    let dust = [[500.0, 500.0, 500.0]];
    let scene = cloud(&[&one[..], &other, &dust].concat());
    let of_rows = |cloud: &Cloud<3>, values: &[f64]| -> Vec<f64> {
        cloud.places_of_rows().iter().map(|&place| values[place as usize]).collect()
    };
    type Function = fn(&Cloud<3>) -> asphera_graph::functions::Field;
    let functions: [Function; 3] = [
        |cloud| harmonic_between_ends(cloud, &cloud.nearest(10).unwrap()).unwrap(),
        |cloud| eigenfunction(cloud, &cloud.nearest(10).unwrap(), 2).unwrap(),
        |cloud| heat_kernel(cloud, &cloud.nearest(10).unwrap(), 0.2).unwrap(),
    ];
    for function in functions {
        let whole = of_rows(&scene, &function(&scene).values);
        for (part, rows) in [(&one, 0..1_000), (&other, 1_000..2_000)] {
            let alone = cloud(part);
            assert_eq!(of_rows(&alone, &function(&alone).values), whole[rows]);
        }
        assert_eq!(whole[2_000], 0.0);
    }
    // Of pieces that are all too small nothing is made up.
    let crumbs: Vec<[f64; 3]> =
        (0..12).map(|at| [f64::from(at / 4) * 1e3, f64::from(at % 4), 0.0]).collect();
    let crumbs = cloud(&crumbs);
    let refused = eigenfunction(&crumbs, &crumbs.nearest(2).unwrap(), 2).unwrap_err();
    assert_eq!(refused, FunctionError::Pieces { pieces: 3 });
}

/// The order of the points, the threads and a scale by a power of two change no bit; a quarter turn changes rounding.
#[test]
fn the_same_points_give_the_same_functions() {
    let points = rod(1_500, 4);
    let values = |points: &[[f64; 3]]| {
        let cloud = cloud(points);
        let nearest = cloud.nearest(10).unwrap();
        let eigen = eigenfunctions(&cloud, &nearest, 3).unwrap();
        let heat = heat_kernel(&cloud, &nearest, 0.1).unwrap().values;
        let between = harmonic_between_ends(&cloud, &nearest).unwrap().values;
        let of_rows: Vec<[f64; 3]> = cloud
            .places_of_rows()
            .iter()
            .map(|&place| place as usize)
            .map(|at| [eigen.fields[0].values[at], heat[at], between[at]])
            .collect();
        of_rows
    };
    let own = values(&points);
    let mut reversed = points.clone();
    reversed.reverse();
    let mut back = values(&reversed);
    back.reverse();
    assert_eq!(own, back);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(own, one.install(|| values(&points)));
    let larger: Vec<[f64; 3]> = points.iter().map(|point| point.map(|mm| 1024.0 * mm)).collect();
    assert_eq!(own, values(&larger));
    let turned: Vec<[f64; 3]> = points.iter().map(|&[x, y, z]| [-y, x, z]).collect();
    for (own, turned) in own.iter().zip(values(&turned)) {
        let off = (0..2).map(|at| (own[at] - turned[at]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-5, "{own:?} {turned:?}");
    }
}

/// The inverse of the Laplacian is worked out on threads where there are many places.
#[test]
fn many_places_have_the_same_functions_whatever_the_order_and_the_threads() {
    let points = Body::torus().sample(9_000, &mut Random::new(11));
    let values = |points: &[[f64; 3]]| {
        let cloud = cloud(points);
        let found = eigenfunctions(&cloud, &cloud.nearest(12).unwrap(), 6).unwrap();
        assert!(found.residuals.iter().all(|residual| *residual <= 1e-8), "{found:?}");
        assert_eq!(found.rounds, 1, "the inverse leaves nothing to do");
        let of_row = cloud.places_of_rows().iter().map(|&place| place as usize);
        of_row.map(|at| [0, 3, 5].map(|field| found.fields[field].values[at])).collect::<Vec<_>>()
    };
    let own = values(&points);
    let mut reversed = points.clone();
    reversed.reverse();
    let mut back = values(&reversed);
    back.reverse();
    assert_eq!(own, back);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(own, pool.install(|| values(&points)));
    }
}

#[test]
fn what_has_no_such_function_is_refused() {
    let none = cloud(&[]);
    let empty = none.nearest(10).unwrap();
    assert_eq!(eigenfunctions(&none, &empty, 1).unwrap_err(), FunctionError::NoPoints);
    assert_eq!(harmonic_between_ends(&none, &empty).unwrap_err(), FunctionError::NoPoints);
    let one = cloud(&[[1.0, 2.0, 3.0]; 9]);
    let alone = one.nearest(10).unwrap();
    assert_eq!(harmonic_between_ends(&one, &alone).unwrap().values, [0.0]);
    let refused = eigenfunctions(&one, &alone, 1).unwrap_err();
    assert_eq!(refused, FunctionError::Eigenfunctions { found: 1, most: 0 });
    let mut two_parts = rod(500, 5);
    two_parts.extend(rod(500, 6).iter().map(|&[x, y, z]| [x, y, z + 50.0]));
    let parted = cloud(&two_parts);
    let nearest = parted.nearest(10).unwrap();
    assert_eq!(
        eigenfunctions(&parted, &nearest, 2).unwrap_err(),
        FunctionError::Pieces { pieces: 2 }
    );
    let message = harmonic(&parted, &nearest, &[(0, 1.0)]).unwrap_err().to_string();
    assert!(message.contains("2 pieces") && message.contains("asphera parts"), "{message}");
    let strip = cloud(&rod(100, 7));
    let nearest = strip.nearest(10).unwrap();
    assert!(matches!(heat_kernel(&strip, &nearest, 0.0), Err(FunctionError::Time { .. })));
    assert!(matches!(heat_kernel(&strip, &nearest, f64::NAN), Err(FunctionError::Time { .. })));
    let of = |fixed: &[(u32, f64)]| harmonic(&strip, &nearest, fixed).unwrap_err();
    assert!(matches!(of(&[]), FunctionError::Sources { found: 0, .. }));
    assert!(matches!(of(&[(100, 1.0)]), FunctionError::Source { found: 100, .. }));
    assert!(matches!(of(&[(3, f64::NAN)]), FunctionError::Fixed { place: 3, .. }));
    assert_eq!(harmonic(&strip, &nearest, &[(3, 2.5)]).unwrap().range(), Some([2.5, 2.5]));
    // On an exact line, far from the origin.
    let line: Vec<[f64; 3]> = (0..400).map(|at| [1e6 + 0.01 * f64::from(at), 0.0, 0.0]).collect();
    let line = cloud(&line);
    let found = eigenfunctions(&line, &line.nearest(4).unwrap(), 2).unwrap();
    assert!((found.eigenvalues[1] / found.eigenvalues[0] - 4.0).abs() < 0.05);
}
