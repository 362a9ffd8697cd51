//! The CT-shape: edges between triangles that lie alike go in one pass.

use asphera_geometry::predicates::scalar_product;

use super::{doubled_area_mm2, radius_mm};
use crate::triangulation::{EdgeId, TriangleId};
use crate::{Graph, Region, SampleId, Triangulation};

/// The CT-shape: the border of dot patterns, or the curve that border samples are of.
///
/// 1. An edge is marked if the centres of its two triangles' circles lie on one side of it, one on the hull if the centre lies beyond.
/// 2. So are the two longer sides of a triangle without an obtuse angle whose shortest side is shorter than the distance between the
///    centres of its circumcircle and its incircle.
/// 3. The marks of a triangle are taken back, if none lies on the hull and each is the only one of the triangle beyond.
/// 4. The border is made of the sides without a mark of triangles with one, and the hull sides without a mark. A sample with more than two
///    keeps its two shortest. Then what leads to an end goes.
///
/// The region is what the border encloses. Proven for r-samples (see [`super::ec_shape`]). S. B. Thayyil, A. D. Parakkat, R.
/// Muthuganapathy, Computer Aided Geometric Design (2020); as their public program works, that step 4 is done at all samples at once
/// is our choice. Obtuse angles are decided exactly, step 2 in doubles. Linear time but for the order of lengths.
pub fn ct_shape(triangulation: &Triangulation) -> Region {
    let marks = without_lonely(triangulation, &marked(triangulation));
    let is_marked = |triangle: TriangleId| {
        triangulation.sides(triangle).into_iter().any(|side| marks[side as usize])
    };
    let is_border: Vec<bool> = (0..)
        .zip(triangulation.edges())
        .map(|(edge, sides): (EdgeId, _)| {
            let is_open = sides.triangles.contains(&None)
                || sides.triangles.into_iter().flatten().any(is_marked);
            !marks[edge as usize] && is_open && !triangulation.triangles().is_empty()
        })
        .collect();
    let two_shortest = shortest_two(triangulation, &is_border);
    let border = Graph::of_edges(triangulation, |edge| {
        is_border[edge as usize]
            && triangulation
                .ends(edge)
                .iter()
                .all(|&end| two_shortest[end as usize].contains(&Some(edge)))
    });
    Region::enclosed(triangulation, without_ends(triangulation.len(), border))
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

/// A graph of at most two edges at a sample, without what leads to an end: its closed lines.
fn without_ends(samples: usize, graph: Graph) -> Graph {
    let closed = graph.chains(samples).into_iter().filter(|chain| chain.closed);
    Graph::new(closed.flat_map(|chain| {
        let next = chain.samples[1..].iter().chain(chain.samples.first());
        chain.samples.iter().zip(next).map(|(&p, &q)| [p, q]).collect::<Vec<[SampleId; 2]>>()
    }))
}
