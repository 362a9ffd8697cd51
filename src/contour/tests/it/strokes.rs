//! Broken and repeated lines: regions, gaps, labels and middle lines.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use asphera_contour::strokes::{
    Hint, HintError, Strokes, beziers_of, closing_gap_mm, colour_by_numbers, delaunay_painting,
    hints_of, triangle_growing,
};
use asphera_contour::{Method, MethodError, Parameters, PlaceMm, Triangulation};

use crate::places::{circle, distance, lattice, scattered, triangulation};

/// Points of a circle about the origin, without those between two angles in degrees.
fn broken(radius: f64, count: usize, gap_deg: [f64; 2]) -> Vec<PlaceMm> {
    let angle = |index: usize| 360.0 * index as f64 / count as f64;
    let there = (0..count).map(angle).filter(|at| !(gap_deg[0]..gap_deg[1]).contains(at));
    there
        .map(|at| at.to_radians().sin_cos())
        .map(|(sin, cos)| [radius * cos, radius * sin])
        .collect()
}

fn hints(text: &str) -> Vec<Hint> {
    hints_of(text).unwrap()
}

/// Area of the parts of a label.
fn area(found: &Strokes, set: &Triangulation, label: &str) -> f64 {
    let number = found.labels.iter().position(|it| it == label).unwrap() as u32 + 1;
    let parts = found.region.parts().iter().filter(|part| part.label == number);
    parts.map(|part| part.area_mm2(set.samples())).sum()
}

/// Two circles, the inner one broken over 0.56 mm, the outer one over 0.94 mm: hints close both, and both gaps are listed.
#[test]
fn hints_close_gaps_and_name_what_lies_between() {
    let lines = [broken(3.0, 200, [200.0, 210.0]), broken(5.0, 300, [40.0, 50.0])];
    let points = lines.concat();
    let set = triangulation(&points);
    let found =
        delaunay_painting(&set, &hints("0.01,0.02=hole; 4,0.03=ring; 9,0=air"), 0.0).unwrap();
    assert_eq!(found.labels, ["hole", "ring", "air"]);
    let [inner, outer] = lines.map(|line| {
        let next = line.iter().cycle().skip(1);
        let terms = line.iter().zip(next).map(|(p, q)| p[0] * q[1] - p[1] * q[0]);
        0.5 * terms.sum::<f64>()
    });
    assert!((area(&found, &set, "hole") - inner).abs() < 1e-9, "{}", area(&found, &set, "hole"));
    assert!((area(&found, &set, "ring") - (outer - inner)).abs() < 1e-9);
    let widths: Vec<f64> = found
        .gaps
        .iter()
        .map(|ends| ends.map(|end| set.place(end)))
        .map(|[p, q]| distance(p, q))
        .collect();
    assert_eq!(widths.len(), 2, "{widths:?}");
    // Five of 200 points lack, and eight of 300.
    assert!((widths[0] - 6.0 * (TAU * 6.0 / 400.0).sin()).abs() < 1e-9, "{widths:?}");
    assert!((widths[1] - 10.0 * (TAU * 9.0 / 600.0).sin()).abs() < 1e-9, "{widths:?}");
    // Both lines are closed, through all points.
    assert_eq!(found.lines.len(), 2);
    assert!(found.lines.iter().all(|line| line.closed));
    let places: usize = found.lines.iter().map(|line| line.places_mm.len()).sum();
    assert_eq!(places, set.len());
}

/// The label of every triangle is that of the strongest flow, by a search for the best way from every seed.
#[test]
fn labels_are_those_of_the_widest_way() {
    for seed in 0..20 {
        let set = triangulation(&scattered(40, seed + 800));
        let at = [[2.0, 2.1], [7.9, 3.0], [5.0, 8.2]];
        let given: Vec<Hint> = at
            .into_iter()
            .zip(["a", "b", "c"])
            .map(|(at_mm, label)| Hint { at_mm, label: label.to_owned() })
            .collect();
        let Ok(found) = delaunay_painting(&set, &given, 0.0) else { continue };
        let corners = set.triangles();
        let inside = |at: PlaceMm| {
            (0..corners.len()).find(|&triangle| {
                let [a, b, c] = corners[triangle].map(|corner| set.place(corner));
                let left = |p: PlaceMm, q: PlaceMm| {
                    (q[0] - p[0]) * (at[1] - p[1]) - (q[1] - p[1]) * (at[0] - p[0]) > 0.0
                };
                left(a, b) && left(b, c) && left(c, a)
            })
        };
        let beyond = corners.len();
        let sides: Vec<(usize, usize, f64)> = set
            .edges()
            .iter()
            .zip(0..)
            .map(|(edge, number)| {
                let [p, q] = edge.triangles().map(|it| it.map_or(beyond, |it| it as usize));
                (p, q, set.length_mm(number))
            })
            .collect();
        // Widest ways by relaxing all sides until nothing changes (Bellman, Ford).
        let flow = |from: usize| {
            let mut widest = vec![0.0_f64; beyond + 1];
            widest[from] = f64::INFINITY;
            loop {
                let before = widest.clone();
                for &(p, q, width) in &sides {
                    widest[p] = widest[p].max(widest[q].min(width));
                    widest[q] = widest[q].max(widest[p].min(width));
                }
                if widest == before {
                    return widest;
                }
            }
        };
        let seeds: Vec<usize> =
            [beyond].into_iter().chain(at.map(|at| inside(at).unwrap_or(beyond))).collect();
        if seeds.iter().collect::<BTreeSet<_>>().len() < 4 {
            continue;
        }
        let flows: Vec<Vec<f64>> = seeds.iter().map(|&seed| flow(seed)).collect();
        // Spread from the seeds across the longest side first (Prim): a label never passes another.
        let mut labels: Vec<Option<usize>> = vec![None; beyond + 1];
        for (label, &seed) in seeds.iter().enumerate() {
            labels[seed] = Some(label);
        }
        let crossing = |labels: &[Option<usize>]| {
            let across =
                sides.iter().filter(|(p, q, _)| labels[*p].is_some() != labels[*q].is_some());
            across.max_by(|a, b| a.2.total_cmp(&b.2)).copied()
        };
        while let Some((p, q, _)) = crossing(&labels) {
            let label = labels[p].or(labels[q]);
            (labels[p], labels[q]) = (label, label);
        }
        let mut areas = [0.0; 4];
        for triangle in 0..beyond {
            let label = labels[triangle].unwrap();
            let strongest = flows.iter().map(|flow| flow[triangle]).fold(0.0, f64::max);
            assert_eq!(flows[label][triangle], strongest);
            let [a, b, c] = corners[triangle].map(|corner| set.place(corner));
            let doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            areas[label] += 0.5 * doubled;
        }
        for (label, expected) in ["a", "b", "c"].into_iter().zip(&areas[1..]) {
            let found = area(&found, &set, label);
            assert!((found - expected).abs() < 1e-9, "seed {seed} {label}: {found} {expected}");
        }
    }
}

/// Three passes 20 µm apart along two nested outlines, one of them broken: two closed lines in the middle of the passes.
#[test]
fn several_passes_become_one_line_each() {
    let mut points = Vec::new();
    for (number, off) in [-0.02, 0.0, 0.02].into_iter().enumerate() {
        for (radius, count) in [(5.0, 700), (2.0, 280)] {
            let gap = if radius == 5.0 && number == 1 { [30.0, 33.0] } else { [0.0, 0.0] };
            let turn = 0.37 * number as f64 * 360.0 / count as f64;
            let pass = broken(radius + off, count, gap).into_iter().map(|[x, y]| {
                let (sin, cos) = turn.to_radians().sin_cos();
                [x * cos - y * sin, x * sin + y * cos]
            });
            points.extend(pass);
        }
    }
    let set = triangulation(&points);
    let gap_mm = closing_gap_mm(&set).unwrap();
    let grown = triangle_growing(&set, gap_mm, gap_mm);
    let numbered =
        colour_by_numbers(&set, &hints("0.013,0.02=in;3.5,0.03=between"), gap_mm).unwrap();
    for found in [&grown, &numbered] {
        assert_eq!(found.region.parts().len(), 2);
        assert_eq!(
            found.lines.len(),
            2,
            "{:?}",
            found.lines.iter().map(|l| (l.closed, l.places_mm.len())).collect::<Vec<_>>()
        );
        for line in &found.lines {
            assert!(line.closed);
            let radii = line.places_mm.iter().map(|[x, y]| x.hypot(*y));
            let radius =
                if line.places_mm[0][0].hypot(line.places_mm[0][1]) > 3.5 { 5.0 } else { 2.0 };
            let worst = radii.map(|it| (it - radius).abs()).fold(0.0, f64::max);
            assert!(worst < 0.012, "{radius}: {worst}");
            let curves = beziers_of(line, 0.012);
            assert!((3..40).contains(&curves.len()), "{}", curves.len());
            for curve in &curves {
                let off = (0..=10).map(|step| bezier(curve, f64::from(step) / 10.0));
                let off = off.map(|[x, y]| (x.hypot(y) - radius).abs());
                assert!(off.fold(0.0, f64::max) < 0.03);
            }
        }
    }
}

fn bezier([a, b, c, d]: &[PlaceMm; 4], t: f64) -> PlaceMm {
    let lerp = |p: PlaceMm, q: PlaceMm| [p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])];
    let [ab, bc, cd] = [lerp(*a, *b), lerp(*b, *c), lerp(*c, *d)];
    lerp(lerp(ab, bc), lerp(bc, cd))
}

/// The same circle with a gap that is closed, and one that is too wide.
#[test]
fn growing_closes_gaps_up_to_the_given_width() {
    let set = triangulation(&broken(5.0, 300, [40.0, 50.0]));
    let closed = triangle_growing(&set, 1.0, 1.0);
    assert_eq!(closed.region.parts().len(), 1);
    assert_eq!(closed.gaps.len(), 1);
    assert!(closed.lines.len() == 1 && closed.lines[0].closed);
    let open = triangle_growing(&set, 0.5, 0.5);
    assert!(open.region.parts().is_empty() && open.gaps.is_empty());
    // The line is there, and open.
    let shape: Vec<_> = open.lines.iter().map(|line| (line.closed, line.places_mm.len())).collect();
    assert!(shape.len() == 1 && !shape[0].0, "{shape:?}");
}

/// Hatching splits the disc for a fine brush; a broad one goes across.
#[test]
fn a_brush_crosses_hatching() {
    let mut points = circle(400);
    // Lines of points 0.1 mm apart each, every 0.4 mm, over the middle of the disc.
    for line in -2..=2 {
        points.extend((-20..=20).map(|step| [f64::from(line) * 0.4, f64::from(step) * 0.1 + 0.01]));
    }
    let set = triangulation(&points);
    let given = hints("3.5,0=disc; 0.2,0.05=hatch");
    let fine = delaunay_painting(&set, &given, 0.0).unwrap();
    let broad = delaunay_painting(&set, &given, 0.5).unwrap();
    let [of_fine, of_broad] = [&fine, &broad].map(|found| area(found, &set, "hatch"));
    // Part of one strip of 0.4 by 4 mm, or all four.
    assert!((0.3..1.7).contains(&of_fine), "{of_fine}");
    assert!((5.2..7.2).contains(&of_broad), "{of_broad}");
}

#[test]
fn laws_hold_with_hints() {
    for seed in 0..10 {
        let points = scattered(60, seed + 850);
        let given = hints("2.03,2.1=a; 7.9,3.01=b; 5.02,8.2=a");
        let turned: Vec<PlaceMm> = points.iter().map(|&[x, y]| [-y, x]).collect();
        let turned_hints: Vec<Hint> = given
            .iter()
            .map(|hint| Hint { at_mm: [-hint.at_mm[1], hint.at_mm[0]], label: hint.label.clone() })
            .collect();
        let mut back = points.clone();
        back.reverse();
        let sets = [&points, &turned, &back].map(|points| triangulation(points));
        let all = [&given, &turned_hints, &given];
        let found = [0, 1, 2].map(|it| delaunay_painting(&sets[it], all[it], 0.0));
        let [Ok(first), Ok(turned), Ok(reversed)] = found else { continue };
        assert_eq!(first, reversed);
        for label in ["a", "b"] {
            let areas = [area(&first, &sets[0], label), area(&turned, &sets[1], label)];
            assert!((areas[0] - areas[1]).abs() < 1e-9, "seed {seed}: {areas:?}");
        }
        assert_eq!(first.gaps.len(), turned.gaps.len());
    }
}

#[test]
fn rasters_lines_and_few_points_end() {
    for points in
        [vec![], vec![[1.0, 1.0]], (0..9).map(|it| [f64::from(it), 0.0]).collect(), lattice(60, 7)]
    {
        let set = triangulation(&points);
        for gap in [0.5, 1.2, 3.0] {
            let found = triangle_growing(&set, gap, 0.1);
            assert_eq!(
                found.labels.len(),
                found.region.parts().iter().map(|it| it.label).max().unwrap_or(0) as usize
            );
        }
        let found = delaunay_painting(&set, &hints("-99.5,-99.25=out"), 0.0).unwrap();
        assert_eq!(found.labels, ["out"]);
    }
    // A frame of two rows of lattice points is one stroke about one region.
    let frame: Vec<PlaceMm> = (0..20)
        .flat_map(|x| (0..20).map(move |y| [f64::from(x), f64::from(y)]))
        .filter(|place| place.iter().any(|&it| !(2.0..18.0).contains(&it)))
        .collect();
    let set = triangulation(&frame);
    let found = triangle_growing(&set, 1.5, 2.0);
    assert_eq!(found.region.parts().len(), 1);
    // A diagonal of 1.41 mm cuts each corner off.
    assert!((found.region.area_mm2(set.samples()) - (17.0 * 17.0 - 2.0)).abs() < 1e-9);
    assert!(found.lines.len() == 1 && found.lines[0].closed);
    for place in &found.lines[0].places_mm {
        let out = place.iter().map(|it| (it - 9.5).abs()).fold(0.0, f64::max);
        assert!((8.49..=9.01).contains(&out), "{place:?}");
    }
}

#[test]
fn hints_that_cannot_be_used_say_what_to_write() {
    let refused = |text: &str| hints_of(text).unwrap_err().to_string();
    assert_eq!(
        refused("1,2=a;3=b"),
        "hint 2: expected x,y=label with x and y in mm, found `3=b`; write hints as 1.5,2=hole;8,2=plate"
    );
    for text in ["1,2", "1,x=a", "1,2=", "NaN,1=a", "1,inf=a"] {
        assert!(matches!(hints_of(text), Err(HintError::NotAHint { number: 1, .. })), "{text}");
    }
    let set = triangulation(&circle(40));
    let refused = |text: &str| delaunay_painting(&set, &hints(text), 0.0).unwrap_err();
    assert_eq!(refused(""), HintError::None);
    assert!(matches!(refused("5,0=a"), HintError::OnLine { number: 1, .. }));
    let two = HintError::TwoLabels { number: 2, found: "b".to_owned(), expected: "a".to_owned() };
    assert_eq!(refused("9,0=a;-9,0=b"), two);
    let none = Method::ColourByNumbers.strokes(&set, &Parameters::new(), &[]).unwrap_err();
    assert_eq!(none, MethodError::Hints(HintError::None));
}
