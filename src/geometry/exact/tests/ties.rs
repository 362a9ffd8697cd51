//! The rule for ties: one triangulation of any places, and edges that give way.

use std::cmp::Ordering;

use proptest::prelude::*;

use super::{integer_orientation, near_place};
use crate::exact::*;
use crate::regressions::beside_source;

/// Of the two diagonals of a convex quadrilateral exactly one is Delaunay, and which does not
/// depend on where one starts: for all quadrilaterals of a small raster, many of them cocircular.
#[test]
fn one_diagonal_belongs() {
    for pitch in [1.0, 0.003, 1e-20] {
        let raster: Vec<Place> =
            (0..25).map(|i| near_place([i % 5, i / 5]).map(|x| x * pitch)).collect();
        let mut ties = 0;
        for code in 0..25_usize.pow(4) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|digit| raster[code / 25_usize.pow(digit) % 25]);
            let turns = [(a, b, c), (b, c, d), (c, d, a), (d, a, b)];
            if !turns.into_iter().all(|(p, q, r)| left_of(p, q, r)) {
                continue;
            }
            let from_b_to_d = encloses(a, b, c, d);
            for (p, q, r) in [(b, c, a), (c, a, b)] {
                assert_eq!(encloses(p, q, r, d), from_b_to_d);
            }
            assert_eq!(encloses(b, c, d, a), !from_b_to_d);
            assert_eq!(encloses(c, d, a, b), from_b_to_d);
            assert_eq!(encloses(d, a, b, c), !from_b_to_d);
            match in_circle(a, b, c, d) {
                Ordering::Equal => {
                    let last = [a, b, c, d].into_iter().max_by(|p, q| p.partial_cmp(q).unwrap());
                    assert_eq!(from_b_to_d, last == Some(a) || last == Some(c));
                    ties += 1;
                }
                sign => assert_eq!(from_b_to_d, sign == Ordering::Greater),
            }
        }
        assert!(ties > 500, "{ties} ties at pitch {pitch}");
    }
}

proptest! {
    #![proptest_config(beside_source())]

    /// Also where the circle holds parts of a raster, and other places lie inside and outside.
    #[test]
    fn any_places_have_one_triangulation(
        places in prop::collection::btree_set(prop::array::uniform2(-3_i64..=3), 3..14),
    ) {
        let places: Vec<[i64; 2]> = places.into_iter().collect();
        tiles_its_hull(&places, &triangulation(&places));
    }

    /// Cocircular polygons: any choice among the 108 whole places of a circle about the origin.
    #[test]
    fn cocircular_polygons_have_one_triangulation(
        chosen in prop::sample::subsequence(whole_circle(1105), 3..16),
        centre in prop::array::uniform2(-1_i64 << 40..1 << 40),
    ) {
        let mut places = chosen;
        for place in &mut places {
            *place = [place[0] + centre[0], place[1] + centre[1]];
        }
        let triangles = triangulation(&places);
        prop_assert_eq!(triangles.len(), places.len() - 2);
        tiles_its_hull(&places, &triangles);
    }

    #[test]
    fn a_line_is_left_of_one_of_its_senses(
        whole in prop::array::uniform3(prop::array::uniform2(-4_i64..=4)),
        scale in prop::sample::select(vec![1.0, 0.125, 1e6]),
    ) {
        let [a, b, p] = whole.map(|place| place.map(|count| count as f64 * scale));
        prop_assume!(a != b);
        let both = [outside_edge(a, b, p), outside_edge(b, a, p)];
        match integer_orientation(whole) {
            Ordering::Greater => prop_assert_eq!(both, [true, false]),
            Ordering::Less => prop_assert_eq!(both, [false, true]),
            Ordering::Equal => {
                // On the line, the ends are seen from between in opposite directions.
                let [a, b, p] = whole;
                let seen = (a[0] - p[0]) * (b[0] - p[0]) + (a[1] - p[1]) * (b[1] - p[1]);
                prop_assert_eq!(both, [seen < 0; 2]);
            }
        }
    }
}

#[test]
fn the_whole_circle_has_one_triangulation() {
    let places = whole_circle(1105);
    assert_eq!(places.len(), 108);
    let triangles = triangulation(&places);
    assert_eq!(triangles.len(), 106);
    tiles_its_hull(&places, &triangles);
}

#[test]
fn squares_are_cut_from_bottom_right_to_top_left() {
    // The top right corner is the last of every square.
    for first in [0, 1000, 333_333_333] {
        let place = |x: i32, y: i32| [first + x, first + y].map(|index| f64::from(index) * 0.003);
        let [a, b, c, d] = [place(0, 0), place(1, 0), place(1, 1), place(0, 1)];
        assert!(encloses(a, b, c, d) && encloses(c, d, a, b));
        assert!(!encloses(b, c, d, a) && !encloses(d, a, b, c));
    }
}

#[test]
fn an_edge_gives_way_to_what_lies_on_it_or_beyond() {
    let (a, b) = ([0.3, 0.1], [0.3, 0.7]);
    for y in [0.2, 0.1_f64.next_up(), 0.7_f64.next_down()] {
        assert!(outside_edge(a, b, [0.3, y]) && outside_edge(b, a, [0.3, y]));
    }
    for y in [0.1, 0.7, 0.1_f64.next_down(), 0.7_f64.next_up(), -5.0] {
        assert!(!outside_edge(a, b, [0.3, y]) && !outside_edge(b, a, [0.3, y]));
    }
    assert!(outside_edge(a, b, [0.3_f64.next_down(), 9.0]));
    assert!(!outside_edge(a, b, [0.3_f64.next_up(), 0.2]));
}

/// The places with whole coordinates at `radius` from the origin, counter-clockwise.
fn whole_circle(radius: i64) -> Vec<[i64; 2]> {
    let mut places: Vec<[i64; 2]> = (-radius..=radius)
        .flat_map(|x| {
            let y = (radius * radius - x * x).isqrt();
            [[x, y], [x, -y]].into_iter().filter(move |_| x * x + y * y == radius * radius)
        })
        .collect();
    places.sort_by(|p, q| {
        (p[1] as f64).atan2(p[0] as f64).total_cmp(&(q[1] as f64).atan2(q[0] as f64))
    });
    places.dedup();
    places
}

/// All counter-clockwise triangles that enclose no other place, by brute force.
fn triangulation(whole: &[[i64; 2]]) -> Vec<[usize; 3]> {
    let places: Vec<Place> = whole.iter().copied().map(near_place).collect();
    let empty = |[i, j, k]: [usize; 3]| {
        (0..places.len())
            .filter(|l| ![i, j, k].contains(l))
            .all(|l| !encloses(places[i], places[j], places[k], places[l]))
    };
    let mut triangles = Vec::new();
    for i in 0..places.len() {
        for j in i + 1..places.len() {
            for k in j + 1..places.len() {
                let corners = match integer_orientation([whole[i], whole[j], whole[k]]) {
                    Ordering::Greater => [i, j, k],
                    Ordering::Less => [j, i, k],
                    Ordering::Equal => continue,
                };
                if empty(corners) {
                    triangles.push(corners);
                }
            }
        }
    }
    triangles
}

/// Asserts that the triangles cover the convex hull of the places once: each edge has one triangle
/// on its left and one on its right, but for those that have no place on their right; the areas
/// add up to that of the hull; and Euler's relation holds. Places on one line have no triangles.
fn tiles_its_hull(whole: &[[i64; 2]], triangles: &[[usize; 3]]) {
    let all = |sign: Ordering, [i, j]: [usize; 2]| {
        whole.iter().all(|&p| integer_orientation([whole[i], whole[j], p]) != sign)
    };
    let mut sides: Vec<[usize; 2]> =
        triangles.iter().flat_map(|&[i, j, k]| [[i, j], [j, k], [k, i]]).collect();
    sides.sort_unstable();
    assert!(sides.windows(2).all(|pair| pair[0] != pair[1]), "two triangles on one side");
    let boundary: Vec<[usize; 2]> =
        sides.iter().copied().filter(|&[i, j]| !sides.contains(&[j, i])).collect();
    assert!(boundary.iter().all(|&edge| all(Ordering::Less, edge)), "a hole");
    if triangles.is_empty() {
        assert!(
            (2..whole.len()).all(|k| integer_orientation([whole[0], whole[1], whole[k]]).is_eq())
        );
        return;
    }
    // Every place is used, and the hull's places on the boundary are as many as its edges.
    assert_eq!(triangles.len() + 2 + boundary.len(), 2 * whole.len());
    let double_area = |corners: &[usize]| -> i128 {
        let mut area = 0;
        for (at, &i) in corners.iter().enumerate() {
            let [p, q] = [i, corners[(at + 1) % corners.len()]].map(|i| whole[i].map(i128::from));
            area += p[0] * q[1] - p[1] * q[0];
        }
        area
    };
    let of_triangles: i128 = triangles.iter().map(|corners| double_area(corners)).sum();
    assert_eq!(of_triangles, double_area(&hull(whole)));
}

/// The corners of the convex hull, by wrapping it (R. A. Jarvis, 1973).
fn hull(whole: &[[i64; 2]]) -> Vec<usize> {
    let first = (0..whole.len()).min_by_key(|&i| whole[i]).unwrap();
    let mut corners = vec![first];
    loop {
        let from = corners[corners.len() - 1];
        let squared = |i: usize| {
            let [x, y] = [0, 1].map(|axis| i128::from(whole[i][axis] - whole[from][axis]));
            x * x + y * y
        };
        let next = (0..whole.len())
            .filter(|&i| i != from)
            .reduce(|best, i| match integer_orientation([whole[from], whole[best], whole[i]]) {
                Ordering::Less => i,
                Ordering::Equal if squared(i) > squared(best) => i,
                _ => best,
            })
            .unwrap();
        if next == first {
            return corners;
        }
        corners.push(next);
    }
}
