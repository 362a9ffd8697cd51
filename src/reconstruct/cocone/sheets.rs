//! Facets about their edges, without tetrahedra: pruning and one layer, as [`super::prune`] and [`super::walk`] do it over a
//! triangulation.
//!
//! Facets about an edge are in the order of a turn, by exact signs. So the facet that a turn meets next is the same as over tetrahedra.

use std::cmp::Ordering;
use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use asphera_geometry::predicates::orientation_in_space;
use rayon::prelude::*;

use super::prune::{LID, SHARP};
use crate::geometry::{cross, dot, minus, scaled, unit};
use crate::sampling::radius_mm;

/// Facets that share edges.
pub(super) struct Sheets<'a> {
    pub(super) places_mm: &'a [PointMm],
    /// Corners in ascending order.
    pub(super) facets: Vec<[u32; 3]>,
    pub(super) is_present: Vec<bool>,
    /// Facets at edges: ends in ascending order, third corner, facet. Those of one edge are beside each other, in the order of a turn to
    /// the left about the way from the first end to the second.
    fins: Vec<Fin>,
    /// For each facet where it is among the fins: of the edges opposite its first, second and third corner.
    at: Vec<[u32; 3]>,
}

/// A facet at one of its edges.
#[derive(Clone, Copy)]
pub(super) struct Fin {
    pub(super) edge: [u32; 2],
    pub(super) third: u32,
    pub(super) facet: u32,
}

impl<'a> Sheets<'a> {
    /// Facets by corners in ascending order, each once.
    pub(super) fn of(places_mm: &'a [PointMm], facets: Vec<[u32; 3]>) -> Sheets<'a> {
        let mut fins: Vec<Fin> = (0..)
            .zip(&facets)
            .flat_map(|(facet, &[a, b, c])| {
                [([b, c], a), ([a, c], b), ([a, b], c)].map(|(edge, third)| Fin {
                    edge,
                    third,
                    facet,
                })
            })
            .collect();
        fins.par_sort_unstable_by_key(|fin| (fin.edge, fin.third));
        let mut rings: Vec<&mut [Fin]> =
            fins.chunk_by_mut(|one, other| one.edge == other.edge).collect();
        rings.par_iter_mut().for_each(|ring| sort_about(places_mm, ring));
        let mut at = vec![[0; 3]; facets.len()];
        for (place, fin) in (0..).zip(&fins) {
            let facet = fin.facet as usize;
            let corner = facets[facet].iter().position(|&corner| corner == fin.third).unwrap_or(0);
            at[facet][corner] = place;
        }
        let is_present = vec![true; facets.len()];
        Sheets { places_mm, facets, is_present, fins, at }
    }

    fn place(&self, at: u32) -> PointMm {
        self.places_mm[at as usize]
    }

    /// The fins about the edge opposite a corner of a facet.
    pub(super) fn ring(&self, facet: u32, corner: usize) -> &[Fin] {
        let at = self.at[facet as usize][corner] as usize;
        let edge = self.fins[at].edge;
        let from = self.fins[..at].iter().rev().take_while(|fin| fin.edge == edge).count();
        let to = self.fins[at..].iter().take_while(|fin| fin.edge == edge).count();
        &self.fins[at - from..at + to]
    }

    /// The present fins about an edge.
    pub(super) fn present(&self, facet: u32, corner: usize) -> impl Iterator<Item = &Fin> {
        self.ring(facet, corner).iter().filter(|fin| self.is_present[fin.facet as usize])
    }

    /// The present fin that a turn from a facet meets first, to the left or right about its edge; the facet itself where it is alone.
    pub(super) fn next(&self, facet: u32, corner: usize, is_left: bool) -> Fin {
        let ring: Vec<&Fin> = self.present(facet, corner).collect();
        let own = ring.iter().position(|fin| fin.facet == facet).unwrap_or(0);
        let step = if is_left { 1 } else { ring.len() - 1 };
        *ring[(own + step) % ring.len()]
    }

    /// Takes away lids and facets with sharp edges, until there are none.
    pub(super) fn prune(&mut self, flat: &[bool]) {
        self.remove_lids(flat);
        let mut doubtful: Vec<u32> = (0..self.facets.len() as u32).collect();
        while let Some(facet) = doubtful.pop() {
            let is_present = self.is_present[facet as usize];
            if !is_present || !(0..3).any(|corner| self.is_sharp(facet, corner, flat)) {
                continue;
            }
            for corner in 0..3 {
                doubtful.extend(self.present(facet, corner).map(|fin| fin.facet));
            }
            self.is_present[facet as usize] = false;
        }
    }

    fn remove_lids(&mut self, flat: &[bool]) {
        let mut means = vec![(0.0, 0.0); flat.len()];
        let mut doubtful = Vec::new();
        for (index, corners) in self.facets.iter().enumerate() {
            let radius_mm = radius_mm(corners.map(|corner| self.place(corner)));
            if corners.iter().all(|&corner| !flat[corner as usize]) {
                doubtful.push((index, radius_mm));
                continue;
            }
            for &corner in corners {
                let (sum, count) = &mut means[corner as usize];
                *sum += radius_mm;
                *count += 1.0;
            }
        }
        for (index, radius_mm) in doubtful {
            let mean = |&corner: &u32| {
                let (sum, count) = means[corner as usize];
                if count > 0.0 { sum / count } else { f64::INFINITY }
            };
            if radius_mm > LID * self.facets[index].iter().map(mean).fold(0.0, f64::max) {
                self.is_present[index] = false;
            }
        }
    }

    fn is_sharp(&self, facet: u32, corner: usize, flat: &[bool]) -> bool {
        let edge = self.fins[self.at[facet as usize][corner] as usize].edge;
        if edge.iter().any(|&end| !flat[end as usize]) {
            return false;
        }
        let [from, to] = edge.map(|end| self.place(end));
        let Some(axis) = unit(minus(to, from)) else { return false };
        let mut frame = None;
        let mut angles: Vec<f64> = self
            .present(facet, corner)
            .map(|fin| {
                let way = minus(self.place(fin.third), from);
                let across = minus(way, scaled(axis, dot(way, axis)));
                let (right, up) = *frame.get_or_insert_with(|| (across, cross(axis, across)));
                dot(across, up).atan2(dot(across, right))
            })
            .collect();
        angles.sort_unstable_by(f64::total_cmp);
        let [first, .., last] = *angles else {
            return (0..3).any(|corner| self.present(facet, corner).count() > 2);
        };
        let widest =
            angles.windows(2).map(|pair| pair[1] - pair[0]).fold(first + TAU - last, f64::max);
        widest > SHARP
    }
}

/// Sorts the fins of an edge by turns to the left, beginning with the first by coordinates of the third corners.
fn sort_about(places_mm: &[PointMm], ring: &mut [Fin]) {
    let [Fin { edge, third, .. }, ..] = *ring else { return };
    let [from, to] = edge.map(|end| places_mm[end as usize]);
    let first = places_mm[third as usize];
    let side = |one: PointMm, other: PointMm| {
        // `Greater`: from one to the other it turns left about the edge.
        orientation_in_space(from, to, one, other).reverse()
    };
    let along = |place: PointMm| {
        // In the plane of the first: on its side, or opposite.
        let way = minus(to, from);
        let across = |place: PointMm| {
            let out = minus(place, from);
            minus(scaled(out, dot(way, way)), scaled(way, dot(out, way)))
        };
        dot(across(first), across(place)) > 0.0
    };
    // 0: at the first; 1: less than half a turn; 2: half a turn; 3: more.
    let part = |place: PointMm| match side(first, place) {
        Ordering::Greater => 1,
        Ordering::Less => 3,
        Ordering::Equal if along(place) => 0,
        Ordering::Equal => 2,
    };
    ring.sort_by(|one, other| {
        let [one, other] = [one, other].map(|fin| places_mm[fin.third as usize]);
        part(one).cmp(&part(other)).then_with(|| side(one, other).reverse())
    });
}
