//! The graph method while points arrive, with landmarks by priority.
//!
//! The priority of a point depends on its place alone. So a further point changes lists of neighbours, landmarks, cells and contacts near it,
//! and nothing else: a batch costs time in proportion to what lies within some hops of it. Faces go by the order of all landmarks.
//! They and the triangles are found when the surface is asked for.

mod cells;
mod cover;
mod near;

use std::collections::BTreeMap;

use asphera_geometry::PointMm;

use self::cells::Cells;
use self::cover::{Cover, Marks};
use self::near::Edges;
use super::mapped::Mapped;
use super::{
    Cell, FaceRule, GraphChoices, GraphError, GraphSurface, NoSurface, check_neighbours, left_out,
};
use crate::local::place_tree::PlaceTree;
use crate::local::{MOST_POINTS, Places as _};
use crate::surface::{LeftOut, Numbered, Reconstruction, as_place, finished};

/// A graph of neighbours that takes points in batches.
///
/// After every batch it has the landmarks, cells and contacts that [`PointGraph`](super::PointGraph) finds in all points so far by
/// [`LandmarkOrder::Priority`](super::LandmarkOrder::Priority), bit for bit: batches and threads change nothing. Some 450 bytes a point.
#[derive(Clone, Debug)]
pub struct LiveGraph {
    received: usize,
    tree: PlaceTree,
    edges: Edges,
    cover: Cover,
    cells: Cells,
    marks: Marks,
    /// Points without a place of their own.
    left_out: Vec<(u32, LeftOut)>,
    /// Points with coordinates that count as 0, as they came.
    tiny: BTreeMap<u32, PointMm>,
}

impl LiveGraph {
    /// A graph without points: an edge from every place to its `neighbours` nearest, landmarks at least `hops` apart.
    ///
    /// # Errors
    ///
    /// Neighbours or hops out of range.
    pub fn new(neighbours: usize, hops: u8) -> Result<LiveGraph, GraphError> {
        check_neighbours(neighbours)?;
        GraphChoices { hops, ..GraphChoices::default() }.check()?;
        Ok(LiveGraph {
            received: 0,
            tree: PlaceTree::default(),
            edges: Edges::new(neighbours),
            cover: Cover::new(hops),
            cells: Cells::default(),
            marks: Marks::default(),
            left_out: Vec::new(),
            tiny: BTreeMap::new(),
        })
    }

    /// How many points were taken.
    pub fn received(&self) -> usize {
        self.received
    }

    /// Takes points. They are numbered on from those before.
    ///
    /// # Errors
    ///
    /// More than [`MOST_POINTS`] points in all; then none of these is taken.
    pub fn insert(&mut self, points_mm: &[PointMm]) -> Result<(), GraphError> {
        let first = self.received;
        let found = first + points_mm.len();
        if found > MOST_POINTS {
            return Err(GraphError::TooManyPoints { found });
        }
        self.received = found;
        let mut batch: Vec<Numbered> = Vec::with_capacity(points_mm.len());
        for (&point, number) in points_mm.iter().zip(first as u32..) {
            let Some(place) = as_place(point) else {
                self.left_out.push((number, LeftOut::NoPlace));
                continue;
            };
            if place.map(f64::to_bits) != point.map(f64::to_bits) {
                self.tiny.insert(number, point);
            }
            batch.push((place, number));
        }
        let inserted = self.tree.insert(&mut batch);
        let duplicates = inserted.duplicates.iter().map(|&id| (id, LeftOut::Duplicate));
        self.left_out.extend(duplicates);
        if inserted.leaves.is_empty() {
            return Ok(());
        }
        let changes = self.edges.take(&mut self.tree, &inserted);
        let LiveGraph { edges, cover, cells, .. } = self;
        cells.begin(self.tree.len());
        let linked = edges.change(&changes);
        cover.grow(self.tree.points_mm());
        cover.mend(edges, (&changes, &linked), &mut |point| cells.doubt(point));
        let doubts = cells.doubts().to_vec();
        cover.decide(edges, doubts.into_iter(), &mut |point| cells.doubt(point));
        cells.settle(cover);
        cells.touch(edges, &linked, &mut self.marks);
        Ok(())
    }

    /// The surface that [`PointGraph`](super::PointGraph) gives of the points so far by priority. Linear time but for sorting.
    pub fn surface(&self, threshold: u32, faces: FaceRule) -> GraphSurface {
        let landmarks = self.cover.landmarks();
        let mut rank_of = vec![u32::MAX; self.tree.len()];
        for (rank, &landmark) in (0..).zip(&landmarks) {
            rank_of[landmark as usize] = rank;
        }
        let (contacts, meetings) = self.cells.touching(&rank_of);
        let meetings = || (faces == FaceRule::Filled).then_some(meetings);
        let points_mm = self.tree.points_mm();
        let places: Vec<PointMm> = landmarks.iter().map(|&at| points_mm[at as usize]).collect();
        let ids: Vec<u32> = landmarks.iter().map(|&at| self.tree.ids[at as usize]).collect();
        let mut mapped = Mapped::of(&places, contacts, threshold, meetings, &mut |_| {});
        let mut received_mm = vec![[f64::NAN; 3]; self.received];
        for (&place, &id) in places.iter().zip(&ids) {
            received_mm[id as usize] = self.tiny.get(&id).copied().unwrap_or(place);
        }
        let facets = finished(&received_mm, &ids, std::mem::take(&mut mapped.triangles));
        let mut cells = vec![None; self.received];
        for (at, &id) in self.tree.ids.iter().enumerate() {
            let landmark = self.tree.ids[self.cells.owners[at] as usize];
            cells[id as usize] = Some(Cell { landmark, hops: self.cells.hops[at] });
        }
        let map = mapped.map(ids, cells);
        let no_surface =
            facets.is_empty().then(|| NoSurface::of(self.tree.len(), map.landmarks.len()));
        let left_out = left_out(&facets, &map, &self.left_out);
        GraphSurface { reconstruction: Reconstruction { facets, left_out }, map, no_surface }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::neighbours::Neighbours;

    /// Links are those of the definition, and every label is the number of hops to a landmark: none is missing.
    fn check(live: &LiveGraph, points: &[PointMm], count: usize) {
        let places = live.tree.points_mm();
        let tree = Neighbours::of(places.iter().copied().zip(0..).collect());
        let links = crate::graph::links::Links::of(&tree, count);
        for at in 0..tree.len() as u32 {
            let own = tree.ids[at as usize];
            let expected: BTreeSet<u32> =
                links.at(at).iter().map(|&near| tree.ids[near as usize]).collect();
            let found: BTreeSet<u32> = live.edges.at(own).iter().copied().collect();
            assert_eq!(found, expected, "{own} of {} points", points.len());
            assert_eq!(live.edges.at(own).len(), found.len());
        }
        live.cover.check(&live.edges);
    }

    #[test]
    fn links_and_labels_are_those_of_the_definition() {
        for seed in 0..400_u64 {
            let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
            let mut below = |count: u64| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (state >> 33) % count
            };
            let side = [3, 6, 40, 1000][below(4) as usize];
            let total = 20 + below(150);
            let points: Vec<PointMm> =
                (0..total).map(|_| [0, 1, 2].map(|_| below(side) as f64)).collect();
            let count = [1, 3, 8, 15, 40][below(5) as usize];
            let hops = [1, 2, 3, 5, 9][below(5) as usize];
            let mut live = LiveGraph::new(count, hops).unwrap();
            let mut done = 0;
            while done < points.len() {
                let next = (done + 1 + below(30) as usize).min(points.len());
                live.insert(&points[done..next]).unwrap();
                done = next;
                check(&live, &points[..done], count);
            }
        }
    }
}
