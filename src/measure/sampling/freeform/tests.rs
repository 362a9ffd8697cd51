//! Freeforms whose medial axis is known.

use asphera_form::shape::{
    Biconic, Conic, ConicSection, Cylinder, EvenAsphere, Mirror, OffAxis, Toroid,
};

use super::super::meridian::Meridian;
use super::*;

fn disc(radius_mm: f64) -> Footprint {
    Footprint::of(&Aperture::Circle { radius_mm }, &[], &Pose::default())
}

fn rectangle(width_mm: f64, height_mm: f64) -> Footprint {
    Footprint::of(&Aperture::Rectangle { width_mm, height_mm }, &[], &Pose::default())
}

fn section(radius_mm: f64, conic: f64) -> ConicSection {
    ConicSection::new(radius_mm, conic).unwrap()
}

/// Checks some 1,500 places between nodes against the truth: how far off the median and the farthest may be, as
/// shares.
fn keeps(
    shape: impl Shape + 'static,
    footprint: Footprint,
    [median, most]: [f64; 2],
    truth_mm: impl Fn(f64, f64) -> f64,
) {
    let freeform = Freeform::of(&Nominal::Freeform(Arc::new(shape)), footprint).unwrap();
    let Footprint { low_mm, high_mm, rim_mm } = footprint;
    let mut off = Vec::new();
    for i in 0..2000 {
        // An additive sequence of the plastic number: evenly spread, on no lattice.
        let share = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2]
            .map(|step: f64| (step * f64::from(i)).fract());
        let [x, y] = [0, 1].map(|axis| low_mm[axis] + share[axis] * (high_mm[axis] - low_mm[axis]));
        if x.hypot(y) <= rim_mm {
            let (found_mm, truth_mm) = (freeform.at(x, y).unwrap(), truth_mm(x, y));
            off.push(found_mm / truth_mm - 1.0);
        }
    }
    assert!(off.len() > 1500, "{}", off.len());
    off.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let found = [off[off.len() / 2].abs(), off[off.len() - 1].abs()];
    println!("median {:.2e}, most {:.2e}", found[0], found[1]);
    assert!(found[0] <= median && found[1] <= most, "{found:?}");
}

#[test]
fn a_cylinder_and_a_toroid_have_their_smaller_radius() {
    let bound = [1e-3, 3e-3];
    keeps(Cylinder::new(20.0).unwrap(), rectangle(16.0, 30.0), bound, |_, _| 20.0);
    keeps(Cylinder::new(-300.0).unwrap(), rectangle(20.0, 400.0), bound, |_, _| 300.0);
    // A tube of 20 mm about a circle.
    keeps(Toroid::new(50.0, section(20.0, 0.0), &[]).unwrap(), disc(9.0), bound, |_, _| 20.0);
}

#[test]
fn a_paraboloid_and_an_ellipsoid_after_their_formulas() {
    // The axis begins at the centre of curvature of the vertex.
    let paraboloid = |x: f64, y: f64| {
        let r = x.hypot(y);
        r.hypot((10.0 - r * r / 20.0).max(0.0))
    };
    let conic = || section(10.0, -1.0);
    keeps(Biconic::new(conic(), conic()), disc(12.0), [3e-3, 2e-2], paraboloid);
    keeps(Conic::new(conic()), disc(12.0), [3e-3, 2e-2], paraboloid);
    // Semi-axes of 20 mm and 40 mm; of a cap of 16 mm the axis is a part of that between the foci.
    keeps(Conic::new(section(10.0, -0.75)), disc(16.0), [3e-3, 2e-2], |x, y| {
        let r = x.hypot(y);
        let z = 40.0 - 40.0 * (1.0 - r * r / 400.0).sqrt();
        r.hypot(z - z.clamp(10.0, 22.0))
    });
}

/// The normals of z = (x²/a + y²/b)/2 with a < b meet in pairs at x = 0, in (0, y (1 − a/b), z + a): the axis
/// is the part of that plane over a parabola.
#[test]
fn an_elliptic_paraboloid_after_its_formula() {
    let (a, b) = (20.0, 50.0);
    let shape = Biconic::new(section(a, -1.0), section(b, -1.0));
    keeps(shape, disc(16.0), [3e-3, 2e-2], |x, y| {
        let z = 0.5 * (x * x / a + y * y / b);
        let shrunk = 1.0 - a / b;
        let parabola = |s: f64| a + s * s / (2.0 * b * shrunk * shrunk);
        let nearest = (-12_000..=12_000)
            .map(|i| 1e-3 * f64::from(i))
            .map(|s| (y - s).hypot((parabola(s) - z).max(0.0)))
            .fold(f64::INFINITY, f64::min);
        x.hypot(nearest)
    });
}

#[test]
fn a_freeform_of_revolution_is_as_its_meridian() {
    let shape = Biconic::new(section(30.0, 0.5), section(30.0, 0.5));
    let asphere = Nominal::Asphere(asphera_form::Asphere::new(30.0, 0.5, &[]).unwrap());
    let meridian = Meridian::of(&asphere, 15.0).unwrap();
    keeps(shape, disc(15.0), [3e-3, 2e-2], |x, y| meridian.at(x.hypot(y)).unwrap());
}

/// The normals of a paraboloid z = r²/2R meet its axis at z + R; a piece of it has that part of the axis which its own
/// normals meet.
#[test]
fn a_piece_off_the_axis_is_as_its_parent() {
    let (radius_mm, decentre_mm) = (40.0, 25.0);
    let parent: Arc<dyn Shape> = Arc::new(Conic::new(section(radius_mm, -1.0)));
    let piece = OffAxis::parallel(parent, decentre_mm, 0.0).unwrap();
    let low_mm = radius_mm + 0.5 * (decentre_mm - 10.0_f64).powi(2) / radius_mm;
    keeps(piece, disc(10.0), [3e-3, 2e-2], |x, y| {
        let r = (x + decentre_mm).hypot(y);
        r.hypot((low_mm - 0.5 * r * r / radius_mm).max(0.0))
    });
}

/// The curvature of a hyperbola grows all along this piece: no ball is larger than the radius of curvature at its
/// place, none smaller than the least of all.
#[test]
fn a_grazing_mirror_keeps_between_its_radii_of_curvature() {
    let mirror = Mirror::cylindrical(-306.0, 115.0, 4.6e-3).unwrap();
    let radius_mm = |x: f64| mirror.jet(x, 0.0).unwrap().hessian_per_mm[0].recip().abs();
    let least_mm = radius_mm(-28.5).min(radius_mm(28.5));
    let nominal = Nominal::Freeform(Arc::new(mirror));
    let freeform = Freeform::of(&nominal, rectangle(57.0, 6.6)).unwrap();
    for x in [-28.0, -11.3, 0.0, 17.9, 28.0] {
        let found_mm = freeform.at(x, 2.2).unwrap();
        let within = 0.98 * least_mm..1.02 * radius_mm(x);
        assert!(within.contains(&found_mm), "{found_mm} at {x}, expected {within:?}");
    }
}

#[test]
fn a_plane_has_no_end_and_what_cannot_be_known_is_an_error() {
    let flat = Nominal::Freeform(Arc::new(Conic::new(ConicSection::FLAT)));
    let plane = Freeform::of(&flat, disc(5.0)).unwrap();
    assert_eq!(plane.at(1.234, 0.5), Some(f64::INFINITY));
    assert_eq!((plane.at(f64::NAN, 0.0), plane.at(0.0, f64::NAN)), (None, None));
    let sphere = Nominal::Sphere { radius_mm: 20.0 };
    let rotational = Freeform::of(&sphere, disc(5.0));
    assert_eq!(rotational, Err(FreeformError::Rotational { kind: "sphere" }));
    // A wave of 0.5 mm on a raster of 0.4 mm; points on a line; none.
    let groove = Nominal::Freeform(Arc::new(Cylinder::new(0.2).unwrap()));
    let line = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
    let about = |points: &[PointMm]| Footprint::of(&Aperture::None, points, &Pose::default());
    assert!(Freeform::of(&groove, disc(10.0)).is_err());
    assert!(Freeform::of(&flat, about(&line)).is_err());
    assert!(Freeform::of(&flat, about(&[])).is_err());
}

#[test]
fn the_box_about_points_seldom_changes() {
    let points = |width_mm: f64| [[-1.0, 2.0, 0.0], [width_mm - 1.0, 7.0, 1.0]];
    let of = |width_mm| Footprint::of(&Aperture::None, &points(width_mm), &Pose::default());
    assert_eq!(of(9.1), of(9.9));
    assert_eq!(of(9.1).low_mm, [-2.0, 2.0]);
    assert_eq!(of(9.1).high_mm, [10.0, 7.0]);
    let pose = Pose { tx_mm: 1.0, rz_rad: std::f64::consts::FRAC_PI_2, ..Pose::default() };
    let turned = Footprint::of(&Aperture::None, &points(9.9), &pose);
    assert!(turned.low_mm[1] < -7.7 && turned.high_mm[0] > 6.9 && turned.high_mm[1] < 3.0);
}

/// The least over a disc, and over a ring: of a tube everywhere the same, of a paraboloid at the vertex or at the hole.
#[test]
fn the_least_is_where_the_surface_has_it() {
    let least_mm = |shape: Arc<dyn Shape>, hole_mm| {
        Freeform::of(&Nominal::Freeform(shape), disc(9.0)).unwrap().least_mm(hole_mm)
    };
    let near = |found: f64, expected: f64, share: f64| {
        assert!((found / expected - 1.0).abs() < share, "{found}, not {expected}");
    };
    let tube = Arc::new(Toroid::new(50.0, section(20.0, 0.0), &[]).unwrap());
    near(least_mm(tube.clone(), 0.0), 20.0, 3e-3);
    near(least_mm(tube, 4.0), 20.0, 3e-3);
    let paraboloid = Arc::new(Biconic::new(section(5.0, -1.0), section(5.0, -1.0)));
    near(least_mm(paraboloid.clone(), 0.0), 5.0, 3e-3);
    // Beyond 5 mm from its axis it is as far from its medial axis as from that; corners of cells count with up to one
    // diagonal of 0.8 mm less.
    let found = least_mm(paraboloid, 7.0);
    assert!((6.1..7.03).contains(&found), "{found}");
}

/// 7²⁵⁴ mm high at the corners: balls that touch it were looked for over minutes.
#[test]
fn a_surface_as_high_as_none_is_refused_at_once() {
    let steep = EvenAsphere::new(section(50.0, -1.0), &[(254, 1.0)]).unwrap();
    let nominal = Nominal::Freeform(Arc::new(steep));
    let error = Freeform::of(&nominal, rectangle(10.0, 10.0)).unwrap_err();
    assert!(matches!(error, FreeformError::TooHigh { .. }), "{error}");
    assert!(error.to_string().contains("mm high: correct its coefficients"), "{error}");
    // A base that ends before the border hides nothing.
    let ends = EvenAsphere::new(section(4.5, 0.0), &[(254, 1.0)]).unwrap();
    let error = Freeform::of(&Nominal::Freeform(Arc::new(ends)), rectangle(10.0, 10.0));
    assert!(matches!(error, Err(FreeformError::TooHigh { .. })), "{error:?}");
    // Within 0.9 mm of the vertex the same surface is as flat as its base.
    assert!(Freeform::of(&nominal, disc(0.5)).is_ok());
}
