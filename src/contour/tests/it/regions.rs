//! Regions against their definitions, and on areas whose size is known.

mod areas;
mod definitions;
mod peeled;
mod steps;

use std::collections::BTreeSet;

use asphera_contour::{Kind, Method, Parameters, Part, PlaceMm, Region, SampleId, Triangulation};

use crate::places::{circle, distance, lattice, scattered, triangulation};

fn methods() -> impl Iterator<Item = Method> {
    Method::ALL.into_iter().filter(|method| method.kind() == Kind::Region)
}

pub(crate) fn region(method: Method, set: &Triangulation, parameters: &str) -> Region {
    method.region(set, &Parameters::parse(parameters).unwrap()).unwrap().unwrap()
}

/// Twice the signed area of places in order.
fn doubled_area(places: &[PlaceMm]) -> f64 {
    let next = places.iter().cycle().skip(1);
    places.iter().zip(next).map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum()
}

fn places(set: &Triangulation, line: &[SampleId]) -> Vec<PlaceMm> {
    line.iter().map(|&sample| set.place(sample)).collect()
}

/// Fails where the lines of a region are not what they promise.
fn check(set: &Triangulation, region: &Region, name: &str) {
    let mut sides = BTreeSet::new();
    let mut covered = BTreeSet::new();
    for part in region.parts() {
        let lines: Vec<&[SampleId]> = part.lines().collect();
        let mut area = 0.0;
        for (index, line) in lines.iter().enumerate() {
            assert!(line.len() >= 3, "{name}");
            assert_eq!(
                line.iter().collect::<BTreeSet<_>>().len(),
                line.len(),
                "{name}: a sample twice"
            );
            assert_eq!(line.iter().min(), line.first(), "{name}");
            let doubled = doubled_area(&places(set, line));
            assert_eq!(doubled > 0.0, index == 0, "{name}: {doubled}");
            area += 0.5 * doubled_area(&part.lines_mm(set.samples())[index]);
            for (&p, &q) in line.iter().zip(line.iter().cycle().skip(1)) {
                assert!(sides.insert([p, q]), "{name}: a side twice");
                assert!(region.border().joins(p, q), "{name}: a side that is no border");
            }
            covered.extend(line.iter().copied());
        }
        let reported = part.area_mm2(set.samples());
        assert!((reported - area).abs() < 1e-9 * reported.max(1.0), "{name}: {reported} {area}");
        assert!(reported > 0.0 && part.perimeter_mm(set.samples()) > 0.0);
    }
    assert!(region.parts().is_sorted_by(|a, b| a.outline < b.outline));
    assert!(region.left_out().iter().all(|sample| !covered.contains(sample)), "{name}");
}

#[test]
fn lines_are_simple_and_turn_as_they_promise() {
    for seed in 0..12 {
        for points in [scattered(120, seed), lattice(60, seed), scattered(5, seed), circle(40)] {
            let set = triangulation(&points);
            for method in methods() {
                let found = region(method, &set, "");
                check(&set, &found, method.name());
                // The border of the region is its lines, but where curves that enclose nothing are part of it.
                let sides: usize =
                    found.parts().iter().flat_map(Part::lines).map(<[SampleId]>::len).sum();
                if !matches!(method, Method::Ct | Method::Discern) {
                    assert_eq!(found.border().edges().len(), sides, "{}", method.name());
                }
            }
            for alpha in ["alpha_mm=0.3", "alpha_mm=0.5", "alpha_mm=0.8", "alpha_mm=1.1"] {
                check(&set, &region(Method::Alpha, &set, alpha), alpha);
            }
            for holes in [Method::Rgg, Method::Ec] {
                check(&set, &region(holes, &set, "holes=true"), holes.name());
            }
        }
    }
}

/// Two squares that share a corner are two parts; a hole that touches the outline in a corner stays a hole.
#[test]
fn parts_and_holes_that_touch_in_a_place_stay_apart() {
    let raster = |cells: &[[i32; 2]]| {
        let corners =
            cells.iter().flat_map(|&[x, y]| [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]]);
        // The middle of each cell makes its triangles smaller than those of cells that are not there.
        let middles = cells.iter().map(|&[x, y]| [f64::from(x) + 0.5, f64::from(y) + 0.5]);
        corners.map(|place| place.map(f64::from)).chain(middles).collect::<Vec<PlaceMm>>()
    };
    let set = triangulation(&raster(&[[0, 0], [1, 1]]));
    let found = region(Method::Alpha, &set, "alpha_mm=0.6");
    assert_eq!(found.parts().len(), 2);
    assert!((found.area_mm2(set.samples()) - 2.0).abs() < 1e-12);
    // A ring of cells whose hole [1, 1] and a missing corner cell [2, 2] touch in (2, 2).
    let ring = [[0, 0], [1, 0], [2, 0], [0, 1], [2, 1], [0, 2], [1, 2]];
    let set = triangulation(&raster(&ring));
    let found = region(Method::Alpha, &set, "alpha_mm=0.6");
    check(&set, &found, "ring");
    assert_eq!(found.parts().len(), 1);
    let part = &found.parts()[0];
    assert_eq!((part.outline.len(), part.holes.len(), part.holes[0].len()), (12, 1, 4));
    assert!((part.area_mm2(set.samples()) - 7.0).abs() < 1e-12);
    assert!((part.perimeter_mm(set.samples()) - 16.0).abs() < 1e-12);
}

#[test]
fn too_few_points_and_points_on_a_line_have_no_area() {
    let line: Vec<PlaceMm> =
        (0..9).map(|step| [f64::from(step), 2.0 * f64::from(step * step % 7)]).collect();
    let on_line: Vec<PlaceMm> = line.iter().map(|&[x, _]| [x, 0.5 * x]).collect();
    for points in
        [&[][..], &[[1.0, 2.0]], &[[1.0, 2.0], [3.0, 2.0]], &[[1.0, 2.0], [1.0, 2.0]], &on_line]
    {
        let set = triangulation(points);
        for method in methods() {
            let found = region(method, &set, "");
            assert!(found.parts().is_empty(), "{}", method.name());
            assert_eq!(found.area_mm2(set.samples()), 0.0);
        }
    }
}

/// Whether a method asks for lines that are wide against their spacing, or for hints.
fn closes_gaps(method: &Method) -> bool {
    matches!(method, Method::TriangleGrowing | Method::DelaunayPainting | Method::ColourByNumbers)
}

#[test]
fn one_triangle_and_one_square() {
    let triangle = triangulation(&[[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]]);
    let square = triangulation(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let area = |method, set| region(method, set, "").area_mm2(set.samples());
    for method in methods().filter(|method| !closes_gaps(method) && *method != Method::Auto) {
        // Three points are samples of a border, and HNN-Crust leaves their longest side open.
        let expected = if method == Method::Discern { 0.0 } else { 6.0 };
        let found = area(method, &triangle);
        assert!((found - expected).abs() < 1e-12, "{} {found}", method.name());
        let found = area(method, &square);
        assert!((found - 1.0).abs() < 1e-12, "{} {found}", method.name());
        assert_eq!(region(method, &square, "").border().edges().len(), 4, "{}", method.name());
    }
    let curve = Method::HnnCrust.run(&triangle, &Parameters::new()).unwrap();
    assert_eq!(region(Method::Discern, &triangle, "").border(), &curve);
    // Few samples: moved by 0.32 of the median edge of 4 mm.
    let moved = region(Method::Auto, &triangle, "").parts()[0].moved_mm;
    assert!((moved - 4.0 * 0.32).abs() < 1e-12, "{moved}");
}

/// Sides of a rectangle of samples moved by a known length: corners are mitred.
#[test]
fn a_moved_border_lies_beside_the_samples() {
    let raster = (0..121).map(|index| [f64::from(index % 11) - 5.0, f64::from(index / 11) - 5.0]);
    // A hole of 6 by 6 cells but for its corners.
    let raster: Vec<PlaceMm> = raster.filter(|[x, y]| x.abs() > 2.0 || y.abs() > 2.0).collect();
    let set = triangulation(&raster);
    let found = region(Method::Auto, &set, "");
    check(&set, &found, "auto");
    let [part] = found.parts() else { panic!("{} parts", found.parts().len()) };
    // The median edge is 1 mm.
    let by_mm = part.moved_mm;
    assert!((by_mm - 0.32).abs() < 1e-12 && part.holes.len() == 1, "{by_mm}");
    let lines = part.lines_mm(set.samples());
    let low = lines[0].iter().fold([0.0_f64; 2], |low, p| [low[0].min(p[0]), low[1].min(p[1])]);
    assert_eq!(low, [-5.0 - by_mm, -5.0 - by_mm]);
    let side = 10.0 + 2.0 * by_mm;
    assert!((0.5 * doubled_area(&lines[0]) - side * side).abs() < 1e-12);
    // The hole shrinks by as much all round.
    let own = 0.5 * doubled_area(&places(&set, &part.holes[0]));
    let moved = 0.5 * doubled_area(&lines[1]);
    let round = |line: &[PlaceMm]| -> f64 {
        line.iter().zip(line.iter().cycle().skip(1)).map(|(p, q)| distance(*p, *q)).sum()
    };
    let between = 0.5 * by_mm * (round(&places(&set, &part.holes[0])) + round(&lines[1]));
    assert!((moved - own - between).abs() < 1e-12, "{moved} {own} {between}");
    assert!((part.perimeter_mm(set.samples()) - round(&lines[0]) - round(&lines[1])).abs() < 1e-12);
}

/// A border that was sampled on its own, denser than what it encloses, stays where its samples are.
#[test]
fn a_sampled_border_is_not_moved() {
    let mut points = circle(200);
    points.extend(
        scattered(1500, 4)
            .iter()
            .map(|[x, y]| [x - 5.0, y - 5.0])
            .filter(|place| distance(*place, [0.0, 0.0]) < 4.9),
    );
    let set = triangulation(&points);
    let found = region(Method::Auto, &set, "");
    assert_eq!(found.parts()[0].moved_mm, 0.0);
    assert_eq!(found.border().edges().len(), 200);
    let bare = triangulation(&points[200..]);
    assert!(region(Method::Auto, &bare, "").parts()[0].moved_mm > 0.0);
}

#[test]
fn far_offsets_lose_nothing() {
    let near: Vec<PlaceMm> = scattered(300, 9)
        .into_iter()
        .map(|place| place.map(|value| (value * 4096.0).round() / 4096.0))
        .collect();
    let far: Vec<PlaceMm> = near.iter().map(|[x, y]| [x + 3e11, y - 2e11]).collect();
    for method in methods() {
        let [here, there] = [&near, &far].map(|points| {
            let set = triangulation(points);
            let found = region(method, &set, "");
            let area = found.area_mm2(set.samples());
            (found.parts().to_vec(), area)
        });
        assert_eq!(here, there, "{}", method.name());
    }
}

/// Found by a fuzzer: the square of this distance is zero.
#[test]
fn places_next_to_each_other_have_an_area_that_is_a_number() {
    let near = 3.226847045216294e-39;
    let points = [[999_999.0, -1.0], [1e6, 0.0], [1e6, near], [1_000_003.0, 3.0]];
    let found = region(Method::Auto, &triangulation(&points), "");
    assert!(found.area_mm2(triangulation(&points).samples()).is_finite());
}
