//! Bases against tables of other programs: `reference.py` makes `reference.txt`.

use asphera_form::basis::{
    Basis, Counting, Normalisation, NormalisedJet, Product, Q2d, Scale, Zernike, zernike_value,
};
use asphera_form::shape::{Series, Shape as _};

/// The numbers of all lines that begin with `name`.
fn lines(name: &str) -> Vec<Vec<f64>> {
    let lines = include_str!("reference.txt").lines().map(|line| line.split(' '));
    let chosen = lines.filter_map(|mut words| (words.next() == Some(name)).then_some(words));
    let found: Vec<Vec<f64>> =
        chosen.map(|words| words.map(|word| word.parse().unwrap()).collect()).collect();
    assert!(!found.is_empty());
    found
}

fn jet(basis: &dyn Basis, u: f64, v: f64) -> NormalisedJet {
    let mut jets = Vec::new();
    basis.each_jet(u, v, &mut |_, jet| jets.push(jet));
    assert_eq!(jets.len(), 1);
    jets[0]
}

fn value(basis: &dyn Basis, u: f64, v: f64) -> f64 {
    let mut values = Vec::new();
    basis.each_value(u, v, &mut |_, value| values.push(value));
    assert_eq!(values.len(), 1);
    values[0]
}

fn near(found: f64, expected: f64, tolerance: f64, what: &[f64]) {
    assert!((found - expected).abs() <= tolerance * (1.0 + expected.abs()), "{what:?}: {found}");
}

/// To order 60, derivatives included, the centre and the rim included. Derivatives of order n grow as n² and
/// n⁴ times the value; their error is held against that.
#[test]
fn zernike_terms_against_rational_arithmetic() {
    for line in lines("exact") {
        let (n, m, u, v) = (line[0] as u32, line[1] as i32, line[2], line[3]);
        let basis = Zernike::of_orders(&[(n, m)], Normalisation::UnitHeight).unwrap();
        let found = jet(&basis, u, v);
        let size = 1.0 + line[0] * line[0];
        near(found.value, line[4], 2e-14, &line);
        near(value(&basis, u, v), line[4], 2e-14, &line);
        near(zernike_value(n, m, Normalisation::UnitHeight, u, v).unwrap(), line[4], 2e-14, &line);
        for k in 0..2 {
            near(found.gradient[k], line[5 + k], 2e-14 * size, &line);
        }
        for k in 0..3 {
            near(found.hessian[k], line[7 + k], 2e-14 * size * size, &line);
        }
    }
}

#[test]
fn zernike_terms_against_prysm_and_poppy() {
    for line in lines("prysm") {
        let (n, m) = (line[0] as u32, line[1] as i32);
        for (normalisation, expected) in
            [(Normalisation::UnitHeight, line[4]), (Normalisation::UnitRms, line[5])]
        {
            let basis = Zernike::of_orders(&[(n, m)], normalisation).unwrap();
            near(value(&basis, line[2], line[3]), expected, 1e-13, &line);
        }
    }
    for line in lines("poppy") {
        let basis = Zernike::of_orders(&[(line[0] as u32, line[1] as i32)], Normalisation::UnitRms)
            .unwrap();
        near(value(&basis, line[2], line[3]), line[4], 1e-12, &line);
    }
}

#[test]
fn q2d_terms_against_prysm() {
    for line in lines("q2d") {
        let (n, m) = (line[0] as u32, line[1] as i32);
        let plane = Q2d::new(&[(n, m)], 0.0).unwrap();
        near(value(&plane, line[2], line[3]), line[4], 1e-12, &line);
        near(jet(&plane, line[2], line[3]).value, line[4], 1e-12, &line);
        // Over a sphere, eq. (2.2): divided by the cosine of its slope.
        let sphere = Q2d::new(&[(n, m)], 0.4).unwrap();
        let cosine = (1.0 - 0.16 * (line[2] * line[2] + line[3] * line[3])).sqrt();
        near(value(&sphere, line[2], line[3]), line[4] / cosine, 1e-12, &line);
    }
}

#[test]
fn products_against_scipy() {
    type Make = fn(&[(u32, u32)]) -> Result<Product, asphera_form::basis::ProductError>;
    let families: [(&str, Make); 3] = [
        ("chebyshev", Product::chebyshev),
        ("legendre", Product::legendre),
        ("powers", Product::powers),
    ];
    for (name, make) in families {
        for line in lines(name) {
            let basis = make(&[(line[0] as u32, line[1] as u32)]).unwrap();
            near(value(&basis, line[2], line[3]), line[4], 2e-14, &line);
            near(jet(&basis, line[2], line[3]).value, line[4], 2e-14, &line);
        }
    }
}

/// The truth of Optiland's `test_geometries.py` for a Chebyshev surface: R = 22 mm, normalised by 10 mm.
#[test]
fn chebyshev_surface_of_optiland() {
    let basis = Product::chebyshev(&Product::tensor_orders(2, 2)).unwrap();
    let coefficients = [0.0, 1e-2, -2e-3, 0.1, 1e-2, -1e-3, 0.2, 1e-2, 0.0];
    let series = Series::new(basis, Scale::round(10.0).unwrap(), &coefficients).unwrap();
    let places =
        [(0.0, 0.0, -0.198), (1.0, 1.0, -0.13832040010014895), (-2.0, -7.0, 1.036336507973306)];
    for (x, y, expected) in places {
        let square: f64 = x * x + y * y;
        let sphere = square / 22.0 / (1.0 + (1.0 - square / 484.0).sqrt());
        let found = sphere + series.sag_mm(x, y).unwrap();
        assert!((found - expected).abs() < 1e-15, "{x} {y}: {found}");
    }
}

/// The closed forms of Forbes, Opt. Express 18 (2010) 19700, eq. (A.1) ff.
#[test]
fn first_polynomials_of_the_best_fit_sphere() {
    let basis = Q2d::new(&[(0, 0), (1, 0), (2, 0), (3, 0)], 0.0).unwrap();
    let s: f64 = 0.37;
    let mut found = [0.0; 4];
    basis.each_value(s.sqrt(), 0.0, &mut |term, value| found[term] = value / (s * (1.0 - s)));
    let closed = [
        1.0,
        (13.0 - 16.0 * s) / 19_f64.sqrt(),
        (2.0 / 95.0_f64).sqrt() * (29.0 - 4.0 * s * (25.0 - 19.0 * s)),
        (2.0 / 2545.0_f64).sqrt() * (207.0 - 4.0 * s * (315.0 - s * (577.0 - 320.0 * s))),
    ];
    for (found, closed) in found.iter().zip(closed) {
        assert!((found - closed).abs() < 1e-13, "{found} {closed}");
    }
}

#[test]
fn names_say_what_the_terms_are() {
    let names = |basis: &dyn Basis| -> Vec<String> {
        (0..basis.terms()).map(|term| basis.name(term)).collect()
    };
    let height = Normalisation::UnitHeight;
    assert_eq!(names(&Zernike::first(Counting::Fringe, 3, height).unwrap()), ["Z1", "Z2", "Z3"]);
    assert_eq!(names(&Zernike::first(Counting::Ansi, 2, height).unwrap()), ["Z0", "Z1"]);
    assert_eq!(
        names(&Zernike::of_orders(&[(4, 0), (3, -1)], height).unwrap()),
        ["Z(4,0)", "Z(3,-1)"]
    );
    assert_eq!(names(&Q2d::new(&[(2, -1)], 0.0).unwrap()), ["Q(2,-1)"]);
    assert_eq!(names(&Product::chebyshev(&[(2, 3)]).unwrap()), ["T2,3"]);
    assert_eq!(names(&Product::legendre(&[(2, 3)]).unwrap()), ["L2,3"]);
    // The extended polynomial of lens design programs.
    let xy = Product::powers(&Product::degree_orders(1, 3)).unwrap();
    let expected = ["X1Y0", "X0Y1", "X2Y0", "X1Y1", "X0Y2", "X3Y0", "X2Y1", "X1Y2", "X0Y3"];
    assert_eq!(names(&xy), expected);
}

/// The set of 37 ends with (12, 0); counting on gives (6, 6), and (12, 0) is 49th.
#[test]
fn the_fringe_set_of_37() {
    let set = Zernike::fringe_37(Normalisation::UnitHeight);
    let counted = Zernike::first(Counting::Fringe, 37, Normalisation::UnitHeight).unwrap();
    assert_eq!(set.orders()[..36], counted.orders()[..36]);
    assert_eq!((set.orders()[36], counted.orders()[36]), ((12, 0), (6, 6)));
    assert_eq!(Counting::Fringe.orders(49), Some((12, 0)));
    assert_eq!(set.name(36), "Z37");
}
