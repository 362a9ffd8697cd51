//! Methods that peel, against the same rules applied to all triangles again and again.

use asphera_contour::{Method, PlaceMm, Region, SampleId, Triangulation};

use super::region;
use crate::places::{distance, lattice, scattered, triangulation};

/// What is left of the triangles when the ear of the largest key that a rule lets go is taken off, until there is none.
///
/// A rule is asked with what is left, a triangle, the ends of its side on the border and the corner opposite.
fn peeled(
    set: &Triangulation,
    key: impl Fn(usize, [SampleId; 2]) -> f64,
    rule: impl Fn(&[usize], usize, [SampleId; 2], SampleId) -> bool,
) -> Vec<usize> {
    let mut left: Vec<usize> = (0..set.triangles().len()).collect();
    let sides = |triangle: usize| {
        let [a, b, c] = set.triangles()[triangle];
        [([a, b], c), ([b, c], a), ([c, a], b)]
    };
    loop {
        let all: Vec<[SampleId; 2]> =
            left.iter().flat_map(|&triangle| sides(triangle)).map(|(side, _)| side).collect();
        let is_border = |side: [SampleId; 2]| !all.contains(&[side[1], side[0]]);
        let border: Vec<[SampleId; 2]> =
            all.iter().copied().filter(|&side| is_border(side)).collect();
        let ears = left.iter().filter_map(|&triangle| {
            let open: Vec<_> =
                sides(triangle).into_iter().filter(|&(side, _)| is_border(side)).collect();
            let &[(side, apex)] = &open[..] else { return None };
            let is_off = border.iter().all(|side| !side.contains(&apex));
            (is_off && rule(&left, triangle, side, apex)).then(|| (key(triangle, side), triangle))
        });
        let Some((_, next)) = ears.max_by(|a, b| a.0.total_cmp(&b.0)) else { return left };
        left.retain(|&triangle| triangle != next);
    }
}

fn area(set: &Triangulation, triangles: &[usize]) -> f64 {
    triangles
        .iter()
        .map(|&triangle| {
            let [a, b, c] = set.triangles()[triangle].map(|corner| set.place(corner));
            0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
        })
        .sum()
}

/// The same triangles: the same border and the same area.
fn assert_same(set: &Triangulation, found: &Region, expected: &[usize], name: &str) {
    let mut border: Vec<[SampleId; 2]> = Vec::new();
    for &triangle in expected {
        let [a, b, c] = set.triangles()[triangle];
        for [p, q] in [[a, b], [b, c], [c, a]] {
            let side = [p.min(q), p.max(q)];
            match border.iter().position(|other| *other == side) {
                Some(index) => drop(border.swap_remove(index)),
                None => border.push(side),
            }
        }
    }
    border.sort_unstable();
    assert_eq!(found.border().edges(), border, "{name}");
    let area = area(set, expected);
    assert!((found.area_mm2(set.samples()) - area).abs() < 1e-9, "{name}");
    assert!(found.left_out().is_empty() && found.parts().len() == 1, "{name}");
}

fn length(set: &Triangulation, side: [SampleId; 2]) -> f64 {
    distance(set.place(side[0]), set.place(side[1]))
}

#[test]
fn chi_shapes_lose_their_longest_sides() {
    for seed in 0..8 {
        let set = triangulation(&scattered(70, seed + 500));
        for limit in [0.0, 0.9, 1.4, 2.5] {
            let expected = peeled(
                &set,
                |_, side| length(&set, side),
                |_, _, side, _| length(&set, side) > limit,
            );
            let found = asphera_contour::regions::chi_shape(&set, limit);
            assert_same(&set, &found, &expected, "chi");
        }
    }
}

#[test]
fn simple_shapes_replace_a_side_by_two_shorter_ones() {
    for seed in 0..8 {
        let set = triangulation(&scattered(70, seed + 520));
        let nearest = |sample: SampleId| {
            let others = (0..set.len() as SampleId).filter(|&other| other != sample);
            others.map(|other| length(&set, [sample, other])).fold(f64::INFINITY, f64::min)
        };
        let rule = |_: &[usize], _: usize, side: [SampleId; 2], apex: SampleId| {
            let long = length(&set, side);
            side.iter().all(|&end| length(&set, [end, apex]) < long && long > 2.0 * nearest(end))
        };
        let expected = peeled(&set, |_, side| length(&set, side), rule);
        assert_same(&set, &region(Method::SimpleShape, &set, ""), &expected, "simple-shape");
    }
}

#[test]
fn the_shape_hull_loses_triangles_whose_centre_lies_outside() {
    for seed in 0..8 {
        let set = triangulation(&scattered(70, seed + 540));
        let corners = |triangle: usize| set.triangles()[triangle].map(|corner| set.place(corner));
        let centre = |triangle: usize| -> PlaceMm {
            let [a, b, c] = corners(triangle);
            let lift = |p: PlaceMm| (p[0] - a[0]).powi(2) + (p[1] - a[1]).powi(2);
            let twice = 2.0 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
            [
                a[0] + ((c[1] - a[1]) * lift(b) - (b[1] - a[1]) * lift(c)) / twice,
                a[1] + ((b[0] - a[0]) * lift(c) - (c[0] - a[0]) * lift(b)) / twice,
            ]
        };
        let holds = |triangle: usize, x: PlaceMm| {
            let [a, b, c] = corners(triangle);
            [[a, b], [b, c], [c, a]]
                .into_iter()
                .all(|[p, q]| (q[0] - p[0]) * (x[1] - p[1]) - (q[1] - p[1]) * (x[0] - p[0]) >= 0.0)
        };
        let rule = |left: &[usize], triangle: usize, _: [SampleId; 2], _: SampleId| {
            !left.iter().any(|&other| holds(other, centre(triangle)))
        };
        let radius = |triangle: usize| distance(centre(triangle), corners(triangle)[0]);
        let expected = peeled(&set, |triangle, _| radius(triangle), rule);
        assert_same(&set, &region(Method::Rgg, &set, ""), &expected, "rgg");
        // The graph is the triangles of that region.
        let graph = asphera_contour::regions::shape_hull_graph(&set);
        assert!(region(Method::Rgg, &set, "").border().is_part_of(&graph));
        assert_eq!(graph.edges().len(), set.len() + expected.len() - 1, "Euler");
    }
}

/// Whether one of the circles of a triangle's side holds a sample.
fn ec_rule(
    set: &Triangulation,
    v: f64,
) -> impl Fn(&[usize], usize, [SampleId; 2], SampleId) -> bool + '_ {
    let within =
        |centre: PlaceMm, x: SampleId, radius: f64| distance(set.place(x), centre) <= radius;
    let middle = |p: SampleId, q: SampleId| {
        let [p, q] = [p, q].map(|sample| set.place(sample));
        [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]
    };
    move |left, triangle, side, apex| {
        let long = v * length(set, side);
        let beyond = |x: SampleId, y: SampleId| {
            let other = left.iter().copied().find(|&other| {
                let corners = set.triangles()[other];
                other != triangle && corners.contains(&x) && corners.contains(&y)
            });
            let Some(other) = other else { return false };
            let mut corners = set.triangles()[other].into_iter();
            let w = corners.find(|corner| ![x, y].contains(corner)).unwrap();
            let (short, radius) = (length(set, [x, y]), 0.5 * v * long);
            if short >= long || short >= 2.0 * radius {
                return within(middle(x, y), w, radius);
            }
            let [p, q] = [x, y].map(|sample| set.place(sample));
            let up = (radius.powi(2) - (0.5 * short).powi(2)).sqrt();
            [up, -up].into_iter().any(|up| {
                let [mx, my] = middle(x, y);
                let normal = [(p[1] - q[1]) / short, (q[0] - p[0]) / short];
                within([mx + up * normal[0], my + up * normal[1]], w, radius)
            })
        };
        within(middle(side[0], side[1]), apex, 0.5 * long)
            || beyond(side[0], apex)
            || beyond(side[1], apex)
    }
}

#[test]
fn ec_shapes_lose_sides_whose_circles_are_not_empty() {
    for seed in 0..8 {
        let set = triangulation(&scattered(70, seed + 560));
        for v in [1.0, 0.9, 1.3] {
            let expected = peeled(&set, |_, side| length(&set, side), ec_rule(&set, v));
            let found = region(Method::Ec, &set, &format!("v={v}"));
            assert_same(&set, &found, &expected, "ec");
        }
    }
}

/// Holes of the EC-shape by their steps: each begins with the largest triangle that does not touch the outer border.
#[test]
fn ec_holes_begin_with_the_largest_triangle_and_end_where_holes_touch() {
    let mut holes = [0; 4];
    for seed in 0..24 {
        // A jittered raster with one or two openings.
        let jitter = scattered(144, seed + 600).into_iter().zip(0..);
        let points: Vec<PlaceMm> = jitter
            .map(|([u, v], index)| {
                [f64::from(index % 12) + 0.03 * (u - 5.0), f64::from(index / 12) + 0.03 * (v - 5.0)]
            })
            .filter(|place| distance(*place, [3.5, 3.5]) > 1.8)
            .filter(|place| seed % 2 == 0 || distance(*place, [8.0, 7.5]) > 1.6)
            .collect();
        let set = triangulation(&points);
        let outer = peeled(&set, |_, side| length(&set, side), ec_rule(&set, 1.0));
        let expected = with_holes(&set, &outer);
        let found = region(Method::Ec, &set, "holes=true");
        assert!(
            (found.area_mm2(set.samples()) - area(&set, &expected)).abs() < 1e-9,
            "seed {seed}"
        );
        holes[found.parts()[0].holes.len().min(3)] += 1;
    }
    assert!(holes[1] + holes[2] + holes[3] >= 20, "{holes:?}");
}

/// The ends of all sides of triangles that no other of them has, beside a triangle of them.
fn border_of(set: &Triangulation, triangles: &[usize]) -> Vec<[SampleId; 2]> {
    let sides = triangles.iter().flat_map(|&triangle| {
        let [a, b, c] = set.triangles()[triangle];
        [[a, b], [b, c], [c, a]]
    });
    let all: Vec<[SampleId; 2]> = sides.collect();
    all.iter().copied().filter(|&[p, q]| !all.contains(&[q, p])).collect()
}

fn with_holes(set: &Triangulation, outer: &[usize]) -> Vec<usize> {
    let touches = |border: &[[SampleId; 2]], triangle: usize| {
        let corners = set.triangles()[triangle];
        border.iter().flatten().any(|end| corners.contains(end))
    };
    let rim = border_of(set, outer);
    let mut seeds: Vec<usize> =
        outer.iter().copied().filter(|&triangle| !touches(&rim, triangle)).collect();
    seeds.sort_by(|&a, &b| area(set, &[b]).total_cmp(&area(set, &[a])));
    let mut left = outer.to_vec();
    for seed in seeds {
        if !left.contains(&seed) {
            continue;
        }
        if touches(&border_of(set, &left), seed) {
            return left;
        }
        let before = left.clone();
        left.retain(|&triangle| triangle != seed);
        let mut hole = vec![seed];
        loop {
            let border = border_of(set, &left);
            let ears = left.iter().copied().filter(|&triangle| {
                let [a, b, c] = set.triangles()[triangle];
                let sides = [([a, b], c), ([b, c], a), ([c, a], b)];
                let open: Vec<_> =
                    sides.into_iter().filter(|(side, _)| border.contains(side)).collect();
                let &[([p, q], apex)] = &open[..] else { return false };
                let is_of_hole = hole.iter().any(|&gone| {
                    let corners = set.triangles()[gone];
                    corners.contains(&p) && corners.contains(&q)
                });
                is_of_hole
                    && !border.iter().flatten().any(|&end| end == apex)
                    && ec_rule(set, 1.0)(&left, triangle, [p, q], apex)
            });
            let next = ears.max_by(|&a, &b| area(set, &[a]).total_cmp(&area(set, &[b])));
            let Some(next) = next else { break };
            left.retain(|&triangle| triangle != next);
            hole.push(next);
        }
        if hole.len() + 2 <= 4 {
            return before;
        }
    }
    left
}

/// One simple polygon that holds all samples, on rasters with their ties, too.
#[test]
fn what_is_peeled_stays_one_polygon() {
    for seed in 0..40 {
        let set = triangulation(&lattice(60, seed + 900));
        for method in [Method::Chi, Method::Rgg, Method::Ec, Method::SimpleShape] {
            for parameters in ["", if method == Method::Chi { "lambda=0" } else { "" }] {
                let found = region(method, &set, parameters);
                assert_eq!(found.parts().len(), 1, "{}", method.name());
                assert!(found.parts()[0].holes.is_empty() && found.left_out().is_empty());
            }
        }
    }
}
