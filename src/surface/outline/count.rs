//! How many islands and holes there are, told from their borders alone.
//!
//! A border has kept triangles on one side and dropped ones, or nothing, on the other. Joined to closed lines
//! that each follow one island (see `loops.rs`), and these cut where they pass a vertex twice, since there a hole
//! touches another line, the lines that run counter-clockwise are the outlines of islands and the others their
//! holes: as [`super::islands`] finds them by looking at all triangles.

use std::sync::atomic::{AtomicBool, Ordering};

use asphera_geometry::{PointMm, VertexId};
use rayon::prelude::*;

use super::loops::walks;
use crate::relief::sides;

/// How many islands and holes there are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IslandCounts {
    /// Pieces: triangles with a common side belong to one.
    pub islands: u64,
    /// Holes of all pieces.
    pub holes: u64,
    /// Area of the largest hole in mm², what lies in it included; none without a hole.
    pub hole_max_mm2: Option<f64>,
}

/// Counts the islands and holes of the triangles with a flag. `hull` are the vertices of the outline of all
/// triangles in order.
///
/// Takes a pass over the triangles; all else is in proportion to the borders.
pub(crate) fn island_counts(
    points: &[PointMm],
    triangles: &[[VertexId; 3]],
    keep: &[bool],
    hull: &[VertexId],
) -> IslandCounts {
    let borders = borders(points.len(), triangles, keep, hull);
    let mut counts = IslandCounts::default();
    for line in walks(points, borders) {
        for vertices in without_repeats(&line) {
            let signed_mm2 = signed_area_mm2(points, &vertices);
            if signed_mm2 > 0.0 {
                counts.islands += 1;
            } else {
                counts.holes += 1;
                let area_mm2 =
                    counts.hole_max_mm2.map_or(-signed_mm2, |most| most.max(-signed_mm2));
                counts.hole_max_mm2 = Some(area_mm2);
            }
        }
    }
    counts
}

/// The sides of kept triangles that no other kept one shares.
fn borders(
    points: usize,
    triangles: &[[VertexId; 3]],
    keep: &[bool],
    hull: &[VertexId],
) -> Vec<[VertexId; 2]> {
    let known: Vec<AtomicBool> = (0..points).map(|_| AtomicBool::new(false)).collect();
    triangles.par_iter().zip(keep).with_min_len(1 << 14).for_each(|(corners, &keep)| {
        if keep {
            corners.iter().for_each(|&c| known[c as usize].store(true, Ordering::Relaxed));
        }
    });
    let is_known = |vertex: VertexId| known[vertex as usize].load(Ordering::Relaxed);
    // Sides of dropped triangles between vertices of kept ones.
    let mut dropped: Vec<[VertexId; 2]> = triangles
        .iter()
        .zip(keep)
        .filter(|&(corners, &keep)| !keep && corners.iter().filter(|&&c| is_known(c)).count() > 1)
        .flat_map(|(&corners, _)| sides(corners))
        .filter(|side| side.iter().all(|&end| is_known(end)))
        .collect();
    dropped.sort_unstable();
    let mut outer: Vec<[VertexId; 2]> =
        hull.iter().zip(hull.iter().cycle().skip(1)).map(|(&p, &q)| [p, q]).collect();
    outer.sort_unstable();
    let is_in = |list: &[[VertexId; 2]], side: [VertexId; 2]| list.binary_search(&side).is_ok();
    let inner = dropped
        .iter()
        .copied()
        .filter(|&[p, q]| !is_in(&dropped, [q, p]) && !is_in(&outer, [p, q]))
        .map(|[p, q]| [q, p]);
    let along_hull = outer
        .iter()
        .copied()
        .filter(|&[p, q]| is_known(p) && is_known(q) && !is_in(&dropped, [p, q]));
    inner.chain(along_hull).collect()
}

/// A closed line cut where it passes a vertex again.
fn without_repeats(line: &[VertexId]) -> Vec<Vec<VertexId>> {
    let mut distinct = line.to_vec();
    distinct.sort_unstable();
    distinct.dedup();
    if distinct.len() == line.len() {
        return vec![line.to_vec()];
    }
    let number = |vertex: VertexId| distinct.partition_point(|&other| other < vertex);
    let mut at = vec![None; distinct.len()];
    let (mut found, mut open) = (Vec::new(), Vec::new());
    for &vertex in line {
        if let Some(begin) = at[number(vertex)] {
            let closed: Vec<VertexId> = open.drain(begin..).collect();
            closed.iter().for_each(|&vertex| at[number(vertex)] = None);
            found.push(closed);
        }
        at[number(vertex)] = Some(open.len());
        open.push(vertex);
    }
    found.push(open);
    found
}

/// The area a closed line encloses in the plane, positive if it runs counter-clockwise.
fn signed_area_mm2(points: &[PointMm], vertices: &[VertexId]) -> f64 {
    let at = |vertex: VertexId| points[vertex as usize];
    let [x, y, _] = at(vertices[0]);
    let pairs = vertices.iter().zip(vertices.iter().cycle().skip(1));
    let twice_mm2 = pairs.map(|(&p, &q)| {
        let ([px, py, _], [qx, qy, _]) = (at(p), at(q));
        (px - x) * (qy - y) - (py - y) * (qx - x)
    });
    0.5 * twice_mm2.sum::<f64>()
}

#[cfg(test)]
mod tests {
    use asphera_mesh::Mesh;
    use proptest::prelude::*;

    use super::*;
    use crate::outline::islands;
    use crate::regressions::beside_source;
    use crate::rim::{Outline, hull};

    fn by_looking_at_all(
        points: &[PointMm],
        triangles: &[[VertexId; 3]],
        keep: &[bool],
    ) -> IslandCounts {
        let islands = islands(points, triangles, keep);
        let holes = || islands.iter().flat_map(|island| &island.holes);
        IslandCounts {
            islands: islands.len() as u64,
            holes: holes().count() as u64,
            hole_max_mm2: holes().map(|hole| hole.area_mm2).reduce(f64::max),
        }
    }

    fn assert_counts(seed: &[u8], side: u32) {
        let mut mesh = Mesh::new();
        mesh.extend((0..side * side).map(|i| [f64::from(i % side), f64::from(i / side), 0.0]));
        mesh.flush();
        let (points, triangles) = (mesh.points(), mesh.triangles());
        let keep: Vec<bool> = (0..triangles.len()).map(|i| seed[i % seed.len()] > 0).collect();
        let hull = hull(&triangles, &Outline::new(points.len(), &triangles)).unwrap();
        let found = island_counts(points, &triangles, &keep, &hull);
        let expected = by_looking_at_all(points, &triangles, &keep);
        assert_eq!(found, expected, "{keep:?}");
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn as_by_looking_at_all_triangles(
            seed in prop::collection::vec(0_u8..3, 1..200),
            side in 2_u32..12,
        ) {
            assert_counts(&seed, side);
        }
    }

    #[test]
    fn all_and_nothing() {
        assert_counts(&[1], 5);
        assert_counts(&[0], 5);
    }
}
