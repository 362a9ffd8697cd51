//! Ball pivoting and sculpting against their definitions.

use asphera_contour::curves::{ball_pivoting, connect2d, pivoting_radii_mm};
use asphera_contour::regions::{alpha_curve, sculpting};
use asphera_contour::{Graph, PlaceMm, SampleId, Triangulation};

use crate::places::{by_row, circle, closed, distance, lattice, scattered, triangulation};

/// The cycles of samples that a disc rolls along, by search over all samples: from each directed edge that it rests on, on the left, it
/// turns clockwise about the second end and meets the sample of the least turn.
fn rolled_by_search(at: &[PlaceMm], radius: f64) -> Vec<([usize; 2], [usize; 2])> {
    let centre = |p: usize, q: usize| {
        let half = 0.5 * distance(at[p], at[q]);
        let high = (radius * radius - half * half).sqrt();
        let [ux, uy] = [(at[q][0] - at[p][0]) / (2.0 * half), (at[q][1] - at[p][1]) / (2.0 * half)];
        [0.5 * (at[p][0] + at[q][0]) - high * uy, 0.5 * (at[p][1] + at[q][1]) + high * ux]
    };
    let rests = |p: usize, q: usize| {
        let middle = centre(p, q);
        let is_out = |s: usize| s == p || s == q || distance(at[s], middle) > radius;
        middle[0].is_finite() && (0..at.len()).all(is_out)
    };
    let pairs = (0..at.len()).flat_map(|p| (0..at.len()).map(move |q| (p, q)));
    let resting: Vec<(usize, usize)> = pairs.filter(|&(p, q)| p != q && rests(p, q)).collect();
    let next = |&(p, q): &(usize, usize)| {
        let angle = |c: PlaceMm| (c[1] - at[q][1]).atan2(c[0] - at[q][0]);
        let start = angle(centre(p, q));
        let turn = |s: usize| (start - angle(centre(q, s))).rem_euclid(std::f64::consts::TAU);
        let met = resting.iter().filter(|way| way.0 == q).map(|way| way.1);
        let met = met.min_by(|&a, &b| turn(a).total_cmp(&turn(b))).unwrap();
        ([p, q], [q, met])
    };
    resting.iter().map(next).collect()
}

/// The edges that one radius joins, all samples searched, where no sample of the discs' edges has more than two.
#[test]
fn a_disc_rolls_as_a_search_over_all_samples_finds() {
    let mut simple = 0;
    for seed in 0..60 {
        let set = triangulation(&scattered(40, seed + 700));
        let places = set.samples().places();
        for radius in [0.4, 0.8, 1.5, 4.0] {
            let ways = rolled_by_search(places, radius);
            let edges = ways.iter().map(|(way, _)| way.map(|end| end as SampleId));
            let all = Graph::new(edges);
            assert_eq!(all, alpha_curve(&set, radius), "seed {seed}, radius {radius}");
            let found = ball_pivoting(&set, &[radius]);
            assert!(found.is_part_of(&all));
            let degrees = found.degrees(set.len());
            assert!(degrees.iter().all(|&degree| degree <= 2));
            if all.degrees(set.len()).iter().all(|&degree| degree <= 2) {
                simple += 1;
                assert_eq!(found, all, "seed {seed}, radius {radius}");
            }
            // An end is where the disc comes back, or meets a sample that has two edges.
            for end in found.ends(set.len()) {
                let goes_on = ways.iter().any(|&([p, q], [_, to])| {
                    q == end as usize
                        && found.joins(p as SampleId, q as SampleId)
                        && to != p
                        && degrees[to] < 2
                });
                assert!(!goes_on, "seed {seed}, radius {radius}, end {end}");
            }
        }
    }
    assert!(simple > 20, "{simple} sets have no branches");
}

#[test]
fn larger_discs_go_on_where_smaller_ones_end() {
    // A circle whose spacing grows elevenfold.
    let mut angle = 0.0_f64;
    let mut points = Vec::new();
    while angle < 6.0 {
        points.push([5.0 * angle.cos(), 5.0 * angle.sin()]);
        angle += 0.03 + 0.3 * (0.5 * angle).sin().powi(8);
    }
    let set = triangulation(&points);
    let radii = pivoting_radii_mm(&set);
    assert!(radii.len() > 1 && radii.windows(2).all(|pair| pair[1] == 2.0 * pair[0]));
    assert_eq!(by_row(&ball_pivoting(&set, &radii), &set), closed(points.len()));
    let first = ball_pivoting(&set, &radii[..1]);
    assert!(first.edges().len() < points.len() && !first.edges().is_empty());
    assert!(first.is_part_of(&ball_pivoting(&set, &radii)));
}

#[test]
fn discs_do_not_roll_over_gaps_wider_than_they_are() {
    let arc: Vec<PlaceMm> = circle(360)[..60].to_vec();
    let path: Vec<[u32; 2]> = (0..59).map(|row| [row, row + 1]).collect();
    let set = triangulation(&arc);
    assert_eq!(by_row(&ball_pivoting(&set, &pivoting_radii_mm(&set)), &set), path);
    assert!(ball_pivoting(&set, &[0.04]).edges().is_empty());
}

/// Height of a circumcircle beyond the side from the first to the second corner, by its centre.
fn height(places: [PlaceMm; 3]) -> f64 {
    let [a, b, c] = places;
    let [bx, by, cx, cy] = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]];
    let twice = 2.0 * (bx * cy - by * cx);
    let [b2, c2] = [bx * bx + by * by, cx * cx + cy * cy];
    let centre = [(cy * b2 - by * c2) / twice, (bx * c2 - cx * b2) / twice];
    let side = bx.hypot(by);
    // The centre's distance from the side, towards the apex.
    let along = (bx * centre[1] - by * centre[0]) / side * twice.signum();
    centre[0].hypot(centre[1]) - along
}

/// Sculpting by search over all triangles at every step.
fn sculpted_by_search(set: &Triangulation) -> Graph {
    let mut left: Vec<[SampleId; 3]> = set.triangles().to_vec();
    let border = |left: &[[SampleId; 3]]| {
        let sides = left.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let sides: Vec<[SampleId; 2]> = sides.collect();
        sides.iter().copied().filter(|&[p, q]| !sides.contains(&[q, p])).collect::<Vec<_>>()
    };
    loop {
        let sides = border(&left);
        let mut best: Option<(f64, usize)> = None;
        for (index, &[a, b, c]) in left.iter().enumerate() {
            for [p, q, apex] in [[a, b, c], [b, c, a], [c, a, b]] {
                let open =
                    [[a, b], [b, c], [c, a]].iter().filter(|side| sides.contains(side)).count();
                let is_inner = !sides.as_flattened().contains(&apex);
                if sides.contains(&[p, q]) && open == 1 && is_inner {
                    let high = height([p, q, apex].map(|end| set.place(end)));
                    if best.is_none_or(|best| high > best.0) {
                        best = Some((high, index));
                    }
                }
            }
        }
        let Some((_, index)) = best else { return Graph::new(sides) };
        left.remove(index);
    }
}

#[test]
fn sculpting_takes_the_triangle_whose_circle_stands_out_farthest() {
    for seed in 0..20 {
        let set = triangulation(&scattered(50, seed + 900));
        assert_eq!(sculpting(&set), sculpted_by_search(&set), "seed {seed}");
    }
}

#[test]
fn sculpting_leaves_one_closed_curve_through_nearly_all() {
    let mut alone = 0;
    for seed in 0..40 {
        let points = if seed % 2 == 0 { scattered(200, seed) } else { lattice(50, seed) };
        let set = triangulation(&points);
        let graph = sculpting(&set);
        let chains = graph.chains(set.len());
        assert!(chains.len() == 1 && chains[0].closed, "seed {seed}");
        assert!(graph.degrees(set.len()).iter().all(|&degree| degree == 0 || degree == 2));
        alone += graph.alone(set.len()).len();
    }
    println!("{alone} of about 5000 samples lie off the curve");
    assert!(alone < 500, "{alone}");
    // A clean wavy outline is the same as that of Connect2D.
    let wavy: Vec<PlaceMm> = (0..200)
        .map(|step| {
            let angle = f64::from(step) * std::f64::consts::TAU / 200.0;
            let radius = 10.0 + 2.0 * (5.0 * angle).cos();
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect();
    let set = triangulation(&wavy);
    assert_eq!(sculpting(&set), connect2d(&set));
    assert_eq!(by_row(&sculpting(&set), &set), closed(200));
}
