//! Sums of shapes and sections off the axis.

use std::sync::Arc;

use asphera_form::shape::{
    Conic, ConicSection, Cylinder, EvenAsphere, Mirror, OffAxis, Projection, QAsphere, Shape, Sum,
    Toroid,
};
use proptest::prelude::*;

use crate::common::close;

fn conic(radius: f64, conic: f64) -> Arc<dyn Shape> {
    Arc::new(Conic::new(ConicSection::new(radius, conic).unwrap()))
}

fn names(shape: &dyn Shape) -> Vec<String> {
    shape.parameters().into_iter().map(|parameter| parameter.name).collect()
}

#[test]
fn names_of_a_sum() {
    let flat = |terms: &[(u8, f64)]| -> Arc<dyn Shape> {
        Arc::new(EvenAsphere::new(ConicSection::FLAT, terms).unwrap())
    };
    let plain = Sum::new(vec![conic(30.0, -1.0), flat(&[(4, 1e-6), (6, 0.0)])]).unwrap();
    assert_eq!(names(&plain), ["radius", "conic", "A4", "A6"]);
    let repeated = Sum::new(vec![flat(&[(4, 1e-6)]), conic(30.0, 0.0), flat(&[(4, 0.0)])]).unwrap();
    assert_eq!(names(&repeated), ["1.A4", "2.radius", "2.conic", "3.A4"]);
    let nested = Sum::new(vec![Arc::new(repeated), conic(10.0, 0.0), conic(20.0, 0.0)]).unwrap();
    let expected = [
        "1.1.A4",
        "1.2.radius",
        "1.2.conic",
        "1.3.A4",
        "2.radius",
        "2.conic",
        "3.radius",
        "3.conic",
    ];
    assert_eq!(names(&nested), expected);
    let changed = nested.with_parameters(&[0.0, 40.0, 0.0, 0.0, -40.0, 0.0, 25.0, -1.0]).unwrap();
    assert!(close(changed.sag_mm(3.0, 4.0).unwrap(), 25.0 / 50.0, 1e-14));
}

#[test]
fn a_sum_ends_with_its_smallest_part() {
    let q = QAsphere::bfs(ConicSection::FLAT, 9.0, Projection::Axis, &[0.1]).unwrap();
    let sum = Sum::new(vec![conic(30.0, 0.0), Arc::new(q)]).unwrap();
    assert_eq!(sum.domain_mm(), 9.0);
    assert!(sum.jet(0.0, 9.0).is_some());
    assert_eq!(sum.jet(0.0, 9.0 + 1e-9), None);
    assert_eq!(sum.sag_mm(9.1, 0.0), None);
}

proptest! {
    /// A sphere looks the same from any of its places.
    #[test]
    fn tilted_sphere_is_the_sphere(
        (dx, dy) in (-45.0..45.0, -45.0..45.0),
        (u, v) in (-35.0..35.0, -35.0..35.0),
    ) {
        let sphere = Arc::new(Conic::sphere(-100.0).unwrap());
        let section = OffAxis::tilted(sphere.clone(), dx, dy).unwrap();
        // Both places lie within the hemisphere of the parent.
        let [ours, theirs] = [section.jet(u, v).unwrap(), sphere.jet(u, v).unwrap()];
        prop_assert!((ours.z_mm - theirs.z_mm).abs() < 1e-12);
        for (a, b) in ours.gradient.iter().zip(theirs.gradient) {
            prop_assert!((a - b).abs() < 1e-13);
        }
        for (a, b) in ours.hessian_per_mm.iter().zip(theirs.hessian_per_mm) {
            prop_assert!((a - b).abs() < 1e-14);
        }
    }

    /// A section of a paraboloid is the mirror that focuses parallel light: focus at f + d²/(4f), grazing
    /// angle from the slope d/(2f).
    #[test]
    fn tilted_paraboloid_is_the_focusing_mirror(
        f in 40.0..2000.0_f64,
        share in 0.05..4.0_f64,
        (u, v) in (-20.0..20.0, -20.0..20.0),
    ) {
        let d = share * f;
        let section = OffAxis::tilted(conic(2.0 * f, -1.0), -d, 0.0).unwrap();
        let theta = (2.0 * f).atan2(d);
        let mirror = Mirror::revolved(f64::INFINITY, f + d * d / (4.0 * f), theta).unwrap();
        let [ours, theirs] = [section.jet(u, v).unwrap(), mirror.jet(u, v).unwrap()];
        prop_assert!((ours.z_mm - theirs.z_mm).abs() < 1e-14 * (d + f) * (1.0 + share));
        for (a, b) in ours.hessian_per_mm.iter().zip(theirs.hessian_per_mm) {
            prop_assert!((a - b).abs() < 1e-12 * b.abs() + 1e-14, "{a} {b}");
        }
    }

    #[test]
    fn parallel_section_is_a_difference_of_heights(
        (dx, dy) in (-20.0..20.0, -20.0..20.0),
        (u, v) in (-5.0..5.0, -5.0..5.0),
    ) {
        let section = ConicSection::new(60.0, 0.4).unwrap();
        let parent = Arc::new(Toroid::new(80.0, section, &[(4, 1e-6)]).unwrap());
        let shape = OffAxis::parallel(parent.clone(), dx, dy).unwrap();
        let [there, origin] = [parent.jet(dx + u, dy + v).unwrap(), parent.jet(dx, dy).unwrap()];
        let jet = shape.jet(u, v).unwrap();
        prop_assert!((jet.z_mm - (there.z_mm - origin.z_mm)).abs() < 1e-14);
        prop_assert_eq!(jet.gradient, there.gradient);
        prop_assert_eq!(jet.hessian_per_mm, there.hessian_per_mm);
    }

    /// In its own frame a tilted section begins flat, whatever the parent.
    #[test]
    fn tilted_section_begins_flat((dx, dy) in (-8.0..8.0, -8.0..8.0)) {
        let cylinder = Cylinder::acylinder(ConicSection::new(15.0, 0.3).unwrap(), &[(4, 1e-5)]);
        let parts: Vec<Arc<dyn Shape>> = vec![Arc::new(cylinder.unwrap()), conic(-40.0, -2.0)];
        let section = OffAxis::tilted(Arc::new(Sum::new(parts).unwrap()), dx, dy).unwrap();
        let jet = section.jet(0.0, 0.0).unwrap();
        prop_assert!(jet.z_mm.abs() < 1e-15);
        prop_assert!(jet.gradient.iter().all(|slope| slope.abs() < 1e-15));
        let [x, y, z] = section.axes();
        let product = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        for (a, b, expected) in [(x, x, 1.0), (y, y, 1.0), (z, z, 1.0), (x, y, 0.0), (y, z, 0.0)] {
            prop_assert!((product(a, b) - expected).abs() < 1e-15);
        }
    }
}

/// The rim of a tilted hemisphere section: the parent's equator cuts it where the parent ends.
#[test]
fn domain_of_a_section() {
    let sphere: Arc<dyn Shape> = Arc::new(Conic::sphere(100.0).unwrap());
    let parallel = OffAxis::parallel(sphere.clone(), 30.0, 40.0).unwrap();
    assert_eq!(parallel.domain_mm(), 50.0);
    // Seen along the normal at 30° from the axis, the equator comes nearest at 60° from it.
    let tilted = OffAxis::tilted(sphere, 50.0, 0.0).unwrap();
    let expected = 100.0 * 60_f64.to_radians().sin();
    let domain = tilted.domain_mm();
    assert!(domain <= expected && domain > 0.99 * expected, "{domain}, not {expected}");
    assert!(tilted.jet(expected + 0.01, 0.0).is_none());
    let flat = OffAxis::tilted(Arc::new(Conic::plane()), 5.0, -7.0).unwrap();
    assert_eq!(flat.domain_mm(), f64::INFINITY);
}

/// When the radius changes the origin stays on the parent, and the axes keep their directions.
#[test]
fn section_with_another_radius() {
    let section = OffAxis::tilted(conic(100.0, -1.0), 30.0, 0.0).unwrap();
    let other = section.with_parameters(&[110.0, -1.0]).unwrap();
    assert_eq!(other.sag_mm(0.0, 0.0).map(f64::abs), Some(0.0));
    // Slopes of the parents there are 0.3 and 30/110; seen along the first normal, the difference of the
    // angles.
    let slope = (30.0_f64 / 110.0).atan() - 0.3_f64.atan();
    assert!((other.jet(0.0, 0.0).unwrap().gradient[0] - slope.tan()).abs() < 1e-15);
}
