//! Heights where formulas lose digits or end: small curvatures, the vertex, the end of the domain.

use std::f64::consts::PI;
use std::sync::Arc;

use asphera_form::shape::{
    Biconic, Conic, ConicSection, Cylinder, EvenAsphere, Jet, Mirror, OddAsphere, Projection,
    QAsphere, Shape, Sum, Toroid,
};

use crate::common::close;

fn section(radius: f64, conic: f64) -> ConicSection {
    ConicSection::new(radius, conic).unwrap()
}

fn hold(shape: &dyn Shape, x: f64, y: f64, z: f64, tolerance: f64) {
    for ours in [shape.sag_mm(x, y).unwrap(), shape.jet(x, y).unwrap().z_mm] {
        assert!(close(ours, z, tolerance), "{shape:?} at ({x}, {y}): {ours}, not {z}");
    }
}

/// (R, κ, r, z): the sag formula in 60 decimal digits (Python's `decimal`).
#[test]
fn conics_in_sixty_digits() {
    let rows = [
        (1e12, 0.0, 3.0, 4.5e-12),
        (-1e9, -2.5, 7.0, -2.45e-8),
        (11.65, -1.1, 0.001, 4.2918454927716766e-8),
        (50.0, 0.5, 40.8, 32.170960281722486),
        (-50.0, -1.0, 1000.0, -1e4),
    ];
    for (radius, conic, r, z) in rows {
        let section = section(radius, conic);
        hold(&Conic::new(section), 0.6 * r, 0.8 * r, z, 2e-14);
        hold(&Cylinder::acylinder(section, &[]).unwrap(), r, 1e9, z, 2e-14);
        hold(&EvenAsphere::new(section, &[(4, 0.0)]).unwrap(), r, 0.0, z, 2e-14);
        hold(&OddAsphere::new(section, &[(3, 0.0)]).unwrap(), 0.0, -r, z, 2e-14);
        hold(&QAsphere::con(section, 2e3, &[0.0]).unwrap(), -r, 0.0, z, 2e-14);
    }
    // A micrometre inside the equator, where an ulp of r moves the height by 160 of its own.
    hold(&Conic::sphere(50.0).unwrap(), 49.999, 0.0, 49.683773815125946, 1e-13);
}

/// The formulas of the biconic and the toroid, in 60 decimal digits (Python's `decimal`).
#[test]
fn biconics_and_toroids_in_sixty_digits() {
    let biconic = |x, y| Biconic::new(x, y);
    hold(&biconic(section(1e10, 0.0), section(-1e10, 0.0)), 3.0, 3.0001, -3.00005e-14, 1e-11);
    hold(&biconic(section(20.0, -0.3), section(-35.0, 1.7)), 8.0, 5.0, 1.2996298932378763, 1e-15);
    hold(
        &biconic(section(100.0, -1.0), section(50.0, -4.0)),
        30.0,
        -20.0,
        7.669567922945723,
        1e-15,
    );
    let toroid =
        |rotation, section, terms: &[(u8, f64)]| Toroid::new(rotation, section, terms).unwrap();
    hold(&toroid(1e9, section(-1e8, 0.0), &[]), 2.0, 5.0, -1.2300000000000008e-7, 1e-15);
    let second = toroid(100.0, section(50.0, -0.5), &[(2, 1e-5)]);
    hold(&second, 10.0, -7.0, 0.995442116928827, 1e-15);
    let third = toroid(-30.0, section(25.0, -3.0), &[(2, 1e-4), (4, -2e-6)]);
    hold(&third, 11.0, 6.0, -1.3368677502748767, 1e-15);
}

/// The figure of every shape at the vertex: no height, no slope, the curvatures of its definition.
#[test]
fn vertices() {
    let base = section(-40.0, -0.3);
    let q = [0.02, -0.01, 0.003];
    let shapes: Vec<(Arc<dyn Shape>, [f64; 3])> = vec![
        (Arc::new(Conic::plane()), [0.0; 3]),
        (Arc::new(Conic::new(base)), [-0.025, 0.0, -0.025]),
        (Arc::new(Cylinder::new(40.0).unwrap()), [0.025, 0.0, 0.0]),
        (Arc::new(EvenAsphere::new(base, &[(2, 0.5), (4, 1.0)]).unwrap()), [0.975, 0.0, 0.975]),
        (Arc::new(OddAsphere::new(base, &[(3, 0.5), (2, 0.5)]).unwrap()), [0.975, 0.0, 0.975]),
        (Arc::new(Biconic::new(base, section(10.0, 2.0))), [-0.025, 0.0, 0.1]),
        (Arc::new(Toroid::new(10.0, base, &[(2, 0.5)]).unwrap()), [0.1, 0.0, 0.975]),
        // z″ = 2·ΣQ_m(0)/ρmax² with Q_0, Q_1, Q_2 at 0 from their closed forms.
        (Arc::new(QAsphere::bfs(ConicSection::FLAT, 2.0, Projection::Axis, &q).unwrap()), {
            let [q1, q2] = [13.0 / 19_f64.sqrt(), 29.0 * (2.0 / 95.0_f64).sqrt()];
            let bend = 2.0 * (q[0] + q[1] * q1 + q[2] * q2) / 4.0;
            [bend, 0.0, bend]
        }),
        (Arc::new(QAsphere::con(base, 2.0, &q).unwrap()), [-0.025, 0.0, -0.025]),
        // Coddington: 2/(R·sin θ) = 1/p + 1/q along, 2·sin θ/ρ = 1/p + 1/q across.
        (
            Arc::new(Mirror::revolved(300.0, 150.0, PI / 6.0).unwrap()),
            [0.5 * 0.5 * 0.01, 0.0, 0.01],
        ),
    ];
    for (shape, hessian) in shapes {
        let jet = shape.jet(0.0, 0.0).unwrap();
        assert_eq!(jet.z_mm, 0.0, "{shape:?}");
        assert_eq!(jet.gradient, [0.0, 0.0], "{shape:?}");
        for (ours, expected) in jet.hessian_per_mm.iter().zip(hessian) {
            assert!((ours - expected).abs() < 1e-15, "{shape:?}: {ours}, not {expected}");
        }
    }
}

/// Within the domain every place has a height; a little beyond, some place has none.
#[test]
fn domains_end_where_heights_do() {
    let base = section(-40.0, 1.25);
    let tight = 1e-9;
    let shapes: Vec<(Arc<dyn Shape>, f64)> = vec![
        (Arc::new(Conic::new(base)), tight),
        (Arc::new(Conic::sphere(7.0).unwrap()), tight),
        (Arc::new(Cylinder::new(-7.0).unwrap()), tight),
        (Arc::new(EvenAsphere::new(base, &[(4, 1e-6)]).unwrap()), tight),
        (Arc::new(OddAsphere::new(base, &[(3, 1e-6)]).unwrap()), tight),
        (Arc::new(Biconic::new(base, section(30.0, 0.3))), tight),
        (Arc::new(Biconic::new(section(3.0, -1.0), section(30.0, 0.3))), tight),
        (Arc::new(QAsphere::con(base, 12.0, &[0.1]).unwrap()), tight),
        (Arc::new(QAsphere::bfs(base, 90.0, Projection::SphereNormal, &[0.1]).unwrap()), tight),
        (Arc::new(Mirror::cylindrical(300.0, 100.0, 0.1).unwrap()), tight),
        (Arc::new(Mirror::cylindrical(300.0, -100.0, 0.1).unwrap()), tight),
        (Arc::new(Mirror::cylindrical(f64::INFINITY, 100.0, 1.2).unwrap()), tight),
        (Arc::new(Mirror::revolved(300.0, 100.0, 0.1).unwrap()), 1e-4),
        (Arc::new(Mirror::revolved(300.0, 100.0, 1.5).unwrap()), 1e-4),
        (Arc::new(Mirror::revolved(-300.0, 100.0, 0.4).unwrap()), 1e-4),
        (Arc::new(Mirror::revolved(400.0, -300.0, 0.02).unwrap()), 1e-4),
        (Arc::new(Mirror::revolved(f64::INFINITY, 100.0, 0.3).unwrap()), 1e-4),
        (Arc::new(Mirror::revolved(f64::INFINITY, 100.0, 1.2).unwrap()), 1e-4),
        // Of the toroid it is a lower bound.
        (Arc::new(Toroid::new(50.0, section(50.0, 0.0), &[]).unwrap()), 0.05),
        (Arc::new(Toroid::new(-50.0, section(-20.0, -3.0), &[(4, -1e-5)]).unwrap()), 0.05),
        (Arc::new(Toroid::new(50.0, section(-20.0, 0.0), &[]).unwrap()), 0.05),
        (Arc::new(Toroid::new(50.0, section(10.0, -1.0), &[]).unwrap()), 0.05),
        (Arc::new(Toroid::new(-50.0, ConicSection::FLAT, &[(2, -0.05)]).unwrap()), 0.05),
        (Arc::new(Toroid::new(50.0, ConicSection::FLAT, &[(4, 1e-6)]).unwrap()), 0.05),
        (Arc::new(Toroid::unrotated(section(-20.0, 0.0), &[]).unwrap()), tight),
    ];
    let directions = 720;
    let on_rim = |shape: &dyn Shape, r: f64| -> Vec<Option<Jet>> {
        let jet = |i: i32| {
            let (sin, cos) = (2.0 * PI * f64::from(i) / f64::from(directions)).sin_cos();
            let (jet, sag) = (shape.jet(r * cos, r * sin), shape.sag_mm(r * cos, r * sin));
            assert_eq!(jet.is_some(), sag.is_some(), "{shape:?}");
            jet
        };
        (0..directions).map(jet).collect()
    };
    for (shape, slack) in shapes {
        let domain = shape.domain_mm();
        assert!(domain.is_finite(), "{shape:?}");
        for share in [0.1, 0.5, 0.9, 0.999, 1.0 - 1e-9] {
            let jets = on_rim(shape.as_ref(), share * domain);
            assert!(jets.iter().all(Option::is_some), "{shape:?} inside {domain}");
        }
        let beyond = on_rim(shape.as_ref(), (1.0 + slack) * domain);
        assert!(beyond.iter().any(Option::is_none), "{shape:?} beyond {domain}");
    }
}

#[test]
fn domains_without_end() {
    let saddle = Arc::new(Biconic::new(section(9.0, -1.0), section(-9.0, -2.0)));
    let hyperbolic = Arc::new(Mirror::revolved(400.0, -150.0, 1.4).unwrap());
    let sheet = Arc::new(Cylinder::acylinder(ConicSection::FLAT, &[(4, 1e-6)]).unwrap());
    let parts: Vec<Arc<dyn Shape>> = vec![saddle.clone(), sheet.clone()];
    let sum = Arc::new(Sum::new(parts).unwrap());
    let shapes: [Arc<dyn Shape>; 5] = [Arc::new(Conic::plane()), saddle, hyperbolic, sheet, sum];
    for shape in shapes {
        assert_eq!(shape.domain_mm(), f64::INFINITY, "{shape:?}");
        for (x, y) in [(1e4, 0.0), (0.0, 1e4), (-1e4, -3e3), (2e3, -1e4)] {
            assert!(shape.jet(x, y).is_some(), "{shape:?} at ({x}, {y})");
        }
    }
}
