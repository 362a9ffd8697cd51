//! Points that landmarks stand for, put back as vertices of the coarse surface.
//!
//! The outlook of "Graph-based 2-manifold reconstruction". Every step keeps components, handles and borders: a facet is cut into
//! three, or the facets of an edge into two each, or a border goes round a further facet. Then edges about the new vertex are
//! flipped until each is locally Delaunay in its two facets laid flat (as C. L. Lawson, Software for C1 surface interpolation, 1977).
//! A flip joins the new vertex to one more vertex, so that it ends.
//!
//! A step that would turn a facet far from the one before is left out. Such a point comes again after all others.

mod flips;
mod mesh;
mod ways;

use std::cmp::Ordering;
use std::collections::BTreeSet;

use asphera_geometry::PointMm;
use rayon::prelude::*;

use self::mesh::Mesh;
use self::ways::Way;
use super::landmarks::hash;
use super::{GraphSurface, PointGraph, Stage};
use crate::deviation::nearest;
use crate::geometry::{dot, squared, unit};
use crate::neighbours::by_coordinates;
use crate::surface::{LeftOut, Reconstruction, finished};

impl PointGraph<'_> {
    /// The surface with the points of its cells put back as vertices, of the same topology. n·log n time.
    ///
    /// Points stay out whose landmark has no facet, and those that would fold the surface. `enters` is given the stage as it begins.
    ///
    /// # Panics
    ///
    /// If the surface is not one of these points.
    pub fn put_back(&self, coarse: &GraphSurface, enters: &mut dyn FnMut(Stage)) -> Reconstruction {
        enters(Stage::PutBack);
        let mut at = vec![u32::MAX; self.points_mm.len()];
        for (place, &id) in (0..).zip(&self.tree.ids) {
            at[id as usize] = place;
        }
        let mut rank = vec![u32::MAX; self.points_mm.len()];
        for (order, &id) in (0..).zip(&coarse.map.landmarks) {
            rank[id as usize] = order;
        }
        let mut facets = coarse.reconstruction.facets.clone();
        for facet in &mut facets {
            facet.sort_unstable_by_key(|&id| rank[id as usize]);
        }
        facets.sort_unstable_by_key(|facet| facet.map(|id| rank[id as usize]));
        let facets = facets.into_iter().map(|facet| facet.map(|id| at[id as usize])).collect();
        let mesh = Mesh::new(self.tree.len(), facets);
        let pruned = coarse.reconstruction.left_out.iter();
        let pruned = pruned.filter(|left| left.1 == LeftOut::Pruned).filter_map(|&(id, _)| {
            let landmark = coarse.map.cells[id as usize]?.landmark;
            let is_vertex = mesh.is_vertex(at[landmark as usize]);
            is_vertex.then_some((rank[landmark as usize], at[id as usize]))
        });
        let pruned = in_order(&self.tree.points_mm, pruned.collect());
        let landmarks: Vec<u32> = coarse.map.landmarks.iter().map(|&id| at[id as usize]).collect();
        let points_mm = &self.tree.points_mm;
        let mut filling =
            Filling { graph: self, points_mm, landmarks: &landmarks, mesh, fan: Vec::new() };
        let folding = filling.put_back_all(pruned);
        let mut left_out = coarse.reconstruction.left_out.clone();
        left_out.retain(|&(id, why)| {
            why != LeftOut::Pruned || !filling.mesh.is_vertex(at[id as usize])
        });
        let is_folding: BTreeSet<u32> =
            folding.into_iter().map(|point| self.tree.ids[point as usize]).collect();
        for (_, why) in left_out.iter_mut().filter(|left| is_folding.contains(&left.0)) {
            *why = LeftOut::Folding;
        }
        let facets = finished(self.points_mm, &self.tree.ids, filling.mesh.corners);
        Reconstruction { facets, left_out }
    }
}

/// Points with the rank of their landmark, in the order in which they are put back: a few of every cell, then about twice as many,
/// and so on. So facets shrink evenly, and what is near in the surface is near in time.
fn in_order(points_mm: &[PointMm], pruned: Vec<(u32, u32)>) -> Vec<(u32, u32)> {
    let mut keyed: Vec<((u32, u32, u64), u32)> = pruned
        .into_par_iter()
        .map(|(rank, point)| {
            let [x, y, z] = points_mm[point as usize];
            // A quarter turn about z changes neither.
            let key = hash([x * x + y * y, z * z, 0.0]);
            let round = ROUNDS - key.trailing_zeros().min(ROUNDS);
            ((round, rank, key), point)
        })
        .collect();
    let place = |point: u32| points_mm[point as usize];
    let compare = |a: &((u32, u32, u64), u32), b: &((u32, u32, u64), u32)| -> Ordering {
        a.0.cmp(&b.0).then_with(|| by_sweep(place(a.1), place(b.1)))
    };
    keyed.par_sort_unstable_by(compare);
    keyed.into_iter().map(|((_, rank, _), point)| (rank, point)).collect()
}

/// A surface at work.
struct Filling<'a> {
    graph: &'a PointGraph<'a>,
    points_mm: &'a [PointMm],
    /// Landmarks by their ranks.
    landmarks: &'a [u32],
    mesh: Mesh,
    /// Room for the facets about a vertex.
    fan: Vec<u32>,
}

impl Filling<'_> {
    /// Puts points back, each with the rank of its landmark, and gives those that would fold the surface.
    fn put_back_all(&mut self, pruned: Vec<(u32, u32)>) -> Vec<u32> {
        let mut waiting = pruned;
        for bounds in BOUNDS {
            for _ in 0..PASSES {
                let before = waiting.len();
                let landmarks = self.landmarks;
                waiting.retain(|&(rank, point)| {
                    !self.put_back(landmarks[rank as usize], point, &bounds)
                });
                if waiting.len() == before {
                    break;
                }
            }
        }
        waiting.into_iter().map(|(_, point)| point).collect()
    }

    fn put_back(&mut self, landmark: u32, point: u32, bounds: &Bounds) -> bool {
        let (square, facet) = self.locate(landmark, point);
        let Some(way) = self.way(facet, point, bounds) else { return false };
        let is_far = square > bounds.border_share * bounds.border_share * self.reach(point);
        if is_far && way.corner().is_some_and(|corner| self.mesh.is_border(facet, corner)) {
            return false;
        }
        let facets = match way {
            Way::Facet => self.mesh.split_facet(facet, point).to_vec(),
            Way::Edge(corner) => self.mesh.split_edge(facet, corner, point),
            Way::Ear(corner) => vec![self.mesh.add_ear(facet, corner, point)],
        };
        self.flip_about(point, facets);
        true
    }

    fn place(&self, vertex: u32) -> PointMm {
        self.points_mm[vertex as usize]
    }

    fn places(&self, facet: u32) -> [PointMm; 3] {
        self.mesh.corners[facet as usize].map(|corner| self.place(corner))
    }

    /// The square of the distance of a point from a facet.
    fn square(&self, facet: u32, point: u32) -> f64 {
        let place = self.place(point);
        squared(place, nearest(self.places(facet), place))
    }

    /// The facet that a point lies over: found from the nearest neighbour that is a vertex already, else from its landmark.
    fn locate(&mut self, landmark: u32, point: u32) -> (f64, u32) {
        let own = self.place(point);
        let links = self.graph.links.at(point).iter().copied();
        let vertices = links.filter(|&near| self.mesh.is_vertex(near));
        let near = vertices.map(|near| (squared(own, self.place(near)), near)).min_by(|a, b| {
            a.0.total_cmp(&b.0).then_with(|| by_sweep(self.place(a.1), self.place(b.1)))
        });
        let start = near.map_or(landmark, |(_, near)| near);
        let mut fan = std::mem::take(&mut self.fan);
        self.mesh.fan(start, &mut fan);
        let best = |one: (f64, u32), other: (f64, u32)| if other.0 < one.0 { other } else { one };
        let all = fan.iter().map(|&facet| (self.square(facet, point), facet));
        let mut found = all.reduce(best).unwrap_or_default();
        self.fan = fan;
        // Every step is nearer, so that it ends.
        loop {
            let over = (0..3).filter_map(|corner| self.mesh.over(found.1, corner));
            let next = over.map(|facet| (self.square(facet, point), facet)).fold(found, best);
            if next.1 == found.1 {
                return found;
            }
            found = next;
        }
    }
}

/// The order of places by z, x, y: one that quarter turns about z leave as it is but for ties.
fn by_sweep(p: PointMm, q: PointMm) -> Ordering {
    p[2].total_cmp(&q[2]).then_with(|| by_coordinates(p, q))
}

/// The cosine of the angle of two vectors; -1 where one has no direction.
fn cosine(a: PointMm, b: PointMm) -> f64 {
    match (unit(a), unit(b)) {
        (Some(a), Some(b)) => dot(a, b),
        _ => -1.0,
    }
}

/// How far a step may go.
struct Bounds {
    /// A facet turns by no more than the angle of this cosine.
    turn_cosine: f64,
    /// New facets cross nothing near, by exact signs.
    crosses_nothing: bool,
    /// A point goes to a border that is no farther than this share of the distance to its neighbours.
    border_share: f64,
}

/// Rounds of points, each about twice the one before: 64 points of a cell make seven.
const ROUNDS: u32 = 6;
/// Bounds in turn for what is still out: the careful first; borders last and from near to far, as a front goes.
const BOUNDS: [Bounds; 8] = [
    Bounds { turn_cosine: 0.7, crosses_nothing: false, border_share: 0.0 },
    Bounds { turn_cosine: 0.5, crosses_nothing: true, border_share: 0.0 },
    Bounds { turn_cosine: 0.5, crosses_nothing: true, border_share: 0.25 },
    Bounds { turn_cosine: 0.5, crosses_nothing: true, border_share: 0.5 },
    Bounds { turn_cosine: 0.5, crosses_nothing: true, border_share: 1.0 },
    Bounds { turn_cosine: 0.5, crosses_nothing: true, border_share: 2.0 },
    Bounds { turn_cosine: 0.5, crosses_nothing: true, border_share: 4.0 },
    Bounds { turn_cosine: 0.0, crosses_nothing: true, border_share: f64::INFINITY },
];
/// Tries of what is still out within the same bounds. In each a front goes on by a ring of points or more.
const PASSES: usize = 64;
/// Rings of facets about a step that are asked for crossings.
const RINGS: usize = 2;
