//! Every derivative of every shape against differences of its heights, over random places and parameters.

use std::sync::Arc;

use asphera_form::shape::{
    Biconic, Conic, ConicSection, Cylinder, EvenAsphere, Mirror, OddAsphere, OffAxis, Projection,
    QAsphere, Shape, Sum, Toroid,
};
use proptest::prelude::*;

use crate::common::check;

/// A radius of either sign.
fn radius() -> impl Strategy<Value = f64> {
    (8.0..200.0, any::<bool>()).prop_map(|(r, negative): (f64, bool)| if negative { -r } else { r })
}

fn section() -> impl Strategy<Value = ConicSection> {
    (radius(), -3.0..0.9).prop_map(|(radius, conic)| ConicSection::new(radius, conic).unwrap())
}

/// A curved or, one time in four, a flat section.
fn base() -> impl Strategy<Value = ConicSection> {
    prop_oneof![3 => section(), 1 => Just(ConicSection::FLAT)]
}

/// A place within 5 mm of the vertex, often on an axis or at the vertex itself.
fn place() -> impl Strategy<Value = (f64, f64)> {
    let number = || prop_oneof![6 => -3.5..3.5, 1 => Just(0.0)];
    (number(), number())
}

/// Coefficients that give micrometres to millimetres at 5 mm.
fn coefficient(order: i32) -> impl Strategy<Value = f64> {
    (-0.1..0.1).prop_map(move |height: f64| height / 5_f64.powi(order))
}

const STEP: f64 = 0.05;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn conic(section in base(), (x, y) in place()) {
        check(&Conic::new(section), x, y, STEP, 5.0);
    }

    #[test]
    fn sphere(radius in radius(), (x, y) in place()) {
        check(&Conic::sphere(radius).unwrap(), x, y, STEP, 5.0);
    }

    #[test]
    fn cylinder(radius in radius(), (x, y) in place()) {
        check(&Cylinder::new(radius).unwrap(), x, y, STEP, 5.0);
    }

    #[test]
    fn acylinder(section in base(), a4 in coefficient(4), a8 in coefficient(8), (x, y) in place()) {
        let shape = Cylinder::acylinder(section, &[(8, a8), (2, 0.0), (4, a4)]).unwrap();
        check(&shape, x, y, STEP, 5.0);
    }

    #[test]
    fn even_asphere(
        base in base(),
        a2 in coefficient(2),
        a4 in coefficient(4),
        a10 in coefficient(10),
        (x, y) in place(),
    ) {
        let shape = EvenAsphere::new(base, &[(2, a2), (4, a4), (6, 0.0), (10, a10)]).unwrap();
        check(&shape, x, y, STEP, 5.0);
    }

    #[test]
    fn odd_asphere(
        base in base(),
        a2 in coefficient(2),
        a3 in coefficient(3),
        a5 in coefficient(5),
        a8 in coefficient(8),
        (x, y) in (0.5..3.5, -3.5..3.5),
    ) {
        let terms = [(1, 0.01), (2, a2), (3, a3), (5, a5), (8, a8)];
        check(&OddAsphere::new(base, &terms).unwrap(), x, y, STEP, 5.0);
    }

    #[test]
    fn odd_asphere_of_even_orders_is_even(
        base in base(),
        a2 in coefficient(2),
        a4 in coefficient(4),
        (x, y) in place(),
    ) {
        let odd = OddAsphere::new(base, &[(2, a2), (4, a4)]).unwrap();
        let even = EvenAsphere::new(base, &[(2, a2), (4, a4)]).unwrap();
        check(&odd, x, y, STEP, 5.0);
        let [odd, even] = [odd.jet(x, y).unwrap(), even.jet(x, y).unwrap()];
        prop_assert!((odd.z_mm - even.z_mm).abs() <= 1e-14);
        for (a, b) in odd.hessian_per_mm.iter().zip(even.hessian_per_mm) {
            prop_assert!((a - b).abs() <= 1e-14);
        }
    }

    #[test]
    fn biconic(sx in base(), sy in base(), (x, y) in place()) {
        check(&Biconic::new(sx, sy), x, y, STEP, 5.0);
    }

    #[test]
    fn toroid(
        rotation in radius(),
        section in base(),
        a2 in coefficient(2),
        a4 in coefficient(4),
        (x, y) in place(),
    ) {
        let shape = Toroid::new(rotation, section, &[(2, a2), (4, a4)]).unwrap();
        check(&shape, x, y, STEP, 5.0);
    }

    #[test]
    fn unrotated_toroid(section in section(), a4 in coefficient(4), (x, y) in place()) {
        check(&Toroid::unrotated(section, &[(4, a4)]).unwrap(), x, y, STEP, 5.0);
    }

    #[test]
    fn q_bfs(
        base in base(),
        projection in prop_oneof![
            Just(Projection::Axis), Just(Projection::SphereNormal), Just(Projection::ConicNormal)
        ],
        a in prop::collection::vec(-0.05..0.05, 1..8),
        (x, y) in place(),
    ) {
        let shape = QAsphere::bfs(base, 6.5, projection, &a).unwrap();
        check(&shape, x, y, STEP, 5.0);
    }

    #[test]
    fn q_con(base in base(), a in prop::collection::vec(-0.05..0.05, 1..8), (x, y) in place()) {
        check(&QAsphere::con(base, 6.5, &a).unwrap(), x, y, STEP, 5.0);
    }

    #[test]
    fn mirror(
        p in prop_oneof![2 => 20.0..30_000.0, 1 => -2000.0..-300.0, 1 => Just(f64::INFINITY)],
        q in prop_oneof![2 => 20.0..200.0, 1 => -250.0..-60.0],
        theta in prop_oneof![0.002..0.05, 0.05..1.5],
        revolved: bool,
        (x, y) in (-0.5..0.5, -0.3..0.3),
    ) {
        let make = if revolved { Mirror::revolved } else { Mirror::cylindrical };
        let shape = make(p, q, theta).unwrap();
        let scale = shape.domain_mm().min(f64::abs(q));
        let (x, y, step) = (x * scale, y * scale, 0.01 * scale);
        // Its heights are good to their own rounding, not to that of p or q.
        let [far_x, far_y] = [x, y].map(|place: f64| place + 2.0 * step * place.signum());
        check(&shape, x, y, step, shape.sag_mm(far_x, far_y).unwrap().abs());
    }

    #[test]
    fn sum(section in section(), other in section(), a4 in coefficient(4), (x, y) in place()) {
        let parts: Vec<Arc<dyn Shape>> = vec![
            Arc::new(Conic::new(section)),
            Arc::new(Cylinder::acylinder(other, &[(4, a4)]).unwrap()),
        ];
        check(&Sum::new(parts).unwrap(), x, y, STEP, 5.0);
    }

    #[test]
    fn off_axis(
        radius in radius(),
        conic in -3.0..0.2,
        a4 in coefficient(4),
        (dx, dy) in (-3.0..3.0, -3.0..3.0),
        tilted: bool,
        (x, y) in (-1.5..1.5, -1.5..1.5),
    ) {
        let section = ConicSection::new(radius * 2.0, conic).unwrap();
        let parent = Arc::new(EvenAsphere::new(section, &[(4, a4)]).unwrap());
        let make = if tilted { OffAxis::tilted } else { OffAxis::parallel };
        check(&make(parent, dx, dy).unwrap(), x, y, STEP, 5.0);
    }
}
