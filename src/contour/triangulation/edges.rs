//! Edges and neighbours from a list of triangles.

use super::{Edge, EdgeId, Spoke};
use crate::samples::SampleId;

/// A side of a triangle that begins at its smaller end: the other end above, its triangle and which side of it below. So
/// sides are in the order of their ends.
type Side = u64;

/// The edges sorted by their ends, and the edge from each corner of a triangle to the next.
///
/// Triangles are given from their smallest corner on. Without triangles the samples lie on one line, in order of their numbers: each is
/// joined to the next.
pub(super) fn edges(samples: usize, triangles: &[[SampleId; 3]]) -> (Vec<Edge>, Vec<[EdgeId; 3]>) {
    if triangles.is_empty() {
        let on_line = (1..samples as SampleId)
            .map(|next| Edge { ends: [next - 1, next], triangles: [None, None] });
        return (on_line.collect(), Vec::new());
    }
    let (starts, sides) = sorted_sides(samples, triangles);
    let mut edges: Vec<Edge> = Vec::with_capacity(sides.len() / 2 + samples);
    let mut of_triangle = vec![[0; 3]; triangles.len()];
    for (first, bounds) in (0..).zip(starts.windows(2)) {
        let mut last = None;
        for &key in &sides[bounds[0] as usize..bounds[1] as usize] {
            let (second, triangle, side) = ((key >> 32) as u32, key as u32 >> 2, key as usize & 3);
            if last != Some(second) {
                edges.push(Edge { ends: [first, second], triangles: [None, None] });
                last = Some(second);
            }
            let number = edges.len() as EdgeId - 1;
            // The side between the two larger corners leads from the smaller one where that comes first.
            let is_left = triangles[triangle as usize][side] == first;
            if let Some(edge) = edges.last_mut() {
                edge.triangles[usize::from(!is_left)] = Some(triangle);
            }
            of_triangle[triangle as usize][side] = number;
        }
    }
    (edges, of_triangle)
}

/// All sides by their ends, and where those of each first end begin. They are counted by that, so that only few are compared.
fn sorted_sides(samples: usize, triangles: &[[SampleId; 3]]) -> (Vec<u32>, Vec<Side>) {
    let sides = || {
        triangles.iter().zip(0_u32..).flat_map(|(&[a, b, c], triangle)| {
            // Corner `a` is the smallest.
            let key = |other: SampleId, side: u32| {
                u64::from(other) << 32 | u64::from(triangle << 2 | side)
            };
            [(a, key(b, 0)), (b.min(c), key(b.max(c), 1)), (a, key(c, 2))]
        })
    };
    counted(samples, sides)
}

/// Triangles, each from its smallest corner on, in lexicographic order.
pub(super) fn in_order(samples: usize, triangles: Vec<[SampleId; 3]>) -> Vec<[SampleId; 3]> {
    counted(samples, || triangles.iter().map(|&corners| (corners[0], corners))).1
}

/// Items by a number below `count`, those of the same number sorted, and where those of each number begin.
fn counted<T: Copy + Default + Ord, I: Iterator<Item = (u32, T)>>(
    count: usize,
    items: impl Fn() -> I,
) -> (Vec<u32>, Vec<T>) {
    let mut starts = vec![0_u32; count + 1];
    for (number, _) in items() {
        starts[number as usize + 1] += 1;
    }
    for number in 0..count {
        starts[number + 1] += starts[number];
    }
    let mut next = starts.clone();
    let mut sorted = vec![T::default(); starts[count] as usize];
    for (number, item) in items() {
        let place = &mut next[number as usize];
        sorted[*place as usize] = item;
        *place += 1;
    }
    for pair in starts.windows(2) {
        sorted[pair[0] as usize..pair[1] as usize].sort_unstable();
    }
    (starts, sorted)
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
