//! The outline of the data, where no aperture is given.

use asphera_geometry::{Sets, VertexId};

use super::gauge::{Gauged, Standing};
use crate::outline::Starts;
use crate::relief::sides;

/// The bridges that reach to the hull, across bridges, ascending; and the sides of other triangles
/// beyond which there is such a bridge or nothing, ascending. `open` are the triangles that are not
/// covered, by ascending index.
pub(super) fn outside(
    points: usize,
    triangles: &[[VertexId; 3]],
    open: &[Gauged],
    hull: &[VertexId],
) -> (Vec<usize>, Vec<[VertexId; 2]>) {
    let mut outer: Vec<[VertexId; 2]> = hull
        .iter()
        .copied()
        .zip(hull.iter().copied().cycle().skip(1))
        .map(|(p, q)| [p, q])
        .collect();
    outer.sort_unstable();
    let bridges: Vec<usize> = open
        .iter()
        .filter(|gauged| gauged.standing == Standing::Bridge)
        .map(|gauged| gauged.index)
        .collect();
    if bridges.is_empty() {
        return (bridges, outer);
    }
    let corners: Vec<[VertexId; 3]> = bridges.iter().map(|&index| triangles[index]).collect();
    let starts = Starts::new(points, &corners);
    // The last set is what lies beyond the hull.
    let beyond = bridges.len();
    let mut sets = Sets::new(bridges.len() + 1);
    for (index, &triangle) in corners.iter().enumerate() {
        for [p, q] in sides(triangle) {
            if let Some(other) = starts.triangle_left_of([q, p]) {
                sets.join(index, other);
            } else if outer.binary_search(&[p, q]).is_ok() {
                sets.join(index, beyond);
            }
        }
    }
    let root = sets.root(beyond);
    let outside: Vec<usize> =
        (0..bridges.len()).filter(|&index| sets.root(index) == root).collect();
    outer.extend(outside.iter().flat_map(|&index| sides(corners[index])).map(|[p, q]| [q, p]));
    outer.sort_unstable();
    (outside.into_iter().map(|index| bridges[index]).collect(), outer)
}
