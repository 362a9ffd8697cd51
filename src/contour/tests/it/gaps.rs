//! Curves across gaps: arcs of circles, corners, and that no curve near by varies less.

use asphera_contour::gaps::{GapCurve, GapEnd, GapError, gap_curve, gaps_of};
use asphera_contour::{Graph, PlaceMm, Samples};

use crate::places::{Random, distance};

fn end(at_mm: PlaceMm, angle: f64) -> GapEnd {
    GapEnd { at_mm, onward: [angle.cos(), angle.sin()], is_straight: false }
}

fn smooth(from: GapEnd, to: GapEnd) -> (Vec<PlaceMm>, f64, f64) {
    match gap_curve(from, to).unwrap() {
        GapCurve::Smooth { places_mm, length_mm, energy } => (places_mm, length_mm, energy),
        corner @ GapCurve::Corner { .. } => panic!("{corner:?}"),
    }
}

#[test]
fn an_arc_of_a_circle_is_found_again() {
    let mut random = Random::new(61);
    for _ in 0..200 {
        let centre = [random.between(-50.0, 50.0), random.between(-50.0, 50.0)];
        let radius = random.between(0.1, 30.0);
        let first = random.between(0.0, std::f64::consts::TAU);
        let turn = random.between(0.05, 5.5) * if random.share() < 0.5 { -1.0 } else { 1.0 };
        let at = |angle: f64| [centre[0] + radius * angle.cos(), centre[1] + radius * angle.sin()];
        let way = std::f64::consts::FRAC_PI_2 * f64::signum(turn);
        // Onward at the second end leads back along the arc.
        let (from, to) = (end(at(first), first + way), end(at(first + turn), first + turn - way));
        let (places, length, energy) = smooth(from, to);
        for place in &places {
            let off = (distance(*place, centre) / radius - 1.0).abs();
            assert!(off < 1e-9, "{off} at a turn of {turn}");
        }
        assert!((length / (radius * turn.abs()) - 1.0).abs() < 1e-9 && energy < 1e-9);
        assert_eq!((places[0], places[places.len() - 1]), (from.at_mm, to.at_mm));
    }
}

#[test]
fn a_straight_gap_is_closed_straight() {
    let (places, length, energy) =
        smooth(end([1.0, 2.0], 0.0), end([4.0, 2.0], std::f64::consts::PI));
    assert!(places.iter().all(|place| (place[1] - 2.0).abs() < 1e-12));
    assert!((length - 3.0).abs() < 1e-12 && energy < 1e-12);
}

/// E of a polyline with evenly spaced places, by differences of its angles.
fn energy_of(places: &[PlaceMm]) -> f64 {
    let steps: Vec<[f64; 2]> =
        places.windows(2).map(|pair| [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]]).collect();
    let length: f64 = steps.iter().map(|step| step[0].hypot(step[1])).sum();
    let each = length / steps.len() as f64;
    let curvatures: Vec<f64> = steps
        .windows(2)
        .map(|pair| {
            let [[ax, ay], [bx, by]] = [pair[0], pair[1]];
            (ax * by - ay * bx).atan2(ax * bx + ay * by) / each
        })
        .collect();
    let varied: f64 = curvatures.windows(2).map(|pair| (pair[1] - pair[0]).powi(2) / each).sum();
    length.powi(5) / distance(places[0], places[places.len() - 1]).powi(2) * varied
}

/// The curvature of a curve of given angle at its ends, changed by a wave that keeps ends and directions, varies more.
#[test]
fn curves_beside_it_vary_more() {
    let mut random = Random::new(62);
    let mut tried = 0;
    while tried < 40 {
        let angles = [random.between(-1.8, 1.8), random.between(-1.8, 1.8)];
        let Ok(GapCurve::Smooth { places_mm, energy, .. }) = gap_curve(
            end([0.0, 0.0], angles[0]),
            end([1.0, 0.0], angles[1] + std::f64::consts::PI),
        ) else {
            continue;
        };
        tried += 1;
        // The polyline sums E to the order of its step; ends lack half a step each.
        let own = energy_of(&places_mm);
        assert!((own / energy - 1.0).abs() < 0.08 || energy < 1e-6, "{own} {energy} {angles:?}");
        let lift: Vec<f64> = (0..places_mm.len())
            .map(|index| {
                let t = index as f64 / (places_mm.len() - 1) as f64;
                (t * (1.0 - t)).powi(3)
            })
            .collect();
        for size in [0.3, -0.3] {
            for skew in [0.0, 1.0, -1.0] {
                let moved: Vec<PlaceMm> = places_mm
                    .iter()
                    .zip(&lift)
                    .enumerate()
                    .map(|(index, (&[x, y], lift))| {
                        let t = index as f64 / (places_mm.len() - 1) as f64;
                        [x, y + size * lift * (1.0 + skew * (2.0 * t - 1.0))]
                    })
                    .collect();
                let other = energy_of(&evenly(&moved));
                assert!(other > own * 0.999 - 1e-9, "{other} below {own} at {angles:?}");
            }
        }
    }
}

/// A polyline with places evenly along it.
fn evenly(places: &[PlaceMm]) -> Vec<PlaceMm> {
    let mut sums = vec![0.0];
    for pair in places.windows(2) {
        sums.push(sums[sums.len() - 1] + distance(pair[0], pair[1]));
    }
    let count = places.len() - 1;
    (0..=count)
        .map(|index| {
            let wanted = sums[count] * index as f64 / count as f64;
            let next = sums.partition_point(|sum| *sum < wanted).clamp(1, count);
            let share = (wanted - sums[next - 1]) / (sums[next] - sums[next - 1]);
            [0, 1].map(|axis| {
                places[next - 1][axis] + share * (places[next][axis] - places[next - 1][axis])
            })
        })
        .collect()
}

#[test]
fn the_curve_does_not_depend_on_scale_or_direction() {
    let (from, to) = (end([0.0, 0.0], 0.7), end([3.0, 1.0], 2.2));
    let (places, length, energy) = smooth(from, to);
    let large = |it: GapEnd| GapEnd { at_mm: it.at_mm.map(|value| 1024.0 * value), ..it };
    let (scaled, long, same) = smooth(large(from), large(to));
    assert_eq!((long, same), (1024.0 * length, energy));
    assert!(places.iter().zip(&scaled).all(|(p, q)| p.map(|value| 1024.0 * value) == *q));
    let (mut back, other, again) = smooth(to, from);
    back.reverse();
    assert!((other - length).abs() < 1e-9 && (again - energy).abs() < 1e-9);
    assert!(places.iter().zip(&back).all(|(p, q)| distance(*p, *q) < 1e-9));
}

#[test]
fn straight_sharp_ends_make_a_corner_and_others_do_not() {
    let straight = |at_mm: PlaceMm, onward: [f64; 2]| GapEnd { at_mm, onward, is_straight: true };
    // Two sides that meet at 40° in (10, 0).
    let (sin, cos) = 40_f64.to_radians().sin_cos();
    let (from, to) = (straight([9.0, 0.0], [1.0, 0.0]), straight([10.0 - cos, sin], [cos, -sin]));
    let Ok(GapCurve::Corner { at_mm }) = gap_curve(from, to) else { panic!("no corner") };
    assert!(distance(at_mm, [10.0, 0.0]) < 1e-12);
    // A right angle, a bent end, and sides that meet far away or behind.
    let blunt = straight([10.0, 1.0], [0.0, -1.0]);
    let bent = GapEnd { is_straight: false, ..to };
    let far = straight([9.0, 0.1], [1.0, -0.01]);
    let away = straight([10.0 - cos, sin], [-cos, sin]);
    for other in [blunt, bent, far] {
        assert!(matches!(gap_curve(from, other), Ok(GapCurve::Smooth { .. })), "{other:?}");
    }
    assert!(!matches!(gap_curve(from, away), Ok(GapCurve::Corner { .. })));
    let refused = gap_curve(from, from).unwrap_err();
    assert!(matches!(refused, GapError::NoDirection { .. }));
    assert!(refused.to_string().contains("found one place; leave the gap open"), "{refused}");
    let still = straight([1.0, 1.0], [0.0, 0.0]);
    assert!(gap_curve(from, still).unwrap_err().to_string().contains("without length"));
}

#[test]
fn ends_of_chains_have_the_direction_of_their_curve() {
    let arc: Vec<PlaceMm> = (0..30)
        .map(|index| {
            let (sin, cos) = (0.02 * f64::from(index)).sin_cos();
            [5.0 * cos, 5.0 * sin]
        })
        .collect();
    let found = GapEnd::of_places(&arc, 1e-6).unwrap();
    let (sin, cos) = 0.58_f64.sin_cos();
    let off = (found.onward[0] * cos + found.onward[1] * sin)
        .atan2(-found.onward[0] * sin + found.onward[1] * cos);
    assert!(off.abs() < 1e-3 && !found.is_straight, "{off} {found:?}");
    assert!(GapEnd::of_places(&arc, 0.01).unwrap().is_straight);
    let line: Vec<PlaceMm> = (0..5).map(|x| [f64::from(x), 2.0 * f64::from(x)]).collect();
    let found = GapEnd::of_places(&line, 0.0).unwrap();
    assert!(found.is_straight && (found.onward[1] / found.onward[0] - 2.0).abs() < 1e-12);
    assert!(GapEnd::of_places(&line[..2], 0.0).is_none());
    assert!(GapEnd::of_places(&[[1.0, 1.0]; 5], 0.0).is_none());
}

/// The gaps of lines, each given by its points in order: their kind, width, and the places across.
fn gaps(lines: &[Vec<PlaceMm>], widest_mm: f64) -> Vec<(Vec<PlaceMm>, f64, bool)> {
    let set = Samples::new(&lines.concat()).unwrap();
    let sample = |place: &PlaceMm| set.places().iter().position(|at| at == place).unwrap() as u32;
    let edges = lines.iter().flat_map(|line| line.windows(2));
    let graph = Graph::new(edges.map(|pair| [sample(&pair[0]), sample(&pair[1])]));
    let found = gaps_of(&graph, set.places(), widest_mm, 0.0).unwrap();
    found
        .into_iter()
        .map(|gap| match gap.curve.unwrap() {
            GapCurve::Corner { at_mm } => (vec![at_mm], gap.width_mm, true),
            GapCurve::Smooth { places_mm, .. } => (places_mm, gap.width_mm, false),
        })
        .collect()
}

/// The points of a circle of radius 5 mm from one degree to another, each full degree.
fn arc(degrees: std::ops::RangeInclusive<i32>) -> Vec<PlaceMm> {
    degrees
        .map(|degree| f64::from(degree).to_radians())
        .map(|angle| [3.0 + 5.0 * angle.cos(), 5.0 * angle.sin() - 1.0])
        .collect()
}

#[test]
fn a_gap_of_a_circle_is_closed_by_its_arc_if_it_is_allowed() {
    let points = [arc(0..=330)];
    let width = 2.0 * 5.0 * 15_f64.to_radians().sin();
    assert_eq!(gaps(&points, 0.999 * width), []);
    let found = gaps(&points, 1.001 * width);
    let [(places, wide, false)] = &found[..] else { panic!("{found:?}") };
    assert!((wide - width).abs() < 1e-12);
    // The directions come from a parabola through nine points.
    let off = places.iter().map(|place| (distance(*place, [3.0, -1.0]) - 5.0).abs());
    assert!(off.fold(0.0, f64::max) < 2e-3);
}

/// Straight sides that meet at 40° go on to their corner; those of a square are rounded, by the rule of the 60°.
#[test]
fn a_missing_tip_is_found() {
    let side = |degrees: f64| {
        let [x, y] = [degrees.to_radians().cos(), degrees.to_radians().sin()];
        (10..=50).map(move |step| f64::from(step) / 5.0).map(move |along| [along * x, along * y])
    };
    let found = gaps(&[side(20.0).collect(), side(-20.0).collect()], 1.4);
    let [(at, _, true)] = &found[..] else { panic!("{found:?}") };
    assert!(distance(at[0], [0.0, 0.0]) < 1e-9, "{at:?}");
    let found = gaps(&[side(90.0).collect(), side(0.0).collect()], 3.0);
    assert!(matches!(&found[..], [(_, _, false)]), "{found:?}");
}

/// A dash is shorter than the gaps beside it: its own ends are nearer to each other than to those of other dashes.
#[test]
fn dashes_are_joined_to_each_other_whatever_the_order() {
    let mut dashes: Vec<Vec<PlaceMm>> =
        (0..6).map(|dash| arc(30 * dash..=30 * dash + 12)).collect();
    let found = gaps(&dashes, 2.0);
    assert_eq!(found.len(), 5, "{found:?}");
    let width = 2.0 * 5.0 * 9_f64.to_radians().sin();
    assert!(found.iter().all(|(_, wide, _)| (wide - width).abs() < 1e-9));
    Random::new(5).shuffle(&mut dashes);
    dashes.iter_mut().step_by(2).for_each(|dash| dash.reverse());
    assert_eq!(gaps(&dashes, 2.0), found);
}
