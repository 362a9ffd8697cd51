//! Lines, arcs, corners, chamfers and edges of drawn outlines, whose figures are known.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use asphera_contour::features::{Course, Estimate, Feature, Profile};
use asphera_contour::{Choice, Method, PlaceMm};
use asphera_geometry::Numbers;
use proptest::prelude::*;

use crate::places::{Random, distance, triangulation};

/// A piece of a drawn outline.
#[derive(Clone, Copy)]
pub(crate) enum Drawn {
    Line(PlaceMm, PlaceMm),
    /// Centre, radius, angle at the beginning, and turn counter-clockwise.
    Arc(PlaceMm, f64, f64, f64),
}

impl Drawn {
    fn length(self) -> f64 {
        match self {
            Drawn::Line(p, q) => distance(p, q),
            Drawn::Arc(_, radius, _, turn) => radius * turn.abs(),
        }
    }

    /// The place at a length along it, `off` to the right.
    fn at(self, along: f64, off: f64) -> PlaceMm {
        match self {
            Drawn::Line(p, q) => {
                let length = self.length();
                let [x, y] = [(q[0] - p[0]) / length, (q[1] - p[1]) / length];
                [p[0] + along * x + off * y, p[1] + along * y - off * x]
            }
            Drawn::Arc([x, y], radius, from, turn) => {
                let (sin, cos) = (from + along / radius * turn.signum()).sin_cos();
                let away = radius + off * turn.signum();
                [x + away * cos, y + away * sin]
            }
        }
    }
}

/// `count` points along an outline, evenly but for a share of a step, with normal noise across it.
pub(crate) fn drawn(outline: &[Drawn], count: usize, sigma: f64, draw: u32) -> Vec<PlaceMm> {
    let (noise, shift) = (Numbers::new(77, draw, 0), Numbers::new(77, draw, 1));
    let whole: f64 = outline.iter().map(|piece| piece.length()).sum();
    (0..count)
        .map(|index| {
            let mut along =
                whole * (index as f64 + 0.5 + 0.5 * shift.uniform(index)) / (count + 1) as f64;
            let mut pieces = outline.iter();
            let mut piece = pieces.next().unwrap();
            while along > piece.length() {
                along -= piece.length();
                piece = pieces.next().unwrap();
            }
            piece.at(along, sigma * noise.normal(index))
        })
        .collect()
}

/// A plate of 40 x 24 mm: radius 3 mm below, chamfers of 2 x 2 and 3 x 1.5 mm above.
pub(crate) fn plate() -> Vec<Drawn> {
    let corners = [[40.0, 3.0], [40.0, 22.0], [38.0, 24.0], [3.0, 24.0], [0.0, 22.5], [0.0, 3.0]];
    let mut outline: Vec<Drawn> =
        corners.windows(2).map(|pair| Drawn::Line(pair[0], pair[1])).collect();
    outline.push(Drawn::Arc([3.0, 3.0], 3.0, PI, FRAC_PI_2));
    outline.push(Drawn::Line([3.0, 0.0], [37.0, 0.0]));
    outline.push(Drawn::Arc([37.0, 3.0], 3.0, -FRAC_PI_2, FRAC_PI_2));
    outline
}

/// A disc of 20 mm with a flat 6 mm from its middle.
pub(crate) fn disc_with_flat() -> Vec<Drawn> {
    let half = 0.6_f64.acos();
    let at = |angle: f64| [10.0 * angle.cos(), 10.0 * angle.sin()];
    vec![Drawn::Arc([0.0, 0.0], 10.0, half, TAU - 2.0 * half), Drawn::Line(at(-half), at(half))]
}

fn of(points: Vec<PlaceMm>) -> Profile {
    Profile::new(&Course::new(points, true), 0.0)
}

/// How many lines, arcs, free pieces, corners, chamfers and edges.
fn counts(profile: &Profile) -> [usize; 6] {
    let mut counts = [0; 6];
    for feature in &profile.features {
        counts[match feature {
            Feature::Line { .. } => 0,
            Feature::Arc { .. } => 1,
            Feature::Free { .. } => 2,
            Feature::Corner { .. } => 3,
            Feature::Chamfer { .. } => 4,
            Feature::Edge { .. } => 5,
        }] += 1;
    }
    counts
}

const PLATE_AREA: f64 = 40.0 * 24.0 - 2.0 - 2.25 - 2.0 * (9.0 - 9.0 * PI / 4.0);

/// What the plate is known to have, with what was found: by name.
fn plate_figures(profile: &Profile) -> Vec<(&'static str, f64, Estimate)> {
    let mut found = vec![("area", PLATE_AREA, profile.area_mm2.unwrap())];
    let length = 19.0 + 8.0_f64.sqrt() + 35.0 + 11.25_f64.sqrt() + 19.5 + 34.0 + 3.0 * PI;
    found.push(("perimeter", length, profile.perimeter_mm.unwrap()));
    for feature in &profile.features {
        match feature {
            Feature::Chamfer { at_mm, width_mm, legs_mm, angles_deg } if at_mm[0] > 20.0 => {
                found.push(("45° chamfer", 8.0_f64.sqrt(), *width_mm));
                found.push(("its leg", 2.0, legs_mm[0]));
                found.push(("its angle", 45.0, angles_deg[0]));
            }
            Feature::Chamfer { width_mm, legs_mm, angles_deg, .. } => {
                found.push(("chamfer", 11.25_f64.sqrt(), *width_mm));
                found.push(("leg before", 3.0, legs_mm[0]));
                found.push(("leg after", 1.5, legs_mm[1]));
                found.push(("angle before", 0.5_f64.atan().to_degrees(), angles_deg[0]));
            }
            Feature::Edge { radius_mm, angle_deg, .. } => {
                found.push(("edge radius", 3.0, *radius_mm));
                found.push(("edge angle", 90.0, *angle_deg));
            }
            Feature::Corner { at_mm, angle_deg } if at_mm[0].value > 39.0 => {
                found.push(("corner y", 22.0, at_mm[1]));
                found.push(("corner angle", 135.0, *angle_deg));
            }
            _ => {}
        }
    }
    found
}

#[test]
fn a_plate_without_noise_has_its_figures() {
    let profile = of(drawn(&plate(), 600, 0.0, 0));
    assert_eq!(counts(&profile), [6, 2, 0, 4, 2, 2], "{profile:#?}");
    let figures = plate_figures(&profile);
    assert_eq!(figures.len(), 2 + 3 + 4 + 4 + 2);
    for (name, truth, found) in figures {
        assert!((found.value - truth).abs() < 1e-9, "{name}: {found:?} {truth}");
        assert!(found.u < 1e-9, "{name}: {found:?}");
    }
    assert!(profile.unknown.is_empty());
    let profile = of(drawn(&disc_with_flat(), 300, 0.0, 0));
    assert_eq!(counts(&profile), [1, 1, 0, 2, 0, 0], "{profile:#?}");
    let half = 0.6_f64.acos();
    let area = 100.0 * (PI - half) + 48.0;
    assert!((profile.area_mm2.unwrap().value - area).abs() < 1e-9);
}

#[test]
fn uncertainties_hold_the_truth_of_many_draws() {
    // 1,200 points 0.1 mm apart, 1 µm.
    let draws = if std::env::var_os("ASPHERA_LONG").is_some() { 2000 } else { 100 };
    let mut held: Vec<(&str, u32, u32)> = Vec::new();
    let mut count = |name: &'static str, truth: f64, found: Estimate| {
        let place = held.iter().position(|row| row.0 == name).unwrap_or_else(|| {
            held.push((name, 0, 0));
            held.len() - 1
        });
        held[place].1 += u32::from((found.value - truth).abs() <= 1.96 * found.u);
        held[place].2 += 1;
    };
    for draw in 0..draws {
        let profile = of(drawn(&plate(), 1200, 1e-3, draw));
        assert_eq!(counts(&profile), [6, 2, 0, 4, 2, 2], "draw {draw}: {profile:#?}");
        plate_figures(&profile).into_iter().for_each(|(name, truth, it)| count(name, truth, it));
        let profile = of(drawn(&disc_with_flat(), 500, 1e-3, draw));
        assert_eq!(counts(&profile), [1, 1, 0, 2, 0, 0], "draw {draw}: {profile:#?}");
        let area = 100.0 * (PI - 0.6_f64.acos()) + 48.0;
        count("area of a D", area, profile.area_mm2.unwrap());
    }
    let mut worst = 0.0_f64;
    for (name, held, of) in &held {
        let percent = 100.0 * f64::from(*held) / f64::from(*of);
        println!("{name}: {percent:.2} % of {of}");
        worst = worst.max((percent - 95.0).abs());
    }
    // Of few draws the share itself scatters: three standard deviations of it.
    let bar = if draws == 2000 { 2.0 } else { 300.0 * (0.95 * 0.05 / f64::from(draws)).sqrt() };
    assert!(worst <= bar, "{worst} beyond {bar}");
}

/// A turn by an angle and a shift.
fn moved(points: &[PlaceMm], angle: f64, by: PlaceMm) -> Vec<PlaceMm> {
    let (sin, cos) = angle.sin_cos();
    points.iter().map(|[x, y]| [by[0] + x * cos - y * sin, by[1] + x * sin + y * cos]).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Wherever a closed chain begins and whichever way it goes, its profile is the same to the last bit.
    #[test]
    fn profiles_know_no_beginning(first in 0_usize..700, reverse: bool, draw in 0_u32..1000) {
        let points = drawn(&plate(), 700, 2e-3, draw);
        let mut turned = points.clone();
        turned.rotate_left(first);
        if reverse {
            turned.reverse();
        }
        prop_assert_eq!(of(points), of(turned));
    }

    /// A part that lies elsewhere has the same pieces and figures.
    #[test]
    fn profiles_move_with_the_part(angle in 0.0..TAU, x in -500.0..500.0, y in -500.0..500.0, draw in 0_u32..1000) {
        let points = drawn(&plate(), 700, 2e-3, draw);
        let [here, there] = [of(points.clone()), of(moved(&points, angle, [x, y]))];
        prop_assert_eq!(counts(&here), counts(&there));
        let sizes = |profile: &Profile| {
            let mut sizes = vec![profile.area_mm2.unwrap(), profile.perimeter_mm.unwrap()];
            for feature in &profile.features {
                match feature {
                    Feature::Chamfer { width_mm, .. } => sizes.push(*width_mm),
                    Feature::Edge { radius_mm, angle_deg, .. } => sizes.extend([*radius_mm, *angle_deg]),
                    Feature::Corner { angle_deg, .. } => sizes.push(*angle_deg),
                    _ => {}
                }
            }
            let mut sizes: Vec<[f64; 2]> = sizes.iter().map(|it| [it.value, it.u]).collect();
            sizes.sort_by(|p, q| p[0].total_cmp(&q[0]));
            sizes
        };
        for (here, there) in sizes(&here).into_iter().zip(sizes(&there)) {
            prop_assert!((here[0] - there[0]).abs() <= 1e-3 * here[1], "{here:?} {there:?}");
            prop_assert!((here[1] / there[1] - 1.0).abs() <= 1e-3, "{here:?} {there:?}");
        }
    }

    /// Points of no curve at all: nothing fails, and every figure has an uncertainty.
    #[test]
    fn no_points_are_too_odd(count in 0_usize..60, seed: u64, lattice: bool, closed: bool) {
        let mut random = Random::new(seed);
        let mut value = || {
            let value = random.between(-5.0, 5.0);
            if lattice { value.round() } else { value }
        };
        let points: Vec<PlaceMm> = (0..count).map(|_| [value(), value()]).collect();
        let profile = Profile::new(&Course::new(points, closed), 0.0);
        for feature in &profile.features {
            if let Feature::Line { angle_deg, u_across_mm, .. } = feature {
                prop_assert!(angle_deg.u.is_finite() && u_across_mm.is_finite());
            }
            if let Feature::Arc { radius_mm, .. } = feature {
                prop_assert!(radius_mm.u.is_finite() && radius_mm.value > 0.0);
            }
        }
    }
}

#[test]
fn what_is_not_known_says_why() {
    let few = Profile::new(&Course::new(vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], true), 0.0);
    assert!(few.unknown[0].contains("needs 9 points along a curve or more, this one has 3"));
    assert!(few.features.is_empty() && few.area_mm2.is_none());
    // A chamfer of six points: the lines beside it are there, and no number of it.
    let outline = [
        Drawn::Line([0.0, 0.0], [10.0, 0.0]),
        Drawn::Line([10.0, 0.0], [10.0, 9.6]),
        Drawn::Line([10.0, 9.6], [9.6, 10.0]),
        Drawn::Line([9.6, 10.0], [0.0, 10.0]),
        Drawn::Line([0.0, 10.0], [0.0, 0.0]),
    ];
    let profile = of(drawn(&outline, 400, 1e-4, 0));
    assert_eq!(counts(&profile), [4, 0, 0, 3, 0, 0], "{profile:#?}");
    assert!(profile.unknown[0].starts_with("line near 9."), "{:?}", profile.unknown);
    assert!(profile.unknown[0].contains("8 points or more are needed"), "{:?}", profile.unknown);
    assert!(profile.perimeter_mm.is_none() && profile.area_mm2.unwrap().u > 0.0);
    // An ellipse is neither line nor arc.
    let ellipse = (0..800).map(|index| f64::from(index) * TAU / 800.0);
    let noise = Numbers::new(5, 0, 0);
    let points = ellipse.enumerate().map(|(index, angle)| {
        let off = 1e-3 * noise.normal(index);
        [(20.0 + off) * angle.cos(), (8.0 + off) * angle.sin()]
    });
    let profile = of(points.collect());
    let area = profile.area_mm2.unwrap();
    assert!((area.value - 160.0 * PI).abs() <= 3.0 * area.u, "{area:?}");
    assert!(profile.unknown.iter().any(|it| it.starts_with("perimeter: ")), "{profile:#?}");
}

#[test]
fn an_open_profile_has_ends() {
    let outline = [
        Drawn::Line([0.0, 0.0], [10.0, 0.0]),
        Drawn::Line([10.0, 0.0], [11.0, 1.0]),
        Drawn::Line([11.0, 1.0], [11.0, 8.0]),
    ];
    let profile = Profile::new(&Course::new(drawn(&outline, 300, 5e-4, 3), false), 0.0);
    assert_eq!(counts(&profile), [3, 0, 0, 2, 1, 0], "{profile:#?}");
    assert!(profile.area_mm2.is_none() && profile.perimeter_mm.is_none());
    let Some(Feature::Chamfer { width_mm, legs_mm, .. }) = profile.features.last() else {
        panic!("{profile:#?}");
    };
    for (found, truth) in [(width_mm, 2.0_f64.sqrt()), (&legs_mm[0], 1.0), (&legs_mm[1], 1.0)] {
        assert!((found.value - truth).abs() <= 3.0 * found.u && found.u < 1e-3, "{found:?}");
    }
}

#[test]
fn a_tolerance_takes_waves_for_straight() {
    // Waves of 4 µm on the lines of a square, noise 0.2 µm.
    let wave = |along: f64| 4e-3 * (along * 1.7).sin();
    let noise = Numbers::new(6, 0, 0);
    let points: Vec<PlaceMm> = (0..800)
        .map(|index| {
            let along = 40.0 * (f64::from(index) + 0.5) / 800.0;
            let off = wave(along) + 2e-4 * noise.normal(index as usize);
            let on = along % 10.0;
            match index / 200 {
                0 => [on, -off],
                1 => [10.0 + off, on],
                2 => [10.0 - on, 10.0 + off],
                _ => [-off, 10.0 - on],
            }
        })
        .collect();
    let course = Course::new(points, true);
    let [fine, rough] = [0.0, 0.02].map(|tolerance_mm| Profile::new(&course, tolerance_mm));
    assert!(counts(&fine)[..3].iter().sum::<usize>() > 4, "{fine:#?}");
    assert_eq!(counts(&rough), [4, 0, 0, 4, 0, 0], "{rough:#?}");
}

#[test]
fn noise_wider_than_the_spacing_leaves_the_order() {
    // A ring and beside it an open corner, so noisy that no method joins their points one by one.
    let ring = drawn(&[Drawn::Arc([0.0, 0.0], 10.0, 0.0, TAU)], 4000, 0.02, 1);
    let corner = [Drawn::Line([20.0, 0.0], [30.0, 0.0]), Drawn::Line([30.0, 0.0], [30.0, 10.0])];
    let points = [ring, drawn(&corner, 1500, 0.02, 2)].concat();
    let of = triangulation(&points);
    let choice = Choice::new(&of);
    assert_eq!(choice.method, Method::Lee);
    let courses = Course::of_curve(of.samples(), &choice.curve(&of).unwrap(), &choice.outliers);
    assert_eq!(courses.iter().map(Course::is_closed).collect::<Vec<_>>(), [false, true]);
    let profiles: Vec<Profile> = courses.iter().map(|it| Profile::new(it, 0.0)).collect();
    assert_eq!(counts(&profiles[0]), [2, 0, 0, 1, 0, 0], "{:#?}", profiles[0]);
    assert_eq!(counts(&profiles[1]), [0, 1, 0, 0, 0, 0], "{:#?}", profiles[1]);
    let within = |found: Estimate, truth: f64| (found.value - truth).abs() <= 4.0 * found.u;
    assert!(within(profiles[1].area_mm2.unwrap(), 100.0 * PI), "{:#?}", profiles[1]);
    let Some(Feature::Corner { at_mm, angle_deg }) = profiles[0].features.last() else {
        panic!("{:#?}", profiles[0]);
    };
    assert!(within(at_mm[0], 30.0) && within(at_mm[1], 0.0) && within(*angle_deg, 90.0));
    // Points sorted by noise lie closer to their neighbours than those of a scan: up to 0.2 of it does not show.
    for profile in &profiles {
        assert!((profile.noise_sigma_mm.unwrap() / 0.02 - 1.0).abs() < 0.2, "{profile:#?}");
    }
}
