//! Answers of a surface that takes points in batches: its facets in order, and the points in none.

use std::collections::HashSet;

use asphera_geometry::PointMm;
use rayon::prelude::*;

use super::growing::LocalSurface;
use super::normals::Places as _;
use super::stars::{Facet, sorted};
use crate::neighbours::by_coordinates;
use crate::surface::{LeftOut, Reconstruction, turned};

/// A surface whose points stand in the order of their coordinates, so that it does not depend on the order in which they came.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceByPlace {
    /// Places in ascending order by x, y, z, each once.
    pub points_mm: Vec<PointMm>,
    /// The surface, by numbers of these places.
    pub surface: Reconstruction,
    /// Points at the place of another.
    pub duplicates: usize,
    /// Points with a coordinate that is not finite or too large.
    pub rejected: usize,
}

/// A surface before its facets are turned.
struct Unturned {
    places_mm: Vec<PointMm>,
    facets: Vec<Facet>,
    left_out: Vec<(u32, LeftOut)>,
}

impl Unturned {
    fn turned(self) -> Reconstruction {
        let Unturned { places_mm, facets, left_out } = self;
        Reconstruction { facets: turned(&places_mm, facets), left_out }
    }
}

impl LocalSurface {
    /// The surface of all points up to now. n·log n time.
    pub fn surface(&self) -> Reconstruction {
        self.unturned().turned()
    }

    /// The surface of all points, where no more will come: takes less memory than [`LocalSurface::surface`].
    pub fn into_surface(mut self) -> Reconstruction {
        self.forget_neighbours();
        let unturned = self.unturned();
        rayon::join(|| drop(self), || unturned.turned()).1
    }

    /// The surface of all points up to now, as [`local`](super::local()) gives it of their places in order. n·log n time.
    pub fn by_place(&self) -> SurfaceByPlace {
        let points_mm = self.tree.points_mm();
        let mut order: Vec<u32> = (0..self.tree.len() as u32).collect();
        order.par_sort_unstable_by(|&a, &b| {
            by_coordinates(points_mm[a as usize], points_mm[b as usize])
        });
        let mut numbers = vec![0; order.len()];
        for (&at, number) in order.iter().zip(0..) {
            numbers[at as usize] = number;
        }
        let points_mm: Vec<PointMm> = order.iter().map(|&at| points_mm[at as usize]).collect();
        let facets = self.facets_in_order(&numbers, &order);
        drop(order);
        let mut left_out = self.without_facet(&numbers);
        left_out.sort_unstable();
        let rejected = self.left_out.iter().filter(|&&(_, why)| why == LeftOut::NoPlace).count();
        SurfaceByPlace {
            surface: Reconstruction { facets: turned(&points_mm, facets), left_out },
            points_mm,
            duplicates: self.left_out.len() - rejected,
            rejected,
        }
    }

    fn unturned(&self) -> Unturned {
        let ids = &self.tree.ids;
        let mut order = vec![NONE; self.received()];
        for (&id, at) in ids.iter().zip(0..) {
            order[id as usize] = at;
        }
        let points_mm = self.tree.points_mm();
        let place = |&at: &u32| points_mm.get(at as usize).copied().unwrap_or_default();
        let places_mm = order.par_iter().with_min_len(POINTS_AT_ONCE).map(place).collect();
        let mut left_out = self.left_out.clone();
        left_out.extend(self.without_facet(ids));
        left_out.sort_unstable();
        Unturned { places_mm, facets: self.facets_in_order(ids, &order), left_out }
    }

    /// All facets in ascending order of their corners, which ascend, by numbers that are given to the points of the tree. `order`
    /// has the points by these numbers, and [`NONE`] where there is none.
    fn facets_in_order(&self, numbers: &[u32], order: &[u32]) -> Vec<Facet> {
        let of_points = |points: &[u32]| {
            let mut facets: Vec<Facet> = Vec::with_capacity(2 * points.len());
            for &at in points.iter().filter(|&&at| at != NONE) {
                let (own, from) = (numbers[at as usize], facets.len());
                for others in self.stars.facets_at(at) {
                    let [q, r] = others.map(|other| numbers[other as usize]);
                    // Of its corners the one of the smallest number tells a facet.
                    if own < q && own < r {
                        facets.push([own, q.min(r), q.max(r)]);
                    }
                }
                facets[from..].sort_unstable();
            }
            facets
        };
        let parts: Vec<Vec<Facet>> = order.par_chunks(POINTS_AT_ONCE).map(of_points).collect();
        let mut facets = Vec::with_capacity(parts.iter().map(Vec::len).sum());
        parts.into_iter().for_each(|part| facets.extend(part));
        let stars = facets.len();
        let numbered = |facet: Facet| sorted(facet.map(|corner| numbers[corner as usize]));
        facets.extend(self.mending.facets().map(numbered));
        if facets.len() > stars {
            // Takes two runs that are in order for what they are.
            facets[stars..].sort_unstable();
            facets.sort();
        }
        facets
    }

    /// The places in no facet, by numbers that are given to the points of the tree, and why.
    fn without_facet(&self, numbers: &[u32]) -> Vec<(u32, LeftOut)> {
        let has_none = |&at: &u32| self.stars.facets_at(at).next().is_none();
        let mut unused: Vec<u32> = (0..self.tree.len() as u32)
            .into_par_iter()
            .with_min_len(POINTS_AT_ONCE)
            .filter(has_none)
            .collect();
        if !unused.is_empty() {
            let mended: HashSet<u32> = self.mending.facets().flatten().collect();
            unused.retain(|at| !mended.contains(at));
        }
        let why = |at: u32| match self.planes[at as usize] {
            Some(_) => LeftOut::Disagreement,
            None => LeftOut::NoPlane,
        };
        unused.into_iter().map(|at| (numbers[at as usize], why(at))).collect()
    }
}

/// Points that a thread takes in turn.
const POINTS_AT_ONCE: usize = 1 << 12;
const NONE: u32 = u32::MAX;
