//! The CT-shape: edges between triangles that lie alike go in one pass.

use asphera_geometry::predicates::scalar_product;

use super::ways::closed_ways;
use super::{doubled_area_mm2, radius_mm};
use crate::triangulation::{EdgeId, TriangleId};
use crate::{Graph, Region, SampleId, Triangulation};

/// The CT-shape: the border of dot patterns, or the curve that border samples are of.
///
/// 1. An edge is marked if the centres of its two triangles' circles lie on one side of it, one on the hull if the centre lies beyond.
/// 2. So are the two longer sides of a triangle without an obtuse angle whose shortest side is shorter than the distance between the
///    centres of its circumcircle and its incircle.
/// 3. The marks of a triangle are taken back, if none lies on the hull and each is the only one of the triangle beyond.
/// 4. The border is made of the sides without a mark of triangles with one, and the hull sides without a mark. What leads to an end goes. A
///    sample with more than two keeps its two shortest. Then what stays is on closed ways: each goes from sample to sample by a side that
///    the one it leaves keeps, and never straight back.
///
/// The region is what the border encloses. Proven for r-samples (see [`super::ec_shape`]). S. B. Thayyil, A. D. Parakkat, R.
/// Muthuganapathy, Computer Aided Geometric Design (2020), as their public program works. That takes those closed ways that a search
/// meets, and shows none of ten samples or fewer; here all count, whatever the order. Obtuse angles are decided exactly, step 2 in
/// doubles. Linear time but for the order of lengths.
pub fn ct_shape(triangulation: &Triangulation) -> Region {
    let marks = without_lonely(triangulation, &marked(triangulation));
    let is_marked = |triangle: TriangleId| {
        triangulation.sides(triangle).into_iter().any(|side| marks[side as usize])
    };
    let is_border: Vec<bool> = (0..)
        .zip(triangulation.edges())
        .map(|(edge, sides): (EdgeId, _)| {
            let is_open = sides.triangles().contains(&None)
                || sides.triangles().into_iter().flatten().any(is_marked);
            !marks[edge as usize] && is_open && !triangulation.triangles().is_empty()
        })
        .collect();
    let is_border = without_ends(triangulation, is_border);
    let kept = shortest_two(triangulation, &is_border);
    let step = |sample: SampleId, slot: usize| {
        let other = |edge: EdgeId| {
            triangulation.ends(edge).into_iter().find(|&end| end != sample).unwrap_or(sample)
        };
        kept[sample as usize][slot].map(other)
    };
    Region::enclosed(triangulation, Graph::new(closed_ways(triangulation.len(), step)))
}

/// Steps 1 and 2.
fn marked(triangulation: &Triangulation) -> Vec<bool> {
    let mut marks: Vec<bool> = (0..triangulation.edges().len() as EdgeId)
        .map(|edge| {
            let [p, q] = triangulation.ends_mm(edge);
            let apexes = triangulation.opposite(edge).into_iter().flatten();
            let mut places = apexes.map(|apex| triangulation.place(apex));
            places.any(|apex| scalar_product(apex, p, q).is_lt())
        })
        .collect();
    for triangle in 0..triangulation.triangles().len() as TriangleId {
        let corners = triangulation.triangles()[triangle as usize];
        let at = |corner: usize| triangulation.place(corners[corner % 3]);
        if (0..3).any(|corner| scalar_product(at(corner), at(corner + 1), at(corner + 2)).is_lt()) {
            continue;
        }
        let mut sides = triangulation.sides(triangle);
        sides.sort_unstable_by_key(|&side| (triangulation.length_class(side), side));
        let lengths = sides.map(|side| triangulation.length_mm(side));
        let outer_mm = radius_mm(triangulation, triangle);
        let inner_mm = doubled_area_mm2(triangulation, triangle) / lengths.iter().sum::<f64>();
        // L. Euler: the squared distance of the two centres.
        let apart_mm = (outer_mm * (outer_mm - 2.0 * inner_mm)).max(0.0).sqrt();
        if lengths[0] < apart_mm {
            marks[sides[1] as usize] = true;
            marks[sides[2] as usize] = true;
        }
    }
    marks
}

/// Step 3.
fn without_lonely(triangulation: &Triangulation, marks: &[bool]) -> Vec<bool> {
    let count = |triangle: TriangleId| {
        triangulation.sides(triangle).into_iter().filter(|&side| marks[side as usize]).count()
    };
    let mut left = marks.to_vec();
    for triangle in 0..triangulation.triangles().len() as TriangleId {
        let sides = triangulation.sides(triangle).into_iter().zip(triangulation.across(triangle));
        let mut marked = sides.filter(|&(side, _)| marks[side as usize]);
        if count(triangle) >= 1
            && marked.clone().all(|(_, beyond)| beyond.is_some_and(|beyond| count(beyond) == 1))
        {
            marked.by_ref().for_each(|(side, _)| left[side as usize] = false);
        }
    }
    left
}

/// The two shortest border edges of each sample.
fn shortest_two(triangulation: &Triangulation, is_border: &[bool]) -> Vec<[Option<EdgeId>; 2]> {
    let mut shortest = vec![[None; 2]; triangulation.len()];
    for &edge in triangulation.by_length().iter().filter(|&&edge| is_border[edge as usize]) {
        for end in triangulation.ends(edge) {
            let two: &mut [Option<EdgeId>; 2] = &mut shortest[end as usize];
            if let Some(free) = two.iter_mut().find(|free| free.is_none()) {
                *free = Some(edge);
            }
        }
    }
    shortest
}

/// Edges without those that lead to an end only.
fn without_ends(triangulation: &Triangulation, mut is_border: Vec<bool>) -> Vec<bool> {
    let of = |sample: SampleId| triangulation.spokes(sample).iter();
    let mut degree: Vec<usize> = (0..triangulation.len() as SampleId)
        .map(|sample| of(sample).filter(|spoke| is_border[spoke.edge as usize]).count())
        .collect();
    let mut ends: Vec<SampleId> =
        (0..).zip(&degree).filter(|it| *it.1 == 1).map(|it| it.0).collect();
    while let Some(end) = ends.pop() {
        // The last of its edges may have gone from the other end.
        let Some(spoke) = of(end).find(|spoke| is_border[spoke.edge as usize]) else { continue };
        is_border[spoke.edge as usize] = false;
        let to = spoke.to as usize;
        degree[to] -= 1;
        if degree[to] == 1 {
            ends.push(spoke.to);
        }
    }
    is_border
}
