//! Edges and neighbours from a list of triangles.

use super::{BEYOND, Edge, EdgeId, Spoke};
use crate::samples::SampleId;

/// A side of a triangle that begins at its smaller end: the other end, then its triangle and which side of it. So sides are in
/// the order of their ends.
type Side = [u32; 2];

/// Memory of sides that are done with. Spokes are as many and as large: new memory costs more than what is written to it.
pub(super) type Room = Vec<Side>;

/// The edges sorted by their ends, the edge from each corner of a triangle to the next, and room for spokes.
///
/// Triangles are given from their smallest corner on. Without triangles the samples lie on one line, in order of their numbers: each is
/// joined to the next.
pub(super) fn edges(
    samples: usize,
    triangles: &[[SampleId; 3]],
) -> (Vec<Edge>, Vec<[EdgeId; 3]>, Room) {
    if triangles.is_empty() {
        let on_line = (1..samples as SampleId)
            .map(|next| Edge { ends: [next - 1, next], triangles: [BEYOND; 2] });
        return (on_line.collect(), Vec::new(), Room::new());
    }
    let (starts, sides) = sorted_sides(samples, triangles);
    let mut edges: Vec<Edge> = Vec::with_capacity(count(samples, triangles));
    let mut of_triangle = vec![[0; 3]; triangles.len()];
    for (first, bounds) in (0..).zip(starts.windows(2)) {
        let mut last = None;
        for &[second, at] in &sides[bounds[0] as usize..bounds[1] as usize] {
            let (triangle, side) = (at >> 2, at as usize & 3);
            if last != Some(second) {
                edges.push(Edge { ends: [first, second], triangles: [BEYOND; 2] });
                last = Some(second);
            }
            let number = edges.len() as EdgeId - 1;
            // The side between the two larger corners leads from the smaller one where that comes first.
            let is_left = triangles[triangle as usize][side] == first;
            if let Some(edge) = edges.last_mut() {
                edge.triangles[usize::from(!is_left)] = triangle;
            }
            of_triangle[triangle as usize][side] = number;
        }
    }
    (edges, of_triangle, sides)
}

/// How many edges there are, by Euler's formula: every sample is a corner.
fn count(samples: usize, triangles: &[[SampleId; 3]]) -> usize {
    samples + triangles.len() - 1
}

/// All sides by their ends, and where those of each first end begin. They are counted by that, so that only few are compared.
fn sorted_sides(samples: usize, triangles: &[[SampleId; 3]]) -> (Vec<u32>, Vec<Side>) {
    let sides = || {
        triangles.iter().zip(0_u32..).flat_map(|(&[a, b, c], triangle)| {
            // Corner `a` is the smallest.
            let key = |other: SampleId, side: u32| [other, triangle << 2 | side];
            [(a, key(b, 0)), (b.min(c), key(b.max(c), 1)), (a, key(c, 2))]
        })
    };
    let room = 2 * count(samples, triangles);
    counted(samples, room, sides, |[other, at]| u64::from(other) << 32 | u64::from(at))
}

/// Triangles, each from its smallest corner on, in lexicographic order.
pub(super) fn in_order(samples: usize, triangles: Vec<[SampleId; 3]>) -> Vec<[SampleId; 3]> {
    let items = || triangles.iter().map(|&corners| (corners[0], corners));
    counted(samples, triangles.len(), items, |corners| corners).1
}

/// Items by a number below `count`, those of the same number by their keys, and where those of each number begin. They get room for
/// `room` of them.
fn counted<const N: usize, K: Ord, I: Iterator<Item = (u32, [u32; N])>>(
    count: usize,
    room: usize,
    items: impl Fn() -> I,
    key: impl Fn([u32; N]) -> K,
) -> (Vec<u32>, Vec<[u32; N]>) {
    let mut starts = vec![0_u32; count + 1];
    for (number, _) in items() {
        starts[number as usize + 1] += 1;
    }
    for number in 0..count {
        starts[number + 1] += starts[number];
    }
    let mut next = starts.clone();
    // Zeros come from the system as they are; what is not used is never touched.
    let mut sorted = vec![[0; N]; room.max(starts[count] as usize)];
    sorted.truncate(starts[count] as usize);
    for (number, item) in items() {
        let place = &mut next[number as usize];
        sorted[*place as usize] = item;
        *place += 1;
    }
    for pair in starts.windows(2) {
        sorted[pair[0] as usize..pair[1] as usize].sort_unstable_by_key(|&item| key(item));
    }
    (starts, sorted)
}

/// The edges of every sample, by their other end, and where those of each begin.
pub(super) fn spokes(samples: usize, edges: &[Edge], room: Room) -> (Vec<u32>, Vec<Spoke>) {
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
    let empty = Spoke { to: 0, edge: 0 };
    // A list of as large items as those it is made of takes their memory.
    let mut spokes: Vec<Spoke> = room.into_iter().map(|_| empty).collect();
    spokes.resize(2 * edges.len(), empty);
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
