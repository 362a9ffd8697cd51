//! Mirrors against the property that makes them: light from the source goes to the image.

use asphera_form::shape::{Mirror, Shape};
use proptest::prelude::*;

use crate::common::close;

type Vector = [f64; 3];

fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn times(a: Vector, factor: f64) -> Vector {
    a.map(|component| component * factor)
}

/// Source and image; an infinite distance has none.
fn foci(mirror: &Mirror) -> [Vector; 2] {
    let (sin, cos) = mirror.grazing_rad().sin_cos();
    let [p, q] = [mirror.source_mm(), mirror.image_mm()];
    [[-p * cos, 0.0, p * sin], [q * cos, 0.0, q * sin]]
}

/// Directions of the light that comes in and goes out at a place of the mirror.
fn light(mirror: &Mirror, place: Vector) -> [Vector; 2] {
    let (sin, cos) = mirror.grazing_rad().sin_cos();
    let [source, image] = foci(mirror);
    let unit = |v: Vector, sign: f64| times(v, sign / dot(v, v).sqrt());
    let incoming = if mirror.source_mm().is_finite() {
        unit(minus(place, source), mirror.source_mm().signum())
    } else {
        [cos, 0.0, -sin]
    };
    let outgoing = if mirror.image_mm().is_finite() {
        unit(minus(image, place), mirror.image_mm().signum())
    } else {
        [cos, 0.0, sin]
    };
    [incoming, outgoing]
}

fn distance() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 50.0..30_000.0,
        2 => -30_000.0..-50.0,
        1 => Just(f64::INFINITY),
        1 => Just(f64::NEG_INFINITY),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// A ray from the source, reflected with the normal of the jet, goes to the image.
    #[test]
    fn rays_meet_in_the_image(
        p in distance(),
        q in distance(),
        theta in 0.002..1.57,
        revolved: bool,
        (x, y) in (-0.9..0.9, -0.6..0.6),
    ) {
        prop_assume!(p.is_finite() || q.is_finite());
        prop_assume!((1.0 / p + 1.0 / q).abs() > 1e-6);
        let make = if revolved { Mirror::revolved } else { Mirror::cylindrical };
        let mirror = make(p, q, theta).unwrap();
        let nearest = p.abs().min(q.abs());
        let scale = mirror.domain_mm().min(nearest) * 0.7;
        let (x, y) = (x * scale, if revolved { y * scale } else { 0.0 });
        let jet = mirror.jet(x, y).unwrap();
        let place = [x, y, jet.z_mm];
        let normal = [-jet.gradient[0], -jet.gradient[1], 1.0];
        let normal = times(normal, 1.0 / dot(normal, normal).sqrt());
        let [incoming, outgoing] = light(&mirror, place);
        let reflected = minus(incoming, times(normal, 2.0 * dot(incoming, normal)));
        for (ours, expected) in reflected.iter().zip(outgoing) {
            prop_assert!((ours - expected).abs() < 1e-12, "{reflected:?} {outgoing:?}");
        }
        prop_assert!(dot(incoming, normal) < 0.0, "light comes from the +z side");
    }

    /// Distances to source and image, with their signs, add up to p + q; to a plane wave front and the
    /// image likewise.
    #[test]
    fn path_is_constant(
        p in distance(),
        q in distance(),
        theta in 0.002..1.57,
        (x, y) in (-0.9..0.9, -0.6..0.6),
    ) {
        prop_assume!(p.is_finite() || q.is_finite());
        prop_assume!((1.0 / p + 1.0 / q).abs() > 1e-6);
        let mirror = Mirror::revolved(p, q, theta).unwrap();
        let scale = mirror.domain_mm().min(p.abs().min(q.abs())) * 0.7;
        let (x, y) = (x * scale, y * scale);
        let place = [x, y, mirror.sag_mm(x, y).unwrap()];
        let (sin, cos) = theta.sin_cos();
        let [source, image] = foci(&mirror);
        // Path beyond that at the centre.
        let length = |from: Vector, signed: f64, parallel: f64| {
            if signed.is_infinite() {
                return parallel;
            }
            let way = minus(place, from);
            signed.signum() * dot(way, way).sqrt() - signed
        };
        let before = length(source, p, x * cos - place[2] * sin);
        let after = length(image, q, -x * cos - place[2] * sin);
        let finite = [p, q].into_iter().filter(|distance| distance.is_finite());
        let longest = finite.map(f64::abs).fold(1.0, f64::max);
        prop_assert!((before + after).abs() <= 1e-12 * longest, "{before} {after}");
    }

    /// Source and image exchanged, the mirror is the same seen from the other end.
    #[test]
    fn light_can_go_back(
        p in distance(),
        q in distance(),
        theta in 0.002..1.57,
        revolved: bool,
        (x, y) in (-0.5..0.5_f64, -0.5..0.5_f64),
    ) {
        prop_assume!(p.is_finite() || q.is_finite());
        prop_assume!((1.0 / p + 1.0 / q).abs() > 1e-6);
        let make = if revolved { Mirror::revolved } else { Mirror::cylindrical };
        let (there, back) = (make(p, q, theta).unwrap(), make(q, p, theta).unwrap());
        let scale = there.domain_mm().min(p.abs().min(q.abs()));
        let [a, b] = [there.sag_mm(x * scale, y * scale), back.sag_mm(-x * scale, y * scale)];
        prop_assert!(close(a.unwrap(), b.unwrap(), 1e-12));
    }
}

/// Heights found in 60 decimal digits (Python's `decimal`) by Newton's method on the sum of the distances
/// to the two points: [p, q, θ, x, y], z. A cylinder where y is 0.
#[test]
fn heights_in_sixty_digits() {
    let rows = [
        ([30000.0, 500.0, 0.003, 200.0, 0.0], 0.07719017161311831),
        ([30000.0, 500.0, 0.003, -200.0, 0.0], 0.05134822978051977),
        ([30000.0, 500.0, 0.003, 0.001, 0.0], 1.5249992120772338e-12),
        ([1000.0, 1000.0, 0.02, 50.0, 1.5], 0.08141781610979283),
        ([400.0, -3000.0, 0.01, 60.0, 0.4], 0.02599372343602592),
        ([-400.0, 3000.0, 0.01, 60.0, 0.4], -0.030839194126600612),
        ([-5000.0, 300.0, 0.02, 40.0, -2.0], 0.19719695898435843),
        ([250.0, 100.0, 0.8, 20.0, 15.0], 2.216435160365325),
        ([1e9, 200.0, 0.005, 30.0, 0.1], 0.008804714124941626),
    ];
    for ([p, q, theta, x, y], z) in rows {
        let revolved = Mirror::revolved(p, q, theta).unwrap();
        let ours = revolved.sag_mm(x, y).unwrap();
        assert!(close(ours, z, 5e-15), "{p} {q} {theta} at ({x}, {y}): {ours}, not {z}");
        if y == 0.0 {
            let cylinder = Mirror::cylindrical(p, q, theta).unwrap();
            assert_eq!(cylinder.sag_mm(x, 7.0), Some(ours));
        }
    }
    // The last row's source is so far away that it may be at infinity.
    let parallel = Mirror::revolved(f64::INFINITY, 200.0, 0.005).unwrap();
    assert!(close(parallel.sag_mm(30.0, 0.1).unwrap(), 0.008804714124941626, 2e-6));
}

/// p = q at normal incidence is a sphere about both points; at a grazing angle a cylinder that is an
/// ellipse of half axes p and p·sin θ.
#[test]
fn ellipses_of_one_to_one() {
    let sphere = Mirror::revolved(80.0, 80.0, std::f64::consts::FRAC_PI_2).unwrap();
    let z = 80.0 - (80.0_f64 * 80.0 - 30.0 * 30.0 - 5.0 * 5.0).sqrt();
    assert!(close(sphere.sag_mm(30.0, -5.0).unwrap(), z, 1e-14));
    let mirror = Mirror::cylindrical(1000.0, 1000.0, 0.01).unwrap();
    let half_axis = 1000.0 * 0.01_f64.sin();
    for x in [-999.0, -300.0, 1.0, 600.0] {
        let z = half_axis * (1.0 - (1.0 - (x / 1000.0_f64).powi(2)).sqrt());
        assert!(close(mirror.sag_mm(x, 0.0).unwrap(), z, 1e-10));
    }
}

#[test]
fn figures_have_names() {
    let infinite = f64::INFINITY;
    let kinds = [
        (Mirror::cylindrical(100.0, 50.0, 0.1), "elliptic cylinder", 3),
        (Mirror::cylindrical(100.0, -50.0, 0.1), "hyperbolic cylinder", 3),
        (Mirror::cylindrical(infinite, 50.0, 0.1), "parabolic cylinder", 2),
        (Mirror::revolved(-100.0, -50.0, 0.1), "ellipsoid", 3),
        (Mirror::revolved(-100.0, 50.0, 0.1), "hyperboloid", 3),
        (Mirror::revolved(-50.0, infinite, 0.1), "paraboloid", 2),
    ];
    for (mirror, kind, parameters) in kinds {
        let mirror = mirror.unwrap();
        assert_eq!(mirror.kind(), kind);
        assert_eq!(mirror.parameters().len(), parameters);
    }
    let concave = |p, q| Mirror::cylindrical(p, q, 0.1).unwrap().sag_mm(1.0, 0.0).unwrap() > 0.0;
    assert!(concave(100.0, 50.0) && concave(100.0, -150.0) && concave(infinite, 50.0));
    assert!(!concave(100.0, -50.0) && !concave(-100.0, -50.0) && !concave(infinite, -50.0));
}

/// A hyperbola has a second sheet, which is no part of the mirror.
#[test]
fn only_the_sheet_of_the_mirror() {
    let mirror = Mirror::cylindrical(300.0, -100.0, 0.1).unwrap();
    // The first sheet ends at x = −101 mm; from −297 mm on the equation has roots again.
    assert!(mirror.jet(-100.0, 0.0).is_some());
    for x in [-105.0, -200.0, -290.0, -300.0, -400.0, -4000.0] {
        assert_eq!(mirror.jet(x, 0.0), None, "{x}");
        assert_eq!(mirror.sag_mm(x, 0.0), None, "{x}");
    }
    assert!(mirror.jet(4000.0, 0.0).is_some());
}
