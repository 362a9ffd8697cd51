//! What lies about a vertex, and what it costs to take the vertex away or to move it.

use super::about::{About, Filling};
use super::ends::{is_left_turn, squared};
use super::load::Load;
use super::planar::{HalfEdge, Planar};
use crate::{PlaceMm, SampleId};

/// A change of the triangles about a vertex.
pub(super) struct Star {
    /// The vertex that goes or moves.
    pub(super) vertex: SampleId,
    /// Where it moves.
    pub(super) place: PlaceMm,
    /// The vertices about it, counter-clockwise; in the order of `spokes`.
    pub(super) ring: Vec<u32>,
    /// The half-edges to them.
    pub(super) spokes: Vec<HalfEdge>,
    /// The triangles that fill the ring afterwards, by indices into it.
    pub(super) triangles: Vec<[usize; 3]>,
    /// The edges within the ring afterwards, by indices, smaller first; of a vertex that moves twice the index of each spoke.
    pub(super) inner: Vec<[usize; 2]>,
    /// The loads of the edges within, then those of the sides of the ring.
    pub(super) loads: Vec<Load>,
    /// Whether the points of each side of the ring become others.
    pub(super) is_changed: Vec<bool>,
    /// What the change adds to the cost in mm².
    pub(super) added_mm2: f64,
}

impl Star {
    /// The collapse of a vertex into a neighbour; none where the triangles cannot follow or no edge could take the points.
    pub(super) fn collapsed(planar: &Planar, vertex: SampleId, to: SampleId) -> Option<Star> {
        let mut about = About::new(planar);
        about.turn_to(vertex);
        let first = about.ring().iter().position(|&other| other == to)?;
        let mut filling = Filling::default();
        about.fill(first, &mut filling).then_some(())?;
        let added_mm2 = about.added_mm2(&filling.inner, f64::INFINITY)?;
        Some(about.star(filling, added_mm2))
    }

    /// The move of a vertex to where its points ask for it; none if that is not possible or costs no less.
    pub(super) fn moved(planar: &Planar, vertex: SampleId) -> Option<Star> {
        let mut about = About::new(planar);
        about.turn_to(vertex);
        let place = about.wanted()?;
        let count = about.ring().len();
        let at = |index: usize| planar.place(about.ring()[index % count]);
        if !(0..count).all(|index| is_left_turn(place, at(index), at(index + 1))) {
            return None;
        }
        about.move_to(place);
        let mut filling = Filling::default();
        filling.inner.extend((0..count).map(|index| [index, index]));
        let added_mm2 = about.added_mm2(&filling.inner, f64::INFINITY)?;
        (planar.whole(added_mm2) < 0).then(|| about.star(filling, added_mm2))
    }
}

/// Looks for the cheapest collapses of vertices, one after the other.
pub(super) struct Collapses<'a> {
    planar: &'a Planar,
    about: About<'a>,
    filling: Filling,
    /// The neighbours of the vertex by their distance, with their indices in its ring.
    neighbours: Vec<(f64, SampleId, usize)>,
}

impl<'a> Collapses<'a> {
    pub(super) fn new(planar: &'a Planar) -> Collapses<'a> {
        let (about, filling) = (About::new(planar), Filling::default());
        Collapses { planar, about, filling, neighbours: Vec::new() }
    }

    /// The neighbour into which a vertex collapses at the least cost, and what that adds in mm².
    pub(super) fn cheapest(&mut self, vertex: SampleId) -> Option<(SampleId, f64)> {
        let planar = self.planar;
        if !planar.is_there(vertex) {
            return None;
        }
        self.about.turn_to(vertex);
        let at = planar.place(vertex);
        let ring = self.about.ring().iter().enumerate();
        let ring = ring.filter(|&(_, &other)| !planar.is_corner(other));
        self.neighbours.clear();
        self.neighbours
            .extend(ring.map(|(index, &other)| (squared(at, planar.place(other)), other, index)));
        self.neighbours.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<(i64, i64, SampleId, f64)> = None;
        for &(length_mm2, to, index) in &self.neighbours {
            let most_mm2 = best.map_or(f64::INFINITY, |best| best.3);
            if !self.about.fill(index, &mut self.filling) {
                continue;
            }
            let Some(added_mm2) = self.about.added_mm2(&self.filling.inner, most_mm2) else {
                continue;
            };
            let found = (planar.whole(added_mm2), planar.whole(length_mm2), to, added_mm2);
            if best.is_none_or(|best| (found.0, found.1, found.2) < (best.0, best.1, best.2)) {
                best = Some(found);
            }
        }
        best.map(|(_, _, to, added_mm2)| (to, added_mm2))
    }
}
