//! Pieces that stand off: samples on one level, shut in on all sides by samples on another.

use asphera_geometry::{PointMm, Sets};

use super::steep::Spokes;
use super::tears::Tears;

/// For each slot of `spokes`: whether its vertex belongs to a piece that stands off.
///
/// A piece are vertices joined by sides on one level as far as both ends see it. It stands off if
/// all its vertices have spokes, that is steep sides about them, if all its neighbours on other
/// levels are lower or all are higher, and if no more than a quarter of it is on the outline of the
/// mesh. A piece can be a single vertex, a few, or a line, at most two samples wide: the middle of a
/// wider one has no steep side.
pub(crate) fn standing_off(points: &[PointMm], spokes: &Spokes, tears: &Tears) -> Vec<bool> {
    let level = |slot: usize, neighbour| {
        let back = spokes.slot(neighbour);
        let vertex = spokes.vertices[slot];
        !tears.on_other_level(points, spokes, slot, neighbour)
            && back.is_none_or(|back| !tears.on_other_level(points, spokes, back, vertex))
    };
    let mut sets = Sets::new(spokes.len());
    for slot in 0..spokes.len() {
        for &neighbour in spokes.neighbours(slot) {
            if let Some(other) = spokes.slot(neighbour)
                && level(slot, neighbour)
            {
                sets.join(slot, other);
            }
        }
    }
    let mut surroundings = vec![Surroundings::default(); spokes.len()];
    for slot in 0..spokes.len() {
        let piece = &mut surroundings[sets.root(slot)];
        piece.vertices += 1;
        piece.outer += usize::from(!spokes.is_inner(slot));
        let height_mm = points[spokes.vertices[slot] as usize][2];
        for &neighbour in spokes.neighbours(slot) {
            if !level(slot, neighbour) {
                let higher = points[neighbour as usize][2] > height_mm;
                piece.below |= !higher;
                piece.above |= higher;
            } else if spokes.slot(neighbour).is_none() {
                piece.open = true;
            }
        }
    }
    (0..spokes.len())
        .map(|slot| {
            let Surroundings { vertices, outer, open, below, above } =
                surroundings[sets.root(slot)];
            !open && below != above && 4 * outer <= vertices
        })
        .collect()
}

/// What lies about a piece.
#[derive(Clone, Copy, Default)]
struct Surroundings {
    /// How many vertices it has.
    vertices: usize,
    /// How many of them lie on the outline of the mesh.
    outer: usize,
    /// It goes on on its level.
    open: bool,
    /// A neighbour lies on a lower level.
    below: bool,
    /// A neighbour lies on a higher level.
    above: bool,
}
