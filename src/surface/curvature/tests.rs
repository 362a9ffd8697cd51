//! Normals and curvatures against surfaces of which they are known.

use asphera_mesh::Mesh;
use proptest::prelude::*;

use super::truth::*;
use super::*;
use crate::noise::{Along, NoiseSettings, estimate_noise};
use crate::regressions::beside_source;

type Surface = fn(f64, f64) -> Truth;

const SURFACES: [(&str, Surface, [f64; 2]); 6] = [
    ("sphere", sphere, [4.0, -7.0]),
    ("paraboloid", paraboloid, [5.0, 3.0]),
    ("asphere", asphere, [3.0, 4.0]),
    ("torus", torus, [7.0, 6.5]),
    ("cylinder", cylinder, [1.0, 2.0]),
    ("freeform", freeform, [2.0, -1.0]),
];

/// Normals in rad and curvatures in 1/mm: the largest differences over all vertices of a kind.
struct Errors {
    normal_rad: f64,
    curvature_per_mm: f64,
}

fn angle_rad(p: [f64; 3], q: [f64; 3]) -> f64 {
    let cross = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    dot(cross, cross).sqrt().atan2(dot(p, q))
}

fn dot(p: [f64; 3], q: [f64; 3]) -> f64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

fn normal(slope: [f64; 2]) -> [f64; 3] {
    let secant = (1.0 + slope[0] * slope[0] + slope[1] * slope[1]).sqrt();
    [-slope[0] / secant, -slope[1] / secant, 1.0 / secant]
}

/// Longer edges than three pitches lie along the hull, over samples that are jittered inwards.
fn all_shapes(points: &[PointMm], pitch_mm: f64, settings: &ShapeSettings) -> Vec<LocalShape> {
    let adjacency = adjacency(points, Some(3.0 * pitch_mm));
    let shapes = local_shapes(points, &adjacency, 0..points.len() as VertexId, settings);
    shapes.into_iter().map(Result::unwrap).collect()
}

fn errors(
    places: &[[f64; 2]],
    pitch_mm: f64,
    surface: Surface,
    kind: impl Fn(Surroundings) -> bool,
) -> Errors {
    let shapes = all_shapes(&over(places, surface), pitch_mm, &ShapeSettings::default());
    let mut errors = Errors { normal_rad: 0.0, curvature_per_mm: 0.0 };
    let mut count = 0;
    for (shape, &[x, y]) in shapes.iter().zip(places) {
        if kind(shape.surroundings) {
            let truth = surface(x, y);
            let turned = angle_rad(shape.normal, normal(truth.slope));
            errors.normal_rad = errors.normal_rad.max(turned);
            for i in 0..2 {
                let error = (shape.curvatures_per_mm[i] - truth.curvatures_per_mm[i]).abs();
                errors.curvature_per_mm = errors.curvature_per_mm.max(error);
            }
            count += 1;
        }
    }
    assert!(count > 20, "{count} vertices");
    errors
}

/// On scattered samples, where nothing cancels.
#[test]
fn errors_fall_with_the_square_and_the_cube_of_the_spacing() {
    for (name, surface, centre) in SURFACES {
        for whole in [true, false] {
            let kind = |surroundings| (surroundings == Surroundings::Whole) == whole;
            let at =
                |pitch_mm| errors(&raster(centre, 30, pitch_mm, 0.35, 7), pitch_mm, surface, kind);
            let [coarse, fine] = [at(0.08), at(0.02)];
            let curvature = (coarse.curvature_per_mm / fine.curvature_per_mm).log(4.0);
            let normal = (coarse.normal_rad / fine.normal_rad).log(4.0);
            eprintln!(
                "{name}, whole {whole}: curvature {:.1e} to {:.1e} /mm, order {curvature:.2}; \
                 normal {:.1e} to {:.1e} rad, order {normal:.2}",
                coarse.curvature_per_mm, fine.curvature_per_mm, coarse.normal_rad, fine.normal_rad
            );
            // A paraboloid is a quadric: only rounding is left.
            if name == "paraboloid" {
                assert!(fine.curvature_per_mm < 1e-9, "{name}");
                continue;
            }
            assert!(curvature > 1.75, "{name}, whole {whole}: order {curvature}");
            assert!(normal > 2.6, "{name}, whole {whole}: order {normal}");
        }
    }
}

#[test]
fn an_asphere_out_to_its_rim() {
    let places = raster([0.0, 0.0], 200, 0.06, 0.2, 3);
    let found = errors(&places, 0.06, asphere, |surroundings| surroundings == Surroundings::Whole);
    eprintln!("asphere: {:.1e} rad, {:.1e} /mm", found.normal_rad, found.curvature_per_mm);
    assert!(found.normal_rad < 1e-6 && found.curvature_per_mm < 5e-5);
}

#[test]
fn normals_and_directions_are_a_right_handed_frame() {
    let places = raster([7.0, 6.5], 20, 0.02, 0.3, 5);
    for shape in all_shapes(&over(&places, torus), 0.02, &ShapeSettings::default()) {
        let [first, second] = shape.directions;
        let third = shape.normal;
        let cross = [
            first[1] * second[2] - first[2] * second[1],
            first[2] * second[0] - first[0] * second[2],
            first[0] * second[1] - first[1] * second[0],
        ];
        for axis in 0..3 {
            assert!((cross[axis] - third[axis]).abs() < 1e-12, "{shape:?}");
        }
        for unit in [first, second, third] {
            assert!((dot(unit, unit) - 1.0).abs() < 1e-12);
        }
    }
}

/// On a torus the direction about the axis is a principal one.
#[test]
fn directions_of_a_torus() {
    let places = raster([7.0, 6.5], 20, 0.02, 0.3, 5);
    let shapes = all_shapes(&over(&places, torus), 0.02, &ShapeSettings::default());
    for (shape, [x, y]) in shapes.iter().zip(places) {
        let about = [-y / x.hypot(y), x / x.hypot(y), 0.0];
        let away = angle_rad(shape.directions[0], about);
        let away = away.min(std::f64::consts::PI - away);
        assert!(away < 1e-2, "{away} rad");
    }
}

/// A surface with noise whose curvatures are asked for.
#[derive(Clone, Copy)]
struct Scene {
    surface: Surface,
    centre: [f64; 2],
    pitch_mm: f64,
    sigma_mm: f64,
    rings: usize,
    along: Along,
    /// Whether the noise is to be found in the points.
    estimated: bool,
}

impl Scene {
    /// 2.8 mm wide.
    fn close(surface: Surface, centre: [f64; 2], rings: usize, along: Along) -> Scene {
        let (pitch_mm, sigma_mm) = (0.02, 3e-5);
        Scene { surface, centre, pitch_mm, sigma_mm, rings, along, estimated: false }
    }
}

/// Share of the vertices whose errors are within 1.96 standard uncertainties: of the height, the
/// normal's two tilts together, the larger, the smaller and the mean curvature.
fn coverage(scene: Scene, seed: u64) -> [f64; 5] {
    let Scene { surface, centre, pitch_mm, sigma_mm, rings, along, estimated } = scene;
    let places = raster(centre, 142, pitch_mm, 0.3, seed);
    let mut points = over(&places, surface);
    let clean = triangles(&points);
    let mut random = Random::new(seed + 1);
    for (point, &[x, y]) in points.iter_mut().zip(&places) {
        // In z; a move along the normal is one along z by more, to first order.
        let slope = surface(x, y).slope;
        let secant = if along == Along::Normal { 1.0 / normal(slope)[2] } else { 1.0 };
        point[2] += sigma_mm * secant * random.normal();
    }
    let adjacency = Adjacency::new(&points, &clean, Some(3.0 * pitch_mm)).unwrap();
    let noise = if estimated {
        let settings = NoiseSettings::new(NoiseSettings::NEIGHBOURHOODS, along).unwrap();
        estimate_noise(&points, &adjacency, &settings).unwrap().noise
    } else {
        Noise::new(sigma_mm, along).unwrap()
    };
    let settings = ShapeSettings::new(rings).unwrap().with_noise(noise);
    let shapes = local_shapes(&points, &adjacency, 0..points.len() as VertexId, &settings);
    let mut within = [0_u32; 5];
    for (shape, &[x, y]) in shapes.iter().zip(&places) {
        let shape = shape.as_ref().unwrap();
        let truth = surface(x, y);
        let u = shape.uncertainty.unwrap();
        let expected = normal(truth.slope);
        // Squared length of the tilt in units of its covariance: 95 % are below 5.99.
        let [s, t] = shape.directions.map(|direction| -dot(direction, expected));
        let [a, b] = u.normal_rad.map(|u| u * u);
        let c = u.normal_covariance_rad2;
        let length = (b * s * s - 2.0 * c * s * t + a * t * t) / (a * b - c * c);
        let mean = 0.5 * (truth.curvatures_per_mm[0] + truth.curvatures_per_mm[1]);
        let [larger, smaller] = u.curvatures_per_mm;
        let errors = [
            (shape.height_mm - truth.height_mm).abs() / u.height_mm,
            1.96 * (length / 5.991).sqrt(),
            (shape.curvatures_per_mm[0] - truth.curvatures_per_mm[0]).abs() / larger,
            (shape.curvatures_per_mm[1] - truth.curvatures_per_mm[1]).abs() / smaller,
            (shape.mean_per_mm() - mean).abs() / u.mean_per_mm,
        ];
        for (within, error) in within.iter_mut().zip(errors) {
            *within += u32::from(error <= 1.96);
        }
    }
    within.map(|within| f64::from(within) / shapes.len() as f64)
}

/// The principal curvatures are no linear functions of the heights where they are nearly equal.
fn assert_covered([height, normal, larger, smaller, mean]: [f64; 5]) {
    for share in [height, normal, mean] {
        assert!((share - 0.95).abs() < 0.005, "height {height}, normal {normal}, mean {mean}");
    }
    for share in [larger, smaller] {
        assert!((share - 0.95).abs() < 0.02, "curvatures {larger}, {smaller}");
    }
}

/// Over several seeds: neighbourhoods overlap, so one mesh is few independent ones.
fn mean_coverage(scene: Scene) -> [f64; 5] {
    let seeds = 10..16_u64;
    let count = seeds.clone().count() as f64;
    let mut mean = [0.0; 5];
    for seed in seeds {
        let found = coverage(scene, 2 * seed);
        mean.iter_mut().zip(found).for_each(|(mean, share)| *mean += share / count);
    }
    mean
}

#[test]
fn the_stated_uncertainty_covers_the_error() {
    for (name, surface, centre) in SURFACES {
        for (rings, along) in [(2, Along::Z), (3, Along::Normal)] {
            let found = mean_coverage(Scene::close(surface, centre, rings, along));
            eprintln!("{name}, {rings} rings, {along:?}: {found:.3?}");
            assert_covered(found);
        }
    }
}

/// The vertex of an asphere is an umbilic: both curvatures are equal, and noise drives them apart.
#[test]
fn the_stated_uncertainty_covers_the_error_about_the_vertex_of_an_asphere() {
    for rings in [2, 4] {
        let found = mean_coverage(Scene::close(asphere, [0.0, 0.0], rings, Along::Z));
        eprintln!("{rings} rings: {found:.3?}");
        assert_covered(found);
    }
}

/// 12 mm of an asphere, noise of 20 nm along z that is not told but found.
#[test]
fn the_uncertainty_from_estimated_noise_covers_the_error_on_a_whole_asphere() {
    for rings in [2, 3] {
        let scene = Scene {
            pitch_mm: 0.085,
            sigma_mm: 2e-5,
            estimated: true,
            ..Scene::close(asphere, [0.0, 0.0], rings, Along::Z)
        };
        let found = mean_coverage(scene);
        eprintln!("{rings} rings: {found:.3?}");
        for share in found {
            assert!((share - 0.95).abs() < 0.02, "{found:?}");
        }
    }
}

#[test]
fn the_border_is_told_and_less_certain() {
    let places = raster([3.0, 4.0], 40, 0.05, 0.2, 1);
    let noise = Noise::new(1e-5, Along::Z).unwrap();
    let shapes =
        all_shapes(&over(&places, asphere), 0.05, &ShapeSettings::default().with_noise(noise));
    let mean_u = |row: usize| {
        let row = &shapes[row * 40 + 10..row * 40 + 30];
        row.iter().map(|shape| shape.uncertainty.unwrap().mean_per_mm).sum::<f64>() / 20.0
    };
    let of = |row: usize| shapes[row * 40 + 20].surroundings;
    assert_eq!([of(0), of(20)], [Surroundings::OnBorder, Surroundings::Whole]);
    assert_eq!(of(1), Surroundings::Cut);
    assert!(mean_u(0) > 3.0 * mean_u(20), "{} {}", mean_u(0), mean_u(20));
    assert!(shapes.iter().all(|shape| shape.degrees_of_freedom >= 1));
}

/// Two plates 5 mm apart, one 1 mm higher: the mesh fills the gap between them.
#[test]
fn a_gap_is_not_crossed() {
    let mut points = over(&raster([0.0, 0.0], 30, 0.1, 0.2, 1), sphere);
    let other = raster([8.0, 0.0], 30, 0.1, 0.2, 2);
    points.extend(other.iter().map(|&[x, y]| [x, y, 1.0 + sphere(x - 8.0, y).height_mm]));
    let worst = |reach_mm| {
        let adjacency = adjacency(&points, reach_mm);
        let all = 0..points.len() as VertexId;
        let shapes = local_shapes(&points, &adjacency, all, &ShapeSettings::default());
        let errors = shapes.iter().map(|shape| {
            let found = shape.unwrap().curvatures_per_mm;
            found.map(|curvature| (curvature - 0.05).abs()).into_iter().fold(0.0, f64::max)
        });
        errors.fold(0.0, f64::max)
    };
    let (crossed, kept) = (worst(None), worst(Some(0.5)));
    assert!(crossed > 0.01 && kept < 5e-3, "{crossed} {kept}");
}

#[test]
fn what_is_not_determined_says_why() {
    let settings = ShapeSettings::default();
    let shape = |points: &[PointMm], triangles: &[[VertexId; 3]]| {
        let adjacency = Adjacency::new(points, triangles, None).unwrap();
        local_shape(points, &adjacency, 0, &settings)
    };
    assert_eq!(shape(&[], &[]), Err(Undetermined::NoVertex));
    assert_eq!(shape(&[[0.0; 3]], &[]), Err(Undetermined::Isolated));
    let island = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert_eq!(shape(&island, &[[0, 1, 2]]), Err(Undetermined::TooFew { vertices: 3 }));
    let line: Vec<PointMm> = (0..8).map(|i| [f64::from(i), 2.0 * f64::from(i), 0.3]).collect();
    let flat = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 6], [0, 6, 7]];
    assert_eq!(shape(&line, &flat), Err(Undetermined::Collinear { vertices: 8 }));
    let circle: Vec<PointMm> = (0..8)
        .map(|i| f64::from(i) / 8.0 * std::f64::consts::TAU)
        .map(|t| [t.cos(), t.sin(), 0.0])
        .collect();
    assert_eq!(shape(&circle, &flat), Err(Undetermined::OnConic { vertices: 8 }));
    let rows: Vec<PointMm> =
        (0..8).map(|i| [f64::from(i % 4), f64::from(i / 4), f64::from(i)]).collect();
    assert_eq!(shape(&rows, &flat), Err(Undetermined::OnConic { vertices: 8 }));
    let mut broken = circle;
    for height in [f64::NAN, f64::INFINITY, 1e300] {
        broken[3][2] = height;
        assert_eq!(shape(&broken, &flat), Err(Undetermined::NotFinite));
    }
    assert_eq!(ShapeSettings::new(0), Err(RingsError { rings: 0 }));
    assert_eq!(RingsError { rings: 17 }.to_string(), "17 rings are not from 1 to 16");
}

#[test]
fn exact_lattices_are_determined() {
    let places = raster([0.0, 0.0], 12, 0.125, 0.0, 1);
    let shapes = all_shapes(&over(&places, paraboloid), 0.125, &ShapeSettings::default());
    for (shape, &[x, y]) in shapes.iter().zip(&places) {
        let truth = paraboloid(x, y).curvatures_per_mm;
        let [p, q] = [0, 1].map(|i| (shape.curvatures_per_mm[i] - truth[i]).abs());
        assert!(p.max(q) < 1e-10, "{shape:?}");
        assert_eq!(shape.model, Model::Cubic);
        assert!(shape.residual_mm.unwrap() < 1e-14);
    }
}

/// Samples a thousand times nearer to each other along a line than the lines are.
#[test]
fn scan_lines_far_apart_lose_nothing() {
    let places: Vec<[f64; 2]> = (0..30)
        .flat_map(|row| (0..30).map(move |i| [1e-4 * f64::from(i), 0.1 * f64::from(row)]))
        .collect();
    let points = over(&places, paraboloid);
    // By rows: a Delaunay mesh of so long cells would join whole lines along the outline.
    let cells = (0..29_u32).flat_map(|row| (0..29_u32).map(move |i| 30 * row + i));
    let triangles: Vec<[VertexId; 3]> =
        cells.flat_map(|c| [[c, c + 1, c + 31], [c, c + 31, c + 30]]).collect();
    let adjacency = Adjacency::new(&points, &triangles, None).unwrap();
    let all = 0..points.len() as VertexId;
    for (shape, &[x, y]) in
        local_shapes(&points, &adjacency, all, &ShapeSettings::default()).iter().zip(&places)
    {
        let truth = paraboloid(x, y).curvatures_per_mm;
        let found = shape.unwrap().curvatures_per_mm;
        // Rounding of a height of 0.3 mm is 6e-17 mm, of which second differences over 1e-4 mm
        // make 1e-8 / mm.
        assert!((found[0] - truth[0]).abs().max((found[1] - truth[1]).abs()) < 2e-7, "{found:?}");
    }
}

#[test]
fn threads_do_not_show() {
    let mut points = over(&raster([0.0, 0.0], 60, 0.05, 0.2, 1), asphere);
    roughen(&mut points, 1e-5, 2);
    let adjacency = adjacency(&points, None);
    let settings = ShapeSettings::default().with_noise(Noise::new(1e-5, Along::Z).unwrap());
    let all = local_shapes(&points, &adjacency, 0..3600, &settings);
    for vertex in (0..3600).step_by(37) {
        assert_eq!(all[vertex as usize], local_shape(&points, &adjacency, vertex, &settings));
    }
}

/// What does not change where the part is moved, turned about z, mirrored or scaled.
fn assert_like(left: &LocalShape, right: &LocalShape, tolerance: f64) {
    for i in 0..2 {
        let [p, q] = [left, right].map(|shape| shape.curvatures_per_mm[i]);
        assert!((p - q).abs() <= tolerance, "{left:?} {right:?}");
    }
    assert!((left.normal[2] - right.normal[2]).abs() <= tolerance, "{left:?} {right:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..beside_source() })]

    /// Small lattices with missing nodes, steps and places that lie on one line or conic.
    #[test]
    fn what_is_stated_is_finite(
        nodes in prop::collection::btree_map((0_u8..5, 0_u8..5), -2_i8..=2, 3..25),
        shift in 0_i32..12,
    ) {
        let unit = 10.0_f64.powi(-shift);
        let points: Vec<PointMm> = nodes
            .iter()
            .map(|(&(x, y), &z)| [1e3 + unit * f64::from(x), unit * f64::from(y), f64::from(z)])
            .collect();
        let mut mesh = Mesh::new();
        mesh.insert(&points);
        let points = mesh.points();
        let adjacency = Adjacency::new(points, &mesh.triangles(), None).unwrap();
        let settings = ShapeSettings::default().with_noise(Noise::new(1e-5, Along::Normal).unwrap());
        for shape in local_shapes(points, &adjacency, 0..points.len() as VertexId, &settings) {
            let Ok(shape) = shape else { continue };
            let u = shape.uncertainty.unwrap();
            let stated = [shape.height_mm, shape.condition, u.height_mm, u.mean_per_mm]
                .into_iter()
                .chain(shape.normal)
                .chain(shape.curvatures_per_mm)
                .chain(u.curvatures_per_mm)
                .chain(u.normal_rad)
                .chain(shape.residual_mm);
            for figure in stated {
                prop_assert!(figure.is_finite(), "{:?}", shape);
            }
            prop_assert!(u.curvatures_per_mm[0] > 0.0 && shape.condition >= 1.0, "{:?}", shape);
            prop_assert!(shape.residual_mm.is_none() == (shape.degrees_of_freedom == 0));
        }
        // Three vertices or more, most of them without what it takes: no panic, whatever is found.
        let few = NoiseSettings::new(NoiseSettings::NEIGHBOURHOODS_MIN, Along::Normal).unwrap();
        if let Ok(found) = estimate_noise(points, &adjacency, &few) {
            prop_assert!(found.noise.sigma_mm().is_finite() && found.neighbourhoods >= 20);
        }
    }

    #[test]
    fn motions_and_scales(
        seed in 0_u64..1000,
        angle in 0.0..std::f64::consts::TAU,
        away in -1e6..1e6_f64,
        scale in -30_i32..30,
    ) {
        let places = raster([2.0, -1.0], 8, 0.05, 0.3, seed);
        let mut points = over(&places, freeform);
        roughen(&mut points, 1e-5, seed);
        let triangles = triangles(&points);
        let settings = ShapeSettings::default().with_noise(Noise::new(1e-5, Along::Z).unwrap());
        let shapes = |points: &[PointMm]| -> Vec<LocalShape> {
            let adjacency = Adjacency::new(points, &triangles, None).unwrap();
            let all = local_shapes(points, &adjacency, 0..64, &settings);
            all.into_iter().map(Result::unwrap).collect()
        };
        let found = shapes(&points);
        let (sin, cos) = angle.sin_cos();
        let turned: Vec<PointMm> =
            points.iter().map(|&[x, y, z]| [cos * x - sin * y, sin * x + cos * y, z]).collect();
        for (left, right) in found.iter().zip(&shapes(&turned)) {
            assert_like(left, right, 1e-9);
            let [p, q] = [left, right].map(|shape| shape.uncertainty.unwrap().curvatures_per_mm[0]);
            prop_assert!((p / q - 1.0).abs() < 1e-6, "{} {}", p, q);
        }
        // Coordinates of 1e6 mm are rounded to 1e-10 mm: the places that were moved are the truth.
        let moved: Vec<PointMm> =
            points.iter().map(|&[x, y, z]| [x + away, y - away, z + away]).collect();
        let back: Vec<PointMm> =
            moved.iter().map(|&[x, y, z]| [x - away, y + away, z - away]).collect();
        for (left, right) in shapes(&moved).iter().zip(&shapes(&back)) {
            assert_like(left, right, 1e-8);
        }
        // Powers of two scale without rounding, and the fit with them.
        let factor = 2.0_f64.powi(scale);
        let scaled: Vec<PointMm> = points.iter().map(|point| point.map(|x| x * factor)).collect();
        for (left, right) in found.iter().zip(&shapes(&scaled)) {
            for i in 0..2 {
                let [p, q] = [left.curvatures_per_mm[i], factor * right.curvatures_per_mm[i]];
                prop_assert!((p - q).abs() <= 1e-12, "{} {}", p, q);
            }
        }
        let flipped: Vec<PointMm> = points.iter().map(|&[x, y, z]| [x, y, -z]).collect();
        for (left, right) in found.iter().zip(&shapes(&flipped)) {
            let [p, q] = [left.curvatures_per_mm, right.curvatures_per_mm];
            prop_assert!((p[0] + q[1]).abs().max((p[1] + q[0]).abs()) <= 1e-12);
            let [m, n] = [left.normal, right.normal];
            prop_assert!((m[0] + n[0]).abs().max((m[1] + n[1]).abs()).max((m[2] - n[2]).abs()) <= 1e-14);
        }
    }
}
