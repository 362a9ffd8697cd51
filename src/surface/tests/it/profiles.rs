//! Figures and fits of profiles, against values known by formula and against repeated measurement.

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_surface::sections::{
    MAX_DEGREE, Profile, ProfileError, SectionPath, section, section_where,
};

use crate::patterns::{jittered_raster, raster};
use crate::random::Random;

const PATH: SectionPath = SectionPath::Segment { from_mm: [0.05, 0.1013], to_mm: [0.25, 0.1217] };

fn meshed(points: impl IntoIterator<Item = PointMm>) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.insert(&points.into_iter().collect::<Vec<_>>());
    mesh
}

fn heights(mesh: &Mesh, path: &SectionPath) -> Profile {
    Profile::heights(&section(mesh, path, None).expect("the path has a length"))
}

/// A mesh over a jittered raster with a height of its own.
fn over(height_mm: impl Fn(f64, f64) -> f64) -> Mesh {
    meshed(jittered_raster(60, 0.3, 4).into_iter().map(|[x, y, _]| [x, y, height_mm(x, y)]))
}

#[test]
fn a_tilted_plane_is_a_line() {
    let (a, b, c) = (0.01, -0.02, 5.0);
    let mesh = over(|x, y| a * x + b * y + c);
    let profile = heights(&mesh, &PATH);
    let (dx, dy) = (0.2_f64, 0.0204_f64);
    let length = dx.hypot(dy);
    let slope = (a * dx + b * dy) / length;
    let start = a * 0.05 + b * 0.1013 + c;
    let figures = profile.figures().unwrap();
    assert!((figures.length_mm - length).abs() < 1e-15);
    assert!((figures.pv_mm - slope * length).abs() < 1e-14, "{figures:?}");
    assert!((figures.mean_mm - (start + slope * length / 2.0)).abs() < 1e-14);
    assert!((figures.rms_about_mean_mm - slope * length / 12.0_f64.sqrt()).abs() < 1e-14);
    let mean_square = start * start + start * slope * length + (slope * length).powi(2) / 3.0;
    assert!((figures.rms_mm - mean_square.sqrt()).abs() < 1e-14);
    assert_eq!((figures.min.s_mm, figures.max.s_mm), (0.0, figures.length_mm));
    let line = profile.line().unwrap();
    assert!((line.slope - slope).abs() < 1e-13 && line.rms_mm < 1e-14, "{line:?}");
    assert!((line.level_mm - (start + slope * length / 2.0)).abs() < 1e-14);
    assert!((line.value_mm(0.0) - start).abs() < 1e-14);
    assert!(line.u_slope.unwrap() < 1e-13);
    assert!(line.residual(&profile).figures().unwrap().pv_mm < 1e-14);
    // A straight line has no radius.
    let circle = profile.circle().unwrap();
    assert_eq!((circle.radius_mm(), circle.centre_mm()), (None, None), "{circle:?}");
}

#[test]
fn the_mean_does_not_depend_on_how_many_edges_are_crossed() {
    // Twice as many points in one half of a ramp.
    let coarse = (0..21 * 11).map(|i| [f64::from(i % 21) * 0.1, f64::from(i / 21) * 0.1]);
    let fine = (0..40 * 40).map(|i| [f64::from(i % 40) * 0.025 + 0.01, f64::from(i / 40) * 0.025]);
    let mesh = meshed(coarse.chain(fine).map(|[x, y]| [x, y, 0.5 * x]));
    let path = SectionPath::Segment { from_mm: [0.0, 0.5], to_mm: [2.0, 0.5] };
    let profile = heights(&mesh, &path);
    assert!((profile.figures().unwrap().mean_mm - 0.5).abs() < 1e-14);
    assert!((profile.polynomial(0).unwrap().level_mm - 0.5).abs() < 1e-14);
}

#[test]
fn polynomials_are_found_again() {
    // Of a degree beyond one not exactly: the mesh lies on chords. So it is given at the samples.
    let profile = heights(&over(|x, _| x), &PATH);
    let polynomial = |s: f64| 1.0 + s - 40.0 * s.powi(2) + 300.0 * s.powi(5);
    let profile = profile.map(|sample| polynomial(sample.s_mm));
    for degree in 5..=MAX_DEGREE {
        let fit = profile.polynomial(degree).unwrap();
        assert_eq!(fit.degree(), degree);
        assert!(fit.rms_mm < 1e-13, "{degree}: {}", fit.rms_mm);
        for s in [0.0, 0.07, 0.13, 0.2] {
            assert!((fit.value_mm(s) - polynomial(s)).abs() < 1e-12, "{degree}");
        }
        let middle = 0.2_f64.hypot(0.0204) / 2.0;
        let slope = 1.0 - 80.0 * middle + 1500.0 * middle.powi(4);
        assert!((fit.slope - slope).abs() < 1e-10, "{degree}: {} for {slope}", fit.slope);
    }
    assert!(profile.polynomial(4).unwrap().rms_mm > 1e-7);
    let degree = MAX_DEGREE + 1;
    assert_eq!(profile.polynomial(degree), Err(ProfileError::Degree { degree }));
}

#[test]
fn circles_are_found_again_whatever_their_size() {
    let flat = heights(&over(|_, _| 0.0), &PATH);
    // From nearly half a circle to a sagitta of 0.5 nm; bent up and down; tilted.
    for radius in [0.103, 0.2, 10.0, 1e4] {
        for sign in [1.0, -1.0] {
            for tilt in [0.0, 0.3] {
                if radius < 0.2 && tilt > 0.0 {
                    continue;
                }
                let centre: f64 = 0.1005 + tilt * if radius < 1.0 { 0.1 } else { radius };
                let at = |s: f64| {
                    let squared = (s - centre).powi(2);
                    7.0 + sign * squared / (radius + (radius * radius - squared).sqrt())
                };
                let found = flat.map(|sample| at(sample.s_mm)).circle().unwrap();
                let (r, u) = found.radius_mm().unwrap();
                // Heights of 7 are told to 1e-15, the sagitta is 0.005 / radius.
                let digits = 1e-13 * (1.0 + radius);
                assert!(
                    (r / (sign * radius) - 1.0).abs() < 1e3 * digits,
                    "{r} for {radius} {tilt}"
                );
                assert!(u < 1e3 * digits * radius && found.rms_mm < 1e-13, "{found:?}");
                if radius < 100.0 {
                    let [s, z] = found.centre_mm().unwrap();
                    assert!((s - centre).abs() < 1e-8 && (z - 7.0 - sign * radius).abs() < 1e-8);
                }
                let left = found.residual(&flat.map(|sample| at(sample.s_mm) + 1e-6));
                let left = left.figures().unwrap();
                assert!(left.mean_mm > 0.0 && left.max.value_mm < 1.01e-6, "{left:?}");
            }
        }
    }
}

/// The spread of what is fitted to many noisy measurements of one surface is the uncertainty that
/// each of the fits tells.
#[test]
fn uncertainties_are_the_spread_of_repeated_measurements() {
    let places = raster(40);
    let mut random = Random::new(5);
    let (noise_mm, curvature) = (1e-6, 0.02);
    let path = SectionPath::Segment { from_mm: [0.011, 0.0513], to_mm: [0.18, 0.0671] };
    // Slope, its uncertainty, curvature, its uncertainty.
    let mut sums = [[0.0; 2]; 4];
    let count = 400;
    for _ in 0..count {
        let measured = places.iter().map(|&[x, y, _]| {
            let z = curvature / 2.0 * ((x - 0.1).powi(2) + y * y) + noise_mm * random.normal();
            [x, y, z]
        });
        let profile = heights(&meshed(measured.collect::<Vec<_>>()), &path);
        // The line is fitted to what the true surface leaves: noise alone.
        let circle = profile.circle().unwrap();
        let line = circle.residual(&profile).line().unwrap();
        let found = [
            line.slope,
            line.u_slope.unwrap(),
            circle.curvature_per_mm,
            circle.u_curvature_per_mm.unwrap(),
        ];
        for (sum, found) in sums.iter_mut().zip(found) {
            *sum = [sum[0] + found, sum[1] + found * found];
        }
    }
    let n = f64::from(count);
    let spread = |[sum, squares]: [f64; 2]| ((squares - sum * sum / n) / (n - 1.0)).sqrt();
    let typical = |[_, squares]: [f64; 2]| (squares / n).sqrt();
    let (found, told) = (spread(sums[2]), typical(sums[3]));
    // The spread of 400 is known to 1 / √800 = 3.5 %.
    assert!((found / told - 1.0).abs() < 0.12, "curvature spreads {found}, told {told}");
    assert!((sums[2][0] / n - curvature).abs() < 4.0 * found / n.sqrt());
    assert!(typical(sums[1]) > 0.0 && spread(sums[0]) < typical(sums[1]));
}

#[test]
fn what_is_too_short_says_so() {
    let mesh = meshed([[0.0, 0.0, 0.0], [9.0, 0.0, 1.0], [0.0, 9.0, 2.0]]);
    let path = SectionPath::Segment { from_mm: [1.0, 1.0], to_mm: [3.0, 1.0] };
    let profile = heights(&mesh, &path);
    assert!(profile.figures().is_ok());
    // Of one triangle a line leaves nothing from which its uncertainty could be told.
    let line = profile.line().unwrap();
    assert!((line.slope - 1.0 / 9.0).abs() < 1e-15 && line.u_slope.is_none(), "{line:?}");
    let error = profile.polynomial(2).unwrap_err();
    assert_eq!(error, ProfileError::TooShort { vertices: 3, parameters: 3 });
    assert_eq!(
        error.to_string(),
        "the profile comes from 3 vertices, and a fit of 3 parameters needs 4"
    );
    assert_eq!(profile.circle(), Err(ProfileError::TooShort { vertices: 3, parameters: 3 }));
    let nothing = section_where(&mesh, &path, |_| false).unwrap();
    let profile = Profile::heights(&nothing);
    assert_eq!(profile.figures(), Err(ProfileError::NoLength));
    assert_eq!(profile.line(), Err(ProfileError::NoLength));
}

#[test]
fn a_value_that_is_unknown_breaks_the_profile() {
    let mesh = over(|x, y| x + y);
    let found = section(&mesh, &PATH, None).unwrap();
    let known = |x: f64| !(0.1..0.15).contains(&x);
    let profile = Profile::along(&found, |vertex| {
        let [x, y, _] = mesh.points()[vertex as usize];
        if known(x) { x - y } else { f64::NAN }
    });
    let pieces: Vec<_> = profile.pieces().collect();
    assert_eq!(pieces.len(), 2);
    assert!(pieces[0].last().unwrap().s_mm < 0.06 && pieces[1][0].s_mm > 0.09);
    let length: f64 = profile.samples().iter().map(|sample| sample.length_mm).sum();
    assert!((profile.figures().unwrap().length_mm - length).abs() < 1e-15);
    assert!(Profile::along(&found, |_| f64::NAN).samples().is_empty());
}
