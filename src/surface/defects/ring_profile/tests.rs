//! Profiles of forms that are known, and none where nothing is alike all round.

use asphera_geometry::PointMm;

use super::*;
use crate::curvature::truth::Random;

const SIGMA_MM: f64 = 5e-6;

/// Samples a spacing of 1 mm apart, on a square raster within a disc.
struct Disc {
    points: Vec<PointMm>,
    places_mm: Vec<[f64; 2]>,
    deviations_mm: Vec<f64>,
}

impl Disc {
    fn new(radius: i32, seed: u64, form: impl Fn(f64, f64) -> f64) -> Disc {
        let mut random = Random::new(seed);
        let (mut places_mm, mut deviations_mm) = (Vec::new(), Vec::new());
        for row in -radius..=radius {
            for column in -radius..=radius {
                let [x, y] = [column, row].map(|at| f64::from(at) + 0.1 * random.unit());
                if x.hypot(y) <= f64::from(radius) {
                    places_mm.push([x, y]);
                    deviations_mm.push(form(x, y) + SIGMA_MM * random.normal());
                }
            }
        }
        let points = places_mm.iter().map(|&[x, y]| [x, y, 0.0]).collect();
        Disc { points, places_mm, deviations_mm }
    }

    fn profile(&self) -> Option<RingProfile> {
        let surface = DeviatingSurface {
            points: &self.points,
            triangles: &[],
            deviations_mm: &self.deviations_mm,
            places_mm: Some(&self.places_mm),
            spacing_mm: 1.0,
            reach_mm: 6.0,
        };
        RingProfile::of(&surface, &self.places_mm)
    }
}

/// A ring of Gaussian section of a full width at half of its height.
fn ring(x: f64, y: f64, at: f64, width: f64) -> f64 {
    (-4.0 * 2.0_f64.ln() * ((x.hypot(y) - at) / width).powi(2)).exp()
}

/// Low orders that are not alike all round.
fn low(x: f64, y: f64) -> f64 {
    let [x, y] = [x / 80.0, y / 80.0];
    1e-4 * (x * x - y * y) + 5e-5 * x * (3.0 * (x * x + y * y) - 2.0) + 3e-5 * (x * x + y * y)
}

/// What an even quartic leaves of the differences at radii from 4 mm to an end, at most: any other is followed by windows.
fn largest_off(end_mm: i32, off: impl Fn(f64) -> f64) -> f64 {
    let radii = || (4..=end_mm).map(f64::from);
    let row =
        |radius: f64| nalgebra::Vector3::from_fn(|term, _| (radius / 80.0).powi(2 * term as i32));
    let [mut normal, mut right] = [nalgebra::Matrix3::zeros(), nalgebra::Matrix3::zeros()];
    for radius in radii() {
        normal += row(radius) * row(radius).transpose();
        right += off(radius) * row(radius) * nalgebra::RowVector3::new(1.0, 0.0, 0.0);
    }
    let terms = normal.try_inverse().unwrap() * right.column(0);
    radii().map(|radius| (off(radius) - row(radius).dot(&terms)).abs()).fold(0.0, f64::max)
}

#[test]
fn rings_are_found_with_their_height_and_width_on_other_form() {
    for (at, width) in [(40.0, 3.5), (50.0, 8.0), (60.0, 12.0)] {
        let form = |x: f64, y: f64| 4e-5 * ring(x, y, at, width);
        let profile = Disc::new(80, 3, |x, y| low(x, y) + form(x, y)).profile().unwrap();
        let off = |radius: f64| profile.height_mm([0.6 * radius, 0.8 * radius]) - form(radius, 0.0);
        let largest = largest_off(76, off);
        assert!(largest < 2.5e-6, "{at} {width} {largest}");
    }
}

/// Waves about the axis have their crest in the middle.
#[test]
fn the_middle_of_waves_is_form() {
    let wave = |x: f64, y: f64| 3e-5 * (0.35 * x.hypot(y)).cos();
    let profile = Disc::new(80, 5, wave).profile().unwrap();
    let off = |radius: f64| profile.height_mm([radius, 0.0]) - wave(radius, 0.0);
    let mean = (10..70).map(|radius| off(f64::from(radius))).sum::<f64>() / 60.0;
    // The means next to the axis have ten samples.
    for (radius, most) in [(0.0, 6e-6), (3.0, 4e-6), (8.0, 4e-6), (20.0, 3e-6), (60.0, 3e-6)] {
        assert!((off(radius) - mean).abs() < most, "{radius} {}", off(radius));
    }
}

#[test]
fn a_pit_in_the_middle_stays_beside_rings_and_alone() {
    let pit = |x: f64, y: f64| -8e-5 * ring(x, y, 0.0, 8.0);
    assert!(Disc::new(80, 7, pit).profile().is_none_or(|of| of.height_mm([0.0, 0.0]) > -4e-6));
    let both = |x: f64, y: f64| pit(x, y) + 2.5e-5 * ring(x, y, 55.0, 6.0);
    let profile = Disc::new(80, 7, both).profile().unwrap();
    let [middle, beside] = [0.0, 12.0].map(|x| profile.height_mm([x, 0.0]));
    assert!((middle - beside).abs() < 6e-6, "{middle} {beside}");
    assert!(profile.height_mm([55.0, 0.0]) - profile.height_mm([45.0, 0.0]) > 2e-5);
}

#[test]
fn what_is_not_alike_all_round_has_no_profile() {
    assert!(Disc::new(80, 9, |_, _| 0.0).profile().is_none());
    assert!(Disc::new(80, 9, low).profile().is_none());
    // Spherical aberration is a quartic, which every window follows.
    let spherical = |x: f64, y: f64| {
        let squared = (x * x + y * y) / 6400.0;
        1e-3 * squared * (6.0 * squared - 6.0)
    };
    assert!(Disc::new(80, 9, spherical).profile().is_none());
    let straight = |x: f64, _: f64| 4e-5 * (0.4 * x).sin();
    assert!(Disc::new(80, 9, straight).profile().is_none());
    // An arc over a quarter of the circle, and a scratch across the part.
    let arc = |x: f64, y: f64| if x > y.abs() { -1e-4 * ring(x, y, 50.0, 3.0) } else { 0.0 };
    assert!(Disc::new(80, 9, arc).profile().is_none());
    let scratch =
        |x: f64, y: f64| if (y - 20.0).abs() < 1.5 && x.abs() < 60.0 { -1e-4 } else { 0.0 };
    assert!(Disc::new(80, 9, scratch).profile().is_none());
}

/// A ring that a sixth of a turn lacks, and a quadrant of a disc, which has no rings.
#[test]
fn most_of_the_circle_is_enough_and_a_quadrant_is_not() {
    let of = |disc: &mut Disc, keep: &dyn Fn(f64, f64) -> bool| {
        for (deviation, &[x, y]) in disc.deviations_mm.iter_mut().zip(&disc.places_mm) {
            if !keep(x, y) {
                *deviation = f64::NAN;
            }
        }
        disc.profile().is_some()
    };
    let ringed = || Disc::new(80, 11, |x, y| 4e-5 * ring(x, y, 50.0, 6.0));
    assert!(of(&mut ringed(), &|x, y| x < 0.0 || y.abs() > 0.6 * x));
    assert!(!of(&mut ringed(), &|x, y| x > 0.0 && y > 0.0));
    assert!(!of(&mut ringed(), &|_, _| false));
}

#[test]
fn small_scattered_and_single_places_have_no_profile() {
    assert!(Disc::new(38, 13, |x, y| 1e-3 * ring(x, y, 25.0, 6.0)).profile().is_none());
    for place_mm in [[0.0, 0.0], [1e3, 0.0], [1e300, 1e300], [f64::NAN, 0.0]] {
        let points = vec![[0.0; 3]; 500];
        let places_mm = vec![place_mm; 500];
        let deviations_mm = vec![1e-6; 500];
        let disc = Disc { points, places_mm, deviations_mm };
        assert!(disc.profile().is_none(), "{place_mm:?}");
    }
}

/// A ring within a square: the corners have samples in four sectors of twelve.
#[test]
fn what_a_profile_leaves_has_no_bend_where_corners_begin() {
    for (at, width) in [(35.0, 6.0), (44.0, 6.0), (46.0, 10.0)] {
        let mut square = Disc::new(71, 17, |x, y| low(x, y) + 4e-5 * ring(x, y, at, width));
        for (deviation, &[x, y]) in square.deviations_mm.iter_mut().zip(&square.places_mm) {
            if x.abs().max(y.abs()) > 50.0 {
                *deviation = f64::NAN;
            }
        }
        let profile = square.profile().unwrap();
        let off =
            |radius: f64| profile.height_mm([radius, 0.0]) - 4e-5 * ring(radius, 0.0, at, width);
        let largest = largest_off(69, off);
        assert!(largest < 4e-6, "{at} {width} {largest}");
    }
}

/// Rings about a place up to two spacings off the axis, with a scratch across a sector.
#[test]
fn rings_about_another_place_are_found_there() {
    for [x0, y0] in [[0.7, -0.4], [-1.2, 1.5], [2.0, 0.0]] {
        let about = |x: f64, y: f64| 4e-5 * ring(x - x0, y - y0, 50.0, 6.0);
        let scratch = |x: f64, y: f64| if (y - 30.0).abs() < 1.5 && x > 10.0 { -1e-4 } else { 0.0 };
        let disc = Disc::new(80, 19, |x, y| low(x, y) + about(x, y) + scratch(x, y));
        let profile = disc.profile().unwrap();
        let [x, y] = profile.centre_mm;
        assert!((x - x0).hypot(y - y0) < 0.1, "{x0} {y0}: {x} {y}");
        for [u, v] in [[1.0, 0.0], [0.0, 1.0], [-0.6, -0.8]] {
            let [crest, beside] =
                [50.0, 40.0].map(|radius| profile.height_mm([x0 + radius * u, y0 + radius * v]));
            let height = crest - beside;
            assert!((height - 4e-5).abs() < 3e-6, "{x0} {y0} {u} {v}: {height}");
        }
    }
}

/// Where sectors end, their last means lie to one side of their samples: these tell a line there ill.
#[test]
fn ends_of_sectors_make_no_spikes() {
    for seed in [21, 22, 23] {
        let mut square = Disc::new(78, seed, |x, y| 4e-5 * ring(x, y, 35.0, 12.0));
        for (deviation, &[x, y]) in square.deviations_mm.iter_mut().zip(&square.places_mm) {
            if x.abs().max(y.abs()) > 55.0 {
                *deviation = f64::NAN;
            }
        }
        let profile = square.profile().unwrap();
        let jump = |node: usize| {
            let [before, at, after] = [node - 2, node, node + 2].map(|of| profile.heights_mm[of]);
            (at - 0.5 * (before + after)).abs()
        };
        let largest = (100..148).map(jump).fold(0.0, f64::max);
        assert!(largest < SIGMA_MM, "{seed} {largest}");
    }
}

/// Rings that are higher on one side, or on two, with a scratch through them.
#[test]
fn rings_that_change_round_are_found_with_their_change() {
    for terms in [[0.3, 0.0, 0.0, 0.0, 0.0], [0.0, -0.1, 0.4, 0.2, 0.0], [0.0, 0.0, 0.0, 0.0, 0.3]]
    {
        let height = |x: f64, y: f64| {
            let [u, v] = [x, y].map(|of| of / x.hypot(y).max(1e-9));
            let waves = [u, v, u * u - v * v, 2.0 * u * v, 4.0 * u * u * u - 3.0 * u];
            4e-5 * (1.0 + waves.iter().zip(terms).map(|(p, q)| p * q).sum::<f64>())
        };
        let scratch = |x: f64, y: f64| if (y - 30.0).abs() < 1.5 && x > 10.0 { -1e-4 } else { 0.0 };
        let rings = |x: f64, y: f64| height(x, y) * ring(x, y, 50.0, 6.0);
        let profile = Disc::new(80, 23, |x, y| low(x, y) + rings(x, y) + scratch(x, y));
        let profile = profile.profile().unwrap();
        for (one, other) in profile.uneven.terms.iter().zip(terms) {
            assert!((one - other).abs() < 0.05, "{terms:?}: {:?}", profile.uneven.terms);
        }
        for [u, v] in [[1.0, 0.0], [0.0, 1.0], [-0.6, -0.8], [0.8, -0.6]] {
            let [crest, beside] =
                [50.0, 40.0].map(|radius| profile.height_mm([radius * u, radius * v]));
            let off = crest - beside - height(u, v);
            assert!(off.abs() < 4e-6, "{terms:?} {u} {v}: {off}");
        }
        assert!(profile.height_mm(profile.centre_mm).is_finite());
    }
}
