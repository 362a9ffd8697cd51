//! Laws of a fit: rigid motion, scale, order of the points, number of threads.

use crate::common::{Noise, al1815, misaligned, spiral};
use asphera_form::{Aperture, Figures, Fit, FitSettings, Nominal, PointMm, Pose, deviations, fit};
use asphera_form::{Asphere, Parameter};
use proptest::prelude::*;

/// A lens with a rough surface, 20 nm.
fn rough_lens(count: usize, seed: u64) -> Vec<PointMm> {
    let mut noise = Noise::new(seed);
    let point = |[x, y]: [f64; 2]| {
        let z = al1815().sag_mm(x.hypot(y)) + 2e-5 * noise.next();
        misaligned().to_measured([x, y, z])
    };
    spiral(count, 9.0).into_iter().map(point).collect()
}

fn figures(points: &[PointMm], fit: &Fit) -> Figures {
    let found = deviations(points, &fit.nominal, &fit.pose);
    Figures::new(points, &found, &fit.pose, &Aperture::None).unwrap()
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let points = rough_lens(30_000, 3);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let fitted = fit(&points, &al1815(), &FitSettings::default()).unwrap();
            let found = deviations(&points, &fitted.nominal, &fitted.pose);
            (fitted, found)
        })
    };
    let one = with(1);
    for threads in [2, 3, 7] {
        assert_eq!(with(threads), one);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn figures_do_not_change_with_a_rigid_motion(
        t in prop::array::uniform3(-50.0..50.0f64),
        r in prop::array::uniform3(-0.2..0.2f64),
        seed in 0..1000u64,
    ) {
        let points = rough_lens(1_500, seed);
        let motion = Pose {
            tx_mm: t[0], ty_mm: t[1], tz_mm: t[2], rx_rad: r[0], ry_rad: r[1], rz_rad: r[2],
        };
        let moved: Vec<PointMm> = points.iter().map(|&p| motion.to_measured(p)).collect();
        let (a, b) = (
            fit(&points, &al1815(), &FitSettings::default()).unwrap(),
            fit(&moved, &al1815(), &FitSettings::default()).unwrap(),
        );
        prop_assert!(a.termination.is_converged() && b.termination.is_converged(), "{b:?}");
        let (a, b) = (figures(&points, &a), figures(&moved, &b));
        prop_assert!((a.rms_nm - b.rms_nm).abs() < 1e-6, "{} {}", a.rms_nm, b.rms_nm);
        prop_assert!((a.pv_nm - b.pv_nm).abs() < 1e-5, "{} {}", a.pv_nm, b.pv_nm);
    }

    #[test]
    fn figures_scale_with_the_part(scale in 0.01..100.0f64, seed in 0..1000u64) {
        let points = rough_lens(1_500, seed);
        let scaled: Vec<PointMm> = points.iter().map(|p| p.map(|c| c * scale)).collect();
        let Nominal::Asphere(mut asphere) = al1815() else { unreachable!() };
        asphere.radius_mm *= scale;
        for (i, a) in asphere.coefficients.iter_mut().enumerate() {
            *a *= scale.powi(1 - (4 + 2 * i as i32));
        }
        let (a, b) = (
            fit(&points, &al1815(), &FitSettings::default()).unwrap(),
            fit(&scaled, &Nominal::Asphere(asphere), &FitSettings::default()).unwrap(),
        );
        prop_assert!(b.termination.is_converged());
        prop_assert!((b.sigma_mm / scale / a.sigma_mm - 1.0).abs() < 1e-8);
        prop_assert!((b.pose.tx_mm / scale - a.pose.tx_mm).abs() < 1e-9);
        prop_assert!((b.pose.rx_rad - a.pose.rx_rad).abs() < 1e-10);
    }

    #[test]
    fn order_of_the_points_does_not_matter(seed in 0..1000u64) {
        let mut points = rough_lens(1_500, seed);
        let a = fit(&points, &al1815(), &FitSettings::default()).unwrap();
        let mut noise = Noise::new(seed);
        for i in (1..points.len()).rev() {
            points.swap(i, (noise.next().abs() * (i + 1) as f64) as usize % (i + 1));
        }
        let b = fit(&points, &al1815(), &FitSettings::default()).unwrap();
        prop_assert!((a.sigma_mm - b.sigma_mm).abs() < 1e-15);
        for (a, b) in a.estimates.iter().zip(&b.estimates) {
            prop_assert!((a.value - b.value).abs() < 1e-11, "{a:?} {b:?}");
        }
    }

    #[test]
    fn least_squares_is_least(
        nudge in prop::array::uniform5(-1.0..1.0f64), seed in 0..1000u64,
    ) {
        let points = rough_lens(800, seed);
        let best = fit(&points, &al1815(), &FitSettings::default()).unwrap();
        let mut pose = best.pose;
        pose.tx_mm += 1e-3 * nudge[0];
        pose.ty_mm += 1e-3 * nudge[1];
        pose.tz_mm += 1e-5 * nudge[2];
        pose.rx_rad += 1e-4 * nudge[3];
        pose.ry_rad += 1e-4 * nudge[4];
        let other = deviations(&points, &best.nominal, &pose);
        let other = Figures::new(&points, &other, &pose, &Aperture::None).unwrap();
        prop_assert!(figures(&points, &best).rms_nm <= other.rms_nm);
    }
}

/// Rounding of coordinates of 50 mm once hid the descent of the last step.
#[test]
fn converges_where_rounding_exceeds_the_last_descent() {
    let motion = Pose {
        tx_mm: 4.916213095324017,
        ty_mm: 0.0,
        tz_mm: 49.152991583014675,
        rx_rad: 0.16272176510906203,
        ry_rad: -0.04714784655617325,
        rz_rad: 0.04552187241252351,
    };
    let points: Vec<PointMm> =
        rough_lens(1_500, 500).iter().map(|&point| motion.to_measured(point)).collect();
    let fitted = fit(&points, &al1815(), &FitSettings::default()).unwrap();
    assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
    assert!(fitted.iterations < 20);
}

#[test]
fn a_paraboloid_scan_of_a_conic_finds_the_conic_constant() {
    let paraboloid = Nominal::Asphere(Asphere::new(20.0, -1.0, &[]).unwrap());
    let points: Vec<PointMm> =
        spiral(2_000, 10.0).iter().map(|&[x, y]| [x, y, (x * x + y * y) / 40.0]).collect();
    let begin = Nominal::Asphere(Asphere::new(19.0, -0.5, &[]).unwrap());
    let free = Parameter::RIGID.into_iter().chain([Parameter::Radius, Parameter::Conic]).collect();
    let fitted = fit(&points, &begin, &FitSettings { free, ..FitSettings::default() }).unwrap();
    assert!(fitted.termination.is_converged());
    let (found, truth) = (fitted.nominal.asphere().unwrap(), paraboloid.asphere().unwrap());
    assert!((found.radius_mm - truth.radius_mm).abs() < 1e-12);
    assert!((found.conic - truth.conic).abs() < 1e-12);
}
