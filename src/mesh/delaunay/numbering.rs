//! How vertices are numbered in order of arrival once some points of a batch were found to be duplicates.
//!
//! Where few vertices get another number, the triangles about each are found by a walk. Where many do, all triangles are
//! gone through once: in a large batch in no order each walk would cross much of the mesh.

use std::collections::BTreeMap;

use asphera_geometry::VertexId;

use super::cells::{Cells, GHOST, Slot};
use super::editor::Editor;
use super::places::{Places, Vertices};
use super::{Delaunay, Duplicate};

/// All triangles are gone through where more than one vertex in so many gets another number.
const FEW: usize = 16;

impl<C: Cells> Delaunay<C> {
    /// Takes the duplicates of the last batch, which starts with vertex `first`, out of `points`, and numbers the batch's
    /// vertices in order of arrival. Returns the duplicates in order, each of the first to arrive in its place.
    pub(crate) fn close_gaps(
        &mut self,
        points: &mut impl Vertices,
        first: VertexId,
    ) -> Vec<Duplicate> {
        let mut duplicates = std::mem::take(&mut self.sheet.duplicates);
        let swapped = name_by_arrival(&mut duplicates);
        let first_gap = duplicates.first().map_or(first, |duplicate| duplicate.point);
        let shifted = points.count() - first_gap as usize;
        let names = (self.sheet.plane.is_some() && FEW * shifted >= points.count())
            .then(|| names(first..points.count() as VertexId, &swapped, &duplicates));
        if let Some(names) = &names {
            self.rename_all(first, names);
        } else {
            swapped.iter().for_each(|&names| self.rename(points.places(), names, None));
        }
        let first_slot = points.count() - self.sheet.slots.len();
        let mut gaps = duplicates.iter().map(|duplicate| duplicate.point).peekable();
        let mut filled = first_gap;
        for vertex in first_gap..points.count() as VertexId {
            if gaps.next_if_eq(&vertex).is_none() {
                if names.is_none() {
                    let at = (vertex as usize).checked_sub(first_slot);
                    let near = at.and_then(|at| self.sheet.slots.get(at)).copied();
                    self.rename(points.places(), [vertex, filled], near);
                }
                points.copy(vertex, filled);
                filled += 1;
            }
        }
        points.shorten(points.count() - duplicates.len());
        for index in 0..duplicates.len() {
            // An earlier duplicate of the batch moved what comes after it.
            let of = duplicates[index].of;
            let before = duplicates.partition_point(|duplicate| duplicate.point < of);
            duplicates[index].of -= before as VertexId;
        }
        duplicates
    }

    /// Gives a vertex another number. Its point is still, or also, to be found at the old one. The walk to it starts at the
    /// vertex renamed last, or at a triangle that is known to be near.
    pub(super) fn rename(
        &mut self,
        points: &(impl Places + ?Sized),
        [from, to]: [VertexId; 2],
        near: Option<Slot>,
    ) {
        let place = points.place(from);
        match &mut self.sheet.plane {
            None => self.sheet.line.relabel(place, to),
            Some(plane) => {
                let editor = Editor { points, cells: &self.cells, work: &mut self.sheet.work };
                let near = near.unwrap_or(plane.recent);
                plane.recent = editor.relabel(place, from, to, near);
            }
        }
    }

    /// Gives the vertices from `first` on the numbers `names`, in all triangles.
    fn rename_all(&self, first: VertexId, names: &[VertexId]) {
        for slot in 0..self.cells.len() as Slot {
            for (index, corner) in self.cells.corners(slot).into_iter().enumerate() {
                let at = (corner as usize).checked_sub(first as usize);
                match at.and_then(|at| names.get(at)) {
                    Some(&name) if corner != GHOST && name != corner => {
                        self.cells.set_corner(slot, index, name);
                    }
                    _ => (),
                }
            }
        }
    }
}

/// Gives who was inserted first the number of who arrived first, and sorts the duplicates. Returns the numbers that change
/// so: of who was inserted, and of who arrived.
fn name_by_arrival(duplicates: &mut [Duplicate]) -> Vec<[VertexId; 2]> {
    let mut firsts: BTreeMap<VertexId, VertexId> = BTreeMap::new();
    for &Duplicate { point, of } in &*duplicates {
        let first = firsts.entry(of).or_insert(of);
        *first = point.min(*first);
    }
    let mut swapped = Vec::new();
    for duplicate in &mut *duplicates {
        let (inserted, arrived) = (duplicate.of, firsts[&duplicate.of]);
        if duplicate.point == arrived {
            duplicate.point = inserted;
            swapped.push([inserted, arrived]);
        }
        duplicate.of = arrived;
    }
    duplicates.sort_unstable_by_key(|duplicate| duplicate.point);
    swapped
}

/// The number that each vertex of a batch gets when those without duplicates close up.
fn names(
    batch: std::ops::Range<VertexId>,
    swapped: &[[VertexId; 2]],
    duplicates: &[Duplicate],
) -> Vec<VertexId> {
    let mut gaps = duplicates.iter().map(|duplicate| duplicate.point).peekable();
    let mut next = batch.start;
    let mut names: Vec<VertexId> = Vec::with_capacity(batch.len());
    for vertex in batch.clone() {
        names.push(next);
        next += VertexId::from(gaps.next_if_eq(&vertex).is_none());
    }
    let at = |vertex: VertexId| (vertex - batch.start) as usize;
    for &[inserted, arrived] in swapped {
        names[at(inserted)] = names[at(arrived)];
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_arrived_first_bears_the_number_and_the_others_close_up() {
        // The point 13 was inserted first, then 11 and 15 in its place; 12 stands where 3 does.
        let duplicate = |point, of| Duplicate { point, of };
        let mut duplicates = [duplicate(15, 13), duplicate(12, 3), duplicate(11, 13)];
        let swapped = name_by_arrival(&mut duplicates);
        assert_eq!(swapped, [[13, 11]]);
        assert_eq!(duplicates, [duplicate(12, 3), duplicate(13, 11), duplicate(15, 11)]);
        // 10, 11 and 14 are left, and 13 is a corner of triangles in the name of 11.
        let names = names(10..16, &swapped, &duplicates);
        assert_eq!([names[0], names[1], names[3], names[4]], [10, 11, 11, 12]);
    }
}
