//! Sag, slope, curvature and feet of the nominals against published values and closed forms.

use crate::common::al1815;
use asphera_form::{Asphere, Nominal, NominalError, Parameter};
use proptest::prelude::*;

#[test]
fn al1815_sag_table() {
    for (r, z) in [(3.0, 0.38860699918513), (6.0, 1.58193496464626), (9.0, 3.65468364040223)] {
        assert!((al1815().sag_mm(r) - z).abs() < 1e-13, "r = {r}: {}", al1815().sag_mm(r));
    }
}

#[test]
fn asl5040_base_conic_sag_table() {
    let radius_mm = 1.0 / 0.05756078762782423;
    let nominal = Nominal::Asphere(Asphere::new(radius_mm, -0.6760912064040793, &[]).unwrap());
    let table = [
        (5.0, 0.72440175535287),
        (10.0, 2.95970043589438),
        (15.0, 6.92229205986660),
        (20.0, 13.11580728984559),
        (22.86, 18.09109600236299),
    ];
    for (r, z) in table {
        assert!((nominal.sag_mm(r) - z).abs() < 2e-13, "r = {r}: {}", nominal.sag_mm(r));
    }
}

/// Optiland tests/test_geometries.py, EvenAsphere R = 27 with r² and r⁴ coefficients 1e-3 and −1e-5. The r²
/// term is not ours: it is added by hand.
#[test]
fn optiland_even_asphere_less_its_r2_term() {
    let nominal = Nominal::Asphere(Asphere::new(27.0, 0.0, &[(4, -1e-5)]).unwrap());
    let with_r2 = |x: f64, y: f64| nominal.sag_mm(x.hypot(y)) + 1e-3 * (x * x + y * y);
    assert!((with_r2(1.0, 1.0) - 0.039022474574473776).abs() < 1e-15);
    assert!((with_r2(-2.0, 3.0) - 0.25313367948069593).abs() < 1e-15);
}

#[test]
fn conics_with_closed_forms() {
    let conic = |kappa| Nominal::Asphere(Asphere::new(-10.0, kappa, &[]).unwrap());
    assert!((conic(-1.0).sag_mm(4.0) + 0.8).abs() < 1e-15);
    assert_eq!(conic(0.0).sag_mm(6.0), Nominal::Sphere { radius_mm: -10.0 }.sag_mm(6.0));
    assert!((conic(0.0).sag_mm(6.0) + 2.0).abs() < 1e-15);
    assert_eq!(conic(3.0).domain_mm(), 5.0);
    assert!(conic(3.0).sag_mm(5.1).is_nan());
    assert!(conic(-1.0).domain_mm().is_infinite());
}

#[test]
fn curvature_bounds_the_local_feature_size() {
    assert_eq!(Nominal::Plane.lfs_bound_mm(3.0), f64::INFINITY);
    let sphere = Nominal::Sphere { radius_mm: -25.0 };
    for r in [0.0, 1e-9, 5.0, 20.0] {
        assert!((sphere.lfs_bound_mm(r) - 25.0).abs() < 1e-12);
        assert!(sphere.curvatures(r).meridional_per_mm < 0.0);
    }
    assert!(sphere.lfs_bound_mm(26.0).is_nan());
    // Paraboloid z = r²/2R: meridional R·(1+r²/R²)^{3/2}, azimuthal R·(1+r²/R²)^{1/2}.
    let paraboloid = Nominal::Asphere(Asphere::new(10.0, -1.0, &[]).unwrap());
    let stretch = (1.0_f64 + 0.49).sqrt();
    let found = paraboloid.curvatures(7.0);
    assert!((found.meridional_per_mm * 10.0 * stretch.powi(3) - 1.0).abs() < 1e-14);
    assert!((found.azimuthal_per_mm * 10.0 * stretch - 1.0).abs() < 1e-14);
    assert!((paraboloid.lfs_bound_mm(7.0) - 10.0 * stretch).abs() < 1e-13);
    assert!((al1815().lfs_bound_mm(0.0) - 11.65).abs() < 1e-14);
}

#[test]
fn impossible_nominals_are_refused() {
    for radius in [0.0, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE / 2.0] {
        assert!(matches!(
            Nominal::Sphere { radius_mm: radius }.validate(),
            Err(NominalError::Radius(_))
        ));
    }
    assert!(matches!(Asphere::new(1.0, f64::NAN, &[]), Err(NominalError::Conic(_))));
    assert_eq!(Asphere::new(1.0, 0.0, &[(2, 1e-3)]), Err(NominalError::Order(2)));
    assert_eq!(Asphere::new(1.0, 0.0, &[(5, 1e-3)]), Err(NominalError::Order(5)));
    assert_eq!(
        Asphere::new(1.0, 0.0, &[(6, f64::INFINITY)]),
        Err(NominalError::Coefficient { order: 6, value: f64::INFINITY })
    );
}

#[test]
fn a_report_names_the_nominal_in_words() {
    let nominal = Nominal::Asphere(Asphere::new(11.65, -1.1, &[(4, 3.69e-5)]).unwrap());
    assert_eq!(nominal.to_string(), "asphere R 11.65 mm, conic -1.1, A4 3.69e-5 mm^-3");
    assert_eq!(Nominal::Plane.to_string(), "plane");
    assert!(nominal.has(Parameter::A(20)) && !nominal.has(Parameter::A(3)));
    assert!(!Nominal::Plane.has(Parameter::Radius));
}

#[test]
fn feet_of_points_without_one() {
    let sphere = Nominal::Sphere { radius_mm: 10.0 };
    assert!(sphere.foot([0.0, 0.0, 10.0]).is_none(), "the centre has no single foot");
    assert!(sphere.foot([3.0, 0.0, 11.0]).is_none(), "beyond the equator");
    assert!(sphere.foot([f64::NAN, 0.0, 0.0]).is_none());
    let ellipsoid = Nominal::Asphere(Asphere::new(10.0, 3.0, &[]).unwrap());
    assert!(ellipsoid.foot([5.0, 0.0, 40.0]).is_none());
    assert!(al1815().foot([f64::INFINITY, 0.0, 0.0]).is_none());
    assert!(al1815().foot([0.0, 1e200, 0.0]).is_none());
    let vertex = al1815().foot([0.0, 0.0, 1e-3]).unwrap();
    assert_eq!((vertex.foot_mm, vertex.normal, vertex.distance_mm), ([0.0; 3], [0., 0., 1.], 1e-3));
}

#[test]
fn a_large_radius_costs_no_digits() {
    // A metre-radius sphere 5 pm under a point at its vertex, and the same beside it.
    let sphere = Nominal::Sphere { radius_mm: 1e6 };
    let foot = sphere.foot([0.0, 0.0, 5e-9]).unwrap();
    assert!((foot.distance_mm - 5e-9).abs() < 1e-24);
    let z = sphere.sag_mm(10.0);
    let foot = sphere.foot([10.0, 0.0, z + 1e-6]).unwrap();
    assert!((foot.distance_mm - 1e-6).abs() < 1e-15);
}

/// The sphere's closed form against Newton's iteration on the same sphere written as an asphere.
#[test]
fn newton_agrees_with_the_closed_form_on_a_sphere() {
    for radius_mm in [12.0, -12.0] {
        let sphere = Nominal::Sphere { radius_mm };
        let asphere = Nominal::Asphere(Asphere::new(radius_mm, 0.0, &[]).unwrap());
        for i in 0..200 {
            let r = 11.0 * f64::from(i) / 200.0;
            for off in [-0.5, -1e-4, 0.0, 1e-4, 0.5] {
                let point = [0.6 * r, -0.8 * r, sphere.sag_mm(r) + off];
                let (a, b) = (sphere.foot(point), asphere.foot(point));
                let Some(a) = a else { continue };
                let b = b.unwrap();
                assert!((a.distance_mm - b.distance_mm).abs() < 2e-14, "r = {r}: {a:?} {b:?}");
                for k in 0..3 {
                    assert!((a.foot_mm[k] - b.foot_mm[k]).abs() < 1e-12);
                    assert!((a.normal[k] - b.normal[k]).abs() < 1e-12);
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn slope_and_curvature_are_derivatives_of_the_sag(r in 0.01..9.0f64) {
        let nominal = al1815();
        let h = 1e-4;
        let difference = (nominal.sag_mm(r + h) - nominal.sag_mm(r - h)) / (2.0 * h);
        prop_assert!((nominal.slope(r) - difference).abs() < 1e-9);
        let second = (nominal.slope(r + h) - nominal.slope(r - h)) / (2.0 * h);
        let stretch = (1.0 + nominal.slope(r).powi(2)).sqrt();
        let found = nominal.curvatures(r).meridional_per_mm * stretch.powi(3);
        prop_assert!((found - second).abs() < 1e-7);
        let [gx, gy] = nominal.gradient(0.6 * r, 0.8 * r);
        prop_assert!((gx - 0.6 * nominal.slope(r)).abs() < 1e-14);
        prop_assert!((gy - 0.8 * nominal.slope(r)).abs() < 1e-14);
    }

    #[test]
    fn point_made_along_a_normal_has_that_foot(
        r in 0.0..9.0f64, phi in -3.2..3.2f64, d in -2.0..2.0f64, flip in any::<bool>(),
    ) {
        let Nominal::Asphere(mut asphere) = al1815() else { unreachable!() };
        if flip {
            asphere.radius_mm = -asphere.radius_mm;
            asphere.coefficients.iter_mut().for_each(|a| *a = -*a);
        }
        let nominal = Nominal::Asphere(asphere);
        let slope = nominal.slope(r);
        let n_z = (1.0 + slope * slope).sqrt().recip();
        let n_r = -slope * n_z;
        let reach = r + d * n_r;
        // Beyond the axis the point has a nearer foot on the other side.
        prop_assume!(reach >= 0.0);
        let point = [reach * phi.cos(), reach * phi.sin(), nominal.sag_mm(r) + d * n_z];
        let foot = nominal.foot(point).unwrap();
        prop_assert!((foot.distance_mm - d).abs() < 1e-14, "{} {d}", foot.distance_mm);
        prop_assert!((foot.foot_mm[0] - r * phi.cos()).abs() < 1e-13);
        prop_assert!((foot.normal[2] - n_z).abs() < 1e-14);
    }
}
