//! The order in which a mesh lists its triangles.

use std::ops::Range;

use asphera_geometry::{VertexId, from_smallest};
use rayon::prelude::*;

/// Turns every triangle to start with its smallest corner, and sorts all by their corners. Threads share the first
/// corners; each goes through the triangles twice and takes those of its own.
pub(super) fn in_order<I: Iterator<Item = [VertexId; 3]>>(
    vertices: usize,
    triangles: impl Fn() -> I + Sync,
) -> Vec<[VertexId; 3]> {
    let parts = rayon::current_num_threads().clamp(1, MOST_PARTS);
    let first_of = |part: usize| (vertices * part / parts) as VertexId;
    let mut next: Vec<Vec<u32>> = (0..parts)
        .into_par_iter()
        .map(|part| ends(first_of(part)..first_of(part + 1), triangles()))
        .collect();
    let counts: Vec<usize> =
        next.iter().map(|next| next.last().map_or(0, |count| *count as usize)).collect();
    let mut ordered = vec![[0; 3]; counts.iter().sum()];
    let mut rest = &mut ordered[..];
    let places = counts.into_iter().map(|count| rest.split_off_mut(..count).unwrap_or_default());
    let places: Vec<&mut [[VertexId; 3]]> = places.collect();
    places.into_par_iter().zip(&mut next).enumerate().for_each(|(part, (place, next))| {
        write_in_order(first_of(part)..first_of(part + 1), triangles(), next, place);
    });
    ordered
}

/// Where those triangles end whose smallest corner is a vertex of the range, or one before it: entry i + 1 belongs to
/// the one before the i-th, and the last to all.
fn ends(vertices: Range<VertexId>, triangles: impl Iterator<Item = [VertexId; 3]>) -> Vec<u32> {
    let mut next = vec![0_u32; vertices.len() + 2];
    for [a, b, c] in triangles {
        let smallest = a.min(b).min(c);
        if vertices.contains(&smallest) {
            next[(smallest - vertices.start) as usize + 2] += 1;
        }
    }
    for vertex in 0..=vertices.len() {
        next[vertex + 1] += next[vertex];
    }
    next
}

/// Counting those of each first corner leaves only a few to be compared. While they are written, the next one of the
/// i-th vertex of the range goes to `next[i + 1]`; afterwards that is where those of it end.
fn write_in_order(
    vertices: Range<VertexId>,
    triangles: impl Iterator<Item = [VertexId; 3]>,
    next: &mut [u32],
    place: &mut [[VertexId; 3]],
) {
    for corners in triangles {
        let [a, b, c] = corners;
        if vertices.contains(&a.min(b).min(c)) {
            let corners = from_smallest(corners);
            let end = &mut next[(corners[0] - vertices.start) as usize + 1];
            place[*end as usize] = corners;
            *end += 1;
        }
    }
    for pair in next.windows(2) {
        sort_few(&mut place[pair[0] as usize..pair[1] as usize]);
    }
}

/// Sorts triangles with the same first corner by insertion: there are hardly ever more than six.
fn sort_few(triangles: &mut [[VertexId; 3]]) {
    if triangles.len() > MANY {
        triangles.sort_unstable();
        return;
    }
    for end in 1..triangles.len() {
        let corners = triangles[end];
        let mut at = end;
        while at > 0 && triangles[at - 1] > corners {
            triangles[at] = triangles[at - 1];
            at -= 1;
        }
        triangles[at] = corners;
    }
}

/// More threads would mostly go through triangles that are not theirs.
const MOST_PARTS: usize = 4;

/// More triangles are not sorted by insertion.
const MANY: usize = 16;
