//! Faces cut into triangles by short diagonals.

use std::collections::BTreeSet;

use asphera_geometry::PointMm;

use crate::geometry::{dot, minus};

/// Cuts faces into triangles, with the least sum of squared diagonals of each face.
///
/// A diagonal that is an edge already, or one of another face, is taken only where there is no other way: it would be in more
/// than two triangles. `edges` are pairs in ascending order.
pub(super) fn triangles(
    points_mm: &[PointMm],
    edges: &[[u32; 2]],
    faces: &[Vec<u32>],
) -> Vec<[u32; 3]> {
    let mut taken = BTreeSet::new();
    let mut found = Vec::with_capacity(faces.len());
    for face in faces {
        if let &[a, b, c] = &face[..] {
            found.push([a, b, c]);
        } else {
            found.extend(cut(points_mm, edges, &mut taken, face));
        }
    }
    found
}

/// The recursion of G. T. Klincsek (Annals of Discrete Mathematics 9 (1980) 121-123): n³ time.
fn cut(
    points_mm: &[PointMm],
    edges: &[[u32; 2]],
    taken: &mut BTreeSet<[u32; 2]>,
    face: &[u32],
) -> Vec<[u32; 3]> {
    let len = face.len();
    let pair = |from: usize, to: usize| [face[from].min(face[to]), face[from].max(face[to])];
    let mut best = vec![vec![Cut::default(); len]; len];
    for span in 2..len {
        for from in 0..len - span {
            let to = from + span;
            let ways = (from + 1..to).map(|middle| {
                let (one, other) = (best[from][middle], best[middle][to]);
                Cut {
                    crowded: one.crowded + other.crowded,
                    squares_mm2: one.squares_mm2 + other.squares_mm2,
                    middle,
                }
            });
            let none = Cut { crowded: usize::MAX, ..Cut::default() };
            let mut least =
                ways.fold(none, |least, found| if found.is_less(least) { found } else { least });
            if span + 1 < len {
                let ends = pair(from, to);
                let is_crowded = edges.binary_search(&ends).is_ok() || taken.contains(&ends);
                least.crowded += usize::from(is_crowded);
                let [a, b] = ends.map(|end| points_mm[end as usize]);
                least.squares_mm2 += dot(minus(b, a), minus(b, a));
            }
            best[from][to] = least;
        }
    }
    let mut found = Vec::with_capacity(len - 2);
    let mut waiting = vec![(0, len - 1)];
    while let Some((from, to)) = waiting.pop() {
        if to > from + 1 {
            let middle = best[from][to].middle;
            found.push([face[from], face[middle], face[to]]);
            if to - from + 1 < len {
                taken.insert(pair(from, to));
            }
            waiting.extend([(from, middle), (middle, to)]);
        }
    }
    found
}

/// A way to cut what lies between two corners of a face.
#[derive(Clone, Copy, Default)]
struct Cut {
    /// Diagonals that are edges already.
    crowded: usize,
    squares_mm2: f64,
    /// The third corner over the two.
    middle: usize,
}

impl Cut {
    fn is_less(self, other: Cut) -> bool {
        self.crowded < other.crowded
            || (self.crowded == other.crowded && self.squares_mm2 < other.squares_mm2)
    }
}
