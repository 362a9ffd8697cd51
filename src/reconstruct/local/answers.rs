//! Answers of a surface that takes points in batches: its facets in order, and the points in none.

use asphera_geometry::PointMm;
use rayon::prelude::*;

use super::growing::LocalSurface;
use super::normals::Places as _;
use super::stars::Facet;
use crate::neighbours::by_coordinates;
use crate::surface::{LeftOut, Reconstruction, in_order};

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

/// A surface before its facets are put in order and turned.
struct Unturned {
    places_mm: Vec<PointMm>,
    facets: Vec<Facet>,
    left_out: Vec<(u32, LeftOut)>,
}

impl Unturned {
    fn turned(self) -> Reconstruction {
        let Unturned { places_mm, facets, left_out } = self;
        Reconstruction { facets: in_order(&places_mm, facets), left_out }
    }
}

impl LocalSurface {
    /// The surface of all points up to now. n·log n time.
    pub fn surface(&self) -> Reconstruction {
        self.unturned().turned()
    }

    /// The surface of all points, where no more will come: takes less memory than [`LocalSurface::surface`].
    pub fn into_surface(self) -> Reconstruction {
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
        drop(order);
        let facets = self.numbered_facets(&numbers);
        let mut left_out = self.without_facet(&numbers);
        left_out.sort_unstable();
        let rejected = self.left_out.iter().filter(|&&(_, why)| why == LeftOut::NoPlace).count();
        SurfaceByPlace {
            surface: Reconstruction { facets: in_order(&points_mm, facets), left_out },
            points_mm,
            duplicates: self.left_out.len() - rejected,
            rejected,
        }
    }

    fn unturned(&self) -> Unturned {
        let ids = &self.tree.ids;
        let mut places_mm = vec![[0.0; 3]; self.received()];
        for (&id, &place) in ids.iter().zip(self.tree.points_mm()) {
            places_mm[id as usize] = place;
        }
        let mut left_out = self.left_out.clone();
        left_out.extend(self.without_facet(ids));
        left_out.sort_unstable();
        Unturned { places_mm, facets: self.numbered_facets(ids), left_out }
    }

    /// All facets, by numbers that are given to the points of the tree.
    fn numbered_facets(&self, numbers: &[u32]) -> Vec<Facet> {
        let mut facets: Vec<Facet> = Vec::with_capacity(2 * self.tree.len());
        facets.extend(self.stars.facets());
        facets.extend(self.mending.facets());
        facets.par_iter_mut().with_min_len(FACETS_AT_ONCE).for_each(|facet| {
            *facet = facet.map(|corner| numbers[corner as usize]);
        });
        facets
    }

    /// The places in no facet, by numbers that are given to the points of the tree, and why.
    fn without_facet(&self, numbers: &[u32]) -> Vec<(u32, LeftOut)> {
        let has_facet = |at: u32| self.stars.facets_at(at).next().is_some();
        let mut is_used: Vec<bool> = (0..self.tree.len() as u32).map(has_facet).collect();
        for facet in self.mending.facets() {
            facet.iter().for_each(|&corner| is_used[corner as usize] = true);
        }
        let unused = (0..self.tree.len()).filter(|&at| !is_used[at]);
        unused
            .map(|at| {
                let has_plane = self.planes[at].is_some();
                let why = if has_plane { LeftOut::Disagreement } else { LeftOut::NoPlane };
                (numbers[at], why)
            })
            .collect()
    }
}

/// Facets that a thread takes in turn.
const FACETS_AT_ONCE: usize = 1 << 12;
