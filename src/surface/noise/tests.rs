//! Noise that was put on known surfaces, and what it does to facets.

use asphera_geometry::{BoundsMm, PointMm, VertexId};
use proptest::prelude::*;

use super::*;
use crate::curvature::Adjacency;
use crate::curvature::truth::*;
use crate::regressions::beside_source;

type Surface = fn(f64, f64) -> Truth;

const SURFACES: [(&str, Surface, [f64; 2]); 4] = [
    ("sphere", sphere, [1.0, -2.0]),
    ("asphere", asphere, [0.0, 0.0]),
    ("cylinder", cylinder, [1.0, 2.0]),
    ("freeform", freeform, [2.0, -1.0]),
];
const PITCH_MM: f64 = 0.05;

/// 142² points, 7 mm wide.
fn sampled(surface: Surface, centre: [f64; 2], seed: u64) -> (Vec<PointMm>, Adjacency) {
    let points = over(&raster(centre, 142, PITCH_MM, 0.3, seed), surface);
    let adjacency = adjacency(&points, Some(3.0 * PITCH_MM));
    (points, adjacency)
}

fn estimate(points: &[PointMm], adjacency: &Adjacency) -> NoiseEstimate {
    estimate_noise(points, adjacency, &NoiseSettings::default()).unwrap()
}

#[test]
fn white_noise_is_recovered_within_its_stated_uncertainty() {
    let mut deviations = Vec::new();
    for (name, surface, centre) in SURFACES {
        for seed in 0..8 {
            let (mut points, adjacency) = sampled(surface, centre, seed);
            let sigma_mm = 1e-5;
            roughen(&mut points, sigma_mm, 100 + seed);
            let found = estimate(&points, &adjacency);
            let error = found.noise.sigma_mm() / sigma_mm - 1.0;
            assert!(error.abs() < 0.03, "{name}: {found:?}");
            assert!(found.uncertainty_mm < 0.012 * sigma_mm, "{name}: {found:?}");
            assert!(found.outlier_share < 1e-3, "{name}: {found:?}");
            deviations.push((found.noise.sigma_mm() - sigma_mm) / found.uncertainty_mm);
        }
    }
    let mean = deviations.iter().sum::<f64>() / deviations.len() as f64;
    let spread = deviations.iter().map(|d| d * d).sum::<f64>() / deviations.len() as f64;
    eprintln!("mean {mean:.2}, rms {:.2} stated uncertainties", spread.sqrt());
    assert!(mean.abs() < 0.6 && (0.4..1.4).contains(&spread.sqrt()), "{mean} {spread}");
}

#[test]
fn wrong_readings_do_not_count_as_noise() {
    for (name, surface, centre) in SURFACES {
        for (share, tolerance) in [(0.01, 0.02), (0.05, 0.05), (0.1, 0.2)] {
            let (mut points, adjacency) = sampled(surface, centre, 3);
            roughen(&mut points, 1e-5, 4);
            let mut random = Random::new(9);
            for point in &mut points {
                if random.unit() < share {
                    point[2] += if random.unit() < 0.5 { 1e-3 } else { -1e-3 };
                }
            }
            let found = estimate(&points, &adjacency);
            let error = found.noise.sigma_mm() / 1e-5 - 1.0;
            eprintln!("{name}, {share}: {error:+.4}, {found:?}");
            assert!(error.abs() < tolerance, "{name}: {error} {found:?}");
            assert!((found.outlier_share - share).abs() < 0.2 * share + 0.002, "{name}: {found:?}");
        }
    }
}

/// All wrong readings to the same side, as dust makes them.
#[test]
fn dust_does_not_count_as_noise() {
    let (mut points, adjacency) = sampled(asphere, [0.0, 0.0], 3);
    roughen(&mut points, 1e-5, 4);
    let mut random = Random::new(9);
    points.iter_mut().filter(|_| random.unit() < 0.05).for_each(|point| point[2] += 1e-3);
    let error = estimate(&points, &adjacency).noise.sigma_mm() / 1e-5 - 1.0;
    assert!(error.abs() < 0.05, "{error}");
}

#[test]
fn noise_along_the_normal_of_a_steep_surface() {
    // About 45°: along z it is √2 of that.
    let centre = [20.0 / 2.0_f64.sqrt() - 2.0, 0.0];
    let (mut points, adjacency) = sampled(sphere, centre, 1);
    let mut random = Random::new(2);
    for point in &mut points {
        let slope = sphere(point[0], point[1]).slope;
        point[2] += 1e-5 * slope[0].hypot(slope[1]).hypot(1.0) * random.normal();
    }
    let settings = NoiseSettings::new(4096, Along::Normal).unwrap();
    let found = estimate_noise(&points, &adjacency, &settings).unwrap();
    assert!((found.noise.sigma_mm() / 1e-5 - 1.0).abs() < 0.03, "{found:?}");
    assert_eq!(found.noise.along(), Along::Normal);
    let along_z = estimate(&points, &adjacency).noise.sigma_mm();
    assert!(along_z > 1.2e-5, "{along_z}");
}

#[test]
fn a_surface_without_noise_has_next_to_none() {
    let (points, adjacency) = sampled(asphere, [0.0, 0.0], 1);
    let found = estimate(&points, &adjacency);
    assert!(found.noise.sigma_mm() < 2e-8, "{found:?}");
    // A quadric is followed to rounding: 1 mm is rounded to 1e-16 mm.
    let followed = over(&raster([0.0, 0.0], 20, 0.1, 0.0, 1), paraboloid);
    let lattice = crate::curvature::truth::adjacency(&followed, None);
    let rounding_mm = estimate(&followed, &lattice).noise.sigma_mm();
    assert!(rounding_mm > 0.0 && rounding_mm < 1e-16, "{rounding_mm}");
    let flat: Vec<PointMm> = points.iter().map(|&[x, y, _]| [x, y, 5.0]).collect();
    assert_eq!(estimate(&flat, &adjacency).noise.sigma_mm(), 0.0);
}

#[test]
fn the_noise_of_regions() {
    let (mut points, adjacency) = sampled(asphere, [0.0, 0.0], 1);
    let mut random = Random::new(2);
    for point in &mut points {
        let sigma_mm = if point[0] < 0.0 { 1e-5 } else { 5e-5 };
        point[2] += sigma_mm * random.normal();
    }
    let settings = NoiseSettings::new(8192, Along::Z).unwrap();
    let map = noise_map(&points, &adjacency, &settings, [2, 1]);
    assert_eq!(map.size(), [2, 1]);
    let sigma_mm = |x: f64| map.at(x, 1.0).unwrap().sigma_mm();
    assert!((sigma_mm(-1.0) / 1e-5 - 1.0).abs() < 0.04, "{:?}", map.cells());
    assert!((sigma_mm(1.0) / 5e-5 - 1.0).abs() < 0.04, "{:?}", map.cells());
    let BoundsMm { low, high } = map.bounds_mm().unwrap();
    assert_eq!(map.at(low[0], low[1]).unwrap().sigma_mm(), sigma_mm(-1.0));
    assert_eq!(map.at(high[0], high[1]).unwrap().sigma_mm(), sigma_mm(1.0));
    assert_eq!(map.at(high[0].next_up(), 0.0), None);
    assert_eq!(map.at(f64::NAN, 0.0), None);
    // The mean square of 10 and 50 nm, half of the part each.
    let found = estimate(&points, &adjacency).over(&map.known()).uneven.unwrap();
    assert!((found.rms_mm / (0.5_f64 * (1e-10 + 25e-10)).sqrt() - 1.0).abs() < 0.04, "{found:?}");
    assert!(found.least_mm < 1.1e-5 && found.most_mm > 4.8e-5, "{found:?}");
    // Cells so small that they hold next to nothing.
    let fine = noise_map(&points, &adjacency, &settings, [40, 40]);
    assert!(fine.cells().iter().all(Result::is_err));
}

#[test]
fn regions_of_one_noise_do_not_differ() {
    for (seed, sigma_mm) in [(1, 5e-6), (2, 5e-6), (3, 1e-4), (4, 0.0)] {
        let (mut points, adjacency) = sampled(asphere, [0.0, 0.0], seed);
        let mut random = Random::new(seed);
        points.iter_mut().for_each(|point| point[2] += sigma_mm * random.normal());
        for neighbourhoods in [400, 2048, 8192] {
            let settings = NoiseSettings::new(neighbourhoods, Along::Z).unwrap();
            let map = noise_map(&points, &adjacency, &settings, [4, 4]);
            let found = estimate_noise(&points, &adjacency, &settings).unwrap().over(&map.known());
            assert_eq!(found.uneven, None, "{seed} {neighbourhoods}");
        }
    }
}

#[test]
fn too_little_to_tell() {
    let nothing = Adjacency::new(&[], &[], None).unwrap();
    let found = estimate_noise(&[], &nothing, &NoiseSettings::default()).unwrap_err();
    assert_eq!(found, NoiseUnknown::TooFewNeighbourhoods { usable: 0 });
    assert_eq!(
        found.to_string(),
        "the points have 0 neighbourhoods to estimate it from, 20 are needed"
    );
    assert!(noise_map(&[], &nothing, &NoiseSettings::default(), [3, 0]).cells().len() == 3);
    let points = over(&raster([0.0, 0.0], 4, 1.0, 0.1, 1), sphere);
    let few = adjacency(&points, None);
    assert!(estimate_noise(&points, &few, &NoiseSettings::default()).is_err());
    assert_eq!(NoiseSettings::new(19, Along::Z), Err(NoiseSettingsError { neighbourhoods: 19 }));
    for sigma_mm in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(Noise::new(sigma_mm, Along::Z).is_err());
    }
}

#[test]
fn threads_do_not_show() {
    let (mut points, adjacency) = sampled(freeform, [0.0, 0.0], 1);
    roughen(&mut points, 1e-5, 4);
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| estimate(&points, &adjacency))
    };
    assert_eq!(of(1), of(3));
}

/// The mean square of tilts drawn at random against the formula.
#[test]
fn facet_tilt_against_random_deviations() {
    let corners = [[0.0, 0.0, 0.0], [0.3, 0.02, 0.25], [-0.1, 0.2, 0.1]];
    let minus = |p: PointMm, q: PointMm| [0, 1, 2].map(|axis| p[axis] - q[axis]);
    let normal = |[a, b, c]: [PointMm; 3]| {
        let (u, v) = (minus(b, a), minus(c, a));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let size = n.iter().map(|x| x * x).sum::<f64>().sqrt();
        n.map(|x| x / size)
    };
    let level = normal(corners);
    let mut random = Random::new(1);
    for along in [Along::Z, Along::Normal] {
        let way = if along == Along::Z { [0.0, 0.0, 1.0] } else { level };
        let mut squares = 0.0;
        let draws = 100_000;
        for _ in 0..draws {
            let turned = normal(corners.map(|corner| {
                let by = 1e-5 * random.normal();
                [0, 1, 2].map(|axis| corner[axis] + by * way[axis])
            }));
            squares += minus(turned, level).iter().map(|x| x * x).sum::<f64>();
        }
        let drawn = (squares / f64::from(draws)).sqrt();
        let stated = facet_tilt_rad(corners, Noise::new(1e-5, along).unwrap()).unwrap();
        assert!((drawn / stated - 1.0).abs() < 0.01, "{along:?}: {drawn} {stated}");
    }
}

#[test]
fn facet_tilt_of_known_triangles() {
    let noise = Noise::new(1e-5, Along::Z).unwrap();
    let half_square = [[0.0, 0.0, 1.0], [0.01, 0.0, 1.0], [0.0, 0.01, 1.0]];
    let equilateral = [[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.005, 0.01 * 0.75_f64.sqrt(), 0.0]];
    for corners in [half_square, equilateral] {
        assert!((facet_tilt_rad(corners, noise).unwrap() - 2e-3).abs() < 1e-15);
    }
    assert_eq!(facet_tilt_rad([[0.0; 3]; 3], noise), None);
    assert_eq!(facet_tilt_rad([[0.0; 3], [1.0; 3], [2.0; 3]], noise), None);
    assert_eq!(facet_tilt_rad([[0.0; 3], [1.0, f64::NAN, 0.0], [2.0; 3]], noise), None);
}

/// The bound is met by the worst facet: two sides s, 120° between them.
#[test]
fn the_worst_facet_at_the_packed_bound() {
    let criteria = SpacingCriteria::new(1e-9, Some(0.05)).unwrap();
    let noise = Noise::new(1e-4, Along::Z).unwrap();
    let s = criteria.packed_bound_mm(noise, 0.0, 1.0);
    assert!((s / ((20.0_f64 / 3.0).sqrt() * 1e-4 / 0.05) - 1.0).abs() < 1e-8, "{s}");
    let corners = [[0.0, 0.0, 0.0], [s, 0.0, 0.0], [-0.5 * s, 0.75_f64.sqrt() * s, 0.0]];
    assert!((facet_tilt_rad(corners, noise).unwrap() / 0.05 - 1.0).abs() < 1e-8);
    // With gaps and slopes it is near to what the worst facet needs, too.
    for (gap_mm, gradient) in [(0.0, 1.0), (0.004, 0.0), (0.02, 0.0), (0.004, 1.0_f64)] {
        let cosine = 1.0 / gradient.hypot(1.0);
        let s = criteria.packed_bound_mm(noise, gap_mm, cosine);
        let (radius_mm, side_mm) = (s + gap_mm, s * cosine);
        // Two projected sides along the slope, as short as they can be.
        let height_mm = side_mm * side_mm / (2.0 * radius_mm);
        let half_mm = (side_mm * side_mm - height_mm * height_mm).sqrt();
        let corners =
            [[-half_mm, 0.0], [0.0, height_mm], [half_mm, 0.0]].map(|[x, y]| [x, y, gradient * x]);
        let tilt_rad = facet_tilt_rad(corners, noise).unwrap();
        assert!(tilt_rad <= 0.05 * (1.0 + 1e-8) && tilt_rad > 0.045, "{tilt_rad} {gap_mm}");
    }
}

fn spaced(
    pitch_mm: f64,
    criteria: &SpacingCriteria,
    sigma_mm: impl Fn(f64, f64) -> Option<f64>,
    lfs_mm: f64,
) -> Spacing {
    let points: Vec<PointMm> =
        raster([0.0, 0.0], 21, pitch_mm, 0.0, 1).iter().map(|&[x, y]| [x, y, 0.0]).collect();
    let noise = |x, y| Some(Noise::new(sigma_mm(x, y)?, Along::Z).unwrap());
    assess_spacing(&points, triangles(&points), criteria, noise, |_, _| lfs_mm)
}

#[test]
fn a_raster_that_is_too_dense_and_one_that_is_not() {
    let criteria = SpacingCriteria::new(0.05, None).unwrap();
    assert_eq!(criteria.tilt_limit_rad(), 0.05);
    // Noise turns facets by 2σ/h: by 0.05 rad at 4 µm with 100 nm.
    for (pitch_mm, fraction) in [(0.00399, 1.0), (0.00401, 0.0)] {
        let found = spaced(pitch_mm, &criteria, |_, _| Some(1e-4), 20.0);
        assert_eq!(found.overdense_fraction, Some(fraction), "{found:?}");
        assert!((found.median_mm.unwrap() / pitch_mm - 1.0).abs() < 1e-12, "{found:?}");
        assert!((found.tilt_median_rad.unwrap() * pitch_mm / 2e-4 - 1.0).abs() < 1e-12);
        assert!((found.area_mm2 / (20.0 * pitch_mm).powi(2) - 1.0).abs() < 1e-12);
        let Some(Advice::Between { noise_bound_mm, epsilon_bound_mm, recommended_mm }) =
            found.advice
        else {
            panic!("{found:?}")
        };
        assert!((noise_bound_mm / 0.004 - 1.0).abs() < 1e-12);
        assert!((epsilon_bound_mm / 2.0_f64.sqrt() - 1.0).abs() < 1e-12);
        // There noise and bending turn facets alike.
        let (noise, bending) = (2e-4 / recommended_mm, recommended_mm / (20.0 * 2.0_f64.sqrt()));
        assert!((noise / bending - 1.0).abs() < 1e-12, "{recommended_mm}");
    }
}

#[test]
fn the_noise_of_one_half_is_not_known_or_larger() {
    let criteria = SpacingCriteria::new(0.05, Some(0.01)).unwrap();
    let half = |x: f64| x < 0.0;
    let found = spaced(0.01, &criteria, |x, _| Some(if half(x) { 1e-5 } else { 1e-4 }), 20.0);
    assert!((found.overdense_fraction.unwrap() - 0.5).abs() < 1e-12, "{found:?}");
    let found = spaced(0.01, &criteria, |x, _| half(x).then_some(1e-4), 20.0);
    assert_eq!(found.overdense_fraction, Some(1.0));
    assert!((found.unknown_area_mm2 / found.area_mm2 - 0.5).abs() < 1e-12, "{found:?}");
    let unknown = spaced(0.01, &criteria, |_, _| None, 20.0);
    assert_eq!((unknown.overdense_fraction, unknown.advice), (None, None));
    assert_eq!(unknown.tilt_median_rad, None);
    let nothing = assess_spacing(&[], [], &criteria, |_, _| None, |_, _| 1.0);
    assert_eq!((nothing.median_mm, nothing.overdense_fraction), (None, None));
}

#[test]
fn advice_where_none_is_possible() {
    let criteria = SpacingCriteria::new(0.05, None).unwrap();
    // Both bounds meet at σ = ε² lfs / √2.
    let limit_mm = 0.05 * 0.05 * 2.0 / 2.0_f64.sqrt();
    let advice = |share: f64| criteria.advice(share * limit_mm, 2.0).unwrap();
    assert!(matches!(advice(0.999), Advice::Between { .. }));
    assert!(matches!(advice(1.001), Advice::Conflict { .. }));
    assert_eq!(
        criteria.advice(1e-4, f64::INFINITY),
        Some(Advice::AtLeast { noise_bound_mm: 2.0 * 1e-4 / 0.05 })
    );
    for lfs_mm in [0.0, -1.0, f64::NAN] {
        let conflict = criteria.advice(0.0, lfs_mm).unwrap();
        assert!(matches!(conflict, Advice::Conflict { epsilon_bound_mm: 0.0, .. }));
    }
    for sigma_mm in [-1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(criteria.advice(sigma_mm, 1.0), None);
    }
    for epsilon in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            SpacingCriteria::new(epsilon, Some(0.1)),
            Err(SpacingCriteriaError::Epsilon { .. })
        ));
    }
    for tilt in [0.0, 1.6, f64::NAN] {
        assert!(matches!(
            SpacingCriteria::new(0.05, Some(tilt)),
            Err(SpacingCriteriaError::Tilt { .. })
        ));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..beside_source() })]

    #[test]
    fn a_spacing_within_the_bounds_satisfies_both_conditions(
        sigma_mm in 1e-9..1e-2_f64,
        lfs_mm in 1e-2..1e4_f64,
        epsilon in 1e-3..0.5_f64,
    ) {
        let criteria = SpacingCriteria::new(epsilon, None).unwrap();
        if let Advice::Between { recommended_mm, .. } = criteria.advice(sigma_mm, lfs_mm).unwrap() {
            let tilt = 2.0 * sigma_mm / recommended_mm;
            let gap_mm = recommended_mm / 2.0_f64.sqrt();
            prop_assert!(tilt <= epsilon * (1.0 + 1e-12) && gap_mm <= epsilon * lfs_mm * (1.0 + 1e-12));
        }
    }

    #[test]
    fn no_facet_at_the_packed_bound_turns_farther_than_the_limit(
        angles in prop::array::uniform3(0.0..std::f64::consts::TAU),
        gradient in prop::array::uniform2(-2.0..2.0_f64),
        gap_share in 0.0..3.0_f64,
        epsilon in 1e-3..1.0_f64,
        radius_share in 0.3..1.0_f64,
        normal in any::<bool>(),
    ) {
        let criteria = SpacingCriteria::new(epsilon, None).unwrap();
        let noise = Noise::new(1e-4, if normal { Along::Normal } else { Along::Z }).unwrap();
        let cosine = 1.0 / gradient[0].hypot(gradient[1]).hypot(1.0);
        let gap_mm = gap_share * 1e-4 / epsilon;
        let spacing_mm = criteria.packed_bound_mm(noise, gap_mm, cosine);
        // Any facet on an empty circle up to the largest, in the plane.
        let largest_mm = (1.0 + epsilon) * spacing_mm + (1.0 + 2.0 * epsilon) * gap_mm;
        let corners = angles.map(|angle: f64| {
            let [x, y] = [angle.cos(), angle.sin()].map(|part| radius_share * largest_mm * part);
            [x, y, gradient[0] * x + gradient[1] * y]
        });
        let shortest_mm = (0..3)
            .map(|i| (0..3).map(move |axis| corners[i][axis] - corners[(i + 1) % 3][axis]))
            .map(|parts| parts.map(|part| part * part).sum::<f64>().sqrt())
            .fold(f64::INFINITY, f64::min);
        prop_assume!(shortest_mm >= spacing_mm);
        prop_assert_eq!(criteria.is_overdense(corners, noise), Some(false));
    }

    #[test]
    fn chosen_vertices_are_even_and_different(all in 0_usize..5000, count in 20_usize..400) {
        let chosen = estimate::chosen(all, count);
        prop_assert!(chosen.len() <= all.min(count) && 10 * chosen.len() >= 7 * all.min(count));
        prop_assert!(chosen.windows(2).all(|pair| pair[0] < pair[1]));
        prop_assert!(chosen.iter().all(|&vertex: &VertexId| (vertex as usize) < all));
        // No stretch of numbers is left out that is three times as long as the mean.
        let widest = chosen.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
        prop_assert!(f64::from(widest) <= 3.0 * all as f64 / count.min(all.max(1)) as f64 + 1.0);
    }

    #[test]
    fn noise_scales_and_does_not_depend_on_place_or_sign(
        seed in 0_u64..1000,
        away in -1e6..1e6_f64,
        scale in -30_i32..30,
    ) {
        let mut points = over(&raster([2.0, -1.0], 20, PITCH_MM, 0.3, seed), freeform);
        roughen(&mut points, 1e-4, seed);
        let adjacency = adjacency(&points, Some(0.2));
        let sigma_mm = |points: &[PointMm]| estimate(points, &adjacency).noise.sigma_mm();
        let found = sigma_mm(&points);
        let factor = 2.0_f64.powi(scale);
        let scaled: Vec<PointMm> = points.iter().map(|point| point.map(|x| x * factor)).collect();
        prop_assert!((sigma_mm(&scaled) / factor / found - 1.0).abs() < 1e-9);
        let flipped: Vec<PointMm> = points.iter().map(|&[x, y, z]| [x, y, -z]).collect();
        prop_assert!((sigma_mm(&flipped) / found - 1.0).abs() < 1e-9);
        let moved: Vec<PointMm> =
            points.iter().map(|&[x, y, z]| [x + away, y - away, z + away]).collect();
        prop_assert!((sigma_mm(&moved) / found - 1.0).abs() < 1e-4);
    }
}
