//! The EC-shape: triangles go where circles on their sides hold a sample.

use std::cmp::Reverse;

use asphera_geometry::predicates::scalar_product;

use super::doubled_area_mm2;
use super::peeling::{Ear, Peeling, Verdict};
use crate::triangulation::{EdgeId, TriangleId, distance_mm};
use crate::{PlaceMm, Region, SampleId, Triangulation};

/// The EC-shape: from the convex hull the longest side ab of the border goes with its triangle abc, again and again, where the removal is
/// regular and one of three circles holds a sample.
///
/// With L = v·|ab| the circles are: that of diameter L about the middle of ab, which must hold c; and for each of the sides xy = ac and bc,
/// with w the corner opposite in the triangle beyond, that of radius v·L/2 about the middle of xy, if xy is at least as long as L, or else
/// those of that radius through x and y, one of which must hold w. The region is one part that holds all samples. Proven with v = 1 of
/// r-samples: neighbours on the border at most 2r apart, samples within at least 2r.
///
/// With `holes` the largest triangle off the border begins a hole, which grows by the same circles with v = 1, the largest triangle first.
/// That is done until the next triangle touches a hole, or until a hole would have fewer than five sides; that one is not made. Of points
/// at random holes are found that are none. S. Methirumangalath, A. D. Parakkat, R. Muthuganapathy, Computers & Graphics 51 (2015) 90-97,
/// and of holes 2017; as their public program works. Right angles are decided exactly where v = 1, the circles in doubles. n·log n time.
///
/// # Panics
///
/// If v is not above 0 or not finite.
pub fn ec_shape(triangulation: &Triangulation, v: f64, holes: bool) -> Region {
    assert!(v.is_finite() && v > 0.0, "expected a finite v above 0, found {v}");
    let mut peeling = Peeling::new(triangulation);
    peeling.peel(
        peeling.hull(),
        |side, _| triangulation.length_class(side),
        |_, ear| verdict(triangulation, ear, v),
    );
    if holes {
        open_holes(triangulation, &mut peeling);
    }
    peeling.region()
}

fn open_holes(triangulation: &Triangulation, peeling: &mut Peeling) {
    let is_outer: Vec<bool> =
        (0..triangulation.len() as SampleId).map(|sample| peeling.is_on_border(sample)).collect();
    let area = |triangle: TriangleId| doubled_area_mm2(triangulation, triangle).to_bits();
    let corners = |triangle: TriangleId| triangulation.triangles()[triangle as usize];
    let mut seeds: Vec<TriangleId> = (0..triangulation.triangles().len() as TriangleId)
        .filter(|&triangle| peeling.holds(triangle))
        .filter(|&triangle| !corners(triangle).iter().any(|&corner| is_outer[corner as usize]))
        .collect();
    seeds.sort_by_key(|&triangle| (Reverse(area(triangle)), triangle));
    let mut was_on_border = is_outer;
    for seed in seeds.into_iter() {
        if !peeling.holds(seed) {
            continue;
        }
        if corners(seed).iter().any(|&corner| peeling.is_on_border(corner)) {
            return;
        }
        let before = peeling.removed();
        peeling.remove(seed);
        peeling.peel(
            triangulation.sides(seed),
            |_, triangle| area(triangle),
            |_, ear| verdict(triangulation, ear, 1.0),
        );
        // A triangle has three sides, and each that joins it adds one.
        if peeling.removed() - before + 2 <= 4 {
            peeling.restore(before, |sample| was_on_border[sample as usize]);
            return;
        }
        for &triangle in peeling.removed_after(before) {
            for corner in corners(triangle) {
                was_on_border[corner as usize] = true;
            }
        }
    }
}

/// Whether one of the circles of an ear holds a sample.
fn verdict(triangulation: &Triangulation, ear: Ear, v: f64) -> Verdict {
    let [a, b] = triangulation.ends_mm(ear.side);
    let c = triangulation.place(ear.apex);
    let length_mm = v * distance_mm(a, b);
    let holds_apex = match v == 1.0 {
        true => scalar_product(c, a, b).is_le(),
        false => distance_mm(c, middle(a, b)) <= 0.5 * length_mm,
    };
    let sides = triangulation.sides(ear.triangle).into_iter().filter(|&side| side != ear.side);
    let mut beyond = sides.filter_map(|side| Some((side, far(triangulation, ear.triangle, side)?)));
    let holds_far = |(side, w): (EdgeId, PlaceMm)| {
        let [x, y] = triangulation.ends_mm(side);
        let (side_mm, radius_mm) = (distance_mm(x, y), 0.5 * v * length_mm);
        if side_mm >= length_mm || 2.0 * radius_mm <= side_mm {
            return distance_mm(w, middle(x, y)) <= radius_mm;
        }
        let off = (radius_mm * radius_mm - 0.25 * side_mm * side_mm).sqrt() / side_mm;
        let [mx, my] = middle(x, y);
        [off, -off].into_iter().any(|off| {
            let centre = [mx - off * (y[1] - x[1]), my + off * (y[0] - x[0])];
            distance_mm(w, centre) <= radius_mm
        })
    };
    if holds_apex || beyond.any(holds_far) { Verdict::Go } else { Verdict::Stay }
}

/// The corner opposite a side in the triangle beyond it.
fn far(triangulation: &Triangulation, triangle: TriangleId, side: EdgeId) -> Option<PlaceMm> {
    let [left, right] = triangulation.edges()[side as usize].triangles();
    let [of_left, of_right] = triangulation.opposite(side);
    let corner = if left == Some(triangle) { right.and(of_right) } else { left.and(of_left) };
    corner.map(|corner| triangulation.place(corner))
}

fn middle(p: PlaceMm, q: PlaceMm) -> PlaceMm {
    [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]
}
