//! Heights that others computed: Zemax and Optiland tables, vendors' prescriptions.

use std::sync::Arc;

use asphera_form::shape::{
    Biconic, Conic, ConicSection, Cylinder, EvenAsphere, OddAsphere, Projection, QAsphere, Shape,
    Sum, Toroid,
};

use crate::common::close;

fn section(radius: f64, conic: f64) -> ConicSection {
    ConicSection::new(radius, conic).unwrap()
}

/// Holds heights against a table of (x, y, z) to a relative tolerance.
fn table(shape: &dyn Shape, tolerance: f64, places: &[(f64, f64, f64)]) {
    for &(x, y, z) in places {
        let ours = shape.sag_mm(x, y).unwrap();
        assert!(close(ours, z, tolerance), "{} at ({x}, {y}): {ours}, not {z}", shape.kind());
    }
}

/// Optiland's test_even_asphere.py and test_odd_asphere.py: R = 27, κ = 0.
#[test]
fn aspheres_of_optiland() {
    let even = EvenAsphere::new(section(27.0, 0.0), &[(2, 1e-3), (4, -1e-5)]).unwrap();
    table(
        &even,
        1e-14,
        &[
            (0.0, 0.0, 0.0),
            (1.0, 1.0, 0.039022474574473776),
            (-2.0, 3.0, 0.25313367948069593),
            (3.0, -7.0, 1.1206923060227627),
            (8.0, 2.1, 1.3196652673420655),
        ],
    );
    let odd = OddAsphere::new(section(27.0, 0.0), &[(1, 1e-3), (2, -1e-5)]).unwrap();
    table(&odd, 1e-14, &[(1.0, 1.0, 0.03845668813684687), (-2.0, 3.0, 0.24529923075615997)]);
    table(&odd, 1e-8, &[(3.0, -7.0, 1.10336808), (8.0, 2.1, 1.30564148)]);
}

/// Optiland's test_toroidal.py; the table with eight digits there comes from Zemax.
#[test]
fn toroid_of_zemax() {
    let toroid = Toroid::new(100.0, section(50.0, -0.5), &[(2, 1e-5)]).unwrap();
    let rows = [
        (2.5, 0.0, 3.12548843e-02),
        (0.0, 2.5, 6.25820434e-02),
        (-2.5, 0.0, 3.12548843e-02),
        (5.0, 2.5, 1.87738689e-01),
        (-5.0, -2.5, 1.87738689e-01),
        (2.5, -2.5, 9.38565061e-02),
        (-2.5, 2.5, 9.38565061e-02),
    ];
    table(&toroid, 3e-8, &rows);
    // What the same file gives elsewhere is good to six digits.
    let rows = [(0.0, 10.0, 1.00605051), (10.0, 0.0, 0.50125628), (0.0, 5.0, 0.25056330)];
    table(&toroid, 1e-6, &rows);
    let along_x = Toroid::unrotated(section(-50.0, 0.0), &[]).unwrap();
    table(&along_x, 1e-6, &[(0.0, 5.0, -0.25062818), (10.0, 5.0, -0.25062818)]);
    let along_y = Cylinder::new(100.0).unwrap();
    table(&along_y, 1e-6, &[(5.0, 0.0, 0.12507822), (5.0, 10.0, 0.12507822)]);
}

/// Optiland's test_biconic.py, whose biconic is the sum of two acylinders, good to six digits.
#[test]
fn separable_biconic_of_optiland() {
    let sum = |x: (f64, f64), y: (f64, f64)| {
        let x = Cylinder::acylinder(section(x.0, x.1), &[]).unwrap();
        let y = Toroid::unrotated(section(y.0, y.1), &[]).unwrap();
        Sum::new(vec![Arc::new(x), Arc::new(y)]).unwrap()
    };
    let spheres = sum((10.0, 0.0), (20.0, 0.0));
    let rows = [(1.0, 1.0, 0.07514126037252641), (2.0, 1.0, 0.2270567219061282)];
    table(&spheres, 1e-6, &rows);
    table(&sum((10.0, -1.0), (20.0, 0.5)), 1e-6, &[(1.0, 1.0, 0.05 + 0.02502345130203264)]);
}

/// On the axes the biconic is that sum; both radii equal, it is the conic; one flat, an acylinder.
#[test]
fn biconic_at_its_limits() {
    let biconic = Biconic::new(section(10.0, -0.7), section(20.0, 0.5));
    let [x, y] = [section(10.0, -0.7), section(20.0, 0.5)].map(Conic::new);
    for s in [-4.0, 0.0, 1e-5, 3.0, 8.0] {
        assert!(close(biconic.sag_mm(s, 0.0).unwrap(), x.sag_mm(s, 0.0).unwrap(), 1e-15));
        assert!(close(biconic.sag_mm(0.0, s).unwrap(), y.sag_mm(s, 0.0).unwrap(), 1e-15));
    }
    let round = Biconic::new(section(-30.0, -2.0), section(-30.0, -2.0));
    let conic = Conic::new(section(-30.0, -2.0));
    let ours = round.jet(5.0, -7.0).unwrap();
    let theirs = conic.jet(5.0, -7.0).unwrap();
    assert!(close(ours.z_mm, theirs.z_mm, 1e-14));
    for (a, b) in ours.hessian_per_mm.iter().zip(theirs.hessian_per_mm) {
        assert!(close(*a, b, 1e-13), "{a} {b}");
    }
    let flat_in_y = Biconic::new(section(10.0, 0.0), ConicSection::FLAT);
    table(&flat_in_y, 1e-6, &[(1.0, 10.0, 0.05012562854249503), (1.0, -5.0, 0.05012562854249503)]);
    let flat_in_x = Biconic::new(ConicSection::FLAT, section(20.0, 0.0));
    table(&flat_in_x, 1e-6, &[(10.0, 1.0, 0.02501563183003138)]);
}

/// Thorlabs AL1815-C from the vendor's Zemax file, heights from the formula in double precision.
#[test]
fn thorlabs_al1815() {
    let terms = [
        (4, 3.69067205091e-5),
        (6, -1.285461192617e-8),
        (8, -1.400167659754e-10),
        (10, -2.51311664812e-13),
        (12, 5.01789877647e-16),
        (14, 5.855871513042e-18),
        (16, -1.127794407419e-20),
    ];
    let shape = EvenAsphere::new(section(11.65, -1.1), &terms).unwrap();
    let rows =
        [(3.0, 0.0, 0.38860699918513), (0.0, 6.0, 1.58193496464626), (-9.0, 0.0, 3.65468364040223)];
    table(&shape, 1e-13, &rows);
}

/// Thorlabs ASL5040-UV from the vendor's Zemax file: the base from the formula in double precision; the
/// whole from Forbes' recurrence for Q^bfs in 50 decimal digits (Python's `decimal`).
#[test]
fn thorlabs_asl5040() {
    let conic = -0.676_091_206_404_079_3;
    let base = Conic::new(section(1.0 / 0.05756078762782423, conic));
    let rows = [
        (5.0, 0.0, 0.72440175535287),
        (10.0, 0.0, 2.95970043589438),
        (0.0, 15.0, 6.92229205986660),
        (-20.0, 0.0, 13.11580728984559),
        (0.0, -22.86, 18.09109600236299),
    ];
    table(&base, 1e-13, &rows);
    let a = [-0.8148370167576, -0.32311, 0.10591, -0.05058, 0.00987, -0.0022];
    let whole = |p| QAsphere::bfs(section(17.3729, conic), 27.0, p, &a).unwrap();
    let conic_normal = [
        (5.0, 0.0, 0.6712211283973181),
        (0.0, -10.0, 2.758209000243775),
        (15.0, 0.0, 6.5215770704627625),
        (0.0, 17.0, 8.615439751359991),
        (22.86, 0.0, 17.63559169174206),
    ];
    table(&whole(Projection::ConicNormal), 1e-14, &conic_normal);
    let axis = [(5.0, 0.0, 0.6733494918148435), (22.86, 0.0, 17.886240178147947)];
    table(&whole(Projection::Axis), 1e-14, &axis);
    let sphere = whole(Projection::SphereNormal);
    table(&sphere, 1e-13, &[(5.0, 0.0, 0.6710939246732704), (17.0, 0.0, 7.605407173023508)]);
    // The part is larger than the sphere: that projection has no value at its rim, so it cannot be the
    // one its designers' program takes.
    assert_eq!(sphere.sag_mm(22.86, 0.0), None);
    assert_eq!(sphere.domain_mm(), 17.3729);
}

/// Optiland's test_forbes_qbfs.py: Zemax' heights, cut after three digits.
#[test]
fn q_bfs_of_zemax() {
    let a = [1.614, 0.348, 0.150, 0.033, 0.030];
    let rows = [(0.75, 6.26e-2), (1.0, 1.08e-1), (1.25, 1.64e-1), (1.86, 3.30e-1)];
    let cut_equal = |projection| {
        let shape = QAsphere::bfs(section(21.723, -4.428), 6.336, projection, &a).unwrap();
        rows.iter().all(|&(y, z)| {
            let unit = if z < 0.1 { 1e-4 } else { 1e-3 };
            let ours = shape.sag_mm(0.0, y).unwrap();
            z <= ours && ours < z + unit
        })
    };
    assert!(cut_equal(Projection::ConicNormal));
    assert!(!cut_equal(Projection::Axis), "the table tells the projections apart");
}
