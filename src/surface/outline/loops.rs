//! Closed lines made of the sides that have a triangle on the left only.
//!
//! Where such lines touch at a vertex, several sides lead away from it. The right one to go on with
//! bounds the same void: it is the first one counter-clockwise from the way back.
//!
//! ```text
//!          void            a side comes up from a to v, its triangles on the left, the void on the
//!     c         d          right. Turning counter-clockwise from a about v, the void ends at d,
//!      \  ///  /           where the triangles between c and d begin, and d it is. Going on to
//!    //  \   /             the other end of the triangles at a would join two voids in one line.
//!   /////  v    void
//!      /// |
//!     /////a
//! ```

use std::cmp::Ordering;

use asphera_geometry::predicates::orientation;
use asphera_geometry::{BoundsMm, PointMm, Sum, VertexId, place};

use crate::outline::Contour;

/// A closed line with its area, positive if it runs counter-clockwise.
#[derive(Clone)]
pub(crate) struct Loop {
    pub(crate) contour: Contour,
    pub(crate) signed_area_mm2: f64,
}

/// The closed lines of the sides of each group, with their group.
///
/// A side is the group it belongs to and its ends, the triangle on its left. Sides of different
/// groups are never joined.
pub(crate) fn loops(points: &[PointMm], sides: Vec<(usize, [VertexId; 2])>) -> Vec<(usize, Loop)> {
    let lines = followed(points, sides, |first| first).into_iter();
    lines.map(|(group, vertices)| (group, measured(points, vertices))).collect()
}

/// The closed lines of sides that each follow the border of one piece: where lines touch at a vertex they go
/// on along the same triangles, which is the last side counter-clockwise from the way back. They may pass a
/// vertex again.
pub(crate) fn walks(points: &[PointMm], sides: Vec<[VertexId; 2]>) -> Vec<Vec<VertexId>> {
    let sides = sides.into_iter().map(|side| (0, side)).collect();
    let lines = followed(points, sides, Ordering::reverse).into_iter();
    lines.map(|(_, vertices)| vertices).collect()
}

/// The closed lines that go on, where several sides lead on, along the least in an order: that in which they
/// are met turning counter-clockwise from the way back, as `order` changes it.
fn followed(
    points: &[PointMm],
    mut sides: Vec<(usize, [VertexId; 2])>,
    order: impl Fn(Ordering) -> Ordering,
) -> Vec<(usize, Vec<VertexId>)> {
    sides.sort_unstable();
    let mut used = vec![false; sides.len()];
    let mut found = Vec::new();
    for first in 0..sides.len() {
        let mut vertices = Vec::new();
        let mut next = Some(first);
        while let Some(index) = next.filter(|&index| !used[index]) {
            used[index] = true;
            let (group, [from, to]) = sides[index];
            vertices.push(from);
            let start = sides.partition_point(|&(other, [start, _])| (other, start) < (group, to));
            let away = (start..sides.len())
                .take_while(|&other| sides[other].0 == group && sides[other].1[0] == to);
            let at = |vertex: VertexId| place(points[vertex as usize]);
            next = away.min_by(|&left, &right| {
                let [left, right] = [left, right].map(|side| at(sides[side].1[1]));
                order(turning(at(to), at(from), left, right))
            });
        }
        if !vertices.is_empty() {
            found.push((sides[first].0, vertices));
        }
    }
    found
}

/// Which of two places is met first, turning counter-clockwise about `centre` from `start`.
fn turning(centre: [f64; 2], start: [f64; 2], left: [f64; 2], right: [f64; 2]) -> Ordering {
    // 0 for the first half turn, 1 for the straight line, 2 for the second half.
    let half = |p: [f64; 2]| match orientation(centre, start, p) {
        Ordering::Greater => 0,
        Ordering::Equal => 1,
        Ordering::Less => 2,
    };
    half(left).cmp(&half(right)).then_with(|| orientation(centre, left, right).reverse())
}

fn measured(points: &[PointMm], mut vertices: Vec<VertexId>) -> Loop {
    let at = |vertex: VertexId| place(points[vertex as usize]);
    let first = (0..vertices.len())
        .min_by(|&i, &j| {
            let [p, q] = [i, j].map(|i| at(vertices[i]));
            p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1]))
        })
        .expect("a closed line has vertices");
    vertices.rotate_left(first);
    let [x0, y0] = at(vertices[0]);
    let (mut twice, mut perimeter) = (Sum::default(), Sum::default());
    for (index, &vertex) in vertices.iter().enumerate() {
        let [x, y] = at(vertex);
        let [to_x, to_y] = at(vertices[(index + 1) % vertices.len()]);
        twice.add((x - x0) * (to_y - y0));
        twice.add(-(y - y0) * (to_x - x0));
        perimeter.add((to_x - x).hypot(to_y - y));
    }
    let BoundsMm { low: min_mm, high: max_mm } =
        BoundsMm::about(vertices.iter().map(|&vertex| at(vertex)));
    let signed_area_mm2 = 0.5 * twice.total();
    let area_mm2 = signed_area_mm2.abs();
    let contour = Contour { vertices, area_mm2, perimeter_mm: perimeter.total(), min_mm, max_mm };
    Loop { contour, signed_area_mm2 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_of_turning() {
        let [east, north, west, south] = [[1.0, 0.0], [0.0, 2.0], [-3.0, 0.0], [0.0, -1.0]];
        let mut places = [south, west, [5.0, 1.0], north, [5.0, -1.0], [-1.0, -1.0]];
        places.sort_by(|&p, &q| turning([0.0; 2], east, p, q));
        assert_eq!(places, [[5.0, 1.0], north, west, [-1.0, -1.0], south, [5.0, -1.0]]);
    }
}
