//! Radii from starts of either sign, up to nearly flat: steps are those of the curvature.

use std::sync::Arc;

use asphera_form::shape::{Biconic, Conic, ConicSection, Cylinder, Shape, Toroid};
use asphera_form::{Asphere, Fit, FitSettings, Nominal, Parameter, PointMm, Pose, fit};
use rand_core::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::common::{normals, spiral};

/// 10 mm to 10 km.
const RADII_MM: [f64; 7] = [10.0, 100.0, 1e3, 1e4, 1e5, 1e6, 1e7];

fn points(nominal: &Nominal, pose: &Pose, reach_mm: f64) -> Vec<PointMm> {
    let place = |[x, y]: [f64; 2]| pose.to_measured([x, y, nominal.height_mm(x, y).unwrap()]);
    spiral(600, reach_mm).into_iter().map(place).collect()
}

fn radius(fit: &Fit) -> f64 {
    fit.nominal.radius_mm().unwrap()
}

/// The curvature is known to the rounding of heights, some 1e-15 mm, over half the square of the aperture.
fn assert_found(found: f64, truth: f64, what: &str) {
    let off_per_mm = (found.recip() - truth.recip()).abs();
    assert!(off_per_mm < 1e-15 + 1e-11 / truth.abs(), "{what}: {found} for {truth} mm");
}

/// Before, 1 m of the wrong sign ended at −2,325,817 mm, or at no fit at all.
#[test]
fn spheres_arrive_from_starts_of_either_sign() {
    use Parameter::{Radius, Rx, Ry, Tx, Ty, Tz};
    let ways: [&[Parameter]; 3] =
        [&[Tz, Radius], &[Tx, Ty, Tz, Radius], &[Tx, Ty, Tz, Rx, Ry, Radius]];
    for (size_mm, sign) in RADII_MM.iter().flat_map(|r| [(r, 1.0), (r, -1.0)]) {
        let truth_mm = sign * size_mm;
        let truth = Nominal::Sphere { radius_mm: truth_mm };
        let laid = Pose { tz_mm: 0.3, ..Pose::default() };
        let measured = points(&truth, &laid, (0.2 * size_mm).min(5.0));
        for start in [1.0, -1.0, 3.0, -3.0, -0.5] {
            for free in ways {
                let nominal = Nominal::Sphere { radius_mm: start * truth_mm };
                let settings = FitSettings { free: free.to_vec(), ..FitSettings::default() };
                let found = fit(&measured, &nominal, &settings).unwrap();
                let what =
                    format!("{truth_mm} mm from {} with {} free", start * truth_mm, free.len());
                assert!(found.termination.is_converged(), "{what}: {:?}", found.termination);
                assert_found(radius(&found), truth_mm, &what);
                assert!(found.iterations < 40, "{what}: {} steps", found.iterations);
            }
        }
    }
}

#[test]
fn aspheres_and_every_radius_of_other_shapes_arrive() {
    for size_mm in [20.0, 1e3, 1e5] {
        let section = |sign: f64, conic: f64| ConicSection::new(sign * size_mm, conic).unwrap();
        let shapes = |sign: f64| -> Vec<Nominal> {
            let free = |shape: Arc<dyn Shape>| Nominal::Freeform(shape);
            vec![
                Nominal::Asphere(Asphere::new(sign * size_mm, -1.0, &[(4, 1e-7)]).unwrap()),
                free(Arc::new(Conic::sphere(sign * size_mm).unwrap())),
                free(Arc::new(Cylinder::new(sign * size_mm).unwrap())),
                free(Arc::new(Toroid::new(2.0 * sign * size_mm, section(sign, 0.0), &[]).unwrap())),
                free(Arc::new(Biconic::new(section(sign, 0.3), section(2.0 * sign, -0.5)))),
            ]
        };
        for (truth, start) in shapes(1.0).into_iter().zip(shapes(-1.0)) {
            let free: Vec<Parameter> = start
                .parameters()
                .into_iter()
                .filter(|(_, name)| name == "tz" || name.contains("radius"))
                .map(|(parameter, _)| parameter)
                .collect();
            let measured = points(&truth, &Pose::default(), 4.0);
            let settings = FitSettings { free: free.clone(), ..FitSettings::default() };
            let found = fit(&measured, &start, &settings).unwrap();
            for parameter in free.into_iter().filter(|&free| free != Parameter::Tz) {
                let value = |nominal| parameter.value(&Pose::default(), nominal).unwrap();
                let what = format!("{} of {truth}", parameter.name(&truth));
                assert_found(value(&found.nominal), value(&truth), &what);
            }
        }
    }
}

/// Against a straight line through height over r²/2, whose slope is the curvature: u(R) = R²·u(c).
#[test]
fn the_uncertainty_of_a_radius_is_that_of_its_curvature() {
    for truth_mm in [-1e7, 1e4, 1e6] {
        let sphere = Nominal::Sphere { radius_mm: truth_mm };
        let mut measured = points(&sphere, &Pose::default(), 10.0);
        let noise = normals(&mut Pcg64Mcg::seed_from_u64(7), measured.len());
        // 0.01 nm: of a radius of 10 km one in a thousand.
        measured.iter_mut().zip(noise).for_each(|(point, e)| point[2] += 1e-8 * e);
        let settings =
            FitSettings { free: vec![Parameter::Tz, Parameter::Radius], ..FitSettings::default() };
        let start = Nominal::Sphere { radius_mm: -truth_mm };
        let found = fit(&measured, &start, &settings).unwrap();
        let halves: Vec<f64> = measured.iter().map(|[x, y, _]| 0.5 * (x * x + y * y)).collect();
        let n = halves.len() as f64;
        let (q, z) = (
            halves.iter().sum::<f64>() / n,
            measured.iter().map(|point| point[2]).sum::<f64>() / n,
        );
        let square: f64 = halves.iter().map(|half| (half - q).powi(2)).sum();
        let mixed: f64 =
            halves.iter().zip(&measured).map(|(half, point)| (half - q) * (point[2] - z)).sum();
        let c = mixed / square;
        let left: f64 = halves
            .iter()
            .zip(&measured)
            .map(|(half, point)| (point[2] - z - c * (half - q)).powi(2))
            .sum();
        let u_c = (left / (n - 2.0) / square).sqrt();
        let u = found.estimates.iter().find(|one| one.parameter == Parameter::Radius).unwrap().u;
        let expected = radius(&found).powi(2) * u_c;
        assert!((u.unwrap() / expected - 1.0).abs() < 1e-3, "{truth_mm}: {u:?}, {expected}");
        // A sphere is steeper than its parabola by the fourth order.
        assert!((radius(&found) * c - 1.0).abs() < 1e-4, "{truth_mm}: {}", radius(&found));
    }
}
