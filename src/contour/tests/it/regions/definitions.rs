//! α-shapes, the A-shape and the petal ratio over all triangles and all pairs.

use asphera_contour::regions::{
    Sampling, alpha_curve, alpha_shape, connecting_alpha_mm, joining_alpha_mm, petals,
};
use asphera_contour::{Graph, Method, PlaceMm, SampleId, Triangulation};

use super::region;
use crate::places::{by_row, circle, closed, distance, lattice, scattered, triangulation};

/// Whole coordinates of places that are multiples of 1/1000.
fn whole(set: &Triangulation, corners: [SampleId; 3]) -> [[i128; 2]; 3] {
    corners.map(|corner| set.place(corner).map(|value| (value * 1024.0).round() as i128))
}

/// Places that are whole multiples of 1/1024.
fn rounded(count: usize, seed: u64) -> Vec<PlaceMm> {
    let points = scattered(count, seed).into_iter();
    points.map(|place| place.map(|value| (value * 1024.0).round() / 1024.0)).collect()
}

/// Whether the circle through the corners has a radius of at most `alpha` / 1024 mm, in whole numbers.
fn is_within(set: &Triangulation, corners: [SampleId; 3], alpha: i128) -> bool {
    let [a, b, c] = whole(set, corners);
    let square = |p: [i128; 2], q: [i128; 2]| (p[0] - q[0]).pow(2) + (p[1] - q[1]).pow(2);
    let cross = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    square(a, b) * square(b, c) * square(c, a) <= 4 * alpha * alpha * cross * cross
}

#[test]
fn alpha_shapes_are_all_triangles_of_small_circles() {
    for seed in 0..10 {
        for points in [rounded(80, seed), lattice(50, seed)] {
            let set = triangulation(&points);
            for alpha in [300, 512, 724, 900, 1024, 1500] {
                let found = alpha_shape(&set, alpha as f64 / 1024.0);
                let kept: Vec<[SampleId; 3]> = set
                    .triangles()
                    .iter()
                    .copied()
                    .filter(|&corners| is_within(&set, corners, alpha))
                    .collect();
                let mut sides: Vec<[SampleId; 2]> = kept
                    .iter()
                    .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
                    .map(|[p, q]| [p.min(q), p.max(q)])
                    .collect();
                sides.sort_unstable();
                let once =
                    |side: &[SampleId; 2]| sides.iter().filter(|other| *other == side).count() == 1;
                let border = sides.iter().copied().filter(once).collect::<Vec<_>>();
                assert_eq!(found.border(), &Graph::new(border));
                let area: f64 = kept
                    .iter()
                    .map(|&corners| {
                        let [a, b, c] = whole(&set, corners);
                        ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) as f64
                    })
                    .sum::<f64>()
                    / (2.0 * 1024.0 * 1024.0);
                assert!((found.area_mm2(set.samples()) - area).abs() < 1e-9);
                let corners: Vec<SampleId> = kept.iter().flatten().copied().collect();
                let bare = (0..set.len() as SampleId).filter(|sample| !corners.contains(sample));
                assert_eq!(found.left_out(), bare.collect::<Vec<_>>());
            }
        }
    }
}

#[test]
fn alpha_curves_are_all_pairs_with_an_empty_disc() {
    for seed in 0..10 {
        let set = triangulation(&scattered(60, seed + 20));
        let at = set.samples().places();
        for alpha in [0.2, 0.5, 0.8, 1.5] {
            let is_edge = |p: usize, q: usize| {
                let length = distance(at[p], at[q]);
                if length > 2.0 * alpha {
                    return false;
                }
                let off = (alpha * alpha - 0.25 * length * length).sqrt() / length;
                [off, -off].into_iter().any(|off| {
                    let centre = [
                        0.5 * (at[p][0] + at[q][0]) - off * (at[q][1] - at[p][1]),
                        0.5 * (at[p][1] + at[q][1]) + off * (at[q][0] - at[p][0]),
                    ];
                    (0..at.len()).all(|x| x == p || x == q || distance(at[x], centre) >= alpha)
                })
            };
            let pairs = (0..at.len()).flat_map(|p| (p + 1..at.len()).map(move |q| (p, q)));
            let expected =
                pairs.filter(|&(p, q)| is_edge(p, q)).map(|(p, q)| [p as SampleId, q as SampleId]);
            assert_eq!(alpha_curve(&set, alpha), Graph::new(expected), "seed {seed} alpha {alpha}");
        }
    }
}

#[test]
fn the_connecting_alpha_is_the_smallest_of_all_radii() {
    for seed in 0..20 {
        let set = triangulation(&scattered(40, seed + 60));
        let mut radii: Vec<f64> = set
            .triangles()
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|corner| set.place(corner));
                let cross = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                distance(a, b) * distance(b, c) * distance(c, a) / (2.0 * cross)
            })
            .collect();
        radii.sort_by(f64::total_cmp);
        let is_whole = |&&radius: &&f64| {
            let found = alpha_shape(&set, radius * (1.0 + 1e-12));
            found.parts().len() == 1 && found.left_out().is_empty()
        };
        let expected = radii.iter().find(is_whole).unwrap();
        let found = connecting_alpha_mm(&set).unwrap();
        assert!((found / expected - 1.0).abs() < 1e-11, "seed {seed}: {found} {expected}");
    }
    // Points of one circle come together.
    let set = triangulation(&circle(30));
    assert!((connecting_alpha_mm(&set).unwrap() - 5.0).abs() < 1e-9);
    assert!(joining_alpha_mm(&set).unwrap() < 0.53 && joining_alpha_mm(&set).unwrap() > 0.52);
    assert_eq!(connecting_alpha_mm(&triangulation(&[[0.0, 0.0], [1.0, 1.0]])), None);
    assert_eq!(joining_alpha_mm(&triangulation(&[[0.0, 0.0]])), None);
}

#[test]
fn a_lower_t_of_the_a_shape_is_part_of_the_alpha_shape() {
    let mut smaller = 0;
    for seed in 0..10 {
        let set = triangulation(&scattered(200, seed + 400));
        for alpha in [0.6, 0.8, 1.1] {
            let shape = region(Method::A, &set, &format!("t=0,alpha_mm={alpha}"));
            let wide = alpha_shape(&set, alpha);
            let [small, large] = [&shape, &wide].map(|region| region.area_mm2(set.samples()));
            assert!(small <= large + 1e-9, "{small} {large}");
            smaller += usize::from(small < large - 1e-9);
        }
        // With all circles in the set nothing is left, with none the hull.
        assert!(region(Method::A, &set, "t=0,alpha_mm=1e-9").parts().is_empty());
        let hull = region(Method::Chi, &set, "lambda=1").area_mm2(set.samples());
        assert!(
            (region(Method::A, &set, "t=0,alpha_mm=1e12").area_mm2(set.samples()) - hull).abs()
                < 1e-9
        );
    }
    assert!(smaller > 0);
}

#[test]
fn petals_tell_an_area_from_its_border() {
    let raster: Vec<PlaceMm> = (0..900)
        .map(|index| [f64::from(index % 30), f64::from(index / 30)])
        .filter(|place| distance(*place, [14.5, 14.5]) < 12.0)
        .collect();
    let set = triangulation(&raster);
    assert_eq!(petals(&set), Sampling::Area);
    for method in [Method::Ct, Method::Discern] {
        let found = region(method, &set, "");
        assert_eq!(
            (found.parts().len(), found.parts()[0].holes.len()),
            (1, 0),
            "{}",
            method.name()
        );
        // The polygon through the samples of the rim leaves half a spacing of the disc out.
        let area = found.area_mm2(set.samples()) / (std::f64::consts::PI * 11.5 * 11.5);
        assert!((area - 1.0).abs() < 0.03, "{} {area}", method.name());
    }
    for count in [20, 100, 333] {
        let set = triangulation(&circle(count));
        assert_eq!(petals(&set), Sampling::Border);
        for method in [Method::Ct, Method::Discern] {
            assert_eq!(
                by_row(region(method, &set, "").border(), &set),
                closed(count),
                "{}",
                method.name()
            );
        }
    }
}

#[test]
fn an_outlier_of_a_dot_pattern_is_left_out() {
    let mut points: Vec<PlaceMm> =
        (0..100).map(|index| [f64::from(index % 10), f64::from(index / 10)]).collect();
    points.push([30.0, 4.0]);
    points.push([-20.0, 41.0]);
    let set = triangulation(&points);
    let found = region(Method::Discern, &set, "");
    let outliers = [101, 100].map(|row| set.samples().of_row(row));
    assert_eq!(found.left_out(), outliers);
    assert!((found.area_mm2(set.samples()) - 81.0).abs() < 1e-9);
}

/// Every triangle against every place of the set, found anew.
#[test]
fn a_shapes_are_all_triangles_whose_circle_holds_no_place_of_the_set() {
    for seed in 0..12 {
        let set = triangulation(&scattered(60, seed + 440));
        let mean = |sample: SampleId| {
            let ends =
                set.edges().iter().map(|edge| edge.ends).filter(|ends| ends.contains(&sample));
            let lengths: Vec<f64> =
                ends.map(|[p, q]| distance(set.place(p), set.place(q))).collect();
            lengths.iter().sum::<f64>() / lengths.len() as f64
        };
        let around: Vec<f64> = (0..set.len() as SampleId).map(mean).collect();
        let mut sorted = around.clone();
        sorted.sort_by(f64::total_cmp);
        let circle = |corners: &[SampleId; 3]| -> (PlaceMm, f64) {
            let [a, b, c] = corners.map(|corner| set.place(corner));
            let [b, c] = [b, c].map(|p| [p[0] - a[0], p[1] - a[1]]);
            let lift = |p: PlaceMm| p[0] * p[0] + p[1] * p[1];
            let twice = 2.0 * (b[0] * c[1] - b[1] * c[0]);
            let centre = [
                (c[1] * lift(b) - b[1] * lift(c)) / twice,
                (b[0] * lift(c) - c[0] * lift(b)) / twice,
            ];
            ([a[0] + centre[0], a[1] + centre[1]], centre[0].hypot(centre[1]))
        };
        for (alpha, t) in [(0.7, 0.0), (0.7, 0.5), (1.0, 1.0), (1.6, 0.3)] {
            let is_in_set = |corners: &&[SampleId; 3]| {
                let mean = corners.map(|corner| around[corner as usize]).iter().sum::<f64>() / 3.0;
                circle(corners).1 > alpha * (1.0 - t + t * mean / sorted[sorted.len() / 2])
            };
            let places: Vec<PlaceMm> =
                set.triangles().iter().filter(is_in_set).map(|corners| circle(corners).0).collect();
            let kept = set.triangles().iter().filter(|corners| {
                let (centre, radius) = circle(corners);
                places.iter().all(|place| distance(*place, centre) >= radius)
            });
            let mut border = Vec::new();
            for &[a, b, c] in kept {
                for [p, q] in [[a, b], [b, c], [c, a]] {
                    match border.iter().position(|&side| side == [q, p]) {
                        Some(index) => drop(border.swap_remove(index)),
                        None => border.push([p, q]),
                    }
                }
            }
            let found = region(Method::A, &set, &format!("alpha_mm={alpha},t={t}"));
            assert_eq!(found.border(), &Graph::new(border), "seed {seed} α {alpha} t {t}");
        }
    }
}
