//! From nominals whose medial axis is known.

use asphera_surface::lfs::{Jet, Lfs, Nominal, NominalLfs, Why};

/// z(x, y) over a circle.
struct Over<F> {
    radius_mm: f64,
    jet: F,
}

impl<F: Fn(f64, f64) -> Jet> Nominal for Over<F> {
    fn jet(&self, x: f64, y: f64) -> Option<Jet> {
        (x.hypot(y) <= self.radius_mm).then(|| (self.jet)(x, y))
    }

    fn extent_mm(&self) -> [[f64; 2]; 2] {
        [[-self.radius_mm; 2], [self.radius_mm; 2]]
    }
}

/// z = (x²/a + y²/b) / 2.
fn quadric(a: f64, b: f64) -> impl Fn(f64, f64) -> Jet {
    move |x, y| Jet {
        height_mm: 0.5 * (x * x / a + y * y / b),
        slope: [x / a, y / b],
        bend_per_mm: [1.0 / a, 0.0, 1.0 / b],
    }
}

/// The upper half of an ellipsoid of revolution about z.
fn ellipsoid(a: f64, c: f64) -> impl Fn(f64, f64) -> Jet {
    move |x, y| {
        let z = c * (1.0 - (x * x + y * y) / (a * a)).sqrt();
        let k = c * c / (a * a);
        Jet {
            height_mm: z,
            slope: [-k * x / z, -k * y / z],
            bend_per_mm: [
                -k / z - k * k * x * x / z.powi(3),
                -k * k * x * y / z.powi(3),
                -k / z - k * k * y * y / z.powi(3),
            ],
        }
    }
}

/// Checks 100 places up to `within` of the radius against the truth, to the tolerance.
fn keeps(nominal: Over<impl Fn(f64, f64) -> Jet>, within: f64, truth: impl Fn(f64, f64) -> f64) {
    let reach_mm = within * nominal.radius_mm;
    let step_mm = nominal.radius_mm / 40.0;
    let lfs = NominalLfs::new(nominal, step_mm, TOLERANCE).expect("a nominal");
    for i in 0..100 {
        let (r, angle) = (reach_mm * (f64::from(i) / 99.0).sqrt(), 2.4 * f64::from(i));
        let (x, y) = (r * angle.cos(), r * angle.sin());
        let found = lfs.at(x, y);
        let Lfs::Known { mm, lower_mm, upper_mm } = found else { panic!("{found:?}") };
        let truth_mm = truth(x, y);
        assert!((mm / truth_mm - 1.0).abs() <= TOLERANCE, "{found:?} instead of {truth_mm}");
        assert!(lower_mm <= truth_mm && truth_mm <= upper_mm, "{found:?}, but {truth_mm}");
        assert!(lower_mm > 0.9 * mm, "{found:?}");
    }
}

const TOLERANCE: f64 = 1e-4;

#[test]
fn a_sphere() {
    keeps(Over { radius_mm: 30.0, jet: ellipsoid(50.0, 50.0) }, 1.0, |_, _| 50.0);
}

#[test]
fn a_long_ellipsoid() {
    // The axis of the whole is the segment up to (c² - a²)/c = 30 mm; that of this cap begins with the
    // centre of its border, (1 - a²/c²) times its height.
    keeps(Over { radius_mm: 16.0, jet: ellipsoid(20.0, 40.0) }, 1.0, |x, y| {
        let (r, z) = (x.hypot(y), ellipsoid(20.0, 40.0)(x, y).height_mm);
        r.hypot(z - z.clamp(18.0, 30.0))
    });
}

#[test]
fn a_paraboloid() {
    keeps(Over { radius_mm: 60.0, jet: quadric(40.0, 40.0) }, 1.0, |x, y| {
        let r = x.hypot(y);
        r.hypot((40.0 - r * r / 80.0).max(0.0))
    });
}

/// The normals of z = (x²/a + y²/b)/2 with a < b meet in pairs at x = 0, in
/// (0, y (1 - a/b), z + a): the axis is the part of that plane over a parabola.
#[test]
fn an_elliptic_paraboloid() {
    let (a, b) = (20.0, 50.0);
    keeps(Over { radius_mm: 40.0, jet: quadric(a, b) }, 0.6, |x, y| {
        let z = quadric(a, b)(x, y).height_mm;
        let shrunk = 1.0 - a / b;
        let parabola = |s: f64| a + s * s / (2.0 * b * shrunk * shrunk);
        let nearest = (-400_000..=400_000)
            .map(|i| 1e-4 * f64::from(i))
            .map(|s| (y - s).hypot((parabola(s) - z).max(0.0)))
            .fold(f64::INFINITY, f64::min);
        x.hypot(nearest)
    });
}

/// Its trough and its ridge are curved alike, on two sides.
#[test]
fn a_saddle_is_as_its_mirror_image() {
    let saddle = || Over { radius_mm: 10.0, jet: quadric(30.0, -30.0) };
    let lfs = NominalLfs::new(saddle(), 0.25, TOLERANCE).unwrap();
    for (x, y) in [(0.0, 0.0), (3.0, 1.0), (-6.0, 4.0), (0.0, 8.0)] {
        let (one, other) = (lfs.at(x, y).mm().unwrap(), lfs.at(y, x).mm().unwrap());
        assert!((one / other - 1.0).abs() < 2.0 * TOLERANCE, "{one} and {other}");
        let [_, high] = saddle().jet(x, y).unwrap().curvatures_per_mm();
        assert!(one <= (1.0 + TOLERANCE) / high, "{one}");
    }
    let at_rest = lfs.at(0.0, 0.0).mm().unwrap();
    assert!((at_rest / 30.0 - 1.0).abs() < TOLERANCE, "{at_rest}");
}

#[test]
fn a_plane_and_beside_it() {
    let plane = Over {
        radius_mm: 5.0,
        jet: |x, y| Jet { height_mm: 0.5 * x - y, slope: [0.5, -1.0], bend_per_mm: [0.0; 3] },
    };
    let lfs = NominalLfs::new(plane, 0.5, TOLERANCE).unwrap();
    assert!(matches!(lfs.at(1.0, 1.0), Lfs::Beyond { lower_mm } if lower_mm >= 1e5));
    assert_eq!(lfs.axis().balls(), []);
    assert_eq!(lfs.at(4.0, 4.0), Lfs::Unknown(Why::Outside));
    assert_eq!(lfs.at(f64::NAN, 0.0), Lfs::Unknown(Why::Outside));
}

#[test]
fn curvatures_of_a_slanting_place() {
    for (x, y) in [(0.0, 0.0), (20.0, -10.0), (5.0, 28.0)] {
        for curvature in ellipsoid(50.0, 50.0)(x, y).curvatures_per_mm() {
            assert!((curvature + 0.02).abs() < 1e-15, "{curvature}");
        }
    }
    // A parabolic trough: κ = 1/a / (1 + (x/a)²)^1.5 across, none along.
    let trough = Jet { height_mm: 0.0, slope: [0.75, 0.0], bend_per_mm: [0.1, 0.0, 0.0] };
    let [along, across] = trough.curvatures_per_mm();
    assert!(along.abs() < 1e-16 && (across - 0.1 / 1.25_f64.powi(3)).abs() < 1e-15);
}

#[test]
fn what_is_no_nominal_is_refused() {
    let refused = |nominal: Over<fn(f64, f64) -> Jet>, step_mm, tolerance| {
        NominalLfs::new(nominal, step_mm, tolerance).err().unwrap().to_string()
    };
    let flat: fn(f64, f64) -> Jet =
        |_, _| Jet { height_mm: 0.0, slope: [0.0; 2], bend_per_mm: [0.0; 3] };
    let broken: fn(f64, f64) -> Jet =
        |x, _| Jet { height_mm: x.ln(), slope: [0.0; 2], bend_per_mm: [0.0; 3] };
    let over = |radius_mm, jet| Over { radius_mm, jet };
    assert_eq!(
        refused(over(1.0, flat), 0.0, 0.01),
        "step_mm is 0, but must be finite and above zero"
    );
    assert_eq!(
        refused(over(1.0, flat), 0.1, 1.0),
        "tolerance is 1, but must be between 1e-9 and 0.1"
    );
    assert_eq!(
        refused(over(-1.0, flat), 0.1, 0.01),
        "extent of the nominal in mm is -2, but must be finite and above zero"
    );
    assert_eq!(
        refused(over(1e4, flat), 1.0, 0.01),
        "400040001 samples are more than the 16000000 that are allowed"
    );
    assert_eq!(
        refused(over(1.0, broken), 0.5, 0.01),
        "the nominal is not finite at (0.0, -1.0) mm, within its domain"
    );
}
