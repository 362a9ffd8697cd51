//! Regions against their definitions, and on areas whose size is known.

mod areas;
mod definitions;
mod peeled;

use std::collections::BTreeSet;

use asphera_contour::{Kind, Method, Parameters, Part, PlaceMm, Region, SampleId, Triangulation};

use crate::places::{circle, lattice, scattered, triangulation};

fn methods() -> impl Iterator<Item = Method> {
    Method::ALL.into_iter().filter(|method| method.kind() == Kind::Region)
}

fn region(method: Method, set: &Triangulation, parameters: &str) -> Region {
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
            area += 0.5 * doubled;
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

#[test]
fn one_triangle_and_one_square() {
    for method in methods() {
        let set = triangulation(&[[0.0, 0.0], [4.0, 0.0], [0.0, 3.0]]);
        let area_mm2 = region(method, &set, "").area_mm2(set.samples());
        // Of border samples HNN-Crust makes the curve, and no angle of a triangle is wide enough for it to go on.
        let expected = if method == Method::Discern { 0.0 } else { 6.0 };
        assert!((area_mm2 - expected).abs() < 1e-12, "{}", method.name());
        // The ends of the diagonal have longer edges than the other two corners: this one asks differently of each.
        if method == Method::A {
            continue;
        }
        let set = triangulation(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        let found = region(method, &set, "");
        assert!((found.area_mm2(set.samples()) - 1.0).abs() < 1e-12, "{}", method.name());
        assert_eq!(found.border().edges().len(), 4, "{}", method.name());
    }
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
