//! Contacts of a ball: closed forms, an independent root finder, laws and degenerate places.

use std::sync::Arc;

use asphera_form::shape::Cylinder;
use asphera_form::{Asphere, Nominal, PointMm, Pose, Touch, Untouched, deviations};
use proptest::prelude::*;

const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn off_mm(a: PointMm, b: PointMm) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

fn sphere(radius_mm: f64) -> Nominal {
    Nominal::Sphere { radius_mm }
}

/// Centres of balls on a sphere lie on one whose radius is larger by that of the ball, of a bowl smaller.
#[test]
fn centres_over_a_sphere_lie_on_a_sphere() {
    for (radius_mm, ball_mm) in [(30.0, 1.0), (-30.0, 1.0), (-2.0, 2.5), (5.0, 4.9)] {
        let nominal = sphere(radius_mm);
        let touch = Touch::new(&nominal, &Pose::default(), ball_mm, UP);
        for (x, y) in [(0.0, 0.0), (0.3, -0.4), (1.1, 0.9)] {
            let from_centre: [f64; 3] =
                [x, y, -radius_mm.signum() * (radius_mm * radius_mm - x * x - y * y).sqrt()];
            let place = [x, y, radius_mm + from_centre[2]];
            let times = 1.0 - ball_mm / radius_mm;
            let [cx, cy, cz] = from_centre.map(|along| along * times);
            let found = touch.contact([cx, cy, radius_mm + cz], place).unwrap();
            assert!(off_mm(found.at_mm, place) < 1e-14 * 40.0, "{found:?} {place:?}");
            // Where both curvatures agree, the root of a rounding error is in them.
            assert!((found.hollow_per_mm - 1.0 / radius_mm).abs() < 1e-7 / radius_mm.abs());
        }
    }
}

/// A plane tilted by rx gives z + r/cos rx.
#[test]
fn a_tilted_plane_is_lower_by_the_secant() {
    let pose = Pose { rx_rad: 0.6, tz_mm: 2.0, ..Pose::default() };
    let touch = Touch::new(&Nominal::Plane, &pose, 0.25, UP);
    for (x, y) in [(0.0, 0.0), (4.0, -7.0)] {
        let z = 2.0 + y * 0.6_f64.tan() + 0.25 / 0.6_f64.cos();
        let found = touch.contact([x, y, z], [x, y, z]).unwrap();
        let expected = [x, y + 0.25 * 0.6_f64.sin(), z - 0.25 * 0.6_f64.cos()];
        assert!(off_mm(found.at_mm, expected) < 1e-14, "{found:?}");
        assert_eq!(found.hollow_per_mm, 0.0);
        assert!(
            off_mm(
                touch.contact_at_any_height([x, y, z + 9.0]),
                [x, expected[1], expected[2] + 9.0]
            ) < 1e-13
        );
    }
}

/// The offset curve of a parabola z = a·x², in closed form: (x − 2·a·x·r/w, a·x² + r/w), w = √(1 + 4·a²·x²).
#[test]
fn centres_over_a_parabola_are_its_offset_curve() {
    let (a, ball_mm) = (0.05, 1.5);
    let nominal = Nominal::Asphere(Asphere::new(0.5 / a, -1.0, &[]).unwrap());
    let touch = Touch::new(&nominal, &Pose::default(), ball_mm, UP);
    for x in [0.0_f64, 0.5, 3.0, 8.0] {
        let w = (1.0 + 4.0 * a * a * x * x).sqrt();
        let centre = [x - 2.0 * a * x * ball_mm / w, 0.0, a * x * x + ball_mm / w];
        let place = [x, 0.0, a * x * x];
        assert!(off_mm(touch.contact(centre, centre).unwrap().at_mm, place) < 1e-14);
        assert!(off_mm(touch.contact_at_any_height(centre), place) < 1e-11);
    }
}

/// Radius of the ball, distance and height of its centre, distance and height of the contact, mm, on the asphere R = 20,
/// κ = −0.7, A4 = 1e-5, A6 = −2e-8. Found by scipy 1.17.1, `optimize.brentq(f, -1, 20, xtol=1e-15, rtol=1e-15)` with
/// `f = lambda s: s - r*dz(s)/sqrt(1 + dz(s)**2) - rho`, dz the derivative of the sag.
const BY_SCIPY: [[f64; 5]; 8] = [
    [0.5, 0.75, 0.5144280787767191, 0.7692298646030108, 0.014798003313532197],
    [0.5, 2.5, 0.6608690810336936, 2.5640582893155717, 0.16498952350993107],
    [0.5, 5.0, 1.1505732622724871, 5.127587779251509, 0.6671258932800928],
    [0.5, 9.0, 2.669203551322222, 9.22361195478266, 2.2219925343757723],
    [2.0, 0.75, 2.0156313228135376, 0.8333283214234205, 0.017367979095109044],
    [2.0, 2.5, 2.1743832691549416, 2.7775228253694104, 0.19373158816734806],
    [2.0, 5.0, 2.7063548565522866, 5.551851167027385, 0.7839968541368902],
    [2.0, 9.0, 4.361393805229235, 9.95739545263639, 2.605434253510812],
];

#[test]
fn contacts_on_an_asphere_are_those_of_a_root_finder() {
    let powers = [(4, 1e-5), (6, -2e-8)];
    let nominal = Nominal::Asphere(Asphere::new(20.0, -0.7, &powers).unwrap());
    for [ball_mm, rho, height, s, sag] in BY_SCIPY {
        let touch = Touch::new(&nominal, &Pose::default(), ball_mm, UP);
        // In the direction (3, 4)/5.
        let centre = [0.6 * rho, 0.8 * rho, height];
        let found = touch.contact(centre, centre).unwrap();
        assert!(off_mm(found.at_mm, [0.6 * s, 0.8 * s, sag]) < 2e-14 * 20.0, "{found:?} {s} {sag}");
    }
}

/// A profile over a sphere beside its crest: the contact leaves the line, and comes back to it with its deviation.
#[test]
fn a_contact_of_a_profile_stays_on_its_line() {
    let nominal = sphere(-10.0);
    let touch = Touch::new(&nominal, &Pose::default(), 0.5, UP);
    // Centres at 10.5 mm + 3 µm from the centre of the sphere, along y = 1.
    for x in [-3.0_f64, 0.0, 2.0] {
        let z = -10.0 + (10.503_f64.powi(2) - x * x - 1.0).sqrt();
        let found = touch.contact_in_plane([x, 1.0, z], [x, 1.0, z], [0.0, 1.0, 0.0]).unwrap();
        assert_eq!(found.at_mm[1], 1.0);
        let deviation = deviations(&[found.at_mm], &nominal, &Pose::default())[0];
        assert!((deviation - 0.003).abs() < 1e-12, "{deviation}");
    }
}

#[test]
fn a_ball_that_cannot_touch_says_why() {
    let bowl = sphere(2.0);
    let touch = |ball_mm| Touch::new(&bowl, &Pose::default(), ball_mm, UP);
    assert_eq!(touch(2.5).contact([0.0, 0.0, 2.2], [0.0; 3]), Err(Untouched::TooHollow));
    assert_eq!(touch(2.0).contact([0.0, 0.0, 1.9], [0.0; 3]), Err(Untouched::TooHollow));
    assert_eq!(touch(0.1).contact([3.0, 0.0, 5.0], [3.0, 0.0, 5.0]), Err(Untouched::BeyondNominal));
    assert_eq!(touch(0.1).contact([f64::NAN; 3], [f64::NAN; 3]), Err(Untouched::BeyondNominal));
    let wall = Pose { ry_rad: std::f64::consts::FRAC_PI_2, ..Pose::default() };
    let touch = Touch::new(&Nominal::Plane, &wall, 0.1, UP);
    assert_eq!(touch.contact([0.1, 0.0, 0.0], [0.0; 3]), Err(Untouched::Upright));
    // A part that lies face down is touched on its −z side.
    let turned = Pose { rx_rad: std::f64::consts::PI, ..Pose::default() };
    let found = Touch::new(&bowl, &turned, 0.5, UP).contact([0.0, 0.0, 0.5], [0.0; 3]).unwrap();
    assert!(off_mm(found.at_mm, [0.0; 3]) < 1e-15 && (found.hollow_per_mm + 0.5).abs() < 1e-15);
}

proptest! {
    /// The contact is the place that the centre was made from, on any shape, side and pose, and scales with the part.
    #[test]
    fn centres_lead_back_to_their_places(
        turn in prop::array::uniform3(-0.5..0.5_f64), shift in prop::array::uniform3(-50.0..50.0_f64),
        place in prop::array::uniform2(-4.0..4.0_f64), ball_mm in 0.0..3.0_f64, scale in 0.1..10.0_f64,
    ) {
        let cylinder = |scale: f64| Nominal::Freeform(Arc::new(Cylinder::new(-12.0 * scale).unwrap()));
        let asphere = |scale: f64| Nominal::Asphere(Asphere::new(15.0 * scale, -1.5, &[]).unwrap());
        let [rx_rad, ry_rad, rz_rad] = turn;
        let made = |nominal: Nominal, scale: f64| {
            let [tx_mm, ty_mm, tz_mm] = shift.map(|along| scale * along);
            let pose = Pose { tx_mm, ty_mm, tz_mm, rx_rad, ry_rad, rz_rad };
            let [x, y] = place.map(|along| scale * along);
            let jet = nominal.jet(x, y).unwrap();
            let [p, q] = jet.gradient;
            let stretch = (1.0 + p * p + q * q).sqrt();
            let centre = [
                x - scale * ball_mm * p / stretch,
                y - scale * ball_mm * q / stretch,
                jet.z_mm + scale * ball_mm / stretch,
            ];
            let touch = Touch::new(&nominal, &pose, scale * ball_mm, UP);
            let centre = pose.to_measured(centre);
            (touch.contact(centre, centre).unwrap(), pose.to_measured([x, y, jet.z_mm]))
        };
        for nominal in [cylinder, asphere] as [fn(f64) -> Nominal; 2] {
            let (found, expected) = made(nominal(1.0), 1.0);
            prop_assert!(off_mm(found.at_mm, expected) < 1e-12, "{found:?} {expected:?}");
            let (scaled, _) = made(nominal(scale), scale);
            let expected = found.at_mm.map(|along| scale * along);
            prop_assert!(off_mm(scaled.at_mm, expected) < 1e-12 * (1.0 + scale));
        }
    }
}
