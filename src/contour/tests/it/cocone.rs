//! Cocone against its definition, with Voronoi cells cut from a wide box, and where Voronoi edges are points.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_8, PI, TAU};

use asphera_contour::curves::cocone;
use asphera_contour::{Graph, PlaceMm, SampleId};

use crate::places::{Random, by_row, circle, closed, distance, lattice, scattered, triangulation};

/// A side of a cell: where it begins, counter-clockwise, and the sample beyond; none on the border of the box.
type Side = (PlaceMm, Option<usize>);

/// Half the width of the box: no vertex of the cells here lies so far off.
const WIDE_MM: f64 = 1e7;

fn minus(a: PlaceMm, b: PlaceMm) -> PlaceMm {
    [a[0] - b[0], a[1] - b[1]]
}

/// The cell of a place, cut by the bisectors to all others.
fn cell(places: &[PlaceMm], of: usize) -> Vec<Side> {
    let corner = |x: f64, y: f64| ([WIDE_MM * x, WIDE_MM * y], None);
    let mut sides =
        vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let p = places[of];
    for (other, &q) in places.iter().enumerate().filter(|&(other, _)| other != of) {
        let middle = [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
        let beyond = |at: PlaceMm| {
            let [way, off] = [minus(q, p), minus(at, middle)];
            way[0] * off[0] + way[1] * off[1]
        };
        let mut cut = Vec::new();
        for (index, &(from, label)) in sides.iter().enumerate() {
            let to = sides[(index + 1) % sides.len()].0;
            let [a, b] = [beyond(from), beyond(to)];
            let crossing = [0, 1].map(|axis| from[axis] + a / (a - b) * (to[axis] - from[axis]));
            match (a < 0.0, b < 0.0) {
                (true, true) => cut.push((from, label)),
                (true, false) => cut.extend([(from, label), (crossing, Some(other))]),
                (false, true) => cut.push((crossing, label)),
                (false, false) => {}
            }
        }
        sides = cut;
    }
    sides
}

/// The angle of the way to the pole.
fn pole_rad(at: PlaceMm, sides: &[Side]) -> f64 {
    let angle = |way: PlaceMm| way[1].atan2(way[0]);
    if sides.iter().all(|(_, beyond)| beyond.is_some()) {
        let far = |&&(vertex, _): &&Side| distance(at, vertex);
        return angle(minus(sides.iter().max_by(|a, b| far(a).total_cmp(&far(b))).unwrap().0, at));
    }
    let mut sum = [0.0; 2];
    for (index, side) in sides.iter().enumerate() {
        let next = sides[(index + 1) % sides.len()];
        // A ray ends at the border of the box, or begins there.
        let before = sides[(index + sides.len() - 1) % sides.len()];
        let way = match (before.1, side.1, next.1) {
            (_, Some(_), None) => minus(next.0, side.0),
            (None, Some(_), _) => minus(side.0, next.0),
            _ => continue,
        };
        let length = way[0].hypot(way[1]);
        sum = [sum[0] + way[0] / length, sum[1] + way[1] / length];
    }
    angle(sum)
}

/// The samples beyond the sides that meet the cocone: those that are seen at 90° ± 22.5° from the way to the pole, on either side.
fn in_cocone(at: PlaceMm, sides: &[Side], pole_rad: f64) -> Vec<usize> {
    let seen_at = |place: PlaceMm| {
        let way = minus(place, at);
        way[1].atan2(way[0]) - pole_rad
    };
    let meets = |index: usize| {
        let first = seen_at(sides[index].0);
        let turn = (seen_at(sides[(index + 1) % sides.len()].0) - first).rem_euclid(TAU);
        (-4..=4).any(|half_turn| {
            let middle = FRAC_PI_2 + f64::from(half_turn) * PI;
            first <= middle + FRAC_PI_8 && first + turn >= middle - FRAC_PI_8
        })
    };
    (0..sides.len()).filter(|&index| meets(index)).filter_map(|index| sides[index].1).collect()
}

/// Cocone of places, each there once, by its definition.
fn defined(places: &[PlaceMm]) -> Graph {
    let cells: Vec<Vec<Side>> = (0..places.len()).map(|of| cell(places, of)).collect();
    let poles: Vec<f64> = (0..places.len()).map(|of| pole_rad(places[of], &cells[of])).collect();
    let met: Vec<Vec<usize>> =
        (0..places.len()).map(|of| in_cocone(places[of], &cells[of], poles[of])).collect();
    let kept = |of: usize| -> Vec<usize> {
        let candidates = || met[of].iter().copied().filter(|&other| met[other].contains(&of));
        let is_left = |&other: &usize| {
            let way = minus(places[other], places[of]);
            (way[1].atan2(way[0]) - poles[of]).sin() > 0.0
        };
        let nearer = |a: &usize, b: &usize| {
            distance(places[of], places[*a]).total_cmp(&distance(places[of], places[*b]))
        };
        let left = candidates().filter(is_left).min_by(nearer);
        let right = candidates().filter(|it| !is_left(it)).min_by(nearer);
        left.into_iter().chain(right).collect()
    };
    let kept: Vec<Vec<usize>> = (0..places.len()).map(kept).collect();
    let pairs = (0..places.len()).flat_map(|p| kept[p].iter().map(move |&q| [p, q]));
    let pairs = pairs.filter(|&[p, q]| kept[q].contains(&p));
    Graph::new(pairs.map(|pair| pair.map(|end| end as SampleId)))
}

#[test]
fn it_agrees_with_its_definition() {
    let mut edges = 0;
    for seed in 0..300 {
        let mut random = Random::new(seed + 3000);
        let count = 3 + (random.share() * 58.0) as usize;
        let mut points = scattered(count, seed + 3000);
        if seed % 3 == 1 {
            // A wavy curve with noise, which is thinned here and there.
            points = circle(count)
                .into_iter()
                .map(|place| place.map(|it| it * random.between(0.8, 1.0)))
                .collect();
        }
        if seed % 3 == 2 {
            points = circle(2 * count)[..count].to_vec();
            points.iter_mut().for_each(|place| place[1] += 1e-3 * random.share());
        }
        let set = triangulation(&points);
        let found = cocone(&set);
        assert_eq!(found, defined(set.samples().places()), "seed {seed}, {count} points");
        assert!(found.degrees(count).into_iter().all(|degree| degree <= 2));
        edges += found.edges().len();
    }
    assert!(edges > 3_000, "{edges}");
}

#[test]
fn a_voronoi_edge_that_is_a_point_meets_nothing() {
    // Twelve whole places on one circle, where the mesh has to choose diagonals.
    let quarter = [[5.0, 0.0], [4.0, 3.0], [3.0, 4.0]];
    let turned = |&[x, y]: &PlaceMm| [-y, x];
    let mut points: Vec<PlaceMm> = quarter.to_vec();
    for index in 0..9 {
        points.push(turned(&points[index]));
    }
    let set = triangulation(&points);
    assert_eq!(by_row(&cocone(&set), &set), closed(12));
    // Its middle has a cell of its own; the curve stays.
    points.push([0.0, 0.0]);
    let set = triangulation(&points);
    assert_eq!(by_row(&cocone(&set), &set), closed(12));
    for seed in 0..20 {
        let set = triangulation(&lattice(60, seed));
        let places = set.samples().places();
        let found = cocone(&set);
        assert!(found.degrees(set.len()).into_iter().all(|degree| degree <= 2));
        // A diagonal of a full square has no Voronoi edge.
        let whole = |place: PlaceMm| places.contains(&place);
        for &[p, q] in found.edges() {
            let [[px, py], [qx, qy]] = [p, q].map(|end| places[end as usize]);
            let is_diagonal = (px - qx).abs() == 1.0 && (py - qy).abs() == 1.0;
            assert!(!(is_diagonal && whole([px, qy]) && whole([qx, py])), "seed {seed}");
        }
    }
}

#[test]
fn repeated_points_and_nearly_straight_ones_change_nothing() {
    let mut points = circle(100);
    points.extend(circle(100));
    let set = triangulation(&points);
    assert_eq!(by_row(&cocone(&set), &set), closed(100));
    // Places near a line through rounding: circles wider than numbers, and none at all.
    for slope in [1.0 / 3.0, 0.7, 1e-3] {
        let points: Vec<PlaceMm> =
            (0..200).map(|step| f64::from(step) * 0.1).map(|x| [x, slope * x]).collect();
        let set = triangulation(&points);
        let path: Vec<[u32; 2]> = (0..199).map(|row| [row, row + 1]).collect();
        let found = by_row(&cocone(&set), &set);
        let missing = path.iter().filter(|edge| !found.contains(edge)).count();
        assert!(missing == 0 && found.len() <= 200, "{slope}: {missing} missing");
    }
}

#[test]
fn the_ends_of_a_bent_curve_are_joined() {
    // The poles of both ends lie along the curve: the mean of rays to both sides of it. So nothing tells the gap from an edge.
    let arc = circle(360)[..120].to_vec();
    let set = triangulation(&arc);
    assert_eq!(by_row(&cocone(&set), &set), closed(120));
}
