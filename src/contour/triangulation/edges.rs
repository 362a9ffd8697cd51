//! Edges and neighbours from a list of triangles.

use super::{Edge, EdgeId, Spoke, TriangleId};
use crate::samples::SampleId;

/// A side of a triangle: its ends, smaller first, its triangle and which side of it.
type Side = ([SampleId; 2], TriangleId, u8, bool);

/// The edges sorted by their ends, and the edge from each corner of a triangle to the next.
///
/// Without triangles the samples lie on one line, in order of their numbers: each is joined to the next.
pub(super) fn edges(samples: usize, triangles: &[[SampleId; 3]]) -> (Vec<Edge>, Vec<[EdgeId; 3]>) {
    if triangles.is_empty() {
        let on_line = (1..samples as SampleId)
            .map(|next| Edge { ends: [next - 1, next], triangles: [None, None] });
        return (on_line.collect(), Vec::new());
    }
    let mut sides = sorted_sides(samples, triangles);
    let mut edges: Vec<Edge> = Vec::with_capacity(sides.len() / 2 + samples);
    let mut of_triangle = vec![[0; 3]; triangles.len()];
    for (ends, triangle, side, is_left) in sides.drain(..) {
        if edges.last().is_none_or(|edge| edge.ends != ends) {
            edges.push(Edge { ends, triangles: [None, None] });
        }
        let number = edges.len() as EdgeId - 1;
        if let Some(edge) = edges.last_mut() {
            edge.triangles[usize::from(!is_left)] = Some(triangle);
        }
        of_triangle[triangle as usize][usize::from(side)] = number;
    }
    (edges, of_triangle)
}

/// All sides, by their ends. They are counted by the first end, so that only few are compared.
fn sorted_sides(samples: usize, triangles: &[[SampleId; 3]]) -> Vec<Side> {
    let mut next = vec![0_u32; samples + 1];
    let sides = || {
        triangles.iter().zip(0..).flat_map(|(corners, triangle)| {
            [0, 1, 2].map(|side| {
                let [from, to] = [corners[side], corners[(side + 1) % 3]];
                ([from.min(to), from.max(to)], triangle, side as u8, from < to)
            })
        })
    };
    for ([first, _], ..) in sides() {
        next[first as usize + 1] += 1;
    }
    for sample in 0..samples {
        next[sample + 1] += next[sample];
    }
    let starts = next.clone();
    let mut sorted: Vec<Side> = vec![([0; 2], 0, 0, false); 3 * triangles.len()];
    for side in sides() {
        let place = &mut next[side.0[0] as usize];
        sorted[*place as usize] = side;
        *place += 1;
    }
    for pair in starts.windows(2) {
        sorted[pair[0] as usize..pair[1] as usize].sort_unstable();
    }
    sorted
}

/// The edges of every sample, by their other end, and where those of each begin.
pub(super) fn spokes(samples: usize, edges: &[Edge]) -> (Vec<u32>, Vec<Spoke>) {
    let mut first = vec![0_u32; samples + 1];
    for edge in edges {
        for end in edge.ends {
            first[end as usize + 1] += 1;
        }
    }
    for sample in 0..samples {
        first[sample + 1] += first[sample];
    }
    let mut next = first.clone();
    let mut spokes = vec![Spoke { to: 0, edge: 0 }; 2 * edges.len()];
    // Edges come by their first end, then their second: those to smaller samples before those to larger ones need a
    // second pass.
    for is_upper in [true, false] {
        for (edge, &Edge { ends: [low, high], .. }) in (0..).zip(edges) {
            let (at, to) = if is_upper { (high, low) } else { (low, high) };
            let place = &mut next[at as usize];
            spokes[*place as usize] = Spoke { to, edge };
            *place += 1;
        }
    }
    (first, spokes)
}
